"""What can alarm a person: every condition, how urgent it is, and how its alarm behaves.

Sentences and remedies stand in `alarm_text`; `alarm` decides what is signalled.
IEC 60601-1-8 gives the words and the matrix; which harm and which onset belong to a condition is
this project's own judgement from its list of hazards, and so are all times (assumed).
"""

from collections.abc import Callable
from enum import IntEnum
from typing import NamedTuple

from opensuction.safety import trip
from opensuction.safety.trip import Trip


class Priority(IntEnum):
    """How soon somebody must act."""

    NONE = 0
    LOW = 1
    """Be aware."""
    MEDIUM = 2
    """Act promptly."""
    HIGH = 3
    """Act at once."""


NONE, LOW, MEDIUM, HIGH = (int(priority) for priority in Priority)
"""The same as plain integers, as records hold them."""


class Harm(IntEnum):
    """What may come of it if nobody acts."""

    MINOR = 0
    """Discomfort, or an injury that heals by itself."""
    REVERSIBLE = 1
    DEATH = 2
    """Death or an injury that stays."""


class Onset(IntEnum):
    """How soon the harm may come."""

    DELAYED = 0
    """Not within minutes."""
    PROMPT = 1
    """Not at once, but too soon to wait with a manual correction."""
    IMMEDIATE = 2


PRIORITIES: dict[tuple[Harm, Onset], Priority] = {
    (Harm.DEATH, Onset.IMMEDIATE): Priority.HIGH,
    (Harm.DEATH, Onset.PROMPT): Priority.HIGH,
    (Harm.DEATH, Onset.DELAYED): Priority.MEDIUM,
    (Harm.REVERSIBLE, Onset.IMMEDIATE): Priority.HIGH,
    (Harm.REVERSIBLE, Onset.PROMPT): Priority.MEDIUM,
    (Harm.REVERSIBLE, Onset.DELAYED): Priority.LOW,
    (Harm.MINOR, Onset.IMMEDIATE): Priority.MEDIUM,
    (Harm.MINOR, Onset.PROMPT): Priority.LOW,
    (Harm.MINOR, Onset.DELAYED): Priority.LOW,
}
"""Priority matrix of IEC 60601-1-8, table 1 (from memory, unverified)."""

WORD = trip.WORD
"""Conditions that a mask can hold."""


class Condition(IntEnum):
    """What can be wrong. Never renumber: recordings hold these.

    A trip has the number of its condition, so that the governor's bit mask of trips is at once a
    mask of conditions. Those below 20 are trips alone.
    """

    PROPOSAL_INVALID = 0
    HEAD_READING_INVALID = 1
    HEAD_OVERSPEED = 2
    HEAD_NOT_FOLLOWING = 3
    CAM_READING_INVALID = 4
    VACUUM_READING_INVALID = 5
    VACUUM_EXCEEDED = 6
    NEGATIVE_PRESSURE_TIME = 7
    IN_AIRWAY_TIME = 8
    CONTACT_TIME = 9
    CONTACT_READING_INVALID = 10
    LATE_TICKS = 11
    WITHDRAWAL_TIME = 12
    HEAD_STALLED = 13
    HEAD_RUNAWAY = 14
    TIP_BEYOND_CAP = 15
    WITHDRAWAL_BLOCKED = 16
    WITHDRAWAL_UNSEEN = 17
    DRIVE_OVERFORCE = 18
    HEAD_SENSORS_DISAGREE = 19
    AUTOMATION_STOPPED = 20
    RECOVERY_NEEDED = 21
    CATHETER_LIFE_OVER = 22
    CATHETER_LIFE_ENDING = 23
    VACUUM_LOST = 24
    CANISTER_FULL = 25
    LINE_CLOGGED = 26
    LINE_LEAKING = 27
    CARINA_MISSED = 28
    CONTACT_STUCK_CLOSED = 29
    CONTACT_STUCK_OPEN = 30
    VALVE_STUCK_OPEN = 31
    VALVE_STUCK_CLOSED = 32
    PUMP_RUNAWAY = 33
    CATHETER_JAMMED = 34
    TIP_DETACHED = 35
    SPO2_LOW = 36
    HEART_RATE_LOW = 37
    AIRWAY_PRESSURE_UNSAFE = 38
    LUNG_VOLUME_LOST = 39
    CIRCUIT_DISCONNECTED = 40
    MONITOR_LINK_LOST = 41
    RECORDER_LOST = 42
    CONSOLE_LOST = 43
    RESERVE_ENERGY_USED = 44
    PATIENT_SETTINGS_UNCONFIRMED = 45
    MESSAGE_LATE = 46
    PASS_LIMIT_REACHED = 47
    CHECK_FAILED = 48
    WATCHDOG_FIRED = 49
    CALIBRATION_OUT_OF_RANGE = 50
    CARRIAGE_READING_INVALID = 51


