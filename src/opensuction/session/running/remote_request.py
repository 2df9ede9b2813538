"""A button of a machine that runs, pressed from elsewhere, and its answer."""

from uuid import uuid4

from opensuction.ipc.ring import RingReader
from opensuction.kernel.errors import InputError
from opensuction.kernel.phase import Phase
from opensuction.kernel.requests import Requests
from opensuction.result.plain import Json
from opensuction.runtime import controller_request, paths
from opensuction.runtime.loop import ROW_COLUMNS
from opensuction.settings.choice import choose

ANSWERS_S = 1.0
"""Within this time an answer is there: a thousand ticks."""


def ask(name: str, request: str, who: str) -> Json:
    """Press a button of a machine; what became of it.

    Raises InputError for a button that there is not, and where no machine answers.
    """
    buttons = {button.replace("_", "-"): button for button in Requests._fields}
    button = choose(request.replace("_", "-"), buttons, "request")
    folder, key = paths.find(name), uuid4().hex
    if not (folder / paths.EVENTS).exists():
        raise InputError(f"no machine '{name}' runs here: start one with opensuction serve")
    verdict = controller_request.ask(folder, button, who, key, ANSWERS_S)
    if verdict is not None:
        return _plain(name, button, who, key, verdict)
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
    words = "the button went down"
    if answer["verdict"] != controller_request.PRESSED:
        words = f"refused: {controller_request.explain(answer['verdict'])}"
    return f"{answer['request']}: {words}; the machine is {answer['phase']}"
