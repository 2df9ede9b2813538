"""This computer and a simulated one agree: the same tests hold with processes in real time."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.runtime import test_control_process, test_recorder_process, test_supervisor
from tests.runtime.machine_room import running
from tests.runtime.room import Room

pytestmark = pytest.mark.real_time


@pytest.mark.soak
def test_a_supervisor_replaces_what_stands_still(tmp_path: Path) -> None:
    """In `.ci/run` one replaces a controller that died: `test_kills`."""
    with running(begins=False) as room:
        test_supervisor.test_what_stands_still_is_replaced_and_the_catheter_comes_out(
            room, tmp_path
        )


@pytest.fixture(scope="module")
def room() -> Iterator[Room]:
    with running() as made:
        yield made


def test_ticks_come_by_the_clock(room: Room) -> None:
    test_control_process.test_ticks_come_by_the_clock_and_what_is_missed_is_counted(room)


@pytest.mark.soak
def test_a_cycle_is_kept_whole(room: Room, tmp_path: Path) -> None:
    """In `make test` `cli/test_run.py` looks at the recording of a cycle that was run."""
    test_recorder_process.test_a_cycle_is_kept_whole_and_replays_to_the_last_bit(room, tmp_path)


@pytest.mark.soak
def test_of_a_controller_that_was_killed_everything_is_kept(room: Room, tmp_path: Path) -> None:
    """In `make test` `test_kills` looks at the record after such a death, too."""
    test_recorder_process.test_of_a_controller_that_was_killed_everything_is_kept(room, tmp_path)
