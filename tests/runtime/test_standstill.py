"""The loop stands still for as long as the drives wait: they bring the catheter out by themselves.

The host of this machine may take its processor away for 30 ms. The controller goes on then and
knows nothing of it, unlike one that has started anew.
"""

from collections.abc import Iterator
from pathlib import Path

import pytest

from opensuction.kernel.interface import ASSESSED, RESET, START
from opensuction.kernel.vocabulary import Phase
from opensuction.oracle import exposure, harm
from tests.controller.bedside import hurried
from tests.runtime.stepped_room import SteppedRoom

REST_S = 2.0
STILL_TICKS = 30
"""Of 1 ms; the drives wait for 20."""


@pytest.fixture
def room(tmp_path: Path) -> Iterator[SteppedRoom]:
    made = SteppedRoom(tmp_path, *hurried(REST_S))
    yield made
    made.close()


def is_alone(room: SteppedRoom) -> bool:
    """Whether the drives act on their own."""
    return bool(room.shown()["alone"][-1])


@pytest.mark.parametrize("phase", [Phase.INSERTING, Phase.SUCTIONING, Phase.WITHDRAWING])
def test_the_catheter_is_out_and_the_machine_of_use_again_once_a_person_has_reset_it(
    room: SteppedRoom, phase: Phase
) -> None:
    loop, _ = hurried(REST_S)
    room.step(START)
    while room.phase() != phase:
        room.step()
    room.run(0.3)
    room.step(skipped=STILL_TICKS)
    assert is_alone(room)
    room.run(10.0)
    assert room.phase() == Phase.HALTED
    assert is_alone(room)  # nobody has looked at it
    found = exposure.measure(loop.machine, room.shown())
    assert harm.find(loop.machine, found, loop.controller.limits.cap_mm) == ()
    room.step(RESET)
    room.run(0.01)
    assert not is_alone(room)
    room.run(5.0)
    room.step(RESET)  # once more, where it still had to come home
    room.run(REST_S + 0.1)
    room.step(ASSESSED)
    room.cycle()
    assert room.phase() == Phase.PARKED
    assert room.columns()["outputs.verdict.trips"][-1] == 0.0


def test_a_reset_in_the_midst_of_a_cycle_has_no_drive_obey_again(room: SteppedRoom) -> None:
    room.step(START)
    while room.phase() != Phase.INSERTING:
        room.step()
    room.run(0.3)
    room.step(RESET, skipped=STILL_TICKS)
    room.run(0.1)
    assert room.phase() != Phase.HALTED
    assert is_alone(room)
