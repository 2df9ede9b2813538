"""Priority of an alarm: the priority matrix of [IEC-60601-1-8]."""

from enum import IntEnum


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
