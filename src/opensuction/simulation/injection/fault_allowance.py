"""What single faults add to the physical bounds of a run, each with its reason.

Some faults do harm before any sensor can show them, or leave no actuator that could prevent it. For
these a bound is higher by what physics makes unavoidable, as a number, and the higher bound is
checked as the common one is for all other faults.

It is not part of a fault's row: the rows say what happens to the machine, in the twin, and a bound
says what a patient may bear, which is for those to judge who check a trace.
"""

from collections.abc import Iterable
from enum import Enum
from typing import NamedTuple

from opensuction.twin.fault.fault import Fault


class PhysicalBound(Enum):
    """What is bounded, in the words of a report."""

    TIP = "tip within its cap"
    FORCE = "force on the carina"
    ADVANCE = "no advance of the tip under vacuum"
    SUCTION = "time of suction in the airway"
    AIRWAY = "time in the airway"
    VACUUM = "vacuum in the airway"


class Allowance(NamedTuple):
    """What a fault adds to a bound."""

    fault: Fault
    bound: PhysicalBound
    more: float
    """On top of the common bound, in its unit."""
    reason: str


UNDETECTED_CONTACT_N = 0.25
"""Contact is not reported: the tip presses until even the rearmost possible tip is 5 mm past the
carina, 15 mm of overlap at most. It buckles at 0.35 N at most (a neonate's short free end; 0.2 N in
an adult) and then adds 5 % of 0.1 N/mm (0.3): 0.43 N; the patient's and catheter's spread on top
[computed]."""
LIFTED_CARINA_N = 0.9
"""The carina itself comes up against a catheter that stands still: 60 mm of it are 0.2 N to buckle
and 5 % of 0.3 N/mm over the rest, 1.1 N in an adult [computed]. It is over when the catheter has
come out of it, and that begins with contact."""
REROUTED_MM = 9.0
"""A conduit that is moved within a cycle moves the catheter in it: by half of a gap of 26 mm at
most, narrowed to 0.3 of it [computed]."""
CAP_MARGIN_MM = 5.0
"""The cap is at least so far beyond where a cycle stops [design]."""
COAST_MM = 1.2
"""A drive that pushes the wrong way is detected by its travel, and then coasts against friction
alone: 1.7 mm in all with detection after 1 mm [in-silico]; it is 0.3 mm now."""
UNDETECTED_JUMP_MM = 1.0
"""A jump of the reading shows as speed, averaged over 10 ms: one of 0.85 mm or less stays below
1.25 times the fastest 62 mm/s, and the servo follows it [computed]; its overshoot on top."""
WHOLE_WAY_MM = 200.0
"""The whole way in: 100 mm outside the patient, and from there to the deepest cap of an adult."""

ALLOWANCES: tuple[Allowance, ...] = (
    Allowance(
        Fault.SWITCH_STUCK_OPEN,
        PhysicalBound.FORCE,
        UNDETECTED_CONTACT_N,
        "only the travel of the head shows that there must be contact",
    ),
    Allowance(
        Fault.SWITCH_STIFF,
        PhysicalBound.FORCE,
        UNDETECTED_CONTACT_N,
        "as a switch that never closes, where the catheter buckles before it does",
    ),
    Allowance(
        Fault.TUBE_DISPLACED,
        PhysicalBound.FORCE,
        LIFTED_CARINA_N,
        "the fault itself moves the carina into the tip, faster than any drive",
    ),
    Allowance(
        Fault.CONDUIT_REROUTED,
        PhysicalBound.FORCE,
        UNDETECTED_CONTACT_N,
        "moving the conduit pushes the catheter on before anything can be read of it",
    ),
    Allowance(
        Fault.CONDUIT_REROUTED,
        PhysicalBound.ADVANCE,
        REROUTED_MM,
        "as its force: no command moves the tip",
    ),
    Allowance(
        Fault.CONDUIT_REROUTED,
        PhysicalBound.TIP,
        REROUTED_MM - CAP_MARGIN_MM,
        "as its force; the cap allows for gaps of 0.7 to 1.3 of the identified one",
    ),
    Allowance(
        Fault.MOTOR_REVERSED,
        PhysicalBound.ADVANCE,
        COAST_MM,
        "the head must move before its encoder shows it, and coasts when its torque is off",
    ),
    Allowance(
        Fault.ENCODER_OFFSET,
        PhysicalBound.ADVANCE,
        UNDETECTED_JUMP_MM,
        "a small jump cannot be told from motion, and the servo corrects it",
    ),
    Allowance(
        Fault.ENCODER_JUMPING,
        PhysicalBound.ADVANCE,
        UNDETECTED_JUMP_MM,
        "as an offset; larger jumps show as speed",
    ),
    Allowance(
        Fault.VALVE_STUCK_OPEN,
        PhysicalBound.ADVANCE,
        WHOLE_WAY_MM,
        "a slide that leaves its seat by itself shows in the vacuum of the resting line within a "
        "second or two; through a thin catheter, open by less than a fifth, or where mucus blocks "
        "it, not before the next pre-use test, and the insertion goes on",
    ),
)


def raise_limit(bound: PhysicalBound, common: float, faults: Iterable[Fault]) -> float:
    """The bound that holds under these faults: the common one and the most that one of them adds.

    common: the bound without a fault.
    """
    came = tuple(faults)
    more = [one.more for one in ALLOWANCES if one.bound == bound and one.fault in came]
    return common + max(more, default=0.0)
