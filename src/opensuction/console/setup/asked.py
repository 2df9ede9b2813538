"""A request to the control loop, and its answer among the loop's events."""

import time
from pathlib import Path

from opensuction.console.guard.problem import Problem
from opensuction.ipc.event_ring import EventReader
from opensuction.ipc.mailbox import Sender
from opensuction.kernel.errors import InputError
from opensuction.records.database import utc_time
from opensuction.runtime.paths import ASK, EVENTS

ANSWERS_S = 2.0
"""Longest wait: other settings are taken up in some ticks."""
LOOKS_S = 0.002
PRESSED = "pressed"
SENTENCES = {
    "twice": "this was asked for already: load the page again to see what came of it",
    "not at rest": "the machine is not at rest: wait until it is parked",
    "too many": "others ask at the same time: try again",
    "stale": "it came too late to mean the machine as it is now: try again",
    "out of order": "something you asked for later was done first: try again",
}
"""Verdicts in words."""


def ask(folder: Path, what: str, who: str, key: str) -> str:
    """The loop's verdict. Raises Problem 503 where no controller answers."""
    try:
        events = EventReader(folder / EVENTS)
        events.read()
        sender = Sender(folder / ASK, who)
        try:
            sender.ask(what, key, utc_time.now().isoformat())
        finally:
            sender.close()
        ends_s = time.monotonic() + ANSWERS_S
        while time.monotonic() < ends_s:
            for one in events.read()[0]:
                if one.fields.get("key") == key:
                    return str(one.fields["verdict"])
            time.sleep(LOOKS_S)
    except (InputError, OSError) as error:
        raise Problem(503, f"no controller takes requests now: {error}") from None
    raise Problem(503, "the controller does not answer; whether it obeyed, the bedside view shows")


def press(folder: Path, button: str, who: str, key: str) -> None:
    """Press a button. Raises Problem 409 where the loop refuses it."""
    verdict = ask(folder, button, who, key)
    if verdict != PRESSED:
        raise Problem(409, explain(verdict))


def explain(verdict: str) -> str:
    """A verdict that is no consent, in words."""
    reason = verdict.removeprefix("refused: ")
    return SENTENCES.get(verdict, f"the controller refused: {reason}")
