"""News of what is being compiled: it takes up to a minute, and somebody is waiting."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from enum import IntEnum
from typing import Any, NamedTuple

PACKAGE_PREFIX = "opensuction."


class Stage(IntEnum):
    """Stage in the compilation of a root function: one that Python calls."""

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

_listeners: list[Listener] = []
_compiling: list[Compilation] = []
"""The root that is being compiled: one at a time, for numba has one lock."""


def listen(listener: Listener | None) -> None:
    """Tell ``listener`` of every root function that is compiled; None ends it. One at a time.

    It is called by the thread that compiles, must not raise and not call compiled functions. What
    comes from the cache is not told, and nothing is where nothing is compiled.
    """
    _listeners[:] = [] if listener is None else [listener]


def _tell(news: Compilation) -> None:
    _compiling[:] = [news]
    for listener in _listeners:
        listener(news)


@contextmanager
def report(function: Callable[..., Any]) -> Iterator[None]:
    """Tell that a root is compiled in the block, from its beginning to its end."""
    name = f"{function.__module__}.{function.__qualname__}"
    _tell(Compilation(name.removeprefix(PACKAGE_PREFIX), Stage.BEGUN, 0))
    try:
        yield
    finally:
        _tell(_compiling[0]._replace(stage=Stage.FINISHED))
        _compiling.clear()


def count() -> None:
    """Tell that one more function of the root has been translated."""
    for news in tuple(_compiling):
        _tell(news._replace(stage=Stage.TRANSLATED, functions=news.functions + 1))


def report_optimising() -> None:
    """Tell that the machine code of the root is being made."""
    for news in tuple(_compiling):
        _tell(news._replace(stage=Stage.OPTIMISING))
