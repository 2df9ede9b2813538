"""What a person reads of an alarm: what is wrong, and what to do first. Not compiled."""

from typing import NamedTuple

from opensuction.safety import trip
from opensuction.safety.alarm.alarm_condition import Condition
from opensuction.safety.trip import Trip


class Text(NamedTuple):
    """A sentence without its capital and full stop, and a remedy of whole sentences."""

    sentence: str
    remedy: str


OUT_FIRST = "Look at the patient. Draw the catheter out by hand if it is still in the airway."
"""Where the machine may not be able to withdraw by itself."""
SERVICE = "Do not use the machine until it has been serviced."

TRIP_REMEDIES: dict[Trip, str] = {
    Trip.PROPOSAL_INVALID: f"{OUT_FIRST} Restart the controller; suction by hand until then.",
    Trip.HEAD_READING_INVALID: f"{OUT_FIRST} Check the encoder's cable.",
    Trip.HEAD_OVERSPEED: f"{OUT_FIRST} {SERVICE}",
    Trip.HEAD_NOT_FOLLOWING: f"{OUT_FIRST} Look for a kink or a blocked guide.",
    Trip.CAM_READING_INVALID: "See that the valve is closed. Check the valve encoder's cable.",
    Trip.VACUUM_READING_INVALID: "Check the vacuum sensor and its tube before the next cycle.",
    Trip.VACUUM_EXCEEDED: "Check the regulator. Do not suction with this pump until it holds.",
    Trip.NEGATIVE_PRESSURE_TIME: "Look at the patient. See that the valve is closed.",
    Trip.IN_AIRWAY_TIME: OUT_FIRST,
    Trip.CONTACT_TIME: "Look at the patient. Check the taught travel before the next cycle.",
    Trip.CONTACT_READING_INVALID: "Change the catheter, or stop by travel instead of contact.",
    Trip.LATE_TICKS: f"{OUT_FIRST} Restart the controller.",
    Trip.WITHDRAWAL_TIME: OUT_FIRST,
    Trip.HEAD_STALLED: f"{OUT_FIRST} Look for a blocked guide; check the encoder's cable.",
    Trip.HEAD_RUNAWAY: f"{OUT_FIRST} {SERVICE}",
    Trip.TIP_BEYOND_CAP: "Look at the patient. Teach the travel anew before the next cycle.",
    Trip.WITHDRAWAL_BLOCKED: f"{OUT_FIRST} Do not force it: look for a kink or a bitten tube.",
    Trip.WITHDRAWAL_UNSEEN: f"{OUT_FIRST} Check the encoder's cable.",
    Trip.DRIVE_OVERFORCE: f"{OUT_FIRST} {SERVICE}",
    Trip.HEAD_SENSORS_DISAGREE: f"{OUT_FIRST} Look for a parted gear or a slipping encoder.",
    Trip.CARRIAGE_READING_INVALID: "See that the catheter is out. Check the cable of the sensor on "
    "the catheter head.",
    Trip.VACUUM_LOST: "Check pump and tubes; suction by hand when needed.",
    Trip.CANISTER_FULL: "Change the canister.",
    Trip.LINE_CLOGGED: "Rinse or change the catheter; check the tubes and the valve.",
    Trip.LINE_LEAKING: "Check the tubes, the canister's lid, the seal.",
    Trip.CARINA_MISSED: "Look at the patient: the catheter may have entered a bronchus. "
    "Check the taught travel.",
    Trip.CONTACT_STUCK_CLOSED: "Clean the tip or change the catheter; the machine does not start "
    "until then.",
    Trip.CONTACT_STUCK_OPEN: "Look at the patient: the tip may have pressed on the carina. Change "
    "the catheter, or stop by travel.",
    Trip.VALVE_STUCK_OPEN: f"{OUT_FIRST} Switch the pump off. Look for a leak. {SERVICE}",
    Trip.VALVE_STUCK_CLOSED: "Suction by hand when needed. Check the valve.",
    Trip.PUMP_RUNAWAY: f"Pull the pump's plug. {SERVICE}",
    Trip.CATHETER_JAMMED: f"{OUT_FIRST} Look for a kink before the next cycle.",
    Trip.SPO2_LOW: "Look at the patient. Give oxygen.",
    Trip.HEART_RATE_LOW: "Look at the patient. Stop suction.",
    Trip.AIRWAY_PRESSURE_UNSAFE: "Look at the patient. Check circuit, tube and ventilator.",
    Trip.LUNG_VOLUME_LOST: "Look at the patient. Recruit as ordered; lower vacuum or duration.",
    Trip.CIRCUIT_DISCONNECTED: "Look at the patient. Reconnect the circuit.",
    Trip.MONITOR_LINK_LOST: "Watch the monitor itself. Check its cables; no cycle starts.",
}

C = Condition
OWN_TEXTS: dict[Condition, Text] = {
    C.AUTOMATION_STOPPED: Text(
        "automatic suction has stopped",
        "Suction by hand when needed. Deal with what stopped it, then reset.",
    ),
    C.RECOVERY_NEEDED: Text(
        "the machine was put to work with the catheter not at its park position",
        "Look at the patient, then reset: the catheter is drawn out first.",
    ),
    C.CATHETER_LIFE_OVER: Text("the catheter is past its life", "Change the catheter."),
    C.CATHETER_LIFE_ENDING: Text(
        "the catheter's life ends soon", "Have a new catheter ready and plan its change."
    ),
    C.TIP_DETACHED: Text(
        "the catheter's tip may have come off",
        "Draw the catheter out by hand and look at its tip. Call a physician if it is incomplete.",
    ),
    C.RECORDER_LOST: Text(
        "the recorder does not answer", "Write down what happens; restart the recorder."
    ),
    C.CONSOLE_LOST: Text(
        "the console does not answer",
        "Stop with the machine's own button if needed. Restart the console.",
    ),
    C.RESERVE_ENERGY_USED: Text(
        "the machine runs on its reserve energy", "Restore mains power; the catheter comes out."
    ),
    C.PATIENT_SETTINGS_UNCONFIRMED: Text(
        "the patient settings are not confirmed",
        "Compare patient, tube and catheter with the settings, then confirm them.",
    ),
    C.MESSAGE_LATE: Text(
        "a drive does not answer in time", f"{OUT_FIRST} Check the bus cable; restart the machine."
    ),
    C.PASS_LIMIT_REACHED: Text(
        "secretions remain after the permitted number of passes",
        "Look at the patient. Suction by hand; consider a blocked tube.",
    ),
    C.CHECK_FAILED: Text(
        "the pre-use test has failed", "Read which item failed, correct it, then reset."
    ),
    C.WATCHDOG_FIRED: Text(
        "the drives' watchdog has stopped the machine", f"{OUT_FIRST} Restart the controller."
    ),
    C.CALIBRATION_OUT_OF_RANGE: Text(
        "the catheter's gap in its conduit is not what it was calibrated to be",
        "Suction by hand when needed. Lay the conduit as it was, or calibrate the machine anew.",
    ),
}

TEXTS: dict[Condition, Text] = {
    **OWN_TEXTS,
    **{Condition(int(t)): Text(trip.KINDS[t].sentence, r) for t, r in TRIP_REMEDIES.items()},
}
"""Every condition; a trip's sentence is the governor's own."""


def text(condition: int) -> Text:
    """Text of a condition by its number; also of one that has none, which is a software fault."""
    if condition in TEXTS:
        return TEXTS[Condition(condition)]
    return Text(f"unknown condition {condition}: the software is at fault", OUT_FIRST)
