"""Signs of life of the processes of one machine: a number each, in a file that all have mapped.

A task that one process has at a time, and which one that is.

The system lets go of the lock when the process ends, however it ends.
"""

import contextlib
import fcntl
import mmap
import os
import signal
import struct
import time
from enum import IntEnum
from pathlib import Path
from typing import NamedTuple, Self

import numpy as np

from opensuction.kernel import private_file
from opensuction.kernel.errors import InputError

LOOKS_S = 0.005
KILLED_S = 5.0
"""Within this time a process that was killed has gone."""
_QUESTION = "hhqqi4x"
"""The system's ``struct flock``: kind, from where, start, length, process."""


class ProcessLock:
    """The task, held by this process."""

    def __init__(self, path: Path, what: str) -> None:
        """path: a file that all of them know. what: begins the refusal.

        Raises InputError where another process has it, or where the file cannot be.
        """
        try:
            self._file = private_file.append(path)
        except OSError as error:
            raise InputError(f"{path} cannot be written: {error.strerror}") from None
        try:
            fcntl.lockf(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            self._file.close()
            raise InputError(f"{what} already: process {holder(path)}, by {path}") from None

    def close(self) -> None:
        """Let another process have it."""
        self._file.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def holder(path: Path) -> int | None:
    """Number of the process that has the task; None where nobody has it.

    Not for the process that has it itself: to close the file again lets go of it.
    """
    try:
        with path.open("r+b") as file:
            asked = struct.pack(_QUESTION, fcntl.F_WRLCK, os.SEEK_SET, 0, 0, 0)
            kind, _, _, _, process = struct.unpack(
                _QUESTION, fcntl.fcntl(file, fcntl.F_GETLK, asked)
            )
    except OSError:
        return None
    return None if kind == fcntl.F_UNLCK else int(process)


def end_holder(path: Path, seconds: float, *, kills: bool = False) -> None:
    """Tell the process that has the task, where one has it, to end, and wait until it has.

    kills: one that does not within that time is killed; for a process that moves nothing.
    Raises InputError where it does not end.
    """
    pid = holder(path)
    if pid is None or _ends(path, pid, signal.SIGTERM, seconds):
        return
    if not kills or not _ends(path, pid, signal.SIGKILL, KILLED_S):
        raise InputError(f"process {pid} of {path.parent} does not end")


def _ends(path: Path, pid: int, number: signal.Signals, seconds: float) -> bool:
    with contextlib.suppress(ProcessLookupError):  # it ended by itself
        os.kill(pid, number)
    ends_s = time.monotonic() + seconds
    while holder(path) == pid:
        if time.monotonic() > ends_s:
            return False
        time.sleep(LOOKS_S)
    return True


class Process(IntEnum):
    """Process, or task of one, that gives signs of life."""

    SUPERVISOR = 0
    CONTROL = 1
    RECORDER = 2
    CONSOLE = 3
    KEEPING = 4
    """The recorder too, as long as it keeps what it hears."""


FILE = "heartbeat"
WORD = 8
NS_PER_S = 1e9


class Signs(NamedTuple):
    """Signs of life of one process at an instant."""

    is_expected: bool
    """It has given a sign of life and not ended."""
    age_s: float
    """Since its last sign; inf where there is none."""
    deaths: int
    """How many have died whose place another one has taken."""
    starting_s: float | None
    """For how long it has been started and does not work yet; None where it is not being started.
    """


class Heartbeat:
    """The file, for one of them or whoever looks after them."""

    def __init__(self, folder: Path) -> None:
        """Made where it is not there yet. Raises InputError where it cannot be."""
        size = 3 * WORD * len(Process)
        try:
            with private_file.append(folder / FILE) as file:
                os.posix_fallocate(file.fileno(), 0, size)
                words = np.frombuffer(mmap.mmap(file.fileno(), size), np.int64)
        except OSError as error:
            raise InputError(f"no sign of life can be given in {folder}: {error}") from None
        self._beats, self._deaths, self._starts = words.reshape(3, len(Process))

    def start(self, process: Process) -> None:
        """Note that a process is being started: it is waited for until it works.

        One whose place it takes and that never ended has died: it is missed, not waited for. Where
        one died before its first sign, the time of the first attempt counts.
        """
        if self.is_expected(process):
            self._starts[process] = 0
        elif not self._starts[process]:
            self._starts[process] = time.monotonic_ns()

    def begin(self, process: Process) -> None:
        """The first sign of a process; the one before it has died where it never ended."""
        if self.is_expected(process):
            self._deaths[process] += 1
            self._starts[process] = 0
        self.beat(process)

    def work(self, process: Process) -> None:
        """Note that a process works, if it has given a sign: from now on its silence is a loss."""
        if self.is_expected(process):
            self._starts[process] = 0

    def signs(self, process: Process) -> Signs:
        """Signs of life of a process at present."""
        return Signs(
            self.is_expected(process),
            self.age_s(process),
            self.deaths(process),
            self._starting_s(process),
        )

    def _starting_s(self, process: Process) -> float | None:
        began = int(self._starts[process])
        return (time.monotonic_ns() - began) / NS_PER_S if began else None

    def deaths(self, process: Process) -> int:
        """Number of processes that have died and been replaced."""
        return int(self._deaths[process])

    def beat(self, process: Process) -> None:
        """A sign of life, now."""
        self._beats[process] = time.monotonic_ns()

    def end(self, process: Process) -> None:
        """It has ended as it should: nobody need miss it."""
        self._beats[process] = self._starts[process] = 0

    def age_s(self, process: Process) -> float:
        """Since its last sign; inf where it has given none, or has ended."""
        last = int(self._beats[process])
        age_ns = time.monotonic_ns() - last
        # Of before this machine was switched on: its clock began anew.
        return age_ns / NS_PER_S if last and age_ns >= 0 else float("inf")

    def is_expected(self, process: Process) -> bool:
        """True where it has given a sign of life and not ended."""
        return int(self._beats[process]) != 0
