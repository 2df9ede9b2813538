"""Alarm conditions: one enumeration, with a row for each condition.

Whatever is laid down about a condition stands in its row and nowhere else; `condition_mask` derives
from the rows what compiled code needs. Severity and onset of each condition are this project's own
judgement from its list of hazards, and so are all times (assumed).
"""

from enum import IntEnum
from typing import Any, NamedTuple

from opensuction.kernel.unit import HOUR_S
from opensuction.safety.handling import (
    NEVER_S,
    UNANSWERED_S,
    Handling,
    Onset,
    Reaction,
    Severity,
    alarm,
    patient,
    trip,
)


class ConditionRow(NamedTuple):
    """Texts and handling that are laid down for a condition."""

    sentence: str
    """What is wrong, without its capital and full stop."""
    remedy: str
    """What to do first, in whole sentences."""
    handling: Handling


OUT_FIRST = "Look at the patient. Draw the catheter out by hand if it is still in the airway."
"""Where the machine may not be able to withdraw by itself."""
SERVICE = "Do not use the machine until it has been serviced."

DEATH, REVERSIBLE, MINOR = Severity.DEATH, Severity.REVERSIBLE, Severity.MINOR
IMMEDIATE, PROMPT, DELAYED = Onset.IMMEDIATE, Onset.PROMPT, Onset.DELAYED
TORQUE_OFF = Reaction.TORQUE_OFF


