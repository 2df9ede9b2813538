import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from opensuction.control.motion_profile import HeadLimits, step

DT_S = 0.001
LIMITS = HeadLimits(speed_mm_per_s=17.0, acceleration_mm_per_s2=200.0)
STEP_MM = LIMITS.acceleration_mm_per_s2 * DT_S * DT_S
"""Position gained by one tick of full acceleration: 0.2 um."""


def approach(goal_mm: float, ticks: int = 1500) -> NDArray[np.float64]:
    """Positions on the way from rest at 0 to a goal that stands still."""
    position, velocity = 0.0, 0.0
    positions = [position]
    for _ in range(ticks):
        velocity = step(LIMITS, goal_mm - position, 0.0, velocity, DT_S)
        position += velocity * DT_S
        positions.append(position)
    return np.array(positions)


@given(
    distance=st.floats(-100.0, 100.0),
    target=st.floats(-40.0, 40.0),
    velocity=st.floats(-17.0, 17.0),
)
def test_speed_and_acceleration_are_never_exceeded(
    distance: float, target: float, velocity: float
) -> None:
    following = step(LIMITS, distance, target, velocity, DT_S)
    assert abs(following) <= LIMITS.speed_mm_per_s
    assert abs(following - velocity) <= LIMITS.acceleration_mm_per_s2 * DT_S * (1.0 + 1e-12)


@pytest.mark.parametrize("goal_mm", [2e-4, 0.01, 1.0, 5.0, 16.5, -3.0])
def test_it_arrives_and_stays(goal_mm: float) -> None:
    path = approach(goal_mm)
    assert path[-1] == pytest.approx(goal_mm, abs=1e-9)
    assert path[-200:] == pytest.approx(goal_mm, abs=STEP_MM)


@pytest.mark.parametrize("goal_mm", [0.01, 1.0, 5.0, 16.5, -3.0])
def test_it_overshoots_by_less_than_a_tick_of_speed_is_rounded(goal_mm: float) -> None:
    path = np.sign(goal_mm) * approach(goal_mm)
    # Braking fits the distance only to one step of speed: 0.2 mm/s for a tick, 0.2 um.
    assert path.max() <= abs(goal_mm) + STEP_MM


@pytest.mark.parametrize("goal_mm", [1.0, 16.5])
def test_it_takes_hardly_longer_than_the_fastest_move(goal_mm: float) -> None:
    acceleration, speed = LIMITS.acceleration_mm_per_s2, LIMITS.speed_mm_per_s
    ramp = min(speed / acceleration, (goal_mm / acceleration) ** 0.5)
    fastest_s = ramp + goal_mm / (ramp * acceleration)
    arrived = int(np.argmax(approach(goal_mm) > goal_mm - 0.01))
    # The last steps of speed, one a tick, may be rounded: a few ticks.
    assert arrived * DT_S <= fastest_s + 0.005


def test_it_follows_a_goal_that_moves_without_lag() -> None:
    position, velocity = 0.0, 0.0
    for tick in range(1000):
        goal = 9.0 * tick * DT_S
        velocity = step(LIMITS, goal - position, 9.0, velocity, DT_S)
        position += velocity * DT_S
    assert velocity == pytest.approx(9.0)
    # One tick ahead: the velocity asked for is that of the tick to come.
    assert position == pytest.approx(9.0 * 1000 * DT_S, abs=1e-6)


def test_at_the_goal_nothing_moves() -> None:
    assert step(LIMITS, 0.0, 0.0, 0.0, DT_S) == 0.0
