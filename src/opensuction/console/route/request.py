"""People's requests to the machine: each presses a button of the controller from a page."""

import asyncio
import json
from typing import TYPE_CHECKING, Annotated, Any, Literal
from uuid import uuid4

from fastapi import APIRouter, Request, Response
from pydantic import BaseModel, ConfigDict, Field, model_validator

from opensuction.accounts.rule.right import RIGHTS
from opensuction.accounts.session import Session
from opensuction.console.access import (
    ConsoleContext,
    Here,
    allow_change,
    check_reason,
    find_name,
    find_turn,
)
from opensuction.console.guard import origin
from opensuction.console.guard.problem import Problem, documented
from opensuction.console.live.button_press import Asking, ButtonPress
from opensuction.kernel.interface import STOP
from opensuction.records.entry import Action
from opensuction.runtime import machine_button
from opensuction.runtime.journal import ANYBODY
from opensuction.runtime.machine_button import PRESSABLE, MachineButton

router = APIRouter(tags=["Requests"])
page = APIRouter(include_in_schema=False)
NAME_MOST = 64
if TYPE_CHECKING:  # a list that a table gives is none for a type checker
    Ask = str
else:
    Ask = Literal[tuple(PRESSABLE)]


class Pressed(BaseModel):
    """A button."""

    model_config = ConfigDict(extra="forbid", strict=True)

    ask: Ask
    key: Annotated[
        str,
        Field(
            pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]{7,47}$",
            description="Made by whoever asks, anew for each question: the same key again is the "
            "same question again. To stop needs none: each `abort` is another stop.",
        ),
    ]
    reason: Annotated[str | None, Field(max_length=500)] = None

    @model_validator(mode="before")
    @classmethod
    def _give_a_stop_its_key(cls, told: Any) -> Any:
        """Whatever else a request to stop says, it is obeyed, and it is a question of its own."""
        if isinstance(told, dict) and told.get("ask") == STOP:
            return {"ask": STOP, "key": f"stop-{uuid4().hex}"}
        return told


class Answer(BaseModel):
    """Answer to a button press."""

    verdict: str = Field(description="``pressed``: the button went down; else why it did not.")
    refusal: dict[str, str] | None = Field(
        description="Why the machine refused it though the button went down."
    )
    phase: str
    took_ms: float


@router.post("/requests", responses=documented(401, 403, 409, 503))
async def press(request: Request, site: Here, pressed: Pressed) -> Answer:
    """Press a button; to stop (``abort``) is anybody's and asks neither session nor database.

    It needs no key either, is sent to the controller each time, and has no limit but its
    connection's.

    What came of it, phase and alarms say; the answer is that the controller has heard it. All but
    to stop is carried out in the order in which a session presses it; what still waits for its turn
    or for the right when a stop comes is refused.
    """
    button = PRESSABLE[pressed.ask]
    turn = find_turn(request)
    if button.field == STOP:
        turn.stop()
        who = find_name(request) or f"{ANYBODY} ({_peer(request)})"
    else:
        if why := origin.refuse_origin(request.headers, request.url.scheme, needs_origin=True):
            raise Problem(403, why)
        request.app.state.rates.check_button(_peer(request))
        await turn.wait(request.receive)
        who = (await asyncio.to_thread(_allow, request, site, button, pressed)).account
        turn.check()
    asking: Asking = request.app.state.asking
    answered = await asking.ask(ButtonPress(button.field, who[:NAME_MOST], pressed.key))
    return Answer(**answered._asdict())


@page.get("/js/machine_button.js")
async def list_for_page() -> Response:
    """The table of buttons as a module of the page: nothing of it is written twice."""
    text = f"export const BUTTONS = {json.dumps(machine_button.list_plain(), indent=2)};\n"
    return Response(text, media_type="text/javascript")


def _peer(request: Request) -> str:
    return "unknown" if request.client is None else request.client.host


def _allow(
    request: Request, site: ConsoleContext, button: MachineButton, pressed: Pressed
) -> Session:
    """Session of a request, if its holder may; a reason, where needed, is put on record."""
    holder = allow_change(site, request, button.right)
    if RIGHTS[button.right].needs_reason:
        reason = check_reason(pressed.reason)
        machine = site.about().machine
        site.records.note_machine(machine)
        action = Action(holder.account, f"ask-{button.name}", reason, machine.serial)
        site.records.act(action, f"ask-{pressed.key}")
    return holder
