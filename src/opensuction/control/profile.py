"""Point-to-point motion with bounded speed and acceleration, in closed form of time.

Nothing is integrated, so nothing drifts: position at any time is a function of that time.
"""

import math
from typing import NamedTuple

from opensuction.kernel.compiled import compiled


class Profile(NamedTuple):
    """A move from rest to rest: accelerate, cruise, brake (trapezoid of velocity)."""

    start_mm: float
    end_mm: float
    speed_mm_per_s: float
    acceleration_mm_per_s2: float


@compiled
def _ramp_s(profile: Profile) -> float:
    """Duration of the accelerating part; shorter where the move is too short to cruise."""
    distance = abs(profile.end_mm - profile.start_mm)
    return min(
        profile.speed_mm_per_s / profile.acceleration_mm_per_s2,
        math.sqrt(distance / profile.acceleration_mm_per_s2),
    )


@compiled
def duration_s(profile: Profile) -> float:
    """Time from rest to rest."""
    distance = abs(profile.end_mm - profile.start_mm)
    ramp = _ramp_s(profile)
    if ramp == 0.0:
        return 0.0  # no way to go, or less than a root can tell from none
    return ramp + distance / (ramp * profile.acceleration_mm_per_s2)


@compiled
def at(profile: Profile, time_s: float) -> tuple[float, float]:
    """Position (mm) and velocity (mm/s) at ``time_s`` after the start; at rest outside the move."""
    total = duration_s(profile)
    if time_s <= 0.0:
        return profile.start_mm, 0.0
    if time_s >= total:
        return profile.end_mm, 0.0
    sign = 1.0 if profile.end_mm > profile.start_mm else -1.0
    ramp = _ramp_s(profile)
    acceleration = profile.acceleration_mm_per_s2
    speed = ramp * acceleration
    if time_s < ramp:
        travelled = 0.5 * acceleration * time_s * time_s
        return profile.start_mm + sign * travelled, sign * acceleration * time_s
    left = total - time_s
    if left < ramp:
        missing = 0.5 * acceleration * left * left
        return profile.end_mm - sign * missing, sign * acceleration * left
    travelled = speed * (time_s - 0.5 * ramp)
    return profile.start_mm + sign * travelled, sign * speed
