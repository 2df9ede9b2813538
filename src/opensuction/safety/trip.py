"""What makes the governor act: a code each, how it reacts, and the sentence a person reads."""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from opensuction.kernel.compiled import compiled


class Reaction(IntEnum):
    """What the governor does to a proposal, mildest first; a later one includes what it must."""

    PASS = 0
    CAP = 1
    """A setpoint was clamped; the cycle goes on."""
    HOLD = 2
    """The head may not advance."""
    WITHDRAW = 3
    """Out of the airway, whatever was proposed."""
    TORQUE_OFF = 4
    """Moving would be worse than staying."""


WORD = 53
"""Trips and alarm conditions that one mask can hold. Recordings store it as a double, which is
exact below 2^53."""


class Trip(IntEnum):
    """Broken limits and untrusted readings; latched until a reset. Never renumber.

    A trip has the number of its alarm condition (`alarm_condition.Condition`), so that a mask of
    trips is at once a mask of conditions.
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
    SPO2_LOW = 36
    HEART_RATE_LOW = 37
    AIRWAY_PRESSURE_UNSAFE = 38
    LUNG_VOLUME_LOST = 39
    CIRCUIT_DISCONNECTED = 40
    MONITOR_LINK_LOST = 41
    CARRIAGE_READING_INVALID = 51


class TripKind(NamedTuple):
    """How a trip is answered and announced."""

    reaction: Reaction
    vacuum_cut: bool
    """Valve closed and pump off, whatever was proposed."""
    priority: str
    """Alarm priority in the words of IEC 60601-1-8."""
    sentence: str


KINDS: dict[Trip, TripKind] = {
    Trip.PROPOSAL_INVALID: TripKind(
        Reaction.WITHDRAW, True, "high", "the controller proposed an impossible setpoint"
    ),
    Trip.HEAD_READING_INVALID: TripKind(
        Reaction.WITHDRAW, True, "high", "the head encoder gives no valid reading"
    ),
    Trip.HEAD_OVERSPEED: TripKind(
        Reaction.TORQUE_OFF, True, "high", "the catheter head moves faster than its limit"
    ),
    Trip.HEAD_NOT_FOLLOWING: TripKind(
        Reaction.WITHDRAW, True, "high", "the catheter head does not follow its command"
    ),
    Trip.CAM_READING_INVALID: TripKind(
        Reaction.WITHDRAW, True, "medium", "the valve encoder gives no valid reading"
    ),
    Trip.VACUUM_READING_INVALID: TripKind(
        Reaction.WITHDRAW, True, "medium", "the vacuum sensor gives no valid reading"
    ),
    Trip.VACUUM_EXCEEDED: TripKind(
        Reaction.WITHDRAW, True, "high", "the line vacuum is above its limit"
    ),
    Trip.NEGATIVE_PRESSURE_TIME: TripKind(
        Reaction.WITHDRAW, True, "high", "suction has lasted longer than its limit"
    ),
    Trip.IN_AIRWAY_TIME: TripKind(
        Reaction.WITHDRAW, True, "high", "the catheter has been in the airway longer than its limit"
    ),
    Trip.CONTACT_TIME: TripKind(
        Reaction.WITHDRAW, True, "high", "the tip has pressed on tissue longer than its limit"
    ),
    Trip.CONTACT_READING_INVALID: TripKind(
        Reaction.WITHDRAW, False, "medium", "the contact switch gives no valid reading"
    ),
    Trip.LATE_TICKS: TripKind(
        Reaction.WITHDRAW, True, "high", "the controller misses its deadlines"
    ),
    Trip.WITHDRAWAL_TIME: TripKind(
        Reaction.TORQUE_OFF, True, "high", "the catheter could not be withdrawn in time"
    ),
    Trip.HEAD_STALLED: TripKind(
        Reaction.WITHDRAW, True, "high", "the head is driven but its reading does not change"
    ),
    Trip.HEAD_RUNAWAY: TripKind(
        Reaction.TORQUE_OFF, True, "high", "the catheter head advances against its command"
    ),
    Trip.TIP_BEYOND_CAP: TripKind(
        Reaction.WITHDRAW, True, "high", "the tip may be deeper than its cap"
    ),
    # Pulling harder on what is held would be worse than leaving it to a hand.
    Trip.WITHDRAWAL_BLOCKED: TripKind(
        Reaction.TORQUE_OFF, True, "high", "something holds the catheter on its way out"
    ),
    Trip.WITHDRAWAL_UNSEEN: TripKind(
        Reaction.TORQUE_OFF, True, "high", "the catheter was drawn out without a reading of it"
    ),
    Trip.DRIVE_OVERFORCE: TripKind(
        Reaction.TORQUE_OFF, True, "high", "the insertion drive is stronger than its limit"
    ),
    # Slipped, it still comes out; parted, it stays in, and only a hand can help.
    Trip.HEAD_SENSORS_DISAGREE: TripKind(
        Reaction.WITHDRAW,
        True,
        "high",
        "motor and catheter head are not at the same place: the catheter may still be inside",
    ),
    Trip.CARRIAGE_READING_INVALID: TripKind(
        Reaction.WITHDRAW, True, "medium", "the sensor on the catheter head gives no valid reading"
    ),
    # Without vacuum it serves nothing to stay.
    Trip.VACUUM_LOST: TripKind(Reaction.WITHDRAW, True, "medium", "there is no vacuum in the line"),
    Trip.CANISTER_FULL: TripKind(Reaction.WITHDRAW, True, "medium", "the canister is full"),
    # What hangs at the tip would be left in the airway: the vacuum holds it on the way out.
    Trip.LINE_CLOGGED: TripKind(Reaction.WITHDRAW, False, "medium", "the suction line is clogged"),
    Trip.LINE_LEAKING: TripKind(Reaction.WITHDRAW, True, "medium", "the suction line leaks"),
    Trip.CARINA_MISSED: TripKind(
        Reaction.WITHDRAW, True, "high", "no contact where the carina was expected"
    ),
    Trip.CONTACT_STUCK_CLOSED: TripKind(
        Reaction.WITHDRAW, True, "medium", "the contact switch is closed with nothing to touch"
    ),
    Trip.CONTACT_STUCK_OPEN: TripKind(
        Reaction.WITHDRAW, True, "high", "the contact switch has not been seen to close"
    ),
    Trip.VALVE_STUCK_OPEN: TripKind(
        Reaction.WITHDRAW, True, "high", "the suction valve does not close"
    ),
    Trip.VALVE_STUCK_CLOSED: TripKind(
        Reaction.WITHDRAW, True, "medium", "the suction valve does not open"
    ),
    Trip.PUMP_RUNAWAY: TripKind(
        Reaction.WITHDRAW, True, "high", "the pump runs although it was switched off"
    ),
    Trip.CATHETER_JAMMED: TripKind(Reaction.WITHDRAW, True, "high", "the catheter is jammed"),
    # What the patient's monitor says: the catheter comes out first, without suction.
    Trip.SPO2_LOW: TripKind(
        Reaction.WITHDRAW, True, "high", "oxygen saturation is below its limit"
    ),
    Trip.HEART_RATE_LOW: TripKind(Reaction.WITHDRAW, True, "high", "heart rate is below its limit"),
    Trip.AIRWAY_PRESSURE_UNSAFE: TripKind(
        Reaction.WITHDRAW, True, "high", "airway pressure is outside its limits"
    ),
    Trip.LUNG_VOLUME_LOST: TripKind(
        Reaction.WITHDRAW, True, "medium", "suction takes more gas than the ventilator gives"
    ),
    Trip.CIRCUIT_DISCONNECTED: TripKind(
        Reaction.WITHDRAW, True, "high", "the breathing circuit is disconnected"
    ),
    Trip.MONITOR_LINK_LOST: TripKind(
        Reaction.WITHDRAW, True, "medium", "the patient monitor cannot be read"
    ),
}

REACTIONS = np.zeros(WORD, dtype=np.int64)
"""Reaction to each bit of a mask; none to one that is no trip's."""
CUTS = np.zeros(WORD, dtype=np.bool_)
for _trip, _kind in KINDS.items():
    REACTIONS[_trip] = _kind.reaction
    CUTS[_trip] = _kind.vacuum_cut


def names(trips: int) -> list[Trip]:
    """The trips in a bit mask, in order."""
    return [trip for trip in Trip if trips >> trip & 1]


@compiled
def reaction(trips: int) -> int:
    """Strongest reaction that a bit mask of trips asks for."""
    strongest = 0
    if trips == 0:
        return strongest
    for trip in range(REACTIONS.size):
        if trips >> trip & 1:
            strongest = max(strongest, REACTIONS[trip])
    return strongest


@compiled
def cuts_vacuum(trips: int) -> bool:
    """Whether any trip in a bit mask asks for the vacuum to be cut."""
    if trips == 0:
        return False
    for trip in range(CUTS.size):
        if trips >> trip & 1 and CUTS[trip]:
            return True
    return False
