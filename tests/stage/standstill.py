"""Standstills of the computer, seen by bare loops beside the tests in real time.

On each core two loops do nothing but keep deadlines: one of the class that a machine's own
processes ask for, and above them, and one of the ordinary class. Where such a loop is late, the
computer kept it standing, and so it did with whatever else of that class ran on that core. A
computer that others share may also take the core away in slices of some milliseconds, tick after
tick: no slice is long, and a machine halts all the same. So ticks late in a row are counted, too.
``python -m tests.stage.standstill CORE CLASS FILE`` is one of them.
"""

import os
import shutil
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path
from typing import Self

from opensuction.host.this_computer import PRIORITY, THIS_COMPUTER, hardened
from opensuction.ipc.deadline_scheduler import DeadlineScheduler
from tests.stage.judge import Standstill

REAL_TIME, ORDINARY = "real-time", "ordinary"
PERIOD_NS = {REAL_TIME: 1_000_000, ORDINARY: 5_000_000}
"""A controller's; a fifth of what is told of an ordinary process costs a fifth of the core."""
TOLD_NS = 5_000_000
"""Standstills that are longer are written down, and so are several late ticks in a row."""
IN_A_ROW = 2
"""One late tick among others is the rule on most computers."""
CORES_MOST = 4
"""Cores that are watched: each costs some 3 % of one."""
SETTLES_S = 0.1
"""After this a loop that was kept standing until now has written it down."""
STARTS_S = 30.0


class StandstillWatch:
    """The loops, and what they have seen. Used as a context."""

    def __init__(self) -> None:
        self._folder = Path(tempfile.mkdtemp())
        self._loops: list[subprocess.Popen[bytes]] = []

    def __enter__(self) -> Self:
        cores = sorted(os.sched_getaffinity(0))[:CORES_MOST]
        for core in cores:
            for kind in PERIOD_NS:
                command = [sys.executable, "-m", __name__, str(core), kind, self._file(core, kind)]
                self._loops.append(subprocess.Popen(command, stdin=subprocess.PIPE))
        ends_s = time.monotonic() + STARTS_S
        while len(list(self._folder.iterdir())) < len(self._loops):
            if time.monotonic() > ends_s:
                raise RuntimeError(f"the loops that watch for standstills: none in {STARTS_S:g} s")
            time.sleep(0.01)
        return self

    def __exit__(self, *_: object) -> None:
        for one in self._loops:
            one.kill()
            one.communicate()
        shutil.rmtree(self._folder)

    def _file(self, core: int, kind: str) -> str:
        return str(self._folder / f"{core}-{kind}")

    def longest(self, since_ns: int) -> Standstill:
        """The longest standstills from an instant of the monotonic clock until now."""
        time.sleep(SETTLES_S)
        found, in_a_row = dict.fromkeys(PERIOD_NS, 0), 0
        for file in self._folder.iterdir():
            kind = file.name.split("-", 1)[1]
            for line in file.read_text(encoding="utf-8").splitlines():
                ended_ns, stood_ns, late_ticks = map(int, line.split())
                if ended_ns >= since_ns:
                    found[kind] = max(found[kind], stood_ns)
                    in_a_row = max(in_a_row, late_ticks * (kind == REAL_TIME))
        return Standstill(found[REAL_TIME] * 1e-9, found[ORDINARY] * 1e-9, in_a_row)


def keep_deadlines(core: int, kind: str, file: Path) -> None:
    """Write down, until it is killed or orphaned, by how much each deadline was missed."""
    os.sched_setaffinity(0, {core})
    with ExitStack() as stack:
        if kind == REAL_TIME and stack.enter_context(hardened()).scheduler == "fifo":
            # Above the machine's processes: that they take the core from each other is their own
            # doing.
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY + 1))
        clock, parent = THIS_COMPUTER.clock, os.getppid()
        pace = DeadlineScheduler(PERIOD_NS[kind], clock.monotonic_ns())
        log = stack.enter_context(file.open("a", encoding="utf-8", buffering=1))
        late_ticks = 0
        while os.getppid() == parent:
            due_ns = pace.due_ns
            clock.sleep_until(due_ns)
            late_ticks = late_ticks + 1 if pace.begin(clock.monotonic_ns()) else 0
            late_ns = time.monotonic_ns() - due_ns
            if late_ns > TOLD_NS or late_ticks >= IN_A_ROW:
                log.write(f"{due_ns + late_ns} {late_ns} {late_ticks}\n")


if __name__ == "__main__":
    keep_deadlines(int(sys.argv[1]), sys.argv[2], Path(sys.argv[3]))
