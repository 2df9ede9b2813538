"""Insertion in two stages: fast inside the tube, slow beyond its end, in closed form of time."""

import math
from typing import NamedTuple

from opensuction.control import profile
from opensuction.control.profile import Profile
from opensuction.kernel.compiled import compiled


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
def duration_s(path: StagedPath) -> float:
    """Time from rest to rest."""
    stages = _stages(path)
    if not stages.staged:
        return profile.duration_s(_slow_move(path, path.start_mm))
    skipped = path.slow_mm_per_s / path.acceleration_mm_per_s2
    return _first_s(stages) + profile.duration_s(_slow_end(path)) - skipped


@compiled
def at(path: StagedPath, time_s: float) -> tuple[float, float]:
    """Position (mm) and velocity (mm/s) at ``time_s`` after the start; at rest outside the move."""
    stages = _stages(path)
    if not stages.staged:
        return profile.at(_slow_move(path, path.start_mm), time_s)
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
    return profile.at(_slow_end(path), skipped - left)
