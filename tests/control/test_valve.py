import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.control.servo import ValveMotion, step_valve

PAPER = ValveMotion(open_rad=math.radians(30.0), speed_rad_per_s=math.radians(15.0))


@pytest.mark.parametrize(("opened", "start", "end"), [(True, 0.0, 1.0), (False, 1.0, 0.0)])
def test_a_stroke_takes_two_seconds_and_ends_exactly(
    opened: bool, start: float, end: float
) -> None:
    cam, ticks = start * PAPER.open_rad, 0
    while cam != end * PAPER.open_rad:
        cam, speed = step_valve(PAPER, cam, opened, 0.001)
        ticks += 1
        assert abs(speed) <= PAPER.speed_rad_per_s * (1.0 + 1e-9)
        assert ticks < 3000
    assert ticks == pytest.approx(2000, abs=1)  # the last step may be rounding
    assert step_valve(PAPER, cam, opened, 0.001) == (cam, 0.0)


@given(share=st.floats(0.0, 1.0), opened=st.booleans(), dt_s=st.floats(1e-5, 0.1))
def test_it_never_leaves_its_stroke_and_moves_the_right_way(
    share: float, opened: bool, dt_s: float
) -> None:
    before = share * PAPER.open_rad
    cam, speed = step_valve(PAPER, before, opened, dt_s)
    assert 0.0 <= cam <= PAPER.open_rad
    assert speed >= 0.0 if opened else speed <= 0.0
    assert cam == pytest.approx(before + speed * dt_s, abs=1e-12)


def test_it_can_turn_in_the_middle_of_a_stroke() -> None:
    cam, _ = step_valve(PAPER, 0.2, True, 0.001)
    assert step_valve(PAPER, cam, False, 0.001)[0] == pytest.approx(0.2)
