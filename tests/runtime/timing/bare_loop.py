"""A loop that does nothing but sleep: what this machine, as busy as it is, lets any loop keep.

A process of its own, hardened as the control process is: ``python bare_loop.py OUT PERIOD_NS``.
Told to end it writes to OUT how many ticks it kept and missed, and when it was late by a period.
``python bare_loop.py OUT PERIOD_NS CORE`` does so on one core before all other loops: it is late
where the computer keeps that core from everybody.
"""

import json
import os
import signal
import sys
import time
from pathlib import Path

from opensuction.host.this_computer import PRIORITY, THIS_COMPUTER, hardened
from opensuction.ipc.deadline_scheduler import DeadlineScheduler

LONGEST = 64
"""Bits of the longest delay in nanoseconds."""


def keep(out: Path, period_ns: int, core: int | None = None) -> None:
    """Sleep from deadline to deadline until the process is told to end.

    core: to stay on, before all other loops; None: any.
    """
    ending: list[int] = []
    signal.signal(signal.SIGTERM, lambda number, _: ending.append(number))
    late, ticks, stood_ns = [0] * LONGEST, 0, list[tuple[int, int]]()
    with hardened() as allowed:
        if core is not None:
            os.sched_setaffinity(0, {core})
            if allowed.scheduler == "fifo":
                os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY + 1))
        clock = THIS_COMPUTER.clock
        pace = DeadlineScheduler(period_ns, clock.monotonic_ns())
        while not ending:
            due_ns = pace.due_ns
            clock.sleep_until(due_ns)
            if pace.begin(now_ns := clock.monotonic_ns()):
                stood_ns.append((due_ns, now_ns))
            late[max(time.monotonic_ns() - pace.deadline_ns, 0).bit_length()] += 1
            ticks += 1
    told = {
        "scheduler": allowed.scheduler,
        "ticks": ticks,
        "missed": pace.skipped,
        "late_by_bits_of_ns": late,
        "stood_ns": stood_ns,
    }
    out.write_text(json.dumps(told), encoding="utf-8")


if __name__ == "__main__":
    keep(Path(sys.argv[1]), *map(int, sys.argv[2:]))