class Condition(IntEnum):
    """Alarm condition, by part of the machine. Never renumber: recordings hold these.

    Sets of conditions are bit masks; the governor's mask of trips is one of them.
    """

    row: ConditionRow

    def __new__(cls, number: int, *row: Any) -> "Condition":
        """Member with the number as its value."""
        member = int.__new__(cls, number)
        member._value_ = number
        member.row = ConditionRow(*row)
        return member

    # Insertion axis
    HEAD_READING_INVALID = (
        1,
        "the head encoder gives no valid reading, or one that nothing bears out",
        f"{OUT_FIRST} Check the encoder's cable.",
        trip(DEATH, PROMPT, planned=True),
    )
    CARRIAGE_READING_INVALID = (
        51,
        "the sensor on the catheter head gives no valid reading, or one that nothing bears out",
        "See that the catheter is out. Check the cable of the sensor on the catheter head.",
        trip(REVERSIBLE, PROMPT, planned=True),
    )
    # Slipped, it still comes out; parted, it stays in, and only a hand can help.
    HEAD_SENSORS_DISAGREE = (
        19,
        "motor, catheter head and tip are not where they belong together: the catheter may still "
        "be inside",
        f"{OUT_FIRST} Look for a loose clamp, a parted gear, a slipping encoder; clean the light "
        "barrier at the tube's mouth.",
        trip(DEATH, PROMPT, planned=True),
    )
    HEAD_OVERSPEED = (
        2,
        "the catheter head moves faster than its limit",
        f"{OUT_FIRST} {SERVICE}",
        trip(DEATH, IMMEDIATE, planned=True, reaction=TORQUE_OFF),
    )
    HEAD_NOT_FOLLOWING = (
        3,
        "the catheter head does not follow its command",
        f"{OUT_FIRST} Look for a kink or a blocked guide.",
        trip(DEATH, PROMPT, planned=True),
    )
    HEAD_STALLED = (
        13,
        "the head is driven but its reading does not change",
        f"{OUT_FIRST} Look for a blocked guide; check the encoder's cable.",
        trip(DEATH, PROMPT, planned=True),
    )
    HEAD_RUNAWAY = (
        14,
        "the catheter head advances against its command",
        f"{OUT_FIRST} {SERVICE}",
        trip(DEATH, IMMEDIATE, planned=True, reaction=TORQUE_OFF),
    )
    # Told to come out it pushes no more; what holds it on the way out ends that soon.
    DRIVE_OVERFORCE = (
        18,
        "the insertion drive is stronger than its limit",
        f"{OUT_FIRST} {SERVICE}",
        trip(DEATH, IMMEDIATE),
    )
    CATHETER_JAMMED = (
        34,
        "the catheter is jammed",
        f"{OUT_FIRST} Look for a kink before the next cycle.",
        trip(DEATH, PROMPT, planned=True),
    )
    TIP_BEYOND_CAP = (
        15,
        "the tip may be deeper than its cap",
        "Look at the patient. Teach the travel anew before the next cycle.",
        trip(DEATH, IMMEDIATE, planned=True),
    )

    # Withdrawal
    IN_AIRWAY_TIME = (
        8,
        "the catheter has been in the airway longer than its limit",
        OUT_FIRST,
        trip(DEATH, PROMPT, planned=True),
    )
    WITHDRAWAL_TIME = (
        12,
        "the catheter could not be withdrawn in time",
        OUT_FIRST,
        trip(DEATH, PROMPT, planned=True, reaction=TORQUE_OFF),
    )
    # Pulling harder on what is held would be worse than leaving it to a hand.
    WITHDRAWAL_BLOCKED = (
        16,
        "something holds the catheter on its way out",
        f"{OUT_FIRST} Do not force it: look for a kink or a bitten tube.",
        trip(DEATH, PROMPT, planned=True, reaction=TORQUE_OFF),
    )
    WITHDRAWAL_UNSEEN = (
        17,
        "the catheter was to be drawn out, and no reading shows that it was",
        f"{OUT_FIRST} Check the encoder's cable.",
        trip(DEATH, PROMPT, planned=True, reaction=TORQUE_OFF),
    )
    RECOVERY_NEEDED = (
        21,
        "the machine was put to work with the catheter not at its park position",
        "Look at the patient: the catheter is drawn out first. Reset when it is out.",
        alarm(DEATH, PROMPT),
    )

    # Contact
    CONTACT_READING_INVALID = (
        10,
        "the contact switch gives no valid reading",
        "Change the catheter, or stop by travel instead of contact.",
        trip(REVERSIBLE, PROMPT, planned=True, cuts_vacuum=False),
    )
    CONTACT_STUCK_CLOSED = (
        29,
        "the contact switch is closed where no contact was expected: the tip touches, or the "
        "switch sticks",
        "See whether the patient has been moved: then teach the travel anew. Else clean the tip or "
        "change the catheter; the machine does not start until then.",
        trip(REVERSIBLE, PROMPT, planned=True),
    )
    CONTACT_STUCK_OPEN = (
        30,
        "the contact switch has not been seen to close",
        "Look at the patient: the tip may have pressed on the carina. Change the catheter, or "
        "stop by travel.",
        trip(DEATH, PROMPT, planned=True),
    )
    CONTACT_TIME = (
        9,
        "the contact switch has been closed longer than its limit: the tip presses on tissue, or "
        "the switch sticks",
        "Look at the patient. Check the taught travel before the next cycle.",
        trip(REVERSIBLE, IMMEDIATE, planned=True),
    )
    CARINA_MISSED = (
        28,
        "no contact where the carina was expected",
        "Look at the patient: the catheter may have entered a bronchus. Check the taught travel.",
        trip(DEATH, PROMPT, planned=True),
    )

    # Valve
    CAM_READING_INVALID = (
        4,
        "the valve encoder gives no valid reading",
        "See that the valve is closed. Check the valve encoder's cable.",
        trip(REVERSIBLE, PROMPT, planned=True),
    )
    VALVE_STUCK_OPEN = (
        31,
        "the suction valve does not close, or the line holds no vacuum",
        f"{OUT_FIRST} Switch the pump off. Look for a leak. {SERVICE}",
        trip(DEATH, PROMPT),
    )
    VALVE_STUCK_CLOSED = (
        32,
        "the suction valve does not open",
        "Suction by hand when needed. Check the valve.",
        trip(REVERSIBLE, PROMPT, planned=True),
    )
    NEGATIVE_PRESSURE_TIME = (
        7,
        "suction has lasted longer than its limit",
        "Look at the patient. See that the valve is closed.",
        trip(DEATH, PROMPT, planned=True),
    )

    # Pump and suction line
    VACUUM_READING_INVALID = (
        5,
        "the vacuum sensor gives no valid reading",
        "Check the vacuum sensor and its tube before the next cycle.",
        trip(REVERSIBLE, PROMPT, planned=True),
    )
    VACUUM_EXCEEDED = (
        6,
        "the line vacuum is above its limit",
        "Check the regulator. Do not suction with this pump until it holds.",
        trip(REVERSIBLE, IMMEDIATE),
    )
    # Without vacuum it serves nothing to stay.
    VACUUM_LOST = (
        24,
        "there is too little vacuum in the line",
        "Check pump and tubes; suction by hand when needed.",
        trip(DEATH, DELAYED, planned=True),
    )
    PUMP_RUNAWAY = (
        33,
        "the pump runs although it was switched off",
        f"Pull the pump's plug. {SERVICE}",
        trip(REVERSIBLE, IMMEDIATE),
    )
    # What hangs at the tip would be left in the airway: the vacuum holds it on the way out.
    LINE_CLOGGED = (
        26,
        "the suction line is clogged",
        "Rinse or change the catheter; check the tubes and the valve.",
        trip(DEATH, DELAYED, planned=True, cuts_vacuum=False),
    )
    LINE_LEAKING = (
        27,
        "the suction line leaks",
        "Check the tubes, the canister's lid, the seal.",
        trip(DEATH, DELAYED, planned=True),
    )
    CANISTER_FULL = (
        25,
        "the canister is full",
        "Change the canister.",
        trip(DEATH, DELAYED, planned=True),
    )
    # Raised where one more pass is asked for, and not by the last permitted one: passes that did
    # what they should are no alarm.
    PASS_LIMIT_REACHED = (
        47,
        "another pass is asked for after the permitted number: secretions may remain",
        "Look at the patient, then confirm it. Suction by hand; consider a blocked tube.",
        alarm(DEATH, DELAYED),
    )

    # Patient, as the monitor shows
    SPO2_LOW = (
        36,
        "oxygen saturation is below its limit",
        "Look at the patient. Give oxygen.",
        patient(DEATH, IMMEDIATE),
    )
    HEART_RATE_LOW = (
        37,
        "heart rate is below its limit",
        "Look at the patient. Stop suction.",
        patient(DEATH, IMMEDIATE),
    )
    AIRWAY_PRESSURE_UNSAFE = (
        38,
        "airway pressure is outside its limits",
        "Look at the patient. Check circuit, tube and ventilator.",
        patient(DEATH, PROMPT),
    )
    LUNG_VOLUME_LOST = (
        39,
        "suction takes more gas than the ventilator gives",
        "Look at the patient. Recruit as ordered; lower vacuum or duration.",
        patient(REVERSIBLE, PROMPT),
    )
    CIRCUIT_DISCONNECTED = (
        40,
        "the breathing circuit is disconnected",
        "Look at the patient. Reconnect the circuit.",
        patient(DEATH, IMMEDIATE),
    )
    MONITOR_LINK_LOST = (
        41,
        "the patient monitor cannot be read",
        "Watch the monitor itself. Check its cables; no cycle starts.",
        patient(DEATH, DELAYED),
    )
    PATIENT_SETTINGS_UNCONFIRMED = (
        45,
        "the patient settings are not confirmed",
        "Compare patient, tube and catheter with the settings, then confirm them.",
        alarm(REVERSIBLE, DELAYED, planned=True),
    )

    # Catheter
    CATHETER_LIFE_OVER = (
        22,
        "the catheter is past its life",
        "Change the catheter.",
        alarm(REVERSIBLE, PROMPT, planned=True, escalates_s=NEVER_S),
    )
    CATHETER_LIFE_ENDING = (
        23,
        "the catheter's life ends soon",
        "Have a new catheter ready and plan its change.",
        alarm(REVERSIBLE, DELAYED, planned=True, escalates_s=HOUR_S),
    )
    # A vacuum holds what hangs at the tip: it goes on until the catheter is out.
    TIP_DETACHED = (
        35,
        "the catheter's tip is not where it must be, or may have come off",
        "Draw the catheter out and look at its tip. Call a physician if it is incomplete. Whole, "
        "look for a loose clamp, the switch's cable, dirt in the light barrier.",
        trip(DEATH, IMMEDIATE, cuts_vacuum=False),
    )
    # The catheter is out when it is found, and the next cycle is refused.
    CALIBRATION_OUT_OF_RANGE = (
        50,
        "the catheter's gap in its conduit is not what it was calibrated to be",
        "Suction by hand when needed. Lay the conduit as it was, or calibrate the machine anew.",
        alarm(REVERSIBLE, PROMPT, latching=True),
    )

    # Controller and its surroundings
    PROPOSAL_INVALID = (
        0,
        "the controller proposed an impossible setpoint",
        f"{OUT_FIRST} Restart the controller; suction by hand until then.",
        trip(DEATH, PROMPT),
    )
    LATE_TICKS = (
        11,
        "the controller misses its deadlines",
        f"{OUT_FIRST} Restart the controller.",
        trip(DEATH, PROMPT),
    )
    MESSAGE_LATE = (
        46,
        "a drive does not answer in time",
        f"{OUT_FIRST} Check the bus cable; restart the machine.",
        alarm(DEATH, PROMPT, latching=True, planned=True),
    )
    WATCHDOG_FIRED = (
        49,
        "the drives' watchdog has stopped the machine",
        f"{OUT_FIRST} Restart the controller.",
        alarm(DEATH, PROMPT, latching=True),
    )
    RESERVE_ENERGY_USED = (
        44,
        "mains power is lost: the drives have their reserve energy, or none",
        "See that the catheter comes out; if it does not move, draw it out by the handle. Restore "
        "mains power.",
        alarm(DEATH, PROMPT),
    )
    RECORDER_LOST = (
        42,
        "recorder or supervisor does not answer, or what happens is not kept",
        "Write down what happens. Make room on the disk; restart them.",
        alarm(MINOR, DELAYED, delay_s=UNANSWERED_S),
    )
    CONSOLE_LOST = (
        43,
        "the console does not answer",
        "Stop with the machine's own button if needed. Restart the console.",
        alarm(REVERSIBLE, PROMPT, delay_s=UNANSWERED_S),
    )
    LOCKED_OUT = (
        52,
        "the machine has tripped for the same reason again and again, and is locked out",
        f"{OUT_FIRST} The machine will not: take it out of service, find the cause, and return it "
        "to service.",
        alarm(DEATH, PROMPT, planned=True),
    )
    CHECK_FAILED = (
        48,
        "the pre-use test has failed",
        "Read which item failed, correct it, then reset.",
        alarm(DEATH, DELAYED, planned=True),
    )
    AUTOMATION_STOPPED = (
        20,
        "automatic suction has stopped",
        "Suction by hand when needed. Deal with what stopped it, then reset.",
        alarm(DEATH, DELAYED, planned=True),
    )


def row_of(number: int) -> ConditionRow:
    """Row of a condition by its number.

    A number that no condition has is a mistake of the software: as urgent as can be, never lost.
    """
    if number in set(Condition):
        return Condition(number).row
    sentence = f"unknown condition {number}: the software is at fault"
    return ConditionRow(sentence, OUT_FIRST, alarm(DEATH, IMMEDIATE, latching=True))
