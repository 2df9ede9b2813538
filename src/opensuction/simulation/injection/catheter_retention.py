"""A catheter that stays in the airway: when the fault's own nature makes that unavoidable.

It is an outcome of its own, and never a safe state. Unavoidable it is only where the faults take
every actuator that could bring it out; then a person must be told at once, with high priority, and
do what no drive can. Whether a drive is taken is a matter of physics: of the faulty machine's own
parameters, not of a list of names.
"""

from collections.abc import Sequence
from typing import NamedTuple

from opensuction.safety.priority import Priority
from opensuction.simulation.annunciation import Annunciation
from opensuction.simulation.injection.fault_instant import Injection
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_row import MachineEffect
from opensuction.twin.fault.fault_table import ROWS
from opensuction.twin.fault.fault_time import BY_TURNS
from opensuction.twin.machine.machine import Machine

GONE_S = 4.0
"""[design] A drive that has no force for so long is gone: a neonate's withdrawal may take 5 s in
all, and one that starts again later would pull against the hand that has been called."""
SPARE_SHARE = 0.01
"""Share of its force that a drive must have to spare: with less, 0.04 N for 16 kg, a catheter that
it pulls creeps by less than 1 mm/s after 0.4 s and cannot be told from one that is held fast, on
which nothing may go on pulling [computed]."""
PARTED_MM = 1000.0
"""More play than any rack is long: the head does not follow the motor."""


class Unavoidable(NamedTuple):
    """Reason why nothing of the machine can bring a catheter out, and the remedy by a person."""

    reason: str
    person: str


HELD = Unavoidable(
    "the insertion motor's whole force does not overcome what holds the catheter's head",
    "Draw the catheter out by hand, at the head's handle; cut it off its clamp if it is held fast.",
)
PARTED = Unavoidable(
    "the gear has parted: what the motor does no longer reaches the catheter's head",
    "Draw the catheter out by hand: the head moves freely.",
)
POWERLESS = Unavoidable(
    "neither mains nor reserve energy is left to move anything",
    "Draw the catheter out by hand: the head moves freely, and suction is off.",
)
SLIPPED = Unavoidable(
    "the clamp slips: with its head at home the catheter has not come out as far as it went in",
    "Draw the catheter out by hand, beyond the clamp; do not use this clamp again.",
)
LOOSE = Unavoidable(
    "the tip has parted from the catheter: nothing of the machine reaches it",
    "Call for a bronchoscopy: the tip lies in the airway and must be taken out with forceps.",
)


def _find_of_machine(machine: Machine) -> Unavoidable | None:
    axis = machine.insertion_axis
    if (1.0 - SPARE_SHARE) * axis.force_v <= axis.friction_v:
        return HELD
    if machine.gear_backlash_mm > PARTED_MM:
        return PARTED
    return SLIPPED if machine.clamp_slip_ratio > 0.0 else None


def find_unavoidable(machine: Machine, came: Sequence[Injection]) -> Unavoidable | None:
    """Reason why a catheter must stay inside under these faults; None where it could be moved.

    machine: as it was built, before any fault. came: the faults whose instant came.
    """
    for one in came:
        row = ROWS[one.fault]
        if one.fault == Fault.POWER_LOST_WITHOUT_RESERVE:
            return POWERLESS
        if one.fault == Fault.TIP_LEFT_BEHIND:
            return LOOSE
        gone = row.course == BY_TURNS and one.strength >= GONE_S
        if isinstance(row.effect, MachineEffect) and (row.course is None or gone):  # else it passes
            machine = row.change_machine(machine, one.strength)
    return _find_of_machine(machine)


def told_s(told: Sequence[Annunciation], from_s: float) -> float:
    """Time of the first alarm of high priority, from an instant on; nan where there was none."""
    high = [
        one.at_s
        for one in told
        if one.at_s >= from_s and one.condition.row.handling.priority == Priority.HIGH
    ]
    return min(high, default=float("nan"))
