"""Physical bounds that a fault states for itself, each with its reason.

Some faults do their harm before anything can be read of it, or leave nothing that could be moved:
there the patient is spared what physics allows, and that is a number, too. A bound stays a bound:
it is checked for that fault as the common one is for all others.
"""

from collections.abc import Iterable
from enum import Enum
from typing import NamedTuple

from opensuction.twin.fault import Fault


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


STATED: tuple[Stated, ...] = ()
"""All of them."""


def allowed(bound: Bound, common: float, faults: Iterable[Fault]) -> float:
    """The bound that holds under these faults: the common one and the most that one of them adds.

    common: where no fault states another.
    """
    came = tuple(faults)
    more = [one.more for one in STATED if one.bound == bound and one.fault in came]
    return common + max(more, default=0.0)
