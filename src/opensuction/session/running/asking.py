"""A button of a machine that runs, pressed from elsewhere, and its answer."""

import time
from uuid import uuid4

from opensuction.ipc.event_ring import EventReader
from opensuction.ipc.mailbox import Sender
from opensuction.ipc.ring import RingReader
from opensuction.kernel.errors import InputError
from opensuction.kernel.phase import Phase
from opensuction.kernel.requests import Requests
from opensuction.records.database import utc_time
from opensuction.runtime import paths
from opensuction.runtime.loop import ROW_COLUMNS
from opensuction.session.plain import Json
from opensuction.settings.choice import choose

PRESSED = "pressed"
ANSWERS_S = 1.0
"""Within this time an answer is there: a thousand ticks."""
LOOKS_S = 0.002
SENTENCES = {
    PRESSED: "the button went down",
    "nobody": "refused: say who asks",
    "too many": "refused: too many ask at once",
    "stale": "refused: it came too late to mean the machine as it is now",
}


def ask(name: str, request: str, who: str) -> Json:
    """Press a button of a machine; what became of it.

    Raises InputError for a button that there is not, and where no machine answers.
    """
    buttons = {button.replace("_", "-"): button for button in Requests._fields}
    button = choose(request.replace("_", "-"), buttons, "request")
    folder, key = paths.find(name), uuid4().hex
    if not (folder / paths.EVENTS).exists():
        raise InputError(f"no machine '{name}' runs here: start one with opensuction serve")
    events = EventReader(folder / paths.EVENTS)
    events.read()
    sender = Sender(folder / paths.ASK, who)
    try:
        sender.ask(button, key, utc_time.now().isoformat())
    finally:
        sender.close()
    ends_s = time.monotonic() + ANSWERS_S
    while time.monotonic() < ends_s:
        for one in events.read()[0]:
            if one.fields.get("key") == key:
                return _plain(name, button, who, key, str(one.fields["verdict"]))
        time.sleep(LOOKS_S)
    raise InputError(f"the machine '{name}' does not answer: does its controller run?")


def _plain(name: str, request: str, who: str, key: str, verdict: str) -> Json:
    newest = RingReader(paths.find(name) / paths.RING).snapshot()
    phase = None
    if newest is not None:
        phase = Phase(int(newest[1][ROW_COLUMNS.index("outputs.phase")])).name.lower()
    return {
        "machine": name,
        "request": request.replace("_", "-"),
        "who": who,
        "key": key,
        "verdict": verdict,
        "phase": phase,
    }


def say(answer: Json) -> str:
    """The answer in words."""
    words = SENTENCES.get(answer["verdict"], f"refused: {answer['verdict']}")
    return f"{answer['request']}: {words}; the machine is {answer['phase']}"
