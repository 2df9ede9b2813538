"""Faults of the catheter in its conduit, of the insertion drive, and of the head's two sensors.

Faults of the suction valve, its drive and its encoder.
"""

import math

from opensuction.kernel.unit import BLASIUS_POWER
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_row import (
    BY_TURNS,
    MachineEffect,
    ReadingEffect,
    Strength,
    by_turns_of,
    drifting,
    frozen_reading,
    glitch,
    in_machine,
    intermittent_reading,
    invalid_reading,
    lasting,
    row,
    share,
    turn,
)
from opensuction.twin.fault.reading_fault import Channel, Mode
from opensuction.twin.fault.suction_fault import narrow_bore
from opensuction.twin.machine import transmission
from opensuction.twin.machine.dc_axis import DcAxis
from opensuction.twin.machine.machine import Machine
from opensuction.twin.machine.transmission import Transmission

SEIZED_V = 1.0e6
"""Friction that no drive overcomes, and every motion ends in at once."""
PARTED_MM = 1.0e9
"""Play across which nothing is moved."""
KINK_N = 3.0
"""[assumed] Friction of a catheter that is kinked flat, at the head."""
KINK_MM = 15.0
"""[assumed] Head travel that a catheter kinked flat gives way before it moves on."""

PULSE_S = 0.06
"""[assumed] A disturbance on the current's line lasts three periods of the mains' 50 Hz."""
ALTERNATION_S = 0.1
"""[assumed] A loose contact on a head that moves at 10 to 30 mm/s meets a bend every few mm."""
JUMP = Strength("reading less truth", "mm", -50.0, 50.0, 5.0)
DRIFT = Strength("reading less truth, for each second", "mm/s", -20.0, 20.0, 0.5)
CURRENT = Strength("reading less truth", "A", -0.2, 0.2, 0.02)
CARRIAGE = "the value of the sensor on the catheter head"


def _add_friction(machine: Machine, force_n: float) -> Machine:
    """Friction in addition, as a force at the head."""
    axis, more_v = machine.insertion_axis, machine.load_v_per_n * force_n
    return machine._replace(insertion_axis=axis._replace(friction_v=axis.friction_v + more_v))


def _kink(machine: Machine, lost: float) -> Machine:
    """Turbulent gas and creeping mucus through what is left of the bore; friction at the kink."""
    left = 1.0 - lost
    narrow = narrow_bore(_add_friction(machine, lost * KINK_N), left**BLASIUS_POWER, left**4)
    conduit = narrow.transmission
    stretch = conduit.stretch_mm + lost * KINK_MM
    return narrow._replace(transmission=conduit._replace(stretch_mm=stretch))


def _reroute(conduit: Transmission, gap_ratio: float) -> Transmission:
    wider = transmission.widen(conduit, gap_ratio)
    return wider._replace(stretch_mm=conduit.stretch_mm * gap_ratio)


