"""Point-to-point motion with bounded speed and acceleration, in closed form of time.

Nothing is integrated, so nothing drifts: position at any time is a function of that time.

Follow a target position with bounded speed and acceleration.

Insertion in two stages: fast inside the tube, slow beyond its end, in closed form of time.
"""

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


class StagedPath(NamedTuple):
    """A move inwards from rest to rest that passes ``switch_mm`` at the slow speed."""

    start_mm: float
    switch_mm: float
    end_mm: float
    fast_mm_per_s: float
    slow_mm_per_s: float
    acceleration_mm_per_s2: float


class _Stages(NamedTuple):
    """Speeds and times of the first stage; ``staged`` is false where there is none."""

    staged: bool
    peak_mm_per_s: float
    ramp_up_s: float
    cruise_s: float
    ramp_down_s: float


@compiled
def _stages(path: StagedPath) -> _Stages:
    distance = path.switch_mm - path.start_mm
    slow, acceleration = path.slow_mm_per_s, path.acceleration_mm_per_s2
    # Fast enough to matter only where there is room to reach the slow speed and more.
    room = 2.0 * acceleration * distance - slow * slow
    if path.fast_mm_per_s <= slow or room <= 0.0 or path.switch_mm >= path.end_mm:
        return _Stages(False, 0.0, 0.0, 0.0, 0.0)
    peak = min(path.fast_mm_per_s, math.sqrt(acceleration * distance + 0.5 * slow * slow))
    used = (peak * peak - 0.5 * slow * slow) / acceleration
    return _Stages(
        staged=True,
        peak_mm_per_s=peak,
        ramp_up_s=peak / acceleration,
        cruise_s=(distance - used) / peak,
        ramp_down_s=(peak - slow) / acceleration,
    )


@compiled
def _slow_move(path: StagedPath, start_mm: float) -> Profile:
    """A move at the slow speed from rest to the end of the path."""
    return Profile(
        start_mm=start_mm,
        end_mm=path.end_mm,
        speed_mm_per_s=path.slow_mm_per_s,
        acceleration_mm_per_s2=path.acceleration_mm_per_s2,
    )


@compiled
def _slow_end(path: StagedPath) -> Profile:
    """The second stage as the later part of a move that started earlier, from rest."""
    lead = 0.5 * path.slow_mm_per_s * path.slow_mm_per_s / path.acceleration_mm_per_s2
    return _slow_move(path, path.switch_mm - lead)


@compiled
def _first_s(stages: _Stages) -> float:
    return stages.ramp_up_s + stages.cruise_s + stages.ramp_down_s


@compiled
def staged_duration_s(path: StagedPath) -> float:
    """Time from rest to rest."""
    stages = _stages(path)
    if not stages.staged:
        return duration_s(_slow_move(path, path.start_mm))
    skipped = path.slow_mm_per_s / path.acceleration_mm_per_s2
    return _first_s(stages) + duration_s(_slow_end(path)) - skipped


@compiled
def staged_at(path: StagedPath, time_s: float) -> tuple[float, float]:
    """Position (mm) and velocity (mm/s) at ``time_s`` after the start; at rest outside the move."""
    stages = _stages(path)
    if not stages.staged:
        return at(_slow_move(path, path.start_mm), time_s)
    if time_s <= 0.0:
        return path.start_mm, 0.0
    acceleration, peak = path.acceleration_mm_per_s2, stages.peak_mm_per_s
    if time_s < stages.ramp_up_s:
        velocity = acceleration * time_s
        return path.start_mm + 0.5 * velocity * time_s, velocity
    if time_s < stages.ramp_up_s + stages.cruise_s:
        return path.start_mm + peak * (time_s - 0.5 * stages.ramp_up_s), peak
    left = _first_s(stages) - time_s
    if left > 0.0:
        velocity = path.slow_mm_per_s + acceleration * left
        return path.switch_mm - 0.5 * (path.slow_mm_per_s + velocity) * left, velocity
    skipped = path.slow_mm_per_s / acceleration
    return at(_slow_end(path), skipped - left)
