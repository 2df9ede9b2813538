"""A button of a machine that runs, pressed from elsewhere, and its answer."""

from pathlib import Path
from typing import NamedTuple
from uuid import uuid4

from opensuction.ipc.ring import RingReader
from opensuction.kernel.errors import InputError
from opensuction.kernel.phase import Phase
from opensuction.runtime import controller_request, paths
from opensuction.runtime.loop import ROW_COLUMNS
from opensuction.runtime.machine_button import BY_NAME
from opensuction.settings.choice import choose

ANSWERS_S = 1.0
"""Within this time an answer is there: a thousand ticks."""


class Answer(NamedTuple):
    """Answer of a machine to a button."""

    machine: str
    """Name."""
    request: str
    """Name of the button, as people type it."""
    who: str
    key: str
    """Of this press alone."""
    verdict: str
    """See `controller_request`."""
    phase: str | None
    """Of the machine then; None: its controller has not ticked yet."""


def ask(name: str, request: str, who: str) -> Answer:
    """Press a button of a machine; what became of it.

    Raises InputError for a button that there is not, and where no machine answers.
    """
    button = choose(request.replace("_", "-"), BY_NAME, "request")
    folder, key = paths.find(name), uuid4().hex
    if not (folder / paths.EVENTS).exists():
        raise InputError(f"no machine '{name}' runs here: start one with opensuction serve")
    verdict = controller_request.ask(folder, button.field, who, key, ANSWERS_S)
    if verdict is not None:
        return Answer(name, button.name, who, key, verdict, _find_phase(folder))
    raise InputError(f"the machine '{name}' does not answer: does its controller run?")


def _find_phase(folder: Path) -> str | None:
    newest = RingReader(folder / paths.RING).snapshot()
    if newest is None:
        return None
    return Phase(int(newest[1][ROW_COLUMNS.index("outputs.phase")])).name.lower()


def say(answer: Answer) -> str:
    """The answer in words."""
    words = "the button went down"
    if answer.verdict != controller_request.PRESSED:
        words = f"refused: {controller_request.explain(answer.verdict)}"
    return f"{answer.request}: {words}; the machine is {answer.phase}"
