"""The loops beside the tests see for how long the computer keeps a process standing."""

import os
import signal
import time

import pytest

from tests.stage.judge import Premise, Standstill
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
        assert min(found[:2]) > 0.65
        assert max(watch.longest(time.monotonic_ns())[:2]) < 0.65


def test_slices_none_of_which_is_long_are_told_by_how_many_ticks_are_late_in_a_row() -> None:
    with StandstillWatch() as watch:
        begun_ns = time.monotonic_ns()
        loops = [one.pid for one in watch._loops]
        for _ in range(100):
            for pid in loops:
                os.kill(pid, signal.SIGSTOP)
            time.sleep(0.003)
            for pid in loops:
                os.kill(pid, signal.SIGCONT)
            time.sleep(0.0002)
        found = watch.longest(begun_ns)
        assert found.late_ticks > Premise().late_ticks
        assert "ticks in a row" in Premise().breach(found)


def test_nothing_is_left_of_the_loops() -> None:
    with StandstillWatch() as watch:
        folder, loops = watch._folder, list(watch._loops)
        assert isinstance(watch.longest(time.monotonic_ns()), Standstill)
    assert not folder.exists()
    assert all(one.returncode is not None for one in loops)
