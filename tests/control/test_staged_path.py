"""Insertion in two stages: bounded, smooth, at the slow speed from the switch on."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.control import motion_profile
from opensuction.control.motion_profile import Profile, StagedPath

PATHS = st.builds(
    StagedPath,
    start_mm=st.floats(-150.0, -1.0),
    switch_mm=st.floats(-0.5, 20.0),
    end_mm=st.floats(25.0, 120.0),
    fast_mm_per_s=st.floats(5.0, 60.0),
    slow_mm_per_s=st.floats(2.0, 20.0),
    acceleration_mm_per_s2=st.floats(50.0, 500.0),
)


def sampled(path: StagedPath, step_s: float) -> tuple[np.ndarray, np.ndarray]:
    times = np.arange(0.0, motion_profile.staged_duration_s(path) + 2 * step_s, step_s)
    points = [motion_profile.staged_at(path, float(time)) for time in times]
    return np.array([p for p, _ in points]), np.array([v for _, v in points])


@given(PATHS)
def test_goes_from_rest_to_rest_within_speed_and_acceleration(path: StagedPath) -> None:
    step_s = 0.01
    position, velocity = sampled(path, step_s)
    assert position[0] == path.start_mm
    assert position[-1] == path.end_mm
    assert velocity[0] == 0.0
    assert velocity[-1] == 0.0
    assert np.all(np.diff(position) >= 0.0)
    assert np.max(velocity) <= max(path.fast_mm_per_s, path.slow_mm_per_s) + 1e-9
    # A sample may straddle a corner, never exceed the slope on either side of it.
    assert np.max(np.abs(np.diff(velocity))) <= path.acceleration_mm_per_s2 * step_s * (1 + 1e-9)
    assert np.max(np.abs(np.diff(position) - velocity[1:] * step_s)) <= (
        path.acceleration_mm_per_s2 * step_s * step_s
    )


@given(PATHS)
def test_beyond_the_switch_it_is_never_faster_than_slow(path: StagedPath) -> None:
    position, velocity = sampled(path, 0.01)
    beyond = position >= path.switch_mm
    assert np.max(velocity[beyond]) <= path.slow_mm_per_s * (1 + 1e-9)


def test_adult_insertion_takes_the_sum_of_its_stages() -> None:
    path = StagedPath(-100.0, 0.0, 70.0, 30.0, 10.0, 200.0)
    # 100 mm: .15 s up (2.25 mm), .1 s down (2 mm), 95.75 mm at 30; 70 mm at 10 and half a ramp.
    assert motion_profile.staged_duration_s(path) == pytest.approx(
        0.15 + 0.1 + 95.75 / 30.0 + (70.0 - 0.25) / 10.0 + 0.05, abs=1e-9
    )


def test_without_room_to_be_fast_it_is_the_plain_profile() -> None:
    path = StagedPath(-0.01, 0.0, 70.0, 30.0, 10.0, 200.0)
    plain = Profile(-0.01, 70.0, 10.0, 200.0)
    assert motion_profile.staged_duration_s(path) == motion_profile.duration_s(plain)
    for time_s in (0.0, 0.03, 2.0, 7.0, 9.0):
        assert motion_profile.staged_at(path, time_s) == motion_profile.at(plain, time_s)
