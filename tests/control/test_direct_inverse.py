import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from opensuction.control.backlash_inverse import AT_REST, DEAD_MOVE_MM, direct_step
from opensuction.hysteresis import modified_dahl
from opensuction.hysteresis.modified_dahl import PUBLISHED, ModifiedDahl

DT_S = 0.001
SATURATION_MM = modified_dahl.saturation_mm(PUBLISHED)


def commands(model: ModifiedDahl, reference_mm: NDArray[np.float64]) -> NDArray[np.float64]:
    """Head commands for a reference, saturated by a retract at first, one entry a tick."""
    lag = modified_dahl.saturation_mm(model)
    head = (reference_mm[0] - lag - model.offset_mm) / model.slope
    state, heads = AT_REST._replace(head_mm=head, lag_mm=lag), []
    for reference in reference_mm:
        state = direct_step(model, state, float(reference), DT_S)
        heads.append(state.head_mm)
    return np.array(heads)


PAPER_CYCLE = np.concatenate(
    [np.linspace(0.0, 90.0, 10001), np.full(9000, 90.0), np.linspace(90.0, 0.0, 10001)]
)
"""Reference of the paper's cycle at 1 kHz: 9 mm/s in, 9 s dwell, 9 mm/s back."""


def test_the_published_parameters_jump_at_both_reversals() -> None:
    jumps = np.abs(np.diff(commands(PUBLISHED, PAPER_CYCLE)))
    # [calc-inverse]: 2.62 mm in one sample of 1 ms; the smooth motion is 0.03 mm a sample at most.
    assert jumps.max() == pytest.approx(2.62, abs=0.005)
    # It grows 2 beta/c-fold a tick until it has jumped: over within 20 ms of each reversal.
    large = np.flatnonzero(jumps > 1.0)
    assert np.all((large < 20) | ((large > 19000) & (large < 19020)))
    assert {bool(tick < 20) for tick in large} == {True, False}


def test_a_monotone_model_does_not_jump() -> None:
    gentle = PUBLISHED._replace(velocity_gain=0.4)
    assert modified_dahl.is_monotone(gentle)
    # 9 mm/s through the shallowest slope, c - 2 beta = 0.17, of a converging recursion.
    assert np.abs(np.diff(commands(gentle, PAPER_CYCLE))).max() < 0.009 / 0.16


def test_a_reference_at_rest_leaves_the_estimate_alone() -> None:
    heads = commands(PUBLISHED, PAPER_CYCLE)
    dwell = heads[10200:19000]
    assert np.ptp(dwell) < 1e-9


@given(offset=st.floats(-0.99e-9, 0.99e-9), lag=st.floats(-SATURATION_MM, SATURATION_MM))
def test_moves_too_small_to_mean_anything_leave_the_lag_unchanged(
    offset: float, lag: float
) -> None:
    reference = 40.0
    head = (reference - lag - PUBLISHED.offset_mm) / PUBLISHED.slope
    state = AT_REST._replace(head_mm=head + offset, lag_mm=lag)
    after = direct_step(PUBLISHED, state, reference, DT_S)
    assert abs(after.head_mm - state.head_mm) < DEAD_MOVE_MM
    assert after.lag_mm == lag


@given(reference=st.floats(0.0, 90.0), lag=st.floats(-SATURATION_MM, SATURATION_MM))
def test_the_command_is_equation_7_and_the_lag_equation_8(reference: float, lag: float) -> None:
    state = AT_REST._replace(head_mm=30.0, lag_mm=lag)
    after = direct_step(PUBLISHED, state, reference, DT_S)
    assert after.head_mm == pytest.approx((reference - lag + 7.151) / 0.9677)
    assert after.lag_mm == modified_dahl.step(PUBLISHED, lag, after.head_mm - 30.0)
