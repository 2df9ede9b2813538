"""The machine: whose it is, what it is set to, and what it does now.

Sound and light of alarms: the machine's own figures, which the page follows.

The machine decides which alarm is signalled, and when (`GET /state`); this is only its form.

The airway's drawing for the bedside: the same geometry and template as a report's.

Depths come with the request, from what `GET /machine` says: the drawing itself knows no machine.
"""

import asyncio
import contextlib
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Query, Response, WebSocket, WebSocketDisconnect
from pydantic import BaseModel

from opensuction.accounts.rule.right import Right
from opensuction.console.access import Here, Holder, may
from opensuction.console.guard.problem import Problem, documented
from opensuction.console.live import machine_description
from opensuction.console.live.hub import Broadcast
from opensuction.kernel.errors import InputError
from opensuction.report import airway_geometry, sheet
from opensuction.report.airway_geometry import Depth
from opensuction.safety.alarm import alarm_signal
from opensuction.safety.alarm.alarm_signal import HARMONIC_DB, HARMONICS
from opensuction.safety.handling import Priority

router = APIRouter(tags=["Machine"])

DEEPEST_MM = 400.0
"""Deeper is no airway: of an adult the carina lies some 12 cm below a tube's end."""
RAIL_PX = {"from_px": 242, "to_px": 420}
"""Of the head's way on the drawing: where it is furthest in, and at home."""
LABEL_GAP_PX = 25.0
"""The labels are larger than a report's: they are read from further away."""

Below = Annotated[float | None, Query(ge=-DEEPEST_MM, le=DEEPEST_MM, allow_inf_nan=False)]


def draw(
    target_mm: float | None,
    cap_mm: float | None,
    carina_mm: float | None,
    boundary_mm: float | None,
    by_contact: bool,
) -> str:
    """Draw the fixed and the moving parts as SVG; depths below the tube's end."""
    named = [
        ("Tube end", "tube", 0.0),
        ("Target", "target", target_mm),
        ("Search ends" if by_contact else "Cap", "search" if by_contact else "cap", cap_mm),
        ("Carina", "carina", carina_mm),
    ]
    depths = [Depth(name, kind, mm) for name, kind, mm in named if mm is not None]
    listed = "; ".join(
        f"{one.name.lower()} at {one.mm:.1f} mm" for one in airway_geometry.visible(depths)
    )
    return sheet.render_part(
        "anatomy_live.svg.j2",
        drawing=airway_geometry.lay_out(depths, carina_mm, boundary_mm, LABEL_GAP_PX),
        rail=RAIL_PX,
        boundary_mm=boundary_mm,
        px_per_mm=airway_geometry.PX_PER_MM,
        above_mm=airway_geometry.ABOVE_MM,
        straight_mm=airway_geometry.STRAIGHT_MM,
        description=(
            "Tracheostomy tube, trachea and main bronchi from the front, with conduit, drive "
            "head and catheter as they "
            f"are now; the depth stands beside in figures. Depths below the tube's end: {listed}."
        ),
    )


@router.get(
    "/anatomy.svg",
    response_class=Response,
    responses={200: {"content": {"image/svg+xml": {}}, "description": "The drawing"}},
)
def show_anatomy(
    target_mm: Below = None,
    cap_mm: Below = None,
    carina_mm: Below = None,
    boundary_mm: Below = None,
    by_contact: bool = False,
) -> Response:
    """The airway's drawing, to scale; depths in mm below the tube's end, negative above it.

    by_contact: the cap is where the search for the carina ends.
    """
    drawn = draw(target_mm, cap_mm, carina_mm, boundary_mm, by_contact)
    return Response(drawn, media_type="image/svg+xml")


@router.get(
    "/anatomy.css",
    response_class=Response,
    responses={200: {"content": {"text/css": {}}, "description": "Its styles"}},
)
def show_style() -> Response:
    """Style of the drawing's parts; the colours are the page's."""
    return Response(sheet.read("template", "anatomy.css"), media_type="text/css")


