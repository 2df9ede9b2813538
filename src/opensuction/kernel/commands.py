"""Commands of the controller to the actuators in each tick."""

from typing import NamedTuple


class Setpoints(NamedTuple):
    """Setpoints of the machine in a tick, before the servos turn them into volts.

    Procedure and control propose one of these; the governor may only narrow it.
    """

    head_mm: float
    """Catheter head position (u_FF)."""
    head_mm_per_s: float
    """Velocity that belongs to it; the feedforward uses it."""
    insertion_on: bool
    """Torque of the insertion drive; off, a hand may move the head."""
    valve_open: bool
    """Cam towards open or towards closed, at the machine's cam speed."""
    pump_on: bool
    vacuum_mmhg: float
    """Regulator set point."""


class Commands(NamedTuple):
    """Actuator commands of one tick, as the governor let them through."""

    head_mm: float
    insertion_v: float
    insertion_on: bool
    """Torque of the insertion drive."""
    cam_rad: float
    valve_v: float
    valve_on: bool
    """Torque of the valve drive; off, the spring closes the valve."""
    pump_on: bool
    vacuum_mmhg: float
