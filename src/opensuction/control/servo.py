"""Proportional-derivative servo of an axis, with optional velocity and friction feedforward.

Both motors of the paper run under PD control, P = 10, D = 10 (insertion) and P = 7, D = 7 (valve).
The paper prints no units; here they are V/mm and mV s/mm for the insertion axis, V/deg and
mV s/deg for the valve axis.

Cam of the suction valve: a ramp between closed and open at the cam's speed.
"""

from typing import NamedTuple

from opensuction.kernel.compiled import compiled


class ValveMotion(NamedTuple):
    """The cam's stroke: 30 degrees at 15 degrees per second in the paper."""

    open_rad: float
    speed_rad_per_s: float


@compiled
def step_valve(
    motion: ValveMotion, cam_rad: float, opened: bool, dt_s: float
) -> tuple[float, float]:
    """Next commanded cam angle (rad) and its velocity (rad/s) on the way to open or closed."""
    target = motion.open_rad if opened else 0.0
    reach = motion.speed_rad_per_s * dt_s
    move = min(max(target - cam_rad, -reach), reach)
    return cam_rad + move, move / dt_s


class Servo(NamedTuple):
    """Gains in volts for each unit of the axis (mm or rad)."""

    proportional_v: float
    """Volts for each unit of position error."""
    derivative_v_s: float
    """Volts for each unit/s of error change."""
    velocity_v_s: float
    """Feedforward: volts for each unit/s of commanded velocity; 0 in the paper's scheme."""
    friction_v: float
    """Feedforward: volts in the direction of commanded motion; 0 in the paper's scheme."""
    time_constant_s: float
    """Feedforward: lead on the commanded velocity that cancels the axis' own lag."""
    voltage_limit_v: float
    back_emf_v_s: float
    """Volts that the motor needs for each unit/s of speed."""
    catch_up_v: float
    """Volts beyond those of the commanded speed that are there to go in faster: where the axis has
    fallen behind, its motor goes no faster than its voltage."""


class ServoState(NamedTuple):
    """State of a servo from one tick to the next."""

    error: float
    velocity: float


@compiled
def step(
    servo: Servo, state: ServoState, position: float, velocity: float, reading: float, dt_s: float
) -> tuple[ServoState, float]:
    """One tick of the servo.

    position, velocity: commanded, in units of the axis and units/s. reading: encoder.
    Returns the new state and the voltage, within the supply.
    """
    error = position - reading
    volts = servo.proportional_v * error + servo.derivative_v_s / dt_s * (error - state.error)
    lead = velocity + servo.time_constant_s / dt_s * (velocity - state.velocity)
    volts += servo.velocity_v_s * lead
    if velocity > 0.0:
        volts += servo.friction_v
    elif velocity < 0.0:
        volts -= servo.friction_v
    inwards_v = servo.friction_v + servo.back_emf_v_s * max(lead, 0.0) + servo.catch_up_v
    volts = min(max(volts, -servo.voltage_limit_v), servo.voltage_limit_v, inwards_v)
    return ServoState(error=error, velocity=velocity), volts