ROWS = {
    Fault.CATHETER_KINKED: row(
        "the catheter is kinked: it rubs in its conduit, gives way there, and its bore is narrower",
        MachineEffect(_kink),
        share("share of the bore's diameter that is lost", 0.6, 0.1, 0.95),
        detected_by="head behind its command, motor current, vacuum signature of a clog",
    ),
    Fault.CATHETER_JAMMED: row(
        "the catheter is held fast",
        MachineEffect(_add_friction),
        Strength("force that holds it", "N", 1.0, 50.0, 8.0),
        detected_by="motor current, head behind its command; under 2 N only by slowness",
    ),
    Fault.CONDUIT_REROUTED: row(
        "the conduit has been laid otherwise since the identification: its gap is another",
        in_machine("transmission", _reroute),
        Strength("gap over the identified one", "1", 0.3, 3.0, 1.5),
        detected_by="the next identification or self-calibration",
    ),
    Fault.MOTOR_STALLED: row(
        "the insertion motor is seized",
        in_machine("insertion_axis", lambda axis, _: axis._replace(friction_v=SEIZED_V)),
        detected_by="head reading, current",
    ),
    Fault.MOTOR_LOST: row(
        "the insertion motor's winding is broken: no current, no torque, no braking",
        in_machine("insertion_axis", lambda axis, _: axis._replace(force_v=0.0)),
        detected_by="head reading, current",
    ),
    Fault.MOTOR_WEAK: row(
        "the insertion drive gives less current than it should",
        in_machine(
            "insertion_axis", lambda axis, lost: axis._replace(force_v=axis.force_v * (1.0 - lost))
        ),
        share("share of its force that is lost", 0.8, 0.05, 0.99),
        detected_by="head behind its command",
    ),
    Fault.MOTOR_REVERSED: row(
        "the insertion motor's wires are swapped: it turns the wrong way",
        in_machine("insertion_axis", lambda axis, _: axis._replace(polarity=-axis.polarity)),
        detected_by="head against its command",
    ),
    Fault.GEAR_LOST: row(
        "the gear has parted: the motor turns, and the catheter head stays where it is",
        # Neither does the head follow the motor, nor does the motor feel the head.
        MachineEffect(lambda it, _: it._replace(gear_backlash_mm=PARTED_MM, load_v_per_n=0.0)),
        detected_by="the head's two sensors",
    ),
    Fault.GEAR_WORN: row(
        "gear and rack have more play than they should",
        in_machine("gear_backlash_mm", lambda play_mm, more_mm: play_mm + more_mm),
        Strength("play in addition", "mm", 0.1, 30.0, 5.0),
        detected_by="the head's two sensors; under 2 mm the next identification or "
        "self-calibration",
    ),
    Fault.ENCODER_FROZEN: frozen_reading(Channel.HEAD, "the head encoder's value", "head reading"),
    Fault.ENCODER_SLIPPING: row(
        "the head encoder's wheel slips: it counts less than the head moves",
        ReadingEffect(Channel.HEAD, Mode.SCALED),
        share("share of the motion that is not counted", 0.2),
        detected_by="the head's two sensors",
    ),
    Fault.ENCODER_JUMPING: row(
        "the head encoder's value jumps about, anew every 50 ms",
        ReadingEffect(Channel.HEAD, Mode.JUMPING),
        Strength("largest jump", "mm", 0.1, 50.0, 5.0),
        detected_by="head speed",
    ),
    Fault.ENCODER_OFFSET: row(
        "the head encoder has lost counts: it is off by a constant",
        ReadingEffect(Channel.HEAD, Mode.OFFSET),
        Strength("reading less truth", "mm", -50.0, 50.0, -5.0),
        detected_by="head speed at the jump, the head's two sensors",
    ),
    Fault.ENCODER_NOISY: row(
        "the head encoder's value is noisy",
        ReadingEffect(Channel.HEAD, Mode.NOISY),
        Strength("standard deviation", "mm", 0.005, 10.0, 0.5),
        detected_by="head speed",
    ),
    Fault.ENCODER_INVALID: invalid_reading(Channel.HEAD, "the head encoder"),
    Fault.ENCODER_REVERSED: row(
        "the head encoder counts the wrong way",
        ReadingEffect(Channel.HEAD, Mode.SCALED, factor=-1.0),
        detected_by="the head's two sensors, head not following",
    ),
    Fault.CARRIAGE_SENSOR_FROZEN: frozen_reading(
        Channel.CARRIAGE,
        "the value of the sensor on the catheter head",
        "the head's two sensors",
    ),
    Fault.CARRIAGE_SENSOR_INVALID: invalid_reading(
        Channel.CARRIAGE, "the sensor on the catheter head"
    ),
    Fault.CURRENT_SENSOR_DEAD: row(
        "the motor current always reads 0",
        ReadingEffect(Channel.CURRENT, Mode.DEAD),
    ),
    Fault.ENCODER_GLITCH: glitch(
        Channel.HEAD, "the head encoder's value", JUMP._replace(default=0.5)
    ),
    Fault.ENCODER_DRIFTING: drifting(
        Channel.HEAD, "the head encoder's value", DRIFT, "the head's two sensors"
    ),
    Fault.ENCODER_INTERMITTENT: intermittent_reading(
        Channel.HEAD, "the head encoder", "its flag, from five ticks in a row on"
    ),
    Fault.ENCODER_ALTERNATING: row(
        "the head encoder is off by a constant, by turns of 0.1 s",
        ReadingEffect(Channel.HEAD, Mode.OFFSET, spell=by_turns_of(ALTERNATION_S)),
        JUMP,
        detected_by="head speed at the jumps, the head's two sensors",
    ),
    Fault.CARRIAGE_GLITCH: glitch(Channel.CARRIAGE, CARRIAGE, JUMP._replace(default=0.5)),
    Fault.CARRIAGE_DRIFTING: drifting(Channel.CARRIAGE, CARRIAGE, DRIFT, "the head's two sensors"),
    Fault.CARRIAGE_INTERMITTENT: intermittent_reading(
        Channel.CARRIAGE, "the sensor on the catheter head", "its flag, from five ticks in a row on"
    ),
    Fault.CARRIAGE_ALTERNATING: row(
        "the sensor on the catheter head is off by a constant, by turns of 0.1 s",
        ReadingEffect(Channel.CARRIAGE, Mode.OFFSET, spell=by_turns_of(ALTERNATION_S)),
        JUMP,
        detected_by="the head's two sensors",
    ),
    Fault.HEAD_SENSORS_DRIFTING: drifting(
        Channel.HEADS,
        "the common zero of the head's two sensors",
        Strength("reading less truth, for each second", "mm/s", -5.0, 5.0, -0.2),
        "the motor's volts and current; contact before or after its window; the light barrier",
    ),
    Fault.CURRENT_GLITCH: glitch(Channel.CURRENT, "the motor current's value", CURRENT),
    Fault.CURRENT_PULSE: row(
        "the motor current reads wrong for 60 ms",
        ReadingEffect(Channel.CURRENT, Mode.OFFSET, spell=lasting(PULSE_S)),
        CURRENT,
    ),
    Fault.CURRENT_OFFSET: row(
        "the motor current is off by a constant",
        ReadingEffect(Channel.CURRENT, Mode.OFFSET),
        CURRENT,
        detected_by="its value while the drive rests",
    ),
    Fault.CURRENT_NOISY: row(
        "the motor current is noisy",
        ReadingEffect(Channel.CURRENT, Mode.NOISY),
        Strength("standard deviation", "A", 0.001, 0.2, 0.02),
    ),
    Fault.MOTOR_INTERMITTENT: row(
        "the insertion motor's winding has a loose contact: it has torque by turns",
        in_machine("insertion_axis", lambda axis, _: axis._replace(force_v=0.0)),
        turn(0.1, least_s=0.01),
        detected_by="head reading, current",
        course=BY_TURNS,
    ),
    Fault.CLAMP_SLIPPING: row(
        "the clamp between head and catheter slips: the catheter moves less than the head, in and "
        "out",
        in_machine("clamp_slip_ratio", lambda _, lost: lost),
        share("share of the head's travel that is lost", 0.2),
        detected_by="no contact within the window; the light barrier, by a catheter that does not "
        "come with its head",
    ),
    Fault.MOUTH_BLIND: row(
        "the light barrier at the tube's mouth sees no catheter",
        in_machine("mouth_mm", lambda _mouth_mm, _: math.inf),
        detected_by="itself, on the way in: it must see the catheter before the tube",
    ),
    Fault.MOUTH_DARK: row(
        "the light barrier at the tube's mouth gets no light: dirt, or a broken wire",
        in_machine("mouth_mm", lambda _mouth_mm, _: -math.inf),
        detected_by="itself, with the catheter out",
    ),
}