class Kind(NamedTuple):
    """How the alarm of a condition behaves."""

    harm: Harm
    onset: Onset
    latching: bool
    """Shown and sounded until a person resets, although the condition has ended."""
    delay_s: float
    """How long the condition must hold without a break before it is an alarm."""
    escalates_s: float
    """Unanswered for so long, its priority rises by one; 0: it never does."""
    planned: bool
    """A consequence of planned work (catheter change, cleaning), which then raises no alarm."""

    @property
    def priority(self) -> Priority:
        """By the standard's matrix."""
        return PRIORITIES[self.harm, self.onset]


def _trip(harm: Harm, onset: Onset, escalates_s: float = 0.0, planned: bool = False) -> Kind:
    """A trip: the governor has waited already and holds it itself until a reset.

    planned: hands in a machine that is out of service bring it about. Nothing is driven then, and
    what still holds when the machine is put back to work trips again.
    """
    return Kind(harm, onset, True, 0.0, escalates_s, planned)


def _patient(harm: Harm, onset: Onset, escalates_s: float = 0.0) -> Kind:
    """What the monitor says of the patient: the governor has waited already.

    In a cycle it is a trip, which the governor holds until a reset; at rest it ends with its cause.
    """
    return Kind(harm, onset, False, 0.0, escalates_s, planned=False)


H = Harm
O = Onset  # noqa: E741
ESCALATES_S = 120.0
"""A medium alarm that nobody answers for so long becomes a high one (assumed)."""
HOUR_S = 3600.0

TRIP_KINDS: dict[Trip, Kind] = {
    Trip.PROPOSAL_INVALID: _trip(H.DEATH, O.PROMPT),
    Trip.HEAD_READING_INVALID: _trip(H.DEATH, O.PROMPT, planned=True),
    Trip.HEAD_OVERSPEED: _trip(H.DEATH, O.IMMEDIATE, planned=True),
    Trip.HEAD_NOT_FOLLOWING: _trip(H.DEATH, O.PROMPT, planned=True),
    Trip.CAM_READING_INVALID: _trip(H.REVERSIBLE, O.PROMPT, ESCALATES_S, planned=True),
    Trip.VACUUM_READING_INVALID: _trip(H.REVERSIBLE, O.PROMPT, ESCALATES_S, planned=True),
    Trip.VACUUM_EXCEEDED: _trip(H.REVERSIBLE, O.IMMEDIATE),
    Trip.NEGATIVE_PRESSURE_TIME: _trip(H.DEATH, O.PROMPT, planned=True),
    Trip.IN_AIRWAY_TIME: _trip(H.DEATH, O.PROMPT, planned=True),
    Trip.CONTACT_TIME: _trip(H.REVERSIBLE, O.IMMEDIATE, planned=True),
    Trip.CONTACT_READING_INVALID: _trip(H.REVERSIBLE, O.PROMPT, ESCALATES_S, planned=True),
    Trip.LATE_TICKS: _trip(H.DEATH, O.PROMPT),
    Trip.WITHDRAWAL_TIME: _trip(H.DEATH, O.PROMPT, planned=True),
    Trip.HEAD_STALLED: _trip(H.DEATH, O.PROMPT, planned=True),
    Trip.HEAD_RUNAWAY: _trip(H.DEATH, O.IMMEDIATE, planned=True),
    Trip.TIP_BEYOND_CAP: _trip(H.DEATH, O.IMMEDIATE, planned=True),
    Trip.WITHDRAWAL_BLOCKED: _trip(H.DEATH, O.PROMPT, planned=True),
    Trip.WITHDRAWAL_UNSEEN: _trip(H.DEATH, O.PROMPT, planned=True),
    Trip.DRIVE_OVERFORCE: _trip(H.DEATH, O.IMMEDIATE),
    Trip.HEAD_SENSORS_DISAGREE: _trip(H.DEATH, O.PROMPT, planned=True),
    Trip.CARRIAGE_READING_INVALID: _trip(H.REVERSIBLE, O.PROMPT, ESCALATES_S, planned=True),
    Trip.VACUUM_LOST: _trip(H.DEATH, O.DELAYED, ESCALATES_S, planned=True),
    Trip.CANISTER_FULL: _trip(H.DEATH, O.DELAYED, ESCALATES_S, planned=True),
    Trip.LINE_CLOGGED: _trip(H.DEATH, O.DELAYED, ESCALATES_S, planned=True),
    Trip.LINE_LEAKING: _trip(H.DEATH, O.DELAYED, ESCALATES_S, planned=True),
    Trip.CARINA_MISSED: _trip(H.DEATH, O.PROMPT, planned=True),
    Trip.CONTACT_STUCK_CLOSED: _trip(H.REVERSIBLE, O.PROMPT, ESCALATES_S, planned=True),
    Trip.CONTACT_STUCK_OPEN: _trip(H.DEATH, O.PROMPT, planned=True),
    Trip.VALVE_STUCK_OPEN: _trip(H.DEATH, O.PROMPT),
    Trip.VALVE_STUCK_CLOSED: _trip(H.REVERSIBLE, O.PROMPT, ESCALATES_S, planned=True),
    Trip.PUMP_RUNAWAY: _trip(H.REVERSIBLE, O.IMMEDIATE),
    Trip.CATHETER_JAMMED: _trip(H.DEATH, O.PROMPT, planned=True),
    Trip.SPO2_LOW: _patient(H.DEATH, O.IMMEDIATE),
    Trip.HEART_RATE_LOW: _patient(H.DEATH, O.IMMEDIATE),
    Trip.AIRWAY_PRESSURE_UNSAFE: _patient(H.DEATH, O.PROMPT),
    Trip.LUNG_VOLUME_LOST: _patient(H.REVERSIBLE, O.PROMPT, ESCALATES_S),
    Trip.CIRCUIT_DISCONNECTED: _patient(H.DEATH, O.IMMEDIATE),
    Trip.MONITOR_LINK_LOST: _patient(H.DEATH, O.DELAYED, ESCALATES_S),
}
"""The priority of each is that of `trip.KINDS`; a test keeps the two in step."""

