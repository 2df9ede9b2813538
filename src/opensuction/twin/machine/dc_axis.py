"""DC motor with gear, referred to its output: the physics of both axes.

The electrical time constant (0.02 ms for a 1524T024SR: 1.67 mH over 79.3 ohm) is a fiftieth of a
tick, so the current is settled; what remains is linear of first order and is integrated exactly
within a tick: exponentially while the voltage rules, at constant acceleration while the drive's
current limit does.
"""

import math
from typing import NamedTuple

from opensuction.kernel.compiled import compiled


class DcAxis(NamedTuple):
    """An axis in units of its output (mm for insertion, rad for the valve)."""

    speed_per_v: float
    """No-load speed for each volt, without friction (1/s per volt)."""
    time_constant_s: float
    """Mechanical time constant: speed reached to 63 % after a step of voltage."""
    voltage_limit_v: float
    """Supply."""
    friction_v: float
    """Coulomb friction as the voltage that just overcomes it."""
    force_v: float
    """Current limit as the voltage that drives that current at standstill."""
    encoder_step: float
    """Resolution of the encoder."""
    brakes_when_off: bool
    """Whether the drive shorts the motor's windings when its torque is off; else it is open."""
    polarity: float
    """1; -1 where the motor's wires are swapped."""


class AxisMotion(NamedTuple):
    """State of an axis."""

    position: float
    velocity: float
    drive_v: float
    """Voltage that drives current: supply minus back-EMF, limited; proportional to current."""


@compiled
def _free_run(
    axis: DcAxis, motion: AxisMotion, drive_v: float, limited: bool, brake_v: float, dt_s: float
) -> AxisMotion:
    """Motion of a moving axis against a constant braking voltage (friction and load)."""
    gain = axis.speed_per_v
    tau = axis.time_constant_s
    if limited:
        acceleration = gain * (drive_v - brake_v) / tau
        velocity = motion.velocity + acceleration * dt_s
        position = motion.position + (motion.velocity + velocity) * 0.5 * dt_s
    else:
        final = motion.velocity + gain * (drive_v - brake_v)
        decay = math.exp(-dt_s / tau)
        velocity = final + (motion.velocity - final) * decay
        position = motion.position + final * dt_s + (motion.velocity - final) * tau * (1.0 - decay)
    return AxisMotion(position=position, velocity=velocity, drive_v=drive_v)


@compiled
def step(
    axis: DcAxis, motion: AxisMotion, volts: float, on: bool, load_v: float, dt_s: float
) -> AxisMotion:
    """Advance an axis by one tick.

    volts: amplifier command, clamped to the supply. on: torque enabled; off, the windings are
    open or, where the drive ``brakes_when_off``, shorted: the motor brakes itself.
    load_v: force of the load against positive motion, as the voltage that would balance it.
    Returns the motion after ``dt_s`` seconds.
    """
    drive_v = 0.0
    limited = True
    if on or axis.brakes_when_off:
        wired_v = axis.polarity * volts
        supply_v = min(max(wired_v, -axis.voltage_limit_v), axis.voltage_limit_v) if on else 0.0
        wanted_v = supply_v - motion.velocity / axis.speed_per_v
        drive_v = min(max(wanted_v, -axis.force_v), axis.force_v)
        limited = drive_v != wanted_v
    net_v = drive_v - load_v
    if motion.velocity == 0.0:
        if abs(net_v) <= axis.friction_v:
            return AxisMotion(position=motion.position, velocity=0.0, drive_v=drive_v)
        direction = 1.0 if net_v > 0.0 else -1.0
    else:
        direction = 1.0 if motion.velocity > 0.0 else -1.0
    moved = _free_run(axis, motion, drive_v, limited, load_v + direction * axis.friction_v, dt_s)
    if moved.velocity * direction <= 0.0:
        # Friction can stop an axis but never turn it round: it rests until the next tick decides.
        # Within the tick it brakes evenly, so it stops after this share of it.
        share = motion.velocity / (motion.velocity - moved.velocity)
        rest = motion.position + 0.5 * motion.velocity * share * dt_s
        return AxisMotion(position=rest, velocity=0.0, drive_v=drive_v)
    return moved


@compiled
def stopped(motion: AxisMotion, least: float, most: float) -> AxisMotion:
    """Motion of an axis after its end stops, which it hits without a bounce."""
    if least <= motion.position <= most:
        return motion
    end = least if motion.position < least else most
    return AxisMotion(position=end, velocity=0.0, drive_v=motion.drive_v)


@compiled
def encoder(axis: DcAxis, motion: AxisMotion) -> float:
    """Position as the encoder reports it, rounded to its step."""
    return math.floor(motion.position / axis.encoder_step + 0.5) * axis.encoder_step
