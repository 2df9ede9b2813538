"""Ticks come by absolute deadlines; what is missed is skipped and counted."""

import subprocess
import sys
import time

import pytest

from opensuction.ipc.deadline_scheduler import DeadlineScheduler

pytestmark = pytest.mark.real_time

PERIOD_NS = 2_000_000


def test_deadlines_do_not_drift_with_the_work_between_them() -> None:
    pace = DeadlineScheduler(PERIOD_NS)
    begun = pace.deadline_ns
    for _ in range(100):
        pace.wait()
        assert time.monotonic_ns() >= pace.deadline_ns
        ends = time.monotonic_ns() + PERIOD_NS // 3
        while time.monotonic_ns() < ends:
            pass
    assert pace.deadline_ns == begun + (100 + pace.skipped) * PERIOD_NS


def test_a_missed_tick_is_skipped_and_never_caught_up() -> None:
    pace = DeadlineScheduler(PERIOD_NS)
    pace.wait()
    before_ns = pace.deadline_ns
    time.sleep(0.0255)
    missed = pace.wait()
    assert missed >= 11
    assert pace.deadline_ns == before_ns + (1 + missed) * PERIOD_NS
    assert pace.skipped >= missed
    # The next one is a period later, not at once.
    begun_ns = time.monotonic_ns()
    pace.wait()
    pace.wait()
    assert time.monotonic_ns() - begun_ns > PERIOD_NS


def test_a_signal_does_not_wake_it_early() -> None:
    code = (
        "import signal, time\n"
        "from opensuction.ipc.deadline_scheduler import DeadlineScheduler\n"
        "heard = []\n"
        "signal.signal(signal.SIGALRM, lambda *_: heard.append(1))\n"
        "signal.setitimer(signal.ITIMER_REAL, 0.02, 0.02)\n"
        "pace = DeadlineScheduler(100_000_000)\n"
        "for _ in range(5):\n"
        "    pace.wait()\n"
        "    assert time.monotonic_ns() >= pace.deadline_ns\n"
        "assert heard\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_what_the_kernel_does_not_grant_is_said() -> None:
    """As a user without rights: no priority, and a limit of locked memory that is too small."""
    code = (
        "import gc, os, resource\n"
        "from opensuction.ipc.deadline_scheduler import harden\n"
        "resource.setrlimit(resource.RLIMIT_MEMLOCK, (0, 0))\n"
        "resource.setrlimit(resource.RLIMIT_RTPRIO, (0, 0))\n"
        "if os.getuid() == 0: os.setuid(65534)\n"
        "print(harden(), gc.isenabled())\n"
    )
    run = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert "scheduler='other', memory_locked=False" in run.stdout
    assert "no real-time priority (Operation not permitted)" in run.stdout
    assert "memory is not locked" in run.stdout
    assert run.stdout.endswith("False\n")
