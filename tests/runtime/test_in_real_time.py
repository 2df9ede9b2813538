"""This computer and a simulated one agree: the same tests hold with processes in real time."""

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.runtime import test_control_process, test_recorder_process, test_supervisor
from tests.runtime.machine_room import running
from tests.runtime.room import Room

pytestmark = pytest.mark.real_time


def test_ticks_come_by_the_clock() -> None:
    with running() as room:
        test_control_process.test_ticks_come_by_the_clock_and_what_is_missed_is_counted(room)


@pytest.mark.parametrize(
    ("begins", "test"),
    [
        (True, test_recorder_process.test_a_cycle_is_kept_whole_and_replays_to_the_last_bit),
        (True, test_recorder_process.test_of_a_controller_that_was_killed_everything_is_kept),
        (False, test_supervisor.test_what_stands_still_is_replaced_and_the_catheter_comes_out),
    ],
    ids=["a cycle and its recording", "the death of a controller", "a supervisor that replaces"],
)
def test_what_holds_on_a_simulated_computer_holds_on_this_one(
    begins: bool, test: Callable[[Room, Path], None], tmp_path: Path
) -> None:
    with running(begins) as room:
        test(room, tmp_path)
