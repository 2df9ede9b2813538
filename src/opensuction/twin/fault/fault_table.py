"""What each fault means, how strong it can be, and whether it can be told.

Strengths are [assumed] where no source is given: ranges run from what does nothing much to what no
machine survives, defaults are strong enough to matter.
"""

from typing import NamedTuple

from opensuction.twin.fault.fault import Fault, Means, Part


class Strength(NamedTuple):
    """How strong a fault can be."""

    meaning: str
    unit: str
    """``1`` for a share or ratio."""
    least: float
    most: float
    default: float


class FaultKind(NamedTuple):
    """A row of the table of faults."""

    part: Part
    means: Means
    meaning: str
    """In one sentence: what is broken, and what that does."""
    strength: Strength | None
    """None where there is no more or less of it."""
    told: str
    """What can tell it; empty where nothing in this machine can as long as it is alone."""


def _share(meaning: str, default: float, least: float = 0.01, most: float = 1.0) -> Strength:
    return Strength(meaning, "1", least, most, default)


_M, _R, _L, _S = Means.MACHINE, Means.READING, Means.LINK, Means.SETTING

_SWITCH_TIP_CATHETER: dict[Fault, FaultKind] = {
    Fault.SWITCH_STUCK_OPEN: FaultKind(
        Part.SWITCH, _M, "the contact switch never closes", None, "no contact within the window"
    ),
    Fault.SWITCH_STUCK_CLOSED: FaultKind(
        Part.SWITCH,
        _M,
        "the contact switch is closed although nothing touches the tip",
        None,
        "pre-use test, contact where none can be, contact too long",
    ),
    Fault.SWITCH_BRIDGED: FaultKind(
        Part.SWITCH,
        _M,
        "mucus bridges the contact switch, which closes now and then without a touch",
        _share("share of the time for which it is closed", 0.3),
        "pre-use test, contact where none can be",
    ),
    Fault.SWITCH_STICKING: FaultKind(
        Part.SWITCH,
        _M,
        "the contact switch closes as it should but does not open again",
        None,
        "contact too long, pre-use test of the next cycle",
    ),
    Fault.SWITCH_BOUNCING: FaultKind(
        Part.SWITCH,
        _M,
        "the contact chatters for long after it has closed",
        Strength("how long", "s", 0.001, 10.0, 0.05),
        "",
    ),
    Fault.SWITCH_STIFF: FaultKind(
        Part.SWITCH,
        _M,
        "the contact switch needs more force than it should",
        Strength("force that closes it", "N", 0.081, 5.0, 0.25),
        "no contact within the window where the catheter buckles before",
    ),
    Fault.SWITCH_LATE: FaultKind(
        Part.SWITCH,
        _M,
        "the contact switch is read late",
        Strength("delay", "s", 0.001, 0.059, 0.05),
        "",
    ),
    Fault.SWITCH_INVALID: FaultKind(
        Part.SWITCH, _R, "the contact switch gives no valid reading", None, "its flag"
    ),
    Fault.CARINA_MISSED: FaultKind(
        Part.TIP,
        _M,
        "the tip slips past the carina into a bronchus and meets nothing",
        Strength("how much deeper the way is free", "mm", 5.0, 100.0, 40.0),
        "no contact within the window; none by travel, which stops short of the carina",
    ),
    Fault.TUBE_DISPLACED: FaultKind(
        Part.TIP,
        _M,
        "the tube has slid down or the neck is bent: the carina is nearer than was taught",
        Strength("how much nearer", "mm", 1.0, 60.0, 20.0),
        "contact before the window",
    ),
    Fault.TIP_BUCKLING: FaultKind(
        Part.TIP,
        _M,
        "the tip is so soft that it buckles before the contact switch closes",
        Strength("force at which it buckles", "N", 0.005, 0.08, 0.03),
        "no contact within the window",
    ),
    Fault.TIP_DETACHED: FaultKind(
        Part.TIP,
        _M,
        "the tip has come off with its contact switch, and lies in the airway",
        Strength("length of the tip", "mm", 1.0, 20.0, 5.0),
        "no contact within the window",
    ),
    Fault.CATHETER_KINKED: FaultKind(
        Part.CATHETER,
        _M,
        "the catheter is kinked: it rubs in its conduit, gives way there, and its bore is narrower",
        _share("share of the bore's diameter that is lost", 0.6, 0.1, 0.95),
        "head behind its command, motor current, vacuum signature of a clog",
    ),
    Fault.CATHETER_JAMMED: FaultKind(
        Part.CATHETER,
        _M,
        "the catheter is held fast",
        Strength("force that holds it", "N", 1.0, 50.0, 8.0),
        "motor current, head behind its command; under 2 N only by slowness",
    ),
    Fault.CONDUIT_REROUTED: FaultKind(
        Part.CATHETER,
        _M,
        "the conduit has been laid otherwise since the identification: its gap is another",
        Strength("gap over the identified one", "1", 0.3, 3.0, 1.5),
        "the next identification or self-calibration",
    ),
}

