"""Follow a target position with bounded speed and acceleration."""

import math
from typing import NamedTuple

from opensuction.kernel.compiled import compiled


class HeadLimits(NamedTuple):
    """Limits of the planned motion of the head."""

    speed_mm_per_s: float
    acceleration_mm_per_s2: float


@compiled
def step(
    limits: HeadLimits,
    distance_mm: float,
    target_mm_per_s: float,
    velocity_mm_per_s: float,
    dt_s: float,
) -> float:
    """Velocity for the next tick on the way to a moving target.

    distance_mm: signed distance to the target. target_mm_per_s: velocity of the target.
    velocity_mm_per_s: velocity of the last tick. As fast as speed and acceleration allow, yet
    never faster than the brakes: v = v_target + sqrt(2 a d), in ticks of ``dt_s``.
    """
    reach = limits.acceleration_mm_per_s2 * dt_s
    # The largest speed from which braking by one step a tick ends exactly at the target.
    steps = 2.0 * abs(distance_mm) / (reach * dt_s)
    braking = 0.5 * reach * (math.sqrt(1.0 + 4.0 * steps) - 1.0)
    closing = min(braking, abs(distance_mm) / dt_s)
    wanted = target_mm_per_s + math.copysign(closing, distance_mm)
    wanted = min(max(wanted, velocity_mm_per_s - reach), velocity_mm_per_s + reach)
    return min(max(wanted, -limits.speed_mm_per_s), limits.speed_mm_per_s)
