"""A loop that does nothing but sleep: what this machine, as busy as it is, lets any loop keep.

A process of its own, hardened as the control process is: ``python bare_loop.py OUT PERIOD_NS``.
Told to end it writes to OUT how many ticks it kept and missed.
"""

import json
import signal
import sys
import time
from pathlib import Path

from opensuction.host.this_computer import THIS_COMPUTER, hardened
from opensuction.ipc.deadline_scheduler import DeadlineScheduler

LONGEST = 64
"""Bits of the longest delay in nanoseconds."""


def keep(out: Path, period_ns: int) -> None:
    """Sleep from deadline to deadline until the process is told to end."""
    ending: list[int] = []
    signal.signal(signal.SIGTERM, lambda number, _: ending.append(number))
    late, ticks = [0] * LONGEST, 0
    with hardened() as allowed:
        clock = THIS_COMPUTER.clock
        pace = DeadlineScheduler(period_ns, clock.monotonic_ns())
        while not ending:
            clock.sleep_until(pace.due_ns)
            pace.begin(clock.monotonic_ns())
            late[max(time.monotonic_ns() - pace.deadline_ns, 0).bit_length()] += 1
            ticks += 1
    told = {
        "scheduler": allowed.scheduler,
        "ticks": ticks,
        "missed": pace.skipped,
        "late_by_bits_of_ns": late,
    }
    out.write_text(json.dumps(told), encoding="utf-8")


if __name__ == "__main__":
    keep(Path(sys.argv[1]), int(sys.argv[2]))