_INSERTION_DRIVE: dict[Fault, FaultKind] = {
    Fault.MOTOR_STALLED: FaultKind(
        Part.INSERTION_DRIVE, _M, "the insertion motor is seized", None, "head reading, current"
    ),
    Fault.MOTOR_LOST: FaultKind(
        Part.INSERTION_DRIVE,
        _M,
        "the insertion motor's winding is broken: no current, no torque, no braking",
        None,
        "head reading, current",
    ),
    Fault.MOTOR_WEAK: FaultKind(
        Part.INSERTION_DRIVE,
        _M,
        "the insertion drive gives less current than it should",
        _share("share of its force that is lost", 0.8, 0.05, 0.99),
        "head behind its command",
    ),
    Fault.MOTOR_REVERSED: FaultKind(
        Part.INSERTION_DRIVE,
        _M,
        "the insertion motor's wires are swapped: it turns the wrong way",
        None,
        "head against its command",
    ),
    Fault.GEAR_LOST: FaultKind(
        Part.INSERTION_DRIVE,
        _M,
        "the gear has parted: the motor turns, and the catheter head stays where it is",
        None,
        "the head's two sensors",
    ),
    Fault.GEAR_WORN: FaultKind(
        Part.INSERTION_DRIVE,
        _M,
        "gear and rack have more play than they should",
        Strength("play in addition", "mm", 0.1, 30.0, 5.0),
        "the head's two sensors; under 2 mm the next identification or self-calibration",
    ),
    Fault.ENCODER_FROZEN: FaultKind(
        Part.HEAD_ENCODER, _R, "the head encoder's value no longer changes", None, "head reading"
    ),
    Fault.ENCODER_SLIPPING: FaultKind(
        Part.HEAD_ENCODER,
        _R,
        "the head encoder's wheel slips: it counts less than the head moves",
        _share("share of the motion that is not counted", 0.2),
        "the head's two sensors",
    ),
    Fault.ENCODER_JUMPING: FaultKind(
        Part.HEAD_ENCODER,
        _R,
        "the head encoder's value jumps about, anew every 50 ms",
        Strength("largest jump", "mm", 0.1, 50.0, 5.0),
        "head speed",
    ),
    Fault.ENCODER_OFFSET: FaultKind(
        Part.HEAD_ENCODER,
        _R,
        "the head encoder has lost counts: it is off by a constant",
        Strength("reading less truth", "mm", -50.0, 50.0, -5.0),
        "head speed at the jump, the head's two sensors",
    ),
    Fault.ENCODER_NOISY: FaultKind(
        Part.HEAD_ENCODER,
        _R,
        "the head encoder's value is noisy",
        Strength("standard deviation", "mm", 0.005, 10.0, 0.5),
        "head speed",
    ),
    Fault.ENCODER_INVALID: FaultKind(
        Part.HEAD_ENCODER, _R, "the head encoder gives no valid reading", None, "its flag"
    ),
    Fault.ENCODER_REVERSED: FaultKind(
        Part.HEAD_ENCODER,
        _R,
        "the head encoder counts the wrong way",
        None,
        "the head's two sensors, head not following",
    ),
    Fault.CARRIAGE_SENSOR_FROZEN: FaultKind(
        Part.HEAD_ENCODER,
        _R,
        "the value of the sensor on the catheter head no longer changes",
        None,
        "the head's two sensors",
    ),
    Fault.CARRIAGE_SENSOR_INVALID: FaultKind(
        Part.HEAD_ENCODER,
        _R,
        "the sensor on the catheter head gives no valid reading",
        None,
        "its flag",
    ),
    Fault.CURRENT_SENSOR_DEAD: FaultKind(
        Part.INSERTION_DRIVE, _R, "the motor current always reads 0", None, ""
    ),
}

