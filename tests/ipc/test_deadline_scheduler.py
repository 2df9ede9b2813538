"""Ticks come by absolute deadlines; what is missed is skipped and counted."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from opensuction.host.this_computer import PRIORITY, THIS_COMPUTER
from opensuction.ipc.deadline_scheduler import DeadlineScheduler
from tests.runtime.timing import bare_loop

pytestmark = pytest.mark.real_time

PERIOD_NS = 2_000_000
PATIENCE_NS = 20_000_000
"""Of the drives: a loop that stands still for longer has lost them."""


CLOCK = THIS_COMPUTER.clock


def wait(pace: DeadlineScheduler) -> int:
    """Sleep until the next tick; how many were missed before it."""
    CLOCK.sleep_until(pace.due_ns)
    return pace.begin(CLOCK.monotonic_ns())


def test_deadlines_do_not_drift_with_the_work_between_them() -> None:
    pace = DeadlineScheduler(PERIOD_NS, CLOCK.monotonic_ns())
    begun = pace.deadline_ns
    for _ in range(100):
        wait(pace)
        assert time.monotonic_ns() >= pace.deadline_ns
        ends = time.monotonic_ns() + PERIOD_NS // 3
        while time.monotonic_ns() < ends:
            pass
    assert pace.deadline_ns == begun + (100 + pace.skipped) * PERIOD_NS


def test_a_missed_tick_is_skipped_and_never_caught_up() -> None:
    pace = DeadlineScheduler(PERIOD_NS, CLOCK.monotonic_ns())
    wait(pace)
    before_ns = pace.deadline_ns
    time.sleep(0.0255)
    missed = wait(pace)
    assert missed >= 11
    assert pace.deadline_ns == before_ns + (1 + missed) * PERIOD_NS
    assert pace.skipped >= missed
    # The next one is a period later, not at once.
    begun_ns = time.monotonic_ns()
    wait(pace)
    wait(pace)
    assert time.monotonic_ns() - begun_ns > PERIOD_NS


def test_a_signal_does_not_wake_it_early() -> None:
    code = (
        "import signal, time\n"
        "from opensuction.host.this_computer import THIS_COMPUTER\n"
        "heard = []\n"
        "signal.signal(signal.SIGALRM, lambda *_: heard.append(1))\n"
        "signal.setitimer(signal.ITIMER_REAL, 0.02, 0.02)\n"
        "for _ in range(5):\n"
        "    due_ns = time.monotonic_ns() + 100_000_000\n"
        "    THIS_COMPUTER.clock.sleep_until(due_ns)\n"
        "    assert time.monotonic_ns() >= due_ns\n"
        "assert heard\n"
        # An interpreter that ends no longer hears it, and would be killed by it.
        "signal.setitimer(signal.ITIMER_REAL, 0)\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_what_the_kernel_does_not_grant_is_said() -> None:
    """As a user without rights: no priority, and a limit of locked memory that is too small."""
    code = (
        "import gc, os, resource\n"
        "from opensuction.host.this_computer import hardened\n"
        "resource.setrlimit(resource.RLIMIT_MEMLOCK, (0, 0))\n"
        "resource.setrlimit(resource.RLIMIT_RTPRIO, (0, 0))\n"
        "if os.getuid() == 0: os.setuid(65534)\n"
        "with hardened() as allowed:\n"
        "    print(allowed, gc.isenabled())\n"
    )
    run = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert "scheduler='other', memory_locked=False" in run.stdout
    assert "no real-time priority (Operation not permitted)" in run.stdout
    assert "memory is not locked" in run.stdout
    assert run.stdout.endswith("False\n")


def test_only_the_loop_itself_has_the_priority_not_what_comes_before_and_after() -> None:
    """Locked memory takes many ticks to come, and so does the end of an interpreter."""
    code = (
        "import os\n"
        "from opensuction.host import this_computer\n"
        "class Libc:\n"
        "    def mlockall(self, _):\n"
        "        done.append('locked')\n"
        "        return 0\n"
        "done, this_computer._libc = [], Libc()\n"
        "os.sched_setscheduler = lambda _, kind, param: done.append((kind, param.sched_priority))\n"
        "try:\n"
        "    with this_computer.hardened():\n"
        "        done.append('loop')\n"
        "        raise KeyError\n"
        "except KeyError:\n"
        "    fifo = (os.SCHED_FIFO, this_computer.PRIORITY)\n"
        "    assert done == ['locked', fifo, 'loop', (os.SCHED_OTHER, 0)], done\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_process_that_begins_and_ends_does_not_keep_the_loop_of_another_standing(
    tmp_path: Path,
) -> None:
    """Both on one core, where neither can pass by the other."""
    if subprocess.run(["chrt", "-f", str(PRIORITY), "true"], check=False).returncode:
        pytest.skip("no real-time priority here: nobody can keep others standing")
    code = (
        "import atexit, time\n"
        "from opensuction.host.this_computer import hardened\n"
        "def end():\n"
        "    ends = time.monotonic() + 0.1\n"
        "    while time.monotonic() < ends:\n"
        "        pass\n"
        "atexit.register(end)\n"
        "memory = bytearray(1 << 29)\n"
        "with hardened():\n"
        "    pass\n"
    )
    core, told = {min(os.sched_getaffinity(0))}, tmp_path / "bare.json"
    command = [sys.executable, bare_loop.__file__, str(told), str(PATIENCE_NS)]
    pinned = ["taskset", "-c", str(*core)]
    loop = subprocess.Popen([*pinned, *command])
    try:
        while os.sched_getscheduler(loop.pid) != os.SCHED_FIFO:
            assert loop.poll() is None
            time.sleep(0.01)
        for _ in range(3):
            subprocess.run([*pinned, sys.executable, "-c", code], check=True)
        loop.terminate()
        assert loop.wait(10.0) == 0
    finally:
        loop.kill()
        loop.wait()
    found = json.loads(told.read_text(encoding="utf-8"))
    assert found["ticks"] > 10
    assert found["missed"] == 0
