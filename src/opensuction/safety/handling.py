"""Handling of a condition: the behaviour of its alarm, and the reaction of the governor.

A condition to which the governor reacts is a *trip*. The words are those of [IEC-60601-1-8].

Priority of an alarm: the priority matrix of [IEC-60601-1-8].
"""

from enum import IntEnum
from typing import NamedTuple


class Priority(IntEnum):
    """Priority of an alarm: how soon somebody must act. Never renumber: recordings hold these."""

    NONE = 0
    LOW = 1
    """Be aware."""
    MEDIUM = 2
    """Act promptly."""
    HIGH = 3
    """Act at once."""


NONE, LOW, MEDIUM, HIGH = (int(priority) for priority in Priority)
"""The same as plain integers, as records hold them."""


class Severity(IntEnum):
    """The worst harm that may follow if nobody acts."""

    MINOR = 0
    """Discomfort, or an injury that heals by itself."""
    REVERSIBLE = 1
    DEATH = 2
    """Death or a permanent injury."""


class Onset(IntEnum):
    """Time to the harm."""

    DELAYED = 0
    """Not within minutes."""
    PROMPT = 1
    """Not at once, but too soon to wait with a manual correction."""
    IMMEDIATE = 2


PRIORITIES: dict[tuple[Severity, Onset], Priority] = {
    (Severity.DEATH, Onset.IMMEDIATE): Priority.HIGH,
    (Severity.DEATH, Onset.PROMPT): Priority.HIGH,
    (Severity.DEATH, Onset.DELAYED): Priority.MEDIUM,
    (Severity.REVERSIBLE, Onset.IMMEDIATE): Priority.HIGH,
    (Severity.REVERSIBLE, Onset.PROMPT): Priority.MEDIUM,
    (Severity.REVERSIBLE, Onset.DELAYED): Priority.LOW,
    (Severity.MINOR, Onset.IMMEDIATE): Priority.MEDIUM,
    (Severity.MINOR, Onset.PROMPT): Priority.LOW,
    (Severity.MINOR, Onset.DELAYED): Priority.LOW,
}
"""Priority matrix of [IEC-60601-1-8], table 1 [K]."""


class Reaction(IntEnum):
    """Reaction of the governor to a proposal, mildest first. Never renumber: recordings hold these.

    Each includes what it must of those before it.
    """

    PASS = 0
    CAP = 1
    """A setpoint was clamped; the cycle goes on."""
    HOLD = 2
    """The head may not advance."""
    WITHDRAW = 3
    """Out of the airway, whatever was proposed."""
    TORQUE_OFF = 4
    """Moving would be worse than staying."""


class Handling(NamedTuple):
    """Announcement of a condition, and the governor's reaction to it."""

    severity: Severity
    onset: Onset
    latching: bool
    """Shown and sounded until a person resets, although the condition has ended."""
    planned: bool
    """Planned work (catheter change, cleaning) brings it about, and raises no alarm then."""
    delay_s: float
    """How long the condition must hold without a break before it is an alarm."""
    escalates_s: float
    """Unanswered for so long, its priority rises by one; 0: it never does."""
    reaction: Reaction
    """`Reaction.PASS`: the condition is no trip."""
    cuts_vacuum: bool
    """Valve closed and pump off, whatever was proposed."""

    @property
    def priority(self) -> Priority:
        """By the standard's matrix."""
        return PRIORITIES[self.severity, self.onset]


ESCALATES_S = 120.0
"""A medium alarm that nobody answers for so long becomes a high one (assumed)."""
NEVER_S = 0.0
UNANSWERED_S = 2.0
"""How long recorder or console may be silent (assumed)."""


def alarm(
    severity: Severity,
    onset: Onset,
    *,
    latching: bool = False,
    planned: bool = False,
    delay_s: float = 0.0,
    escalates_s: float | None = None,
) -> Handling:
    """Announce only; unless told otherwise an alarm of medium priority escalates, no other does."""
    if escalates_s is None:
        medium = PRIORITIES[severity, onset] == Priority.MEDIUM
        escalates_s = ESCALATES_S if medium else NEVER_S
    return Handling(
        severity,
        onset,
        latching,
        planned,
        delay_s,
        escalates_s,
        reaction=Reaction.PASS,
        cuts_vacuum=False,
    )


def trip(
    severity: Severity,
    onset: Onset,
    *,
    planned: bool = False,
    reaction: Reaction = Reaction.WITHDRAW,
    cuts_vacuum: bool = True,
) -> Handling:
    """Withdraw without suction and announce at once; the governor latches it until a reset.

    planned: hands in a machine that is out of service bring it about. Nothing is driven then, and
    what still holds when the machine is put back to work trips again.
    """
    announced = alarm(severity, onset, latching=True, planned=planned)
    return announced._replace(reaction=reaction, cuts_vacuum=cuts_vacuum)


def patient(severity: Severity, onset: Onset) -> Handling:
    """Handling of a condition of the patient's monitor: the catheter comes out, without suction.

    In a cycle it is a trip, which the governor latches; at rest the alarm ends with its cause.
    """
    return trip(severity, onset)._replace(latching=False)
