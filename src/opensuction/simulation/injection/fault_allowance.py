"""Physical bounds that a fault states for itself, each with its reason.

Some faults do their harm before anything can be read of it, or leave nothing that could be moved:
there the patient is spared what physics allows, and that is a number, too. A bound stays a bound:
it is checked for that fault as the common one is for all others.
"""

from collections.abc import Iterable
from enum import Enum
from typing import NamedTuple

from opensuction.twin.fault.fault import Fault


class Bound(Enum):
    """What is bounded, in the words of a report."""

    TIP = "tip within its cap"
    FORCE = "force on the carina"
    ADVANCE = "no advance of the tip under vacuum"
    SUCTION = "time of suction in the airway"
    AIRWAY = "time in the airway"
    VACUUM = "vacuum in the airway"


class Stated(NamedTuple):
    """What a fault adds to a bound."""

    fault: Fault
    bound: Bound
    more: float
    """On top of the common bound, in its unit; infinite where nothing bounds it."""
    because: str


PRESSED_UNTOLD_N = 0.25
"""No contact is told: the tip presses until even the rearmost possible tip is 5 mm past the carina,
15 mm of overlap at most. It buckles at 0.35 N at most (a neonate's short free end; 0.2 N in an
adult) and then adds 5 % of 0.1 N/mm (0.3): 0.43 N; the patient's and catheter's spread on top
[computed]."""
LIFTED_N = 0.9
"""The carina itself comes up against a catheter that stands still: 60 mm of it are 0.2 N to buckle
and 5 % of 0.3 N/mm over the rest, 1.1 N in an adult [computed]. It is over when the catheter has
come out of it, and that begins with contact."""
LAID_MM = 9.0
"""A conduit that is laid otherwise in mid-cycle moves the catheter in it: half of a gap of 26 mm
at most, narrowed to 0.3 of it [computed]."""
CAP_MARGIN_MM = 5.0
"""The cap is at least so far beyond where a cycle stops [design]."""
COAST_MM = 1.2
"""A drive that pushes the wrong way is told by its travel, and what speed it has gained by then it
loses against friction alone: 1.7 mm in all where 1 mm told it [in-silico]. Now 0.3 mm does."""
UNTOLD_JUMP_MM = 1.0
"""A jump of the reading shows as speed, averaged over 10 ms: one of 0.85 mm or less stays below
1.25 times the fastest 62 mm/s, and the servo follows it [computed]; its overshoot on top."""
WHOLE_WAY_MM = 200.0
"""The whole way in: 100 mm outside the patient, and from there to the deepest cap of an adult."""

STATED: tuple[Stated, ...] = (
    Stated(
        Fault.SWITCH_STUCK_OPEN,
        Bound.FORCE,
        PRESSED_UNTOLD_N,
        "only the way that the head has gone tells that contact must have come",
    ),
    Stated(
        Fault.SWITCH_STIFF,
        Bound.FORCE,
        PRESSED_UNTOLD_N,
        "as a switch that never closes, where the catheter buckles before it does",
    ),
    Stated(
        Fault.TUBE_DISPLACED,
        Bound.FORCE,
        LIFTED_N,
        "the fault itself moves the carina into the tip, faster than any drive",
    ),
    Stated(
        Fault.CONDUIT_REROUTED,
        Bound.FORCE,
        PRESSED_UNTOLD_N,
        "the catheter is pushed on by whoever lays the conduit, before anything is read",
    ),
    Stated(
        Fault.CONDUIT_REROUTED, Bound.ADVANCE, LAID_MM, "as its force: no command moves the tip"
    ),
    Stated(
        Fault.CONDUIT_REROUTED,
        Bound.TIP,
        LAID_MM - CAP_MARGIN_MM,
        "as its force; the cap allows for gaps of 0.7 to 1.3 of the identified one",
    ),
    Stated(
        Fault.MOTOR_REVERSED,
        Bound.ADVANCE,
        COAST_MM,
        "the head must have moved for its encoder to tell, and coasts when its torque is off",
    ),
    Stated(
        Fault.ENCODER_OFFSET,
        Bound.ADVANCE,
        UNTOLD_JUMP_MM,
        "a small jump is no different from motion, and the servo takes it back",
    ),
    Stated(
        Fault.ENCODER_JUMPING,
        Bound.ADVANCE,
        UNTOLD_JUMP_MM,
        "as an offset; larger jumps are told by their speed",
    ),
    Stated(
        Fault.VALVE_STUCK_OPEN,
        Bound.ADVANCE,
        WHOLE_WAY_MM,
        "a slide that leaves its seat by itself shows in the vacuum of the resting line within a "
        "second or two; through a thin catheter, open by less than a fifth, or where mucus blocks "
        "it, not before the next pre-use test, and the insertion goes on",
    ),
)
"""All of them."""


def allowed(bound: Bound, common: float, faults: Iterable[Fault]) -> float:
    """The bound that holds under these faults: the common one and the most that one of them adds.

    common: where no fault states another.
    """
    came = tuple(faults)
    more = [one.more for one in STATED if one.bound == bound and one.fault in came]
    return common + max(more, default=0.0)
