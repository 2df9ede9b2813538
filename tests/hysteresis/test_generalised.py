import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.typing import NDArray

from opensuction.hysteresis import generalised, modified_dahl
from opensuction.hysteresis.generalised import Generalised
from opensuction.hysteresis.play import ModelState
from tests.hysteresis import distributed_play

Array = NDArray[np.float64]

DECAYS_MM = np.array([2.0, 12.0])
WIDTHS_MM = np.array([0.0, 9.0, 21.0])
EMPTY = np.empty(0)

paths = st.lists(st.floats(-20.0, 120.0), min_size=2, max_size=15).map(np.array)


def example(weights: list[float], envelope: list[float]) -> Generalised:
    model = generalised.on_range(0.0, 100.0, DECAYS_MM, WIDTHS_MM, len(envelope) - 1)
    return generalised.with_factors(model, np.array(weights + envelope))


def started(model: Generalised, head_mm: float, memory_ratio: float) -> ModelState:
    return ModelState(head_mm, generalised.start_elements_mm(model, head_mm, memory_ratio))


MIXED = example([0.1, -0.05, 0.3, 0.2, 0.1], [40.0, 35.0, 3.0, 2.0, -1.0, 0.7])
MONOTONE = example([0.05, 0.1, 0.2, 0.2, 0.1], [40.0, 35.0, 1.0, 2.0, 0.5, 0.7])


def test_one_dahl_state_and_a_line_is_the_modified_dahl_model() -> None:
    dahl = modified_dahl.PUBLISHED
    lengths_mm = np.array([1.0 / dahl.decay_per_mm])
    line = generalised.on_range(0.0, 100.0, lengths_mm, EMPTY, 1)
    middle_mm = dahl.slope * 50.0 + dahl.offset_mm
    model = generalised.with_factors(
        line, np.array([dahl.velocity_gain, middle_mm, dahl.slope * 50.0])
    )
    x_mm = 50.0 * (1.0 - np.cos(np.linspace(0.0, 12.0, 400)))
    start = generalised.start_elements_mm(model, 0.0, -1.0)
    # Rounding of 400 steps; the modified Dahl model scales its lag by beta, here the weight does.
    assert generalised.simulate(model, x_mm, start) == pytest.approx(
        modified_dahl.simulate(dahl, x_mm, modified_dahl.saturation_mm(dahl)), abs=1e-11
    )
    assert generalised.least_slope(model) == pytest.approx(modified_dahl.reversal_slope(dahl))
    assert not generalised.is_monotone(model)


def test_plays_alone_are_a_distributed_play() -> None:
    widths_mm = np.array([14.0, 20.0, 26.0])
    model = generalised.on_range(0.0, 100.0, EMPTY, widths_mm, 0)
    model = generalised.with_factors(model, np.array([0.95 / 3, 0.95 / 3, 0.95 / 3, -6.2]))
    x_mm = 50.0 * (1.0 - np.cos(np.linspace(0.0, 12.0, 400)))
    start = generalised.start_elements_mm(model, 0.0, -1.0)
    assert generalised.simulate(model, x_mm, start) == pytest.approx(
        distributed_play.simulate(widths_mm, 0.95, -6.2, x_mm, start), abs=1e-12
    )


@given(path_mm=paths, memory=st.floats(-1.0, 1.0))
def test_the_model_is_its_basis_times_its_factors(path_mm: Array, memory: float) -> None:
    start = generalised.start_elements_mm(MIXED, path_mm[0], memory)
    columns = generalised.basis(MIXED, path_mm, start)
    assert columns.shape == (path_mm.size, 5 + 6)
    factors = np.concatenate([MIXED.weights, MIXED.envelope_mm])
    assert columns @ factors == pytest.approx(
        generalised.simulate(MIXED, path_mm, start), abs=1e-11
    )


def test_least_squares_on_the_basis_gives_the_weights_back() -> None:
    turns = [0.0, 100.0, 10.0, 80.0, 30.0, 60.0, 0.0, 95.0, 45.0, 70.0]
    x_mm = np.concatenate([np.linspace(a, b, 60) for a, b in pairwise(turns)])
    start = generalised.start_elements_mm(MIXED, x_mm[0], -1.0)
    columns = generalised.basis(MIXED, x_mm, start)
    wanted = generalised.simulate(MIXED, x_mm, start)
    # A play of width 0 is the input itself, as t is: two of the columns are one.
    kept = [j for j in range(columns.shape[1]) if j != 2]
    found = np.linalg.lstsq(columns[:, kept], wanted, rcond=None)[0]
    expected = np.concatenate([MIXED.weights, MIXED.envelope_mm])
    expected[6] += 50.0 * expected[2]  # slope of that play, per half range
    expected[5] += 50.0 * expected[2]  # and its value in the middle
    assert found == pytest.approx(expected[kept], abs=1e-9)


