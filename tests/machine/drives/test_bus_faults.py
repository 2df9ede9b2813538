"""Faults of machine, sensors, line and patient in a cycle over the bus, judged by the oracle.

Each comes as a phase begins and in its middle, at its usual strength and its greatest. What a fault
makes unavoidable is allowed as in the safety case. A cycle on a newborn is played once to know its
phases, and again; at each instant a copy goes on by itself.
"""

from functools import partial
from pathlib import Path
from typing import NamedTuple

import pytest

from opensuction.evidence.campaign import sound_machine
from opensuction.kernel.codegen import plain_row
from opensuction.kernel.interface import Readings
from opensuction.kernel.vocabulary import RESTING, Phase
from opensuction.machine.twin.twin_machine import SHOWN_READINGS
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.injection import run_judgement
from opensuction.simulation.injection.fault_instant import (
    AT_START,
    FaultySide,
    Injection,
    Instant,
)
from opensuction.simulation.injection.injection import Injected
from opensuction.simulation.machine_side import MachineSide
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_row import LinkEffect
from opensuction.twin.fault.fault_table import ROWS
from tests.machine.drives.bus_room import BusRoom, branch
from tests.machine.drives.test_bus_cycle import prepared
from tests.machine.drives.test_bus_kill import INSIDE, NEWBORN, phases, play

pytestmark = pytest.mark.soak

PERIOD = 4
WATCHED_S = 60.0
"""No cycle of a newborn lasts longer."""
AFTER_S = 5.0
STAYS = {
    Fault.MOTOR_REVERSED: "the drive's own servo pushes the wrong way, and is switched off",
    Fault.ENCODER_REVERSED: "the same, until the drive is beyond its following error",
    Fault.ENCODER_INVALID: "a drive without an encoder has no torque",
    Fault.ENCODER_INTERMITTENT: "a drive without an encoder has no torque",
    Fault.CURRENT_NOISY: "a drive that measures ten times its rated current has no torque",
    Fault.CARRIAGE_DRIFTING: "the vote goes by our servo's volts, which the drive does not have",
}
"""Faults of which it is known that the catheter stays inside though the controller of a drive
without a servo of its own brings it out. A person is told."""
FAULTS = [
    fault
    for fault, row in ROWS.items()
    if not row.is_setup and not isinstance(row.effect, LinkEffect)
]
"""Those of the link between controller and machine the bus has in its own way: `test_bus_kill`."""


class End(NamedTuple):
    """What came of a fault."""

    fault: str
    phase: str
    strength: float
    breaches: tuple[str, ...]
    """Bounds that were broken beyond what the fault makes unavoidable."""
    told: bool
    """People were told with high priority within a patient's time in the airway."""


def strengths(fault: Fault) -> list[float]:
    """The usual one, and the greatest."""
    row = ROWS[fault]
    if row.strength is None:
        return [row.default_strength]
    return sorted({row.default_strength, sound_machine.find_strength(fault, 1.0)})


def break_twin(room: BusRoom, one: Injection) -> End:
    """A fault comes; on it goes until the machine has rested for a while."""
    call, began, phase = room.machine.call, len(room.machine.shown), room.phase()
    sound = plain_row.unpack(MachineSide, call.side_row)
    side = FaultySide(sound.machine, sound.wiring.link, seed=1)
    readings = plain_row.unpack(Readings, call.shown_row[SHOWN_READINGS])
    side.inject(one, Instant(began, began), readings)
    left, is_new = round(WATCHED_S / (PERIOD * DT_S)), True
    while left > 0:
        if side.next_done is not None and side.next_done <= len(room.machine.shown):
            side.follow(len(room.machine.shown))
            is_new = True
        if is_new:
            wiring = sound.wiring._replace(link=side.link)
            played = sound._replace(machine=side.machine, wiring=wiring)
            call.side_row[:] = plain_row.pack(MachineSide, played)
            is_new = False
        room.step()
        left -= 1
        if room.phase() in RESTING:
            left = min(left, round(AFTER_S / (PERIOD * DT_S)))
    loop = prepared(NEWBORN).loop
    judged = run_judgement.judge(
        loop.machine,
        loop.controller.limits.cap_mm,
        room.shown(),
        [Injected(one, began * DT_S, None)],
    )
    breaches = tuple(f"{each.name} {each.worst:.3g}" for each in judged.breaches)
    is_told = judged.left_inside is not None and judged.left_inside.in_time
    return End(one.fault.title, phase.name.lower(), one.strength, breaches, is_told)


@pytest.mark.parametrize("place", ["begin", "middle"])
@pytest.mark.parametrize("phase", INSIDE, ids=lambda phase: phase.name.lower())
def test_no_fault_breaks_a_bound_over_the_bus_that_it_need_not(
    tmp_path: Path, phase: Phase, place: str
) -> None:
    first, after = phases(PERIOD)[phase]
    at = first + 1 if place == "begin" else (first + after) // 2
    for number, room in play(tmp_path, PERIOD):
        if number == at:
            ends = [
                branch(partial(break_twin, room, Injection(fault, AT_START, strength)))
                for fault in FAULTS
                for strength in strengths(fault)
            ]
            break
    else:
        pytest.fail("the cycle is over before that")
    room.close()
    assert len(ends) > len(FAULTS)
    known = {fault.title for fault in STAYS}
    assert [end for end in ends if end.breaches and end.fault not in known] == []
    assert [end for end in ends if end.breaches and not end.told] == []
