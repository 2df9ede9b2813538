"""News of what is being compiled: it takes up to a minute, and somebody is waiting."""

from collections.abc import Callable
from enum import IntEnum
from typing import Any, NamedTuple

from numba.core import event

PACKAGE_PREFIX = "opensuction."


class Stage(IntEnum):
    """How far the compilation of a root function is: one that Python calls."""

    BEGUN = 0
    """It is not in the cache: it is compiled now."""
    TRANSLATED = 1
    """One more of the functions in it has been translated; comes hundreds of times."""
    OPTIMISING = 2
    """All are translated, and the machine code is being made."""
    FINISHED = 3
    """It is ready, or was given up with an exception."""


class Compilation(NamedTuple):
    """News of one root function."""

    root: str
    """Its name without the package: ``simulation.closed_loop.run``."""
    stage: Stage
    functions: int
    """Functions in it that have been translated so far."""


Listener = Callable[[Compilation], None]


class _Reporter(event.Listener):
    """Turns the compiler's events into news; roots do not nest, what is compiled in one does."""

    def __init__(self, listener: Listener) -> None:
        self._listener = listener
        self._depth = 0
        self._root = ""
        self._functions = 0

    def _tell(self, stage: Stage) -> None:
        self._listener(Compilation(self._root, stage, self._functions))

    def on_start(self, begun: Any) -> None:
        """A function is about to be compiled."""
        if self._depth == 0:
            function = begun.data["dispatcher"].py_func
            name = f"{function.__module__}.{function.__qualname__}"
            self._root, self._functions = name.removeprefix(PACKAGE_PREFIX), 0
            self._tell(Stage.BEGUN)
        self._depth += 1

    def on_end(self, _: Any) -> None:
        """A function has been compiled."""
        self._depth -= 1
        self._functions += 1
        self._tell(Stage.TRANSLATED if self._depth else Stage.FINISHED)


_KIND = "numba:compile"
_reporters: list[_Reporter] = []


def listen(listener: Listener | None) -> None:
    """Tell ``listener`` of every root function that is compiled; None ends it. One at a time.

    It is called by the thread that compiles, must not raise and not call compiled functions. What
    comes from the cache is not told, and nothing is where nothing is compiled.
    """
    while _reporters:
        event.unregister(_KIND, _reporters.pop())  # type: ignore[no-untyped-call]
    if listener is not None:
        _reporters.append(_Reporter(listener))
        event.register(_KIND, _reporters[-1])  # type: ignore[no-untyped-call]