def test_beyond_its_range_the_envelope_is_its_tangent() -> None:
    model = example([0.0] * 5, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    polynomial = np.polynomial.Polynomial(model.envelope_mm)
    x_mm = np.array([-30.0, 0.0, 25.0, 100.0, 160.0])
    start = generalised.start_elements_mm(model, -30.0, 0.0)
    low, high = polynomial.deriv()(-1.0), polynomial.deriv()(1.0)
    expected = [
        polynomial(-1.0) - 0.6 * low,
        *(polynomial(t) for t in (-1.0, -0.5, 1.0)),
        polynomial(1.0) + 1.2 * high,
    ]
    assert generalised.simulate(model, x_mm, start) == pytest.approx(expected, rel=1e-13)


def test_the_least_slope_is_that_of_a_reversal_after_a_long_stroke() -> None:
    x_mm = np.concatenate([np.linspace(0.0, 300.0, 4001), np.linspace(300.0, -200.0, 5001)])
    for reversal in range(1000, 4001, 50):
        stroke = np.append(x_mm[: reversal + 1], x_mm[reversal] - 1e-6)
        start = generalised.start_elements_mm(MONOTONE, 0.0, 1.0)
        tip_mm = generalised.simulate(MONOTONE, stroke, start)
        # The difference quotient of 1e-6 mm rounds to 1e-7.
        assert (tip_mm[-2] - tip_mm[-1]) / 1e-6 >= generalised.least_slope(MONOTONE) - 1e-7
    slopes = np.polynomial.Polynomial(MONOTONE.envelope_mm).deriv()(np.linspace(-1, 1, 2001)) / 50
    assert generalised.least_slope(MONOTONE) == pytest.approx(slopes.min() - 0.3 + 0.2, abs=1e-6)
    assert generalised.is_monotone(MONOTONE)


@given(path_mm=paths, memory=st.floats(-1.0, 1.0), target_mm=st.floats(-50.0, 200.0))
def test_the_inverse_reaches_every_target(path_mm: Array, memory: float, target_mm: float) -> None:
    state = started(MONOTONE, 0.0, memory)
    for place_mm in path_mm:
        state = generalised.step(MONOTONE, state, place_mm - state.head_mm)
    found = generalised.inverse_step(MONOTONE, state, target_mm)
    assert found.reached
    after = generalised.step(MONOTONE, state, found.move_mm)
    # Rounding of numbers up to 1000, where the travel is known to 1e-16 of the bracket.
    assert generalised.output_mm(MONOTONE, after) == pytest.approx(target_mm, abs=1e-11)
    missing_mm = target_mm - generalised.output_mm(MONOTONE, state)
    assert found.move_mm * missing_mm >= 0.0


@pytest.mark.parametrize("target_mm", [math.nan, math.inf])
def test_a_target_that_is_no_number_is_not_reached(target_mm: float) -> None:
    state = started(MONOTONE, 0.0, 0.0)
    assert generalised.inverse_step(MONOTONE, state, target_mm) == (0.0, False)


def test_a_target_that_a_flat_model_cannot_reach_is_not_reached() -> None:
    flat = example([0.0] * 5, [3.0])
    assert not generalised.is_monotone(flat)
    assert generalised.inverse_step(flat, started(flat, 0.0, 0.0), 4.0) == (0.0, False)


@given(path_mm=paths)
def test_a_step_keeps_the_old_state_and_equals_the_record(path_mm: Array) -> None:
    assume(np.ptp(path_mm) > 0.0)
    state = started(MIXED, path_mm[0], -1.0)
    expected = generalised.simulate(MIXED, path_mm, state.memory)
    for k in range(path_mm.size):
        before = state.memory.tolist()
        following = generalised.step(MIXED, state, path_mm[k] - state.head_mm)
        assert state.memory.tolist() == before
        state = following
        # The head is a sum of moves here: rounding of 15 of them.
        assert generalised.output_mm(MIXED, state) == pytest.approx(expected[k], abs=1e-11)
