"""The machine: whose it is, what it is set to, and what it does now."""

import asyncio
import contextlib
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Response, WebSocket, WebSocketDisconnect

from opensuction.accounts.rule.right import Right
from opensuction.console.access import Here, Holder, may
from opensuction.console.guard.problem import Problem, documented
from opensuction.console.live import machine_description
from opensuction.console.live.broadcast import Broadcast
from opensuction.kernel.errors import InputError

router = APIRouter(tags=["Machine"])
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
