"""The loops beside the tests see for how long the computer keeps a process standing."""

import os
import signal
import time

import pytest

from tests.stage.judge import Standstill
from tests.stage.standstill import StandstillWatch

# Only the standstill that is made here is asked for, and from below.
pytestmark = pytest.mark.real_time


def test_a_loop_that_was_kept_standing_is_told_with_its_time_and_forgotten_afterwards() -> None:
    with StandstillWatch() as watch:
        begun_ns = time.monotonic_ns()
        loops = [one.pid for one in watch._loops]
        for pid in loops:
            os.kill(pid, signal.SIGSTOP)
        time.sleep(0.7)
        for pid in loops:
            os.kill(pid, signal.SIGCONT)
        found = watch.longest(begun_ns)
        assert min(found) > 0.65
        assert max(watch.longest(time.monotonic_ns())) < 0.65


def test_nothing_is_left_of_the_loops() -> None:
    with StandstillWatch() as watch:
        folder, loops = watch._folder, list(watch._loops)
        assert isinstance(watch.longest(time.monotonic_ns()), Standstill)
    assert not folder.exists()
    assert all(one.returncode is not None for one in loops)
