import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from opensuction.control.motion_profile import Profile, at, duration_s

profiles = st.builds(
    Profile,
    start_mm=st.floats(-200.0, 200.0),
    end_mm=st.floats(-200.0, 200.0),
    speed_mm_per_s=st.floats(0.5, 80.0),
    acceleration_mm_per_s2=st.floats(5.0, 3000.0),
)

PAPER = Profile(start_mm=0.0, end_mm=90.0, speed_mm_per_s=9.0, acceleration_mm_per_s2=200.0)


def sampled(profile: Profile, count: int = 400) -> tuple[NDArray[np.float64], ...]:
    """Times from before to after the move, positions and velocities."""
    total = duration_s(profile)
    times = np.linspace(-0.05 * total, 1.05 * total, count)
    values = np.array([at(profile, float(time)) for time in times])
    return times, values[:, 0], values[:, 1]


def test_the_papers_insertion() -> None:
    assert duration_s(PAPER) == pytest.approx(10.045)
    assert at(PAPER, 5.0225) == pytest.approx((45.0, 9.0))


def test_a_move_too_short_to_cruise_is_a_triangle() -> None:
    short = PAPER._replace(end_mm=0.2)
    # Half the way at 200 mm/s2: sqrt(0.2/200) each.
    assert duration_s(short) == pytest.approx(2.0 * (0.2 / 200.0) ** 0.5)
    assert at(short, 0.5 * duration_s(short))[1] == pytest.approx((0.2 * 200.0) ** 0.5)


@pytest.mark.parametrize("end_mm", [7.0, 7.0 + 5e-324, np.nextafter(7.0, 8.0)])
def test_no_distance_takes_no_time(end_mm: float) -> None:
    still = PAPER._replace(start_mm=7.0, end_mm=end_mm)
    assert duration_s(still) == pytest.approx(0.0, abs=1e-7)
    for time_s in (-1.0, 0.0, 1e-3, 5.0):
        assert at(still, time_s) == pytest.approx((7.0, 0.0), abs=1e-5)


def test_a_distance_lost_in_rounding_divides_nothing_by_zero() -> None:
    nearly = PAPER._replace(start_mm=0.0, end_mm=5e-324)
    assert duration_s(nearly) == 0.0
    assert at(nearly, 1.0) == (5e-324, 0.0)


@given(profile=profiles)
def test_it_rests_exactly_at_both_ends(profile: Profile) -> None:
    total = duration_s(profile)
    assert at(profile, 0.0) == (profile.start_mm, 0.0)
    assert at(profile, -1.0) == (profile.start_mm, 0.0)
    assert at(profile, total) == (profile.end_mm, 0.0)
    assert at(profile, total + 1e9) == (profile.end_mm, 0.0)


@given(profile=profiles)
def test_speed_and_acceleration_are_never_exceeded(profile: Profile) -> None:
    times, position, velocity = sampled(profile)
    step = float(times[1] - times[0])
    if step == 0.0:
        return
    # Positions near 200 are rounded to 3e-14, which differences divide by the step.
    noise = 1e-13 / step
    assert np.abs(velocity).max() <= profile.speed_mm_per_s * (1.0 + 1e-12)
    assert np.abs(np.diff(position)).max() / step <= profile.speed_mm_per_s * (1.0 + 1e-9) + noise
    limit = profile.acceleration_mm_per_s2 * (1.0 + 1e-9)
    assert np.abs(np.diff(velocity)).max() / step <= limit + noise
    assert np.abs(np.diff(position, 2)).max() / step**2 <= limit + 4.0 * noise / step


@given(profile=profiles)
def test_velocity_belongs_to_position(profile: Profile) -> None:
    times, position, velocity = sampled(profile)
    moved = np.sum(0.5 * (velocity[1:] + velocity[:-1]) * np.diff(times))
    # The trapezoid rule misses up to a step of acceleration at each of four corners.
    corner = profile.acceleration_mm_per_s2 * float(times[1] - times[0]) ** 2
    assert moved == pytest.approx(position[-1] - position[0], abs=corner + 1e-9)


@given(profile=profiles)
def test_it_never_turns_back_and_stays_between_the_ends(profile: Profile) -> None:
    _, position, velocity = sampled(profile)
    direction = 1.0 if profile.end_mm >= profile.start_mm else -1.0
    assert (direction * np.diff(position)).min() >= -1e-12
    assert (direction * velocity).min() >= 0.0
    assert position.min() >= min(profile.start_mm, profile.end_mm) - 1e-12
    assert position.max() <= max(profile.start_mm, profile.end_mm) + 1e-12


@given(profile=profiles, share=st.floats(0.0, 1.0))
def test_the_second_half_mirrors_the_first(profile: Profile, share: float) -> None:
    total = duration_s(profile)
    early, early_speed = at(profile, share * total)
    late, late_speed = at(profile, total - share * total)
    # Times are rounded to 2e-16 of the total, positions to 3e-14.
    slack = 1e-12 + 1e-14 * profile.speed_mm_per_s * total
    middle = 0.5 * (profile.start_mm + profile.end_mm)
    assert 0.5 * (early + late) == pytest.approx(middle, abs=slack)
    assert early_speed == pytest.approx(
        late_speed, abs=1e-14 * profile.acceleration_mm_per_s2 * total + 1e-12
    )


@given(profile=profiles)
def test_the_way_back_takes_as_long(profile: Profile) -> None:
    back = profile._replace(start_mm=profile.end_mm, end_mm=profile.start_mm)
    assert duration_s(back) == duration_s(profile)
    assert at(back, 0.3 * duration_s(profile))[1] == -at(profile, 0.3 * duration_s(profile))[1]
