"""Requests to the control loop, and its answers among the loop's events: one client for all."""

import time
from pathlib import Path

from opensuction.ipc.event_ring import EventReader
from opensuction.ipc.mailbox import PATIENCE_S, Sender
from opensuction.records.database import utc_time
from opensuction.runtime.paths import ASK, EVENTS

PRESSED = "pressed"
"""Verdict: the button went down."""
LOOKS_S = 0.002
SENTENCES = {
    "twice": "this was asked for already; look what came of it",
    "not at rest": "the machine is not at rest: wait until it is parked",
    "nobody": "say who asks",
    "too many": "others ask at the same time: try again",
    "stale": "it came too late to mean the machine as it is now: try again",
    "out of order": "something you asked for later was done first: try again",
}
"""Verdicts that are no consent, in words."""


def send(folder: Path, what: str, who: str, key: str, patience_s: float = PATIENCE_S) -> None:
    """Send a request to the controller of a machine's folder.

    what: a button or another of `ipc.mailbox.ASKS`. key: no other request has had it. patience_s:
    how long to wait for room. Raises InputError where no controller takes it.
    """
    sender = Sender(folder / ASK, who, patience_s)
    try:
        sender.ask(what, key, utc_time.now().isoformat())
    finally:
        sender.close()


def ask(folder: Path, what: str, who: str, key: str, answers_s: float) -> str | None:
    """The loop's verdict on a request; None where it has not answered within a time.

    Raises InputError and OSError where no controller takes it.
    """
    events = EventReader(folder / EVENTS)
    events.read()
    send(folder, what, who, key)
    ends_s = time.monotonic() + answers_s
    while time.monotonic() < ends_s:
        for one in events.read()[0]:
            if one.fields.get("key") == key:
                return str(one.fields["verdict"])
        time.sleep(LOOKS_S)
    return None


def explain(verdict: str) -> str:
    """A verdict that is no consent, in words."""
    reason = verdict.removeprefix("refused: ")
    return SENTENCES.get(verdict, f"the controller refused: {reason}")
