import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.control import compensation
from opensuction.control.compensation import KIND_OF_NAME, Compensation, CompensationKind
from opensuction.control.exact_inverse import HeadState
from opensuction.control.head_path import HeadLimits
from opensuction.hysteresis import modified_dahl
from opensuction.hysteresis.modified_dahl import PUBLISHED

DT_S = 0.001
FULL = 1000.0
"""No slower than the head can."""


def chosen(kind: CompensationKind) -> Compensation:
    return Compensation(int(kind), PUBLISHED, HeadLimits(17.0, 200.0))


every_kind = pytest.mark.parametrize("kind", CompensationKind)


def test_every_kind_has_one_name() -> None:
    assert sorted(KIND_OF_NAME.values()) == sorted(CompensationKind)


@every_kind
def test_a_parked_head_stays(kind: CompensationKind) -> None:
    parked = compensation.parked(chosen(kind), 0.0)
    after = compensation.step(chosen(kind), parked, 0.0, 0.0, -1.0, DT_S)
    assert after.head_mm == pytest.approx(parked.head_mm, abs=1e-9)
    assert compensation.home(chosen(kind), parked, parked.head_mm, FULL, DT_S) == parked


@every_kind
def test_the_compensators_park_the_modelled_tip_on_the_reference(kind: CompensationKind) -> None:
    parked = compensation.parked(chosen(kind), 0.0)
    tip = modified_dahl.output_mm(PUBLISHED, parked.head_mm, parked.lag_mm)
    if kind == CompensationKind.NONE:
        assert parked.head_mm == 0.0
    else:
        assert tip == pytest.approx(0.0, abs=1e-12)


@every_kind
@given(head=st.floats(-60.0, 120.0), velocity=st.floats(-17.0, 17.0))
def test_home_is_reached_from_anywhere_within_the_limits(
    kind: CompensationKind, head: float, velocity: float
) -> None:
    state = HeadState(head, velocity, 0.0)
    outwards = head >= -3.0
    for tick in range(9000):  # 123 mm at 17 mm/s is 7.3 s
        before = state
        state = compensation.home(chosen(kind), state, -3.0, FULL, DT_S)
        assert abs(state.head_mm_per_s) <= 17.0
        if tick > 0:
            change = abs(state.head_mm_per_s - before.head_mm_per_s)
            assert change <= 0.2 * (1.0 + 1e-9)
        if outwards:  # never further in, not even to brake; the last tick rounds by 25 nm
            assert state.head_mm <= before.head_mm + 1e-4
        if state.head_mm == before.head_mm and state.head_mm_per_s == 0.0:
            break
    assert state.head_mm == pytest.approx(-3.0, abs=1e-6)


def test_homing_keeps_track_of_the_lag() -> None:
    state = HeadState(50.0, 0.0, -modified_dahl.saturation_mm(PUBLISHED))
    for _ in range(5000):
        state = compensation.home(chosen(CompensationKind.EXACT_INVERSE), state, 0.0, FULL, DT_S)
    start = -modified_dahl.saturation_mm(PUBLISHED)
    # The last tick of the way comes back by 25 nm, at up to 2 beta of lag for each.
    expected = modified_dahl.step(PUBLISHED, start, -50.0)
    assert state.lag_mm == pytest.approx(expected, abs=1e-4)
