"""Ctrl-C and being terminated: heard within a second whatever is computed, nothing left behind."""

import contextlib
import os
import signal
import sys
import threading
from collections.abc import Iterator
from types import FrameType
from typing import NoReturn

from opensuction.settings import wording

NATIVE_CALLERS = ("namedtuple_", "enum", "numba.core.serialize", "llvmlite.binding")
"""Beginnings of the names of modules whose functions native code calls: compiled code makes its
records and enumerations anew for Python and takes no refusal, a callback loses what it raises."""

AGAIN_S = 0.001
"""A signal that came there is sent again after so long."""

WORDS = {"SIGINT": "interrupted", "SIGTERM": "terminated", "SIGHUP": "terminal closed"}
"""Signals that end a command in order, as far as the system has them, and what is said then."""


class Stopped(BaseException):
    """Somebody wants the command to end; whoever holds something lets go of it."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number


class _Postponed:
    """Signals that came while something must not be broken off."""

    depth = 0
    number = 0


def _is_called_by_native_code(frame: FrameType | None) -> bool:
    """True if an exception would meet native code, which cannot pass it on."""
    while frame is not None:
        name = str(frame.f_globals.get("__name__"))
        if frame.f_code.co_name == "__del__" or name.startswith(NATIVE_CALLERS):
            return True
        frame = frame.f_back
    return False


def _stop(number: int, frame: FrameType | None) -> None:
    if _Postponed.depth:
        _Postponed.number = number
    elif _is_called_by_native_code(frame):
        # By another thread: sent by this one it would be heard at once, in the same place.
        again = threading.Timer(AGAIN_S, signal.raise_signal, (number,))
        again.daemon = True
        again.start()
    else:
        raise Stopped(number)


@contextlib.contextmanager
def postpone() -> Iterator[None]:
    """Postpone signals until the work inside is done."""
    _Postponed.depth += 1
    try:
        yield
    finally:
        _Postponed.depth -= 1
        if _Postponed.number and not _Postponed.depth:
            number, _Postponed.number = _Postponed.number, 0
            raise Stopped(number)


@contextlib.contextmanager
def hear() -> Iterator[None]:
    """Signals raise Stopped in the main thread in here; those that are ignored stay so."""
    before = {}
    if threading.current_thread() is threading.main_thread():
        for name in WORDS:
            number = getattr(signal, name, None)
            if number is not None and signal.getsignal(number) != signal.SIG_IGN:
                before[number] = signal.signal(number, _stop)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def describe(stopped: Stopped) -> str:
    """Words for a signal."""
    return WORDS[signal.Signals(stopped.number).name]


def leave(status: int, line: str) -> NoReturn:
    """Say a line and exit at once: a compilation in the background knows no interruption."""
    with contextlib.suppress(OSError, AttributeError):  # nobody may be there to read it
        sys.stderr.write(f"opensuction: {wording.one_line(line)}\n")
        sys.stderr.flush()
    os._exit(status)
