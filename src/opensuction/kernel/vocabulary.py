"""Phases of a suction cycle: the words that procedure, trace, reports and console share.

Where each phase may go is a table of its own: `opensuction.procedure.cycle.transition`.

Age groups of patients: limits of suctioning differ between them.

Members of enumerations as files, the command line and people read them.

Meaning of a setting beside its type and range, for the documentation.

Disclaimer of every page, report, file and command of this software.
"""

from enum import Enum, IntEnum
from typing import Final, NamedTuple, TypeVar

NOT_A_DEVICE: Final = "Research software, not a medical device: not for use on people or animals."


class Meaning(NamedTuple):
    """Annotation of a field: ``Annotated[float, Gt(0), Meaning("...")]``."""

    text: str


Member = TypeVar("Member", bound=Enum)


def name_of(member: Enum) -> str:
    """``CATHETER_JAMMED`` is ``catheter-jammed``."""
    return member.name.lower().replace("_", "-")


def by_name(enumeration: type[Member]) -> dict[str, Member]:
    """Its members by those names, aliases by theirs."""
    members = enumeration.__members__.items()
    return {name.lower().replace("_", "-"): member for name, member in members}


class AgeGroup(IntEnum):
    """Age group of the patient, as guidelines divide them; stored in recordings: never renumber."""

    NEONATE = 0
    CHILD = 1
    """Infants and children."""
    ADULT = 2


class Phase(IntEnum):
    """Phase of the machine. Gerunds; the numbers are stored in recordings: never renumber."""

    PARKED = 0
    """Tip out of the patient, valve closed, ready."""
    CHECKING = 1
    """Pre-use test of sensors, valve and pump."""
    PRELOADING = 2
    """Head takes up the gap of the transmission; the tip stands still."""
    INSERTING = 3
    """Tip advances to its stopping point, valve closed."""
    BACKING_OFF = 4
    """Tip leaves the carina after contact, before suction."""
    OPENING = 5
    """Cam opens the suction valve (point A to A' of the paper's Fig. 2)."""
    SUCTIONING = 6
    """Dwell with the valve open (A' to B)."""
    WITHDRAWING = 7
    """Tip moves out with the valve open (B to C)."""
    CLOSING = 8
    """Spring closes the valve (C to D)."""
    ABORTING = 9
    """Out of the airway first, suction as the fault allows."""
    HALTED = 10
    """Stopped and latched until a person resets."""
    TEACHING = 11
    """A person moves the catheter to measure the travel length."""
    IDENTIFYING = 12
    """Bench: the head follows the identification excitation."""
    OUT_OF_SERVICE = 13
    """Catheter change or cleaning."""


CYCLE = (
    Phase.CHECKING,
    Phase.PRELOADING,
    Phase.INSERTING,
    Phase.BACKING_OFF,
    Phase.OPENING,
    Phase.SUCTIONING,
    Phase.WITHDRAWING,
    Phase.CLOSING,
)
"""Phases of a cycle in their order; one that stops by travel does not back off."""
RESTING = (Phase.PARKED, Phase.HALTED, Phase.OUT_OF_SERVICE)
"""Phases that wait for a person."""
