"""Faults of the suction valve, its drive and its encoder."""

from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_row import (
    ReadingEffect,
    Strength,
    frozen_reading,
    glitch,
    in_machine,
    invalid_reading,
    row,
    share,
)
from opensuction.twin.fault.insertion_fault import SEIZED_V
from opensuction.twin.fault.reading_fault import Channel, Mode
from opensuction.twin.machine.dc_axis import DcAxis


def _slow_down(axis: DcAxis, lost: float) -> DcAxis:
    """Drag in proportion to speed slows an axis down, and settles it sooner."""
    left = 1.0 - lost
    return axis._replace(
        speed_per_v=axis.speed_per_v * left, time_constant_s=axis.time_constant_s * left
    )


ROWS = {
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
