"""Set points between a host's targets."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.machine.drives import interpolation
from opensuction.machine.drives.interpolation import Bounds

WIDE = Bounds(-100.0, 100.0, 1000.0)
DT_S = 0.001


def test_a_target_is_reached_evenly_at_the_end_of_its_period() -> None:
    now = interpolation.aim(interpolation.hold(1.0), 3.0, 4)
    places = []
    for _ in range(5):
        now = interpolation.follow(now, WIDE, DT_S)
        places.append((now.position, now.velocity))
    assert [place for place, _ in places] == pytest.approx([1.5, 2.0, 2.5, 3.0, 3.0])
    assert [speed for _, speed in places] == pytest.approx([500.0] * 4 + [0.0])


@given(
    start=st.floats(-90.0, 90.0),
    goal=st.floats(-500.0, 500.0),
    ticks=st.integers(0, 10),
    lowest=st.floats(-80.0, 0.0),
    highest=st.floats(0.0, 80.0),
)
def test_no_bound_is_passed_and_no_speed_exceeded(
    start: float, goal: float, ticks: int, lowest: float, highest: float
) -> None:
    bounds = Bounds(lowest, highest, 2000.0)
    place = start
    for _ in range(60):
        aimed = interpolation.aim(interpolation.hold(place), goal, ticks)
        before, place = place, interpolation.follow(aimed, bounds, DT_S).position
        assert abs(place - before) <= 2.0 + 1e-9
        # Never further beyond a bound than it was.
        assert min(before, lowest) - 1e-9 <= place <= max(before, highest) + 1e-9


def test_it_brakes_to_a_stop_and_stays() -> None:
    now = interpolation.hold(0.0)._replace(velocity=-20.0)
    for _ in range(101):
        now = interpolation.brake(now, 200.0, DT_S)
    assert now.velocity == 0.0
    assert now.position == pytest.approx(-(20.0**2) / (2 * 200.0), rel=0.02)
    assert interpolation.brake(now._replace(velocity=5.0), 0.0, DT_S).velocity == 0.0
