"""A process that is starting is waited for, not for ever; one that has worked is lost at once."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from opensuction.host.host import NS_PER_S
from opensuction.host.this_computer import THIS_COMPUTER
from opensuction.ipc.liveness import Heartbeat, Process, Signs
from opensuction.kernel.interface import START
from opensuction.kernel.vocabulary import Phase
from opensuction.runtime.loop import LOOK_S, LOST_S, MISSED_S, ROW_COLUMNS, STARTS_S, is_lost
from opensuction.runtime.machine_folder import SLOTS_S
from opensuction.safety.condition import Condition
from opensuction.safety.handling import UNANSWERED_S
from tests.controller.bedside import at_bed
from tests.runtime.stepped_room import SteppedRoom

NEVER = float("inf")
LONG_S = 3600.0
JUST_S = 1e-3
BOTH = (Process.RECORDER, Process.KEEPING)
CONDITIONS, PRESENT = (
    ROW_COLUMNS.index(name) for name in ("inputs.host.conditions", "outputs.signals.present")
)
ALIVE = Signs(is_expected=True, age_s=0.0, deaths=0, starting_s=None)
STARTING = Signs(is_expected=False, age_s=NEVER, deaths=0, starting_s=0.0)


@pytest.mark.parametrize(
    ("signs", "running_s", "lost"),
    [
        (ALIVE, LONG_S, False),
        (ALIVE._replace(age_s=MISSED_S), LONG_S, False),
        (ALIVE._replace(age_s=MISSED_S + JUST_S), LONG_S, True),
        # A controller that has just begun misses one that is dead as fast.
        (ALIVE._replace(age_s=MISSED_S + JUST_S), 0.0, True),
        (ALIVE._replace(deaths=1), LONG_S, True),
        (ALIVE._replace(is_expected=False, age_s=NEVER), LONG_S, False),
        (STARTING._replace(starting_s=STARTS_S), LONG_S, False),
        (STARTING._replace(starting_s=STARTS_S + JUST_S), LONG_S, True),
        # There are no rows to lose before the controller's first.
        (STARTING._replace(starting_s=LONG_S), STARTS_S, False),
        (STARTING._replace(starting_s=LONG_S), STARTS_S + JUST_S, True),
        # It has given a sign, and is still preparing.
        (ALIVE._replace(age_s=STARTS_S, starting_s=STARTS_S), LONG_S, False),
        (ALIVE._replace(age_s=STARTS_S, starting_s=STARTS_S + JUST_S), LONG_S, True),
        # A death is told whatever its successor does.
        (STARTING._replace(deaths=1), 0.0, True),
    ],
)
def test_each_bound_from_both_sides(signs: Signs, running_s: float, lost: bool) -> None:
    assert is_lost(signs, 0, running_s) is lost


def test_people_are_told_before_the_ring_has_come_round() -> None:
    assert STARTS_S + UNANSWERED_S < SLOTS_S


class TickedRoom(SteppedRoom):
    """Whose signs of life go by the loop's ticks."""

    def __init__(self, folder: Path) -> None:
        host = THIS_COMPUTER._replace(clock=self)
        super().__init__(folder, *at_bed("neonate"), host=host)
        self.signs = Heartbeat(folder, host)

    def wall_ns(self) -> int:
        """See `Clock.wall_ns`."""
        return self.monotonic_ns()

    def sleep_until(self, due_ns: int) -> None:
        """See `Clock.sleep_until`: time goes by the ticks alone."""
        raise NotImplementedError

    def monotonic_ns(self) -> int:
        """See `Clock.monotonic_ns`."""
        return round((1.0 + (self.loop.tick if hasattr(self, "loop") else 0) * 1e-3) * NS_PER_S)

    def is_lost(self) -> bool:
        return int(self.rows[-1][CONDITIONS]) >> Condition.RECORDER_LOST & 1 == 1

    def is_told(self) -> bool:
        return int(self.rows[-1][PRESENT]) >> Condition.RECORDER_LOST & 1 == 1

    def run_beaten(self, seconds: float) -> None:
        """With a recorder that gives signs of life, and works."""
        for _ in range(round(seconds / LOOK_S)):
            for process in BOTH:
                self.signs.beat(process)
                self.signs.work(process)
            self.run(LOOK_S)


@pytest.fixture
def room(tmp_path: Path) -> Iterator[TickedRoom]:
    made = TickedRoom(tmp_path)
    yield made
    made.close()


def start(room: TickedRoom) -> None:
    """What whoever starts the recorder notes."""
    for process in BOTH:
        room.signs.start(process)


def test_a_recorder_that_takes_long_to_start_is_not_told_as_lost(room: TickedRoom) -> None:
    start(room)
    room.run(1.0)
    room.signs.begin(Process.RECORDER)
    room.signs.beat(Process.KEEPING)
    room.run(STARTS_S - 2.0)  # it prepares, and gives no sign
    room.run_beaten(5.0)
    assert not any(int(row[CONDITIONS]) for row in room.rows)


def test_one_that_has_worked_and_falls_silent_is_told_as_fast_as_ever(room: TickedRoom) -> None:
    start(room)
    room.run_beaten(1.0)
    room.run(MISSED_S + LOOK_S)
    assert room.is_lost()
    assert not room.is_told()
    room.run(UNANSWERED_S)
    assert room.is_told()


def test_one_that_never_comes_is_told_before_the_first_row_is_gone(room: TickedRoom) -> None:
    start(room)
    room.run(STARTS_S)
    assert not room.is_lost()
    room.run(2.0 * LOOK_S)
    assert room.is_lost()
    room.run(UNANSWERED_S)
    assert room.is_told()
    assert room.loop.tick * 1e-3 < SLOTS_S


def test_a_cycle_may_be_started_meanwhile_and_goes_on_when_none_comes(room: TickedRoom) -> None:
    start(room)
    room.step(START)
    room.run(STARTS_S + UNANSWERED_S + 2.0 * LOOK_S)
    assert room.is_told()
    assert room.phase() not in (Phase.PARKED, Phase.HALTED)


def test_one_that_is_killed_stays_lost_until_another_one_lives(room: TickedRoom) -> None:
    start(room)
    room.run_beaten(1.0)
    room.run(MISSED_S + LOOK_S)
    start(room)  # the next one is started, and takes long
    room.run(STARTS_S - LOOK_S)
    assert room.is_lost()
    room.signs.begin(Process.RECORDER)
    room.run(LOOK_S)
    assert room.is_lost()
    room.run_beaten(LOST_S + 2.0 * LOOK_S)
    assert not room.is_lost()


def test_one_that_dies_while_it_prepares_is_told_as_one_that_has_died(room: TickedRoom) -> None:
    start(room)
    room.signs.begin(Process.RECORDER)
    room.run(1.0)
    assert not room.is_lost()
    start(room)
    room.run(LOOK_S)
    assert room.is_lost()


def test_one_that_keeps_nothing_from_the_start_is_told(room: TickedRoom) -> None:
    start(room)
    for _ in range(round((STARTS_S + 2.0 * LOOK_S) / LOOK_S)):
        room.signs.beat(Process.RECORDER)
        room.signs.work(Process.RECORDER)
        room.signs.work(Process.KEEPING)  # it has never kept anything
        room.run(LOOK_S)
    assert room.is_lost()
