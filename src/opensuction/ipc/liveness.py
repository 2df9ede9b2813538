"""Signs of life of the processes of one machine: a number each, in a file that all have mapped.

A task that one process has at a time, and which one that is.

The system lets go of the lock when the process ends, however it ends.
"""

import mmap
import os
import signal
from enum import IntEnum
from pathlib import Path
from typing import NamedTuple, Self

import numpy as np

from opensuction.host.host import NS_PER_S, Host, Steps, after, finish
from opensuction.host.this_computer import THIS_COMPUTER
from opensuction.kernel import private_file
from opensuction.kernel.errors import InputError

LOOKS_S = 0.005
KILLED_S = 5.0
"""Within this time a process that was killed has gone."""


class ProcessLock:
    """The task, held by this process."""

    def __init__(self, path: Path, what: str, host: Host = THIS_COMPUTER) -> None:
        """path: a file that all of them know. what: begins the refusal.

        Raises InputError where another process has it, or where the file cannot be.
        """
        try:
            lock = host.locks.take(path)
        except OSError as error:
            raise InputError(f"{path} cannot be written: {error.strerror}") from None
        if lock is None:
            raise InputError(f"{what} already: process {host.locks.holder(path)}, by {path}")
        self._lock = lock

    def close(self) -> None:
        """Let another process have it."""
        self._lock.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def holder(path: Path) -> int | None:
    """Number of the process of this computer that has the task; see `Locks.holder`."""
    return THIS_COMPUTER.locks.holder(path)


def end_holder(path: Path, seconds: float, *, kills: bool = False) -> None:
    """Tell the process that has the task, where one has it, to end, and wait until it has.

    kills: one that does not within that time is killed; for a process that moves nothing.
    Raises InputError where it does not end.
    """
    host = THIS_COMPUTER
    pid = host.locks.holder(path)
    if pid is None or finish(_ending(host, path, pid, signal.SIGTERM, seconds), host.clock):
        return
    killed = kills and finish(_ending(host, path, pid, signal.SIGKILL, KILLED_S), host.clock)
    if not killed:
        raise InputError(f"process {pid} of {path.parent} does not end")


def _ending(
    host: Host, path: Path, pid: int, number: signal.Signals, seconds: float
) -> Steps[bool]:
    """Steps of a process's end; true where it has ended within the time."""
    host.processes.signal(pid, number)
    ends_ns = after(host.clock, seconds)
    while host.locks.holder(path) == pid:
        if host.clock.monotonic_ns() > ends_ns:
            return False
        yield after(host.clock, LOOKS_S)
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

    def __init__(self, folder: Path, host: Host = THIS_COMPUTER) -> None:
        """Made where it is not there yet. Raises InputError where it cannot be."""
        self._clock, size = host.clock, 3 * WORD * len(Process)
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
            self._starts[process] = self._clock.monotonic_ns()

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
        return (self._clock.monotonic_ns() - began) / NS_PER_S if began else None

    def deaths(self, process: Process) -> int:
        """Number of processes that have died and been replaced."""
        return int(self._deaths[process])

    def beat(self, process: Process) -> None:
        """A sign of life, now."""
        self._beats[process] = self._clock.monotonic_ns()

    def end(self, process: Process) -> None:
        """It has ended as it should: nobody need miss it."""
        self._beats[process] = self._starts[process] = 0

    def age_s(self, process: Process) -> float:
        """Since its last sign; inf where it has given none, or has ended."""
        last = int(self._beats[process])
        age_ns = self._clock.monotonic_ns() - last
        # Of before this machine was switched on: its clock began anew.
        return age_ns / NS_PER_S if last and age_ns >= 0 else float("inf")

    def is_expected(self, process: Process) -> bool:
        """True where it has given a sign of life and not ended."""
        return int(self._beats[process]) != 0