C = Condition
OWN_KINDS: dict[Condition, Kind] = {
    #                                 harm, onset, latching, delay s, escalates s, planned
    C.AUTOMATION_STOPPED: Kind(H.DEATH, O.DELAYED, False, 0.0, ESCALATES_S, True),
    C.RECOVERY_NEEDED: Kind(H.DEATH, O.PROMPT, False, 0.0, 0.0, False),
    C.CATHETER_LIFE_OVER: Kind(H.REVERSIBLE, O.PROMPT, False, 0.0, 0.0, True),
    C.CATHETER_LIFE_ENDING: Kind(H.REVERSIBLE, O.DELAYED, False, 0.0, HOUR_S, True),
    C.TIP_DETACHED: Kind(H.DEATH, O.IMMEDIATE, True, 0.0, 0.0, False),
    C.RECORDER_LOST: Kind(H.MINOR, O.DELAYED, False, 2.0, 0.0, False),
    C.CONSOLE_LOST: Kind(H.REVERSIBLE, O.PROMPT, False, 2.0, ESCALATES_S, False),
    C.RESERVE_ENERGY_USED: Kind(H.DEATH, O.PROMPT, False, 0.0, 0.0, False),
    C.PATIENT_SETTINGS_UNCONFIRMED: Kind(H.REVERSIBLE, O.DELAYED, False, 0.0, 0.0, True),
    C.MESSAGE_LATE: Kind(H.DEATH, O.PROMPT, True, 0.0, 0.0, True),
    C.PASS_LIMIT_REACHED: Kind(H.DEATH, O.DELAYED, False, 0.0, ESCALATES_S, False),
    C.CHECK_FAILED: Kind(H.DEATH, O.DELAYED, False, 0.0, ESCALATES_S, True),
    C.WATCHDOG_FIRED: Kind(H.DEATH, O.PROMPT, True, 0.0, 0.0, False),
    # The catheter is out when it is found, and the next cycle is refused.
    C.CALIBRATION_OUT_OF_RANGE: Kind(H.REVERSIBLE, O.PROMPT, True, 0.0, ESCALATES_S, False),
}

KINDS: dict[Condition, Kind] = {
    **OWN_KINDS,
    **{Condition(int(code)): kind for code, kind in TRIP_KINDS.items()},
}
"""Every condition; one that is a trip too behaves as the trip."""

UNKNOWN = Kind(Harm.DEATH, Onset.IMMEDIATE, True, 0.0, 0.0, planned=False)
"""A bit that no condition has is a mistake of the software: as urgent as can be, never lost."""

ROWS = tuple(KINDS[Condition(bit)] if bit in set(Condition) else UNKNOWN for bit in range(WORD))
"""A row for every bit of a mask."""


def _bits(chosen: Callable[[Kind], bool]) -> int:
    return sum(1 << bit for bit, kind in enumerate(ROWS) if chosen(kind))


KNOWN = 2**WORD - 1
"""Every bit of a mask."""
HIGHS = _bits(lambda kind: kind.priority == Priority.HIGH)
MEDIUMS = _bits(lambda kind: kind.priority == Priority.MEDIUM)
LOWS = _bits(lambda kind: kind.priority == Priority.LOW)
"""Masks of the conditions of each priority."""
LATCHING = _bits(lambda kind: kind.latching)
PLANNED = _bits(lambda kind: kind.planned)
"""Masks of the conditions that latch, and of those that planned work brings about."""


def mask(conditions: set[Condition]) -> int:
    """Bit mask of some conditions."""
    return sum(1 << condition for condition in conditions)


def members(conditions: int) -> list[int]:
    """Numbers of the conditions in a bit mask, in order."""
    return [bit for bit in range(WORD) if conditions >> bit & 1]