_VALVE: dict[Fault, FaultKind] = {
    Fault.VALVE_STUCK_OPEN: FaultKind(
        Part.VALVE,
        _M,
        "the valve's slide does not close, whatever the cam does",
        _share("opening that is left", 1.0, 0.05),
        "vacuum signature; the cam's encoder does not see it",
    ),
    Fault.VALVE_STUCK_CLOSED: FaultKind(
        Part.VALVE,
        _M,
        "the valve's slide has parted from the cam and does not open",
        Strength("opening that is left", "1", 0.0, 0.9, 0.0),
        "vacuum signature; the cam's encoder does not see it",
    ),
    Fault.VALVE_SLOW: FaultKind(
        Part.VALVE,
        _M,
        "cam and slide move through thick grease",
        _share("share of the speed that is lost", 0.8, 0.05, 0.99),
        "phase overdue, pre-use test",
    ),
    Fault.VALVE_JAMMED: FaultKind(
        Part.VALVE, _M, "the cam is seized where it stands", None, "the cam's encoder"
    ),
    Fault.VALVE_MOTOR_LOST: FaultKind(
        Part.VALVE,
        _M,
        "the valve motor's winding is broken: the spring closes the valve",
        None,
        "the cam's encoder",
    ),
    Fault.VALVE_SPRING_BROKEN: FaultKind(
        Part.VALVE,
        _M,
        "the return spring is broken: the valve closes only by its motor",
        None,
        "pre-use test",
    ),
    Fault.CAM_ENCODER_FROZEN: FaultKind(
        Part.CAM_ENCODER, _R, "the valve encoder's value no longer changes", None, "phase overdue"
    ),
    Fault.CAM_ENCODER_OFFSET: FaultKind(
        Part.CAM_ENCODER,
        _R,
        "the valve encoder is off by a constant",
        Strength("reading less truth", "rad", -0.6, 0.6, 0.1),
        "valve not seen closed",
    ),
    Fault.CAM_ENCODER_NOISY: FaultKind(
        Part.CAM_ENCODER,
        _R,
        "the valve encoder's value is noisy",
        Strength("standard deviation", "rad", 0.001, 0.5, 0.05),
        "valve not seen closed",
    ),
    Fault.CAM_ENCODER_INVALID: FaultKind(
        Part.CAM_ENCODER, _R, "the valve encoder gives no valid reading", None, "its flag"
    ),
}

