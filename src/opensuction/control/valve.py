"""Cam of the suction valve: a ramp between closed and open at the cam's speed."""

from typing import NamedTuple

from opensuction.kernel.compiled import compiled


class ValveMotion(NamedTuple):
    """The cam's stroke: 30 degrees at 15 degrees per second in the paper."""

    open_rad: float
    speed_rad_per_s: float


@compiled
def step(motion: ValveMotion, cam_rad: float, opened: bool, dt_s: float) -> tuple[float, float]:
    """Next commanded cam angle (rad) and its velocity (rad/s) on the way to open or closed."""
    target = motion.open_rad if opened else 0.0
    reach = motion.speed_rad_per_s * dt_s
    move = min(max(target - cam_rad, -reach), reach)
    return cam_rad + move, move / dt_s