class PulseBody(BaseModel):
    """One tone of a burst, between its points at 90 %."""

    start_s: float
    end_s: float


class SignalBody(BaseModel):
    """Sound and light of a priority."""

    priority: str
    """``none``: the reminder's."""
    pulses: list[PulseBody]
    edge_s: float
    """Whole rise, and fall, of a pulse: half a cosine."""
    foot_s: float
    """Part of it that lies outside of the points at 90 %."""
    fundamental_hz: float
    harmonics: list[float]
    """Amplitudes of the fundamental and its harmonics; they add up to 1."""
    period_s: float
    """From the beginning of a burst to that of the next."""
    colour: str
    flash_hz: float
    """0: steady."""
    duty_ratio: float


def _signal(priority: Priority) -> SignalBody:
    tone, light = alarm_signal.TONES[priority], alarm_signal.LIGHTS[priority]
    pulses = alarm_signal.pulses(priority)
    levels = [10.0 ** (HARMONIC_DB.value * order / 20.0) for order in range(int(HARMONICS.value))]
    edge_s = alarm_signal.edge_s(priority)
    return SignalBody(
        priority=priority.name.lower(),
        pulses=[PulseBody(**pulse._asdict()) for pulse in pulses],
        edge_s=edge_s,
        foot_s=alarm_signal.NINETY_PERCENT * edge_s,
        fundamental_hz=tone.fundamental_hz.value,
        harmonics=[level / sum(levels) for level in levels],
        period_s=pulses[-1].end_s + tone.interval_s.value,
        colour=light.colour,
        flash_hz=light.flash_hz.value,
        duty_ratio=light.duty_ratio.value,
    )


@router.get("/alarm-signals")
def list_alarm_signals() -> list[SignalBody]:
    """Sound and light of each priority, after IEC 60601-1-8."""
    return [_signal(priority) for priority in Priority]


SEND_S = 5.0
"""A page that takes no state for longer than this is gone."""
SPEAKS = 1008
"""Why a page is sent away that says something: it is only to listen."""


@router.get("/machine", responses=documented(503))
def read_machine(
    site: Here, _: Annotated[Holder, Depends(may(Right.SEE_BEDSIDE))]
) -> dict[str, Any]:
    """Machine and its holder, its patient, the cycle to come, its limits, and the words for it."""
    try:
        return machine_description.tell(site.about(), site.hub.configuration().settings, site.hub)
    except InputError as error:
        raise Problem(503, f"no machine is set up: {error}") from None


@router.get("/state", response_model=dict[str, Any])
def read_state(site: Here, _: Annotated[Holder, Depends(may(Right.SEE_BEDSIDE))]) -> Response:
    """State of the machine; with ``connected`` false only the age of its last row is known."""
    return Response(site.hub.now().text, media_type="application/json")


@router.websocket("/live")
async def live(socket: WebSocket) -> None:
    """The same, 20 times a second, for as long as a page listens."""
    broadcast: Broadcast = socket.app.state.broadcast
    await socket.accept()
    broadcast.join()
    listening = asyncio.create_task(_wait_for_end(socket))
    try:
        while not listening.done():
            async with asyncio.timeout(SEND_S):
                await socket.send_text(await broadcast.next())
    except (WebSocketDisconnect, TimeoutError, RuntimeError):
        pass  # it has gone, or hangs: the next one that opens begins anew
    finally:
        broadcast.leave()
        listening.cancel()
        with contextlib.suppress(asyncio.CancelledError, RuntimeError):
            await listening


async def _wait_for_end(socket: WebSocket) -> None:
    """Until the page is gone; one that says something is sent away."""
    message = await socket.receive()
    if message["type"] == "websocket.receive":
        await socket.close(SPEAKS, "this only tells, and hears nothing")
