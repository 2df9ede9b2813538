import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.control import backlash_inverse
from opensuction.control.backlash_inverse import AT_REST, Curves
from opensuction.control.motion_profile import HeadLimits

DT_S = 0.001
LIMITS = HeadLimits(speed_mm_per_s=17.0, acceleration_mm_per_s2=200.0)
CURVES = Curves(-10.0, 40.0, np.array([5.0, 49.0, 95.0]), np.array([-15.0, 27.0, 74.0]))


@given(tip=st.floats(-60.0, 160.0), outwards=st.booleans())
def test_a_branch_and_its_inverse_agree(tip: float, outwards: bool) -> None:
    inner, outer = backlash_inverse.branches_mm(CURVES, tip)
    assert inner > outer
    head = outer if outwards else inner
    assert backlash_inverse.tip_mm(CURVES, head, outwards) == pytest.approx(tip, abs=1e-9)


def test_the_entries_are_met_exactly() -> None:
    for i, depth in enumerate((-10.0, 30.0, 70.0)):
        expected = (CURVES.inwards_mm[i], CURVES.outwards_mm[i])
        assert backlash_inverse.branches_mm(CURVES, depth) == pytest.approx(expected)


def test_the_branch_changes_when_the_reference_turns_and_not_before() -> None:
    inner, outer = backlash_inverse.branches_mm(CURVES, 30.0)
    state = AT_REST._replace(head_mm=inner, lag_mm=-1.0)
    for _ in range(100):  # standing still says nothing about the way back
        state = backlash_inverse.step_lookup_table(CURVES, LIMITS, state, 30.0, 0.0, DT_S)
    assert state.head_mm == pytest.approx(inner)
    state = backlash_inverse.step_lookup_table(CURVES, LIMITS, state, 30.0, -0.001, DT_S)
    heads = []
    for _ in range(3000):  # 22 mm at 17 mm/s
        state = backlash_inverse.step_lookup_table(CURVES, LIMITS, state, 30.0, 0.0, DT_S)
        heads.append(state.head_mm)
        assert abs(state.head_mm_per_s) <= LIMITS.speed_mm_per_s
    assert np.diff(heads).max() <= 1e-4  # the last tick of the way comes back by 10 nm
    assert state.head_mm == pytest.approx(outer, abs=1e-6)
