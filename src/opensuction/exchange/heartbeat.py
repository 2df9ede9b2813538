"""Signs of life of the processes of one machine: a number each, in a file that all have mapped."""

import mmap
import os
import time
from enum import IntEnum
from pathlib import Path

import numpy as np

from opensuction.kernel.errors import InputError


class Process(IntEnum):
    """Who gives one."""

    SUPERVISOR = 0
    CONTROL = 1
    RECORDER = 2
    CONSOLE = 3
    KEEPING = 4
    """The recorder too, as long as it keeps what it hears."""


FILE = "heartbeat"
WORD = 8
NS_PER_S = 1e9


class Heartbeat:
    """The file, for one of them or whoever looks after them."""

    def __init__(self, folder: Path) -> None:
        """Made where it is not there yet. Raises InputError where it cannot be."""
        size = 2 * WORD * len(Process)
        try:
            with (folder / FILE).open("a+b") as file:
                os.posix_fallocate(file.fileno(), 0, size)
                words = np.frombuffer(mmap.mmap(file.fileno(), size), np.int64)
        except OSError as error:
            raise InputError(f"no sign of life can be given in {folder}: {error}") from None
        self._beats, self._deaths = words[: len(Process)], words[len(Process) :]

    def begin(self, process: Process) -> None:
        """The first sign of a process; the one before it has died where it never ended."""
        if self.is_expected(process):
            self._deaths[process] += 1
        self.beat(process)

    def deaths(self, process: Process) -> int:
        """How many have died whose place another one has taken."""
        return int(self._deaths[process])

    def beat(self, process: Process) -> None:
        """A sign of life, now."""
        self._beats[process] = time.monotonic_ns()

    def end(self, process: Process) -> None:
        """It has ended as it should: nobody need miss it."""
        self._beats[process] = 0

    def age_s(self, process: Process) -> float:
        """Since its last sign; inf where it has given none, or has ended."""
        last = int(self._beats[process])
        age_ns = time.monotonic_ns() - last
        # Of before this machine was switched on: its clock began anew.
        return age_ns / NS_PER_S if last and age_ns >= 0 else float("inf")

    def is_expected(self, process: Process) -> bool:
        """Whether it has given one and not ended."""
        return int(self._beats[process]) != 0