def _slow_down(axis: DcAxis, lost: float) -> DcAxis:
    """Drag in proportion to speed slows an axis down, and settles it sooner."""
    left = 1.0 - lost
    return axis._replace(
        speed_per_v=axis.speed_per_v * left, time_constant_s=axis.time_constant_s * left
    )


VALVE_FAULT_ROWS = {
    Fault.VALVE_STUCK_OPEN: row(
        "the valve's slide does not close, whatever the cam does",
        in_machine("valve", lambda valve, left: valve._replace(least_ratio=left)),
        share("opening that is left", 1.0, 0.05),
        detected_by="vacuum signature; the cam's encoder does not see it",
    ),
    Fault.VALVE_STUCK_CLOSED: row(
        "the valve's slide has parted from the cam and does not open",
        in_machine("valve", lambda valve, left: valve._replace(most_ratio=left)),
        Strength("opening that is left", "1", 0.0, 0.9, 0.0),
        detected_by="vacuum signature; the cam's encoder does not see it",
    ),
    Fault.VALVE_SLOW: row(
        "cam and slide move through thick grease",
        in_machine("valve_axis", _slow_down),
        share("share of the speed that is lost", 0.8, 0.05, 0.99),
        detected_by="phase overdue, pre-use test",
    ),
    Fault.VALVE_JAMMED: row(
        "the cam is seized where it stands",
        in_machine("valve_axis", lambda axis, _: axis._replace(friction_v=SEIZED_V)),
        detected_by="the cam's encoder",
    ),
    Fault.VALVE_MOTOR_LOST: row(
        "the valve motor's winding is broken: the spring closes the valve",
        in_machine("valve_axis", lambda axis, _: axis._replace(force_v=0.0)),
        detected_by="the cam's encoder",
    ),
    Fault.VALVE_SPRING_BROKEN: row(
        "the return spring is broken: the valve closes only by its motor",
        in_machine(
            "valve", lambda valve, _: valve._replace(spring_preload_v=0.0, spring_v_per_rad=0.0)
        ),
        detected_by="pre-use test",
    ),
    Fault.CAM_ENCODER_FROZEN: frozen_reading(
        Channel.CAM, "the valve encoder's value", "phase overdue"
    ),
    Fault.CAM_ENCODER_OFFSET: row(
        "the valve encoder is off by a constant",
        ReadingEffect(Channel.CAM, Mode.OFFSET),
        Strength("reading less truth", "rad", -0.6, 0.6, 0.1),
        detected_by="valve not seen closed",
    ),
    Fault.CAM_ENCODER_NOISY: row(
        "the valve encoder's value is noisy",
        ReadingEffect(Channel.CAM, Mode.NOISY),
        Strength("standard deviation", "rad", 0.001, 0.5, 0.05),
        detected_by="valve not seen closed",
    ),
    Fault.CAM_ENCODER_INVALID: invalid_reading(Channel.CAM, "the valve encoder"),
    Fault.CAM_GLITCH: glitch(
        Channel.CAM,
        "the valve encoder's value",
        Strength("reading less truth", "rad", -0.6, 0.6, 0.1),
    ),
}
