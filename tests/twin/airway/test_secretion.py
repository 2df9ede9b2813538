import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.twin.airway import airway

FULL = np.full(12, 0.25)
NONE = np.zeros(12)
REACH_MM = 15.0

depths = st.floats(-40.0, 140.0)


@given(path=st.lists(st.tuples(depths, st.floats(0.0, 1.0)), max_size=20))
def test_what_is_taken_is_what_the_bins_lose(path: list[tuple[float, float]]) -> None:
    bins, taken = FULL, 0.0
    for tip_mm, share in path:
        part = share * airway.within_reach_ml(bins, tip_mm, REACH_MM)
        rest = airway.step_secretion(bins, NONE, tip_mm, REACH_MM, part, 0.01)
        assert np.all((rest >= 0.0) & (rest <= bins))
        bins, taken = rest, taken + part
    # To the rounding of a few dozen subtractions.
    assert taken + bins.sum() == pytest.approx(3.0, rel=1e-12)
    assert FULL.tolist() == [0.25] * 12


def test_a_tip_reaches_the_bins_in_front_of_it() -> None:
    # From 30 mm to 45 mm it reaches two bins.
    assert airway.within_reach_ml(FULL, 30.0, REACH_MM) == 0.5
    rest = airway.step_secretion(FULL, NONE, 30.0, REACH_MM, 0.5, 0.01)
    assert np.flatnonzero(rest == 0.0).tolist() == [3, 4]
    nearest = airway.step_secretion(FULL, NONE, 30.0, REACH_MM, 0.1, 0.01)
    assert nearest[3:5].tolist() == pytest.approx([0.15, 0.25])


@given(tip_mm=st.floats(-200.0, -REACH_MM))
def test_a_tip_in_the_tube_reaches_nothing(tip_mm: float) -> None:
    assert airway.within_reach_ml(FULL, tip_mm, REACH_MM) == 0.0


@given(hours=st.floats(0.0, 24.0), tip_mm=depths)
def test_what_is_produced_comes_on_top_of_what_is_left(hours: float, tip_mm: float) -> None:
    rate = np.linspace(0.0, 0.2, 12)
    taken = 0.5 * airway.within_reach_ml(FULL, tip_mm, REACH_MM)
    left = airway.step_secretion(FULL, NONE, tip_mm, REACH_MM, taken, hours)
    grown = airway.step_secretion(FULL, rate, tip_mm, REACH_MM, taken, hours)
    assert grown - left == pytest.approx(rate * hours, abs=1e-12)
