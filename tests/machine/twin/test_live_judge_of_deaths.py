"""The judge beside processes that die: what it finds of a machine that runs."""

from collections.abc import Iterator

import pytest

from opensuction.kernel.vocabulary import RESTING
from opensuction.machine import port
from opensuction.machine.twin import twin_machine
from opensuction.machine.twin.live_judge import LiveJudge
from opensuction.oracle.harm import LEFT_INSIDE
from opensuction.safety.condition import Condition
from tests.controller.bedside import at_bed
from tests.runtime.room import INSIDE_MM, Room
from tests.runtime.simulated_room import simulated


@pytest.fixture
def room() -> Iterator[Room]:
    with simulated() as made:
        yield made


def follow(room: Room, witness: LiveJudge, seconds: float) -> None:
    room.wait(lambda: witness.look() < 0, seconds)


def killed_in_the_airway(room: Room, witness: LiveJudge) -> float:
    """The twin's time at which it was."""

    def is_inside() -> bool:
        witness.look()
        return room.truth("truth.tip_mm") > INSIDE_MM

    # The twin was there first, and its drives have said so: a person resets them once they listen.
    assert room.wait(lambda: room.truth("alone") == 0.0)
    room.press("reset")
    room.reach(is_inside)
    witness.look()
    at_s = witness.now_s
    room.stop()
    room.control = None
    return at_s


def cap_mm() -> float:
    return at_bed("neonate")[0].controller.limits.cap_mm


def test_a_controller_is_killed_in_the_airway_and_the_next_one_too_and_the_drives_say_so(
    room: Room,
) -> None:
    witness = LiveJudge(port.open_truth(room.folder), cap_mm())
    at_s = killed_in_the_airway(room, witness)
    follow(room, witness, 3.0)
    found = witness.verdict()
    assert not found.inside_at_end
    assert at_s - 0.1 < found.last_inside_s < at_s + 3.0
    drives = [one for one in found.told_since(at_s) if one.by == "drives"]
    fired = [one for one in drives if one.condition == Condition.WATCHDOG_FIRED]
    assert fired[0].at_s < at_s + 0.5
    room.begin()
    assert room.wait(lambda: witness.look() >= 0 and room.phase() in RESTING)
    assert room.wait(lambda: witness.look() >= 0 and room.truth("alone") == 0.0)
    room.press("reset")
    assert room.wait(lambda: witness.look() >= 0 and witness.verdict().showing == ())
    again_s = witness.now_s
    room.stop()
    room.control = None
    follow(room, witness, 1.0)
    found = witness.verdict()
    assert Condition.WATCHDOG_FIRED in [one.condition for one in found.told_since(again_s)]
    assert found.harm == ()
    assert found.missed_ticks == 0
    assert len([one for one in found.runs if one.borne.in_airway_s > 0.0]) == 1


def test_it_finds_the_catheter_that_drives_without_a_watchdog_leave_inside(room: Room) -> None:
    witness, side = (
        LiveJudge(port.open_truth(room.folder), cap_mm()),
        twin_machine.read_side(room.folder),
    )
    deaf = side.wiring.watchdog._replace(silence_s=1e9)
    twin_machine.change(
        room.folder, side._replace(wiring=side.wiring._replace(watchdog=deaf)), room.host
    )
    at_s = killed_in_the_airway(room, witness)
    follow(room, witness, 3.0)
    found = witness.verdict()
    assert found.inside_at_end
    assert LEFT_INSIDE in [one.name for one in found.harm]
    assert not [one for one in found.told_since(at_s) if one.condition == Condition.WATCHDOG_FIRED]