_LINE: dict[Fault, FaultKind] = {
    Fault.PUMP_RUNAWAY: FaultKind(
        Part.SUCTION_LINE,
        _M,
        "the pump runs whatever it is told, and the regulator is shut",
        None,
        "line vacuum",
    ),
    Fault.PUMP_WEAK: FaultKind(
        Part.SUCTION_LINE,
        _M,
        "the pump moves less gas than it should",
        _share("share of its flow that is lost", 0.7, 0.05, 0.99),
        "vacuum signature, pre-use test",
    ),
    Fault.PUMP_LOST: FaultKind(
        Part.SUCTION_LINE, _M, "the pump stands still", None, "vacuum signature, pre-use test"
    ),
    Fault.REGULATOR_FAILED: FaultKind(
        Part.SUCTION_LINE,
        _M,
        "the regulator lets no air in: vacuum rises to the relief valve, and does not vent",
        None,
        "line vacuum, pre-use test",
    ),
    Fault.RELIEF_FAILED: FaultKind(
        Part.SUCTION_LINE,
        _M,
        "the relief valve does not open",
        None,
        "pre-use test; alone it does no harm",
    ),
    Fault.LINE_LEAK: FaultKind(
        Part.SUCTION_LINE,
        _M,
        "air leaks into line or canister",
        Strength("leak in addition", "mL/s/mmHg", 0.02, 50.0, 2.0),
        "vacuum signature, pre-use test",
    ),
    Fault.LINE_CLOGGED: FaultKind(
        Part.SUCTION_LINE,
        _M,
        "the catheter's bore is clogged",
        _share("share of its conductance that is lost", 0.95, 0.1),
        "vacuum signature",
    ),
    Fault.CANISTER_FULL: FaultKind(
        Part.SUCTION_LINE,
        _M,
        "the canister fills up: it holds less gas, and its float shuts the pump off when full",
        _share("share of its volume that is full; the float shuts from 0.95 on", 1.0, 0.1),
        "vacuum signature, pre-use test",
    ),
    Fault.VACUUM_SENSOR_FROZEN: FaultKind(
        Part.VACUUM_SENSOR, _R, "the vacuum sensor's value no longer changes", None, "signature"
    ),
    Fault.VACUUM_SENSOR_OFFSET: FaultKind(
        Part.VACUUM_SENSOR,
        _R,
        "the vacuum sensor is off by a constant",
        Strength("reading less truth", "mmHg", -200.0, 200.0, -50.0),
        "pre-use test: a vented line",
    ),
    Fault.VACUUM_SENSOR_NOISY: FaultKind(
        Part.VACUUM_SENSOR,
        _R,
        "the vacuum sensor's value is noisy",
        Strength("standard deviation", "mmHg", 0.5, 100.0, 20.0),
        "pre-use test",
    ),
    Fault.VACUUM_SENSOR_INVALID: FaultKind(
        Part.VACUUM_SENSOR, _R, "the vacuum sensor gives no valid reading", None, "its flag"
    ),
}

_LINK: dict[Fault, FaultKind] = {
    Fault.POWER_LOST: FaultKind(
        Part.POWER,
        _L,
        "mains power is gone; the drives draw the catheter out on reserve energy",
        None,
        "the drives themselves",
    ),
    Fault.POWER_LOST_WITHOUT_RESERVE: FaultKind(
        Part.POWER,
        _L,
        "mains power and reserve energy are gone: no torque, valve shut by its spring, line vented",
        None,
        "an alarm on a battery of its own",
    ),
    Fault.CONTROLLER_STOPPED: FaultKind(
        Part.CONTROLLER,
        _L,
        "the controller stops; a new one starts later",
        Strength("time until then", "s", 0.1, 600.0, 10.0),
        "the drives' own watchdog",
    ),
    Fault.TICK_LATE: FaultKind(
        Part.CONTROLLER,
        _L,
        "the controller's ticks end after their deadline",
        Strength("for how long", "s", 0.001, 60.0, 1.0),
        "the host's report of each",
    ),
    Fault.MESSAGE_LATE: FaultKind(
        Part.MESSAGE,
        _L,
        "commands reach the drives late",
        Strength("delay", "s", 0.001, 0.06, 0.02),
        "",
    ),
    Fault.MESSAGE_LOST: FaultKind(
        Part.MESSAGE,
        _L,
        "commands are lost on their way to the drives, which keep the last",
        _share("share that is lost", 1.0),
        "the drives' own watchdog",
    ),
    Fault.MESSAGE_REPEATED: FaultKind(
        Part.MESSAGE,
        _L,
        "the drives are sent the same old command again and again",
        None,
        "the drives' own watchdog: its number does not change",
    ),
    Fault.READING_LATE: FaultKind(
        Part.MESSAGE,
        _L,
        "readings reach the controller late",
        Strength("delay", "s", 0.001, 0.06, 0.02),
        "",
    ),
    Fault.READING_LOST: FaultKind(
        Part.MESSAGE,
        _L,
        "readings are lost on their way and come without a valid flag",
        _share("share that is lost", 1.0),
        "the flags",
    ),
    Fault.READING_REPEATED: FaultKind(
        Part.MESSAGE,
        _L,
        "the controller is sent the same old readings again and again",
        None,
        "head reading",
    ),
}

