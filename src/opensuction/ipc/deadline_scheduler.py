"""Ticks by absolute deadlines, and what a process asks of the kernel to keep them.

A tick that is missed is counted and skipped: what was not done in time is not done twice as fast
afterwards, for a servo would see a step in time that was none.
"""

import ctypes
import gc
import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple, Protocol

NS_PER_S = 1_000_000_000
TIMER_ABSTIME = 1
MCL_CURRENT_AND_FUTURE = 1 | 2
PRIORITY = 50
"""Of the real-time class: above everything that is not, below the kernel's own threads."""


class _Timespec(ctypes.Structure):
    _fields_ = (("tv_sec", ctypes.c_long), ("tv_nsec", ctypes.c_long))


_libc = ctypes.CDLL(None, use_errno=True)


class Pacing(Protocol):
    """Says when a loop's next tick is due."""

    deadline_ns: int
    """Of the present tick, by the monotonic clock."""

    def wait(self) -> int:
        """Sleep until the next deadline; how many were missed before it."""


class DeadlineScheduler:
    """Deadlines a period apart, counted from when it was made."""

    def __init__(self, period_ns: int) -> None:
        """The first deadline is a period from now."""
        self.period_ns = period_ns
        self.deadline_ns = time.monotonic_ns()
        """Of the present tick."""
        self.skipped = 0
        """Ticks that were missed in all."""
        self._until = _Timespec()

    def wait(self) -> int:
        """Sleep until the next deadline; how many were missed before it.

        One that is over by less than a period is that of a tick that begins late, and now.
        """
        self.deadline_ns += self.period_ns
        late_ns = time.monotonic_ns() - self.deadline_ns
        if late_ns >= 0:
            missed = late_ns // self.period_ns
            self.deadline_ns += missed * self.period_ns
            self.skipped += missed
            return missed
        self._until.tv_sec, self._until.tv_nsec = divmod(self.deadline_ns, NS_PER_S)
        until = ctypes.byref(self._until)
        # A signal ends the sleep early: sleep on, the handler has run.
        while _libc.clock_nanosleep(time.CLOCK_MONOTONIC, TIMER_ABSTIME, until, None) != 0:
            pass
        # Nobody is woken at the deadline itself: whole periods late is missed here, too.
        missed = (time.monotonic_ns() - self.deadline_ns) // self.period_ns
        self.deadline_ns += missed * self.period_ns
        self.skipped += missed
        return missed


class Allowed(NamedTuple):
    """Real-time rights that the kernel has granted."""

    scheduler: str
    """``fifo`` at `PRIORITY`, or ``other``: then whoever else wants the core gets its share."""
    memory_locked: bool
    """No page of it has to be fetched from a disk."""
    refusals: tuple[str, ...]
    """What it has not, each in a sentence."""


@contextmanager
def hardened() -> Iterator[Allowed]:
    """Locked memory and real-time priority for a loop, with the collector of garbage at rest.

    Everything must have been built by then: what a loop leaves behind afterwards is freed by its
    references alone, which its memory staying flat is the proof of.

    Only the loop itself has the priority: to lock memory takes some .2 s, and an interpreter with
    machine code takes as long to end. At the priority of other machines' loops it would keep them
    standing meanwhile.
    """
    gc.collect()
    gc.freeze()
    gc.disable()
    locked = _libc.mlockall(MCL_CURRENT_AND_FUTURE) == 0
    not_locked = os.strerror(ctypes.get_errno())
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    scheduler, refusals = "fifo", []
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    except (PermissionError, OSError) as error:
        scheduler = "other"
        refusals.append(
            f"no real-time priority ({os.strerror(error.errno or 0)}): other work on this machine "
            "makes ticks late"
        )
    if not locked:
        refusals.append(
            f"memory is not locked ({not_locked}): a page that was put away makes a tick late"
        )
    try:
        yield Allowed(scheduler, locked, tuple(refusals))
    finally:
        if scheduler == "fifo":
            os.sched_setscheduler(0, *before)