_PATIENT: dict[Fault, FaultKind] = {
    Fault.CIRCUIT_DISCONNECTED: FaultKind(
        Part.PATIENT,
        _M,
        "the breathing circuit has come off the tube",
        None,
        "pressure at the connector on the patient monitor",
    ),
    Fault.VENTILATOR_PRESSURE: FaultKind(
        Part.PATIENT,
        _M,
        "the ventilator gives a multiple of the pressures it is set to",
        Strength("of the pressures it is set to", "1", 0.0, 4.0, 3.0),
        "pressure at the connector on the patient monitor",
    ),
    Fault.DESATURATION: FaultKind(
        Part.PATIENT,
        _M,
        "blood passes the lung without oxygen",
        Strength("share of the blood that does", "1", 0.3, 0.9, 0.7),
        "saturation on the patient monitor, late",
    ),
    Fault.BRADYCARDIA: FaultKind(
        Part.PATIENT,
        _M,
        "the heart slows when the airway is touched",
        Strength("share of the rate that the strongest stimulus takes", "1", 0.5, 0.9, 0.8),
        "heart rate on the patient monitor",
    ),
    Fault.LUNG_VOLUME_LOST: FaultKind(
        Part.PATIENT,
        _M,
        "the ventilator makes up for less gas than suction takes",
        Strength("flow that it makes up for", "L/min", 0.0, 30.0, 0.0),
        "pressure at the connector on the patient monitor",
    ),
    Fault.MONITOR_LOST: FaultKind(
        Part.PATIENT,
        _M,
        "nothing of the patient monitor arrives",
        None,
        "the link's own silence",
    ),
}
"""Of the patient and the patient monitor, in `Machine.patient`; the bench has neither."""

_SETTING: dict[Fault, FaultKind] = {
    Fault.WRONG_PRESET: FaultKind(
        Part.SETTING,
        _S,
        "an adult's protocol is set for a neonate",
        None,
        "the guidelines of the patient's age, before the start",
    ),
    Fault.CATHETER_TOO_WIDE: FaultKind(
        Part.SETTING,
        _S,
        "a catheter is fitted that is too wide for the tube",
        None,
        "the guideline's ratio, before the start",
    ),
    Fault.CATHETER_EXPIRED: FaultKind(
        Part.SETTING,
        _S,
        "the catheter has been used for more than its life",
        Strength("since its first use", "h", 24.0, 1000.0, 25.0),
        "its clock, at the request",
    ),
    Fault.TAUGHT_TOO_DEEP: FaultKind(
        Part.SETTING,
        _S,
        "the way to the carina was taught longer than it is",
        Strength("too much", "mm", 1.0, 60.0, 20.0),
        "the range that is plausible for the age; contact before the window",
    ),
}

KINDS: dict[Fault, FaultKind] = {
    **_SWITCH_TIP_CATHETER,
    **_INSERTION_DRIVE,
    **_VALVE,
    **_LINE,
    **_LINK,
    **_PATIENT,
    **_SETTING,
}
"""Every fault that can be injected."""


def default_strength(fault: Fault) -> float:
    """Strength where none is given; 0 for a fault without one."""
    found = KINDS[fault].strength
    return 0.0 if found is None else found.default
