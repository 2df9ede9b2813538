import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from opensuction.hysteresis import play, preisach
from opensuction.hysteresis.play import ModelState
from opensuction.hysteresis.preisach import Preisach

Array = NDArray[np.float64]

LEVELS = 6
CELLS = LEVELS * (LEVELS + 1) // 2
LOW_MM, HIGH_MM, LEVEL_MM = -10.0, 50.0, 10.0

weight_lists = st.lists(st.floats(0.0, 3.0), min_size=CELLS, max_size=CELLS)
paths = st.lists(st.floats(-30.0, 70.0), min_size=2, max_size=12).map(np.array)


def triangle(weights: list[float], offset_mm: float = -4.0) -> Preisach:
    return preisach.from_factors(LOW_MM, HIGH_MM, LEVELS, np.array([*weights, offset_mm]))


EVEN = triangle([1.0] * CELLS)


def relays(model: Preisach, head_mm: Array, each: int) -> Array:
    """The definition: relays switched one by one, so many for each cell, after a long retract."""
    up, down, weight = [], [], []
    for k in range(LEVELS):
        for j in range(LEVELS - k):
            for i in range(each):
                low = LOW_MM + LEVEL_MM * (j + (i + 0.5) / each)
                down.append(low)
                up.append(low + k * LEVEL_MM)
                weight.append(model.weights_mm[k, j] / each)
    state = np.zeros(len(up))
    output = np.empty(head_mm.size)
    for i, head in enumerate(head_mm):
        rising = i > 0 and head > head_mm[i - 1]
        state[np.array(up) <= head] = 1.0
        if not rising:
            state[np.array(down) > head] = 0.0
        output[i] = model.offset_mm + float(np.array(weight) @ state)
    return output


@given(weights=weight_lists, path_mm=paths)
def test_the_model_is_the_sum_of_its_relays(weights: list[float], path_mm: Array) -> None:
    model = triangle(weights)
    stroke_mm = np.concatenate([[-60.0], path_mm])
    start = preisach.start_positions_mm(model, -60.0, -1.0)
    exact = preisach.simulate(model, stroke_mm, start)
    # Forty relays stand for a cell: in each row at most one cell is in part up, at most one relay
    # of it stands for another share than it should, in either of the strokes that shaped it.
    bound = 2.0 * model.weights_mm.max(axis=1).sum() / 40.0
    assert np.abs(exact - relays(model, stroke_mm, 40)).max() <= bound + 1e-9


def test_the_triangle_counts_all_relays_and_nothing_beyond_the_grid() -> None:
    start = preisach.start_positions_mm(EVEN, -1000.0, -1.0)
    output = preisach.simulate(EVEN, np.array([-1000.0, 50.0, 1000.0, -10.0, -1000.0]), start)
    assert output.tolist() == [-4.0, CELLS - 4.0, CELLS - 4.0, -4.0, -4.0]


def test_one_row_with_equal_weights_is_a_play() -> None:
    model = triangle([0.0] * 11 + [10.0] * 4 + [0.0] * 6, offset_mm=0.0)
    x_mm = 20.0 + 29.0 * np.sin(np.linspace(0.0, 11.0, 300))
    start = preisach.start_positions_mm(model, x_mm[0], 0.0)
    # The row k = 2 has a gap of 20 mm; its cells begin to switch up where the play is at 0.
    assert preisach.simulate(model, x_mm, start) == pytest.approx(
        play.simulate(20.0, x_mm, x_mm[0]), abs=1e-12
    )


@given(weights=weight_lists, path_mm=paths, memory=st.floats(-1.0, 1.0))
def test_the_model_is_its_basis_times_its_factors(
    weights: list[float], path_mm: Array, memory: float
) -> None:
    model = triangle(weights)
    start = preisach.start_positions_mm(model, path_mm[0], memory)
    columns = preisach.basis(model, path_mm, start)
    assert columns.shape == (path_mm.size, CELLS + 1)
    assert columns @ np.array([*weights, -4.0]) == pytest.approx(
        preisach.simulate(model, path_mm, start), abs=1e-11
    )


@given(weights=weight_lists, base=st.floats(-10.0, 20.0), pasts=st.tuples(paths, paths))
def test_minor_loops_of_equal_input_are_congruent(
    weights: list[float], base: float, pasts: tuple[Array, Array]
) -> None:
    model = triangle(weights)
    loop_mm = np.concatenate([np.linspace(base, base + 25.0, 20), np.linspace(base + 25, base, 20)])
    loops = []
    for past_mm in pasts:
        record = np.concatenate([past_mm, [base, base + 25.0], loop_mm])
        start = preisach.start_positions_mm(model, record[0], 0.0)
        loop = preisach.simulate(model, record, start)[past_mm.size + 2 :]
        loops.append(loop - loop[0])
    assert loops[0] == pytest.approx(loops[1], abs=1e-11)


@given(weights=weight_lists, path_mm=paths, share=st.floats(0.0, 1.0))
def test_the_inverse_reaches_every_target_within_the_relays(
    weights: list[float], path_mm: Array, share: float
) -> None:
    model = triangle(weights)
    state = ModelState(0.0, preisach.start_positions_mm(model, 0.0, 0.0))
    for place_mm in path_mm:
        state = preisach.step(model, state, place_mm - state.head_mm)
    highest_mm = float(np.sum(weights))
    target_mm = -4.0 + share * highest_mm
    found = preisach.inverse_step(model, state, target_mm)
    after = preisach.step(model, state, found.move_mm)
    # Weights up to 3 mm over a level of 10 mm, 21 of them: rounding of 63 mm.
    if found.reached:
        assert preisach.output_mm(model, after) == pytest.approx(target_mm, abs=1e-11)
    else:  # the very ends, missed by rounding
        assert min(share, 1.0 - share) * highest_mm < 1e-12


def test_a_target_beyond_all_relays_ends_at_the_end_of_the_grid() -> None:
    state = ModelState(20.0, preisach.start_positions_mm(EVEN, 20.0, -1.0))
    assert preisach.inverse_step(EVEN, state, CELLS + 1.0) == (30.0, False)
    assert preisach.inverse_step(EVEN, state, -5.0) == (-30.0, False)
    assert preisach.inverse_step(EVEN, state, math.nan) == (0.0, False)


def test_what_makes_the_model_rising_and_monotone() -> None:
    assert preisach.is_monotone(EVEN)
    gap = triangle([0.0, *[1.0] * (CELLS - 1)])
    assert preisach.is_rising(gap)
    assert not preisach.is_monotone(gap)
    wrong = triangle([*[1.0] * (CELLS - 1), -0.1])
    assert not preisach.is_rising(wrong)
    assert not preisach.is_monotone(wrong)
    state = ModelState(20.0, preisach.start_positions_mm(wrong, 20.0, 0.0))
    assert preisach.inverse_step(wrong, state, 3.0) == (0.0, False)


def test_an_input_that_is_no_number_shows_in_the_output() -> None:
    start = preisach.start_positions_mm(EVEN, 0.0, 0.0)
    output = preisach.simulate(EVEN, np.array([0.0, math.nan, 10.0]), start)
    assert np.isfinite(output).tolist() == [True, False, True]


def test_a_step_keeps_the_old_state() -> None:
    state = ModelState(20.0, preisach.start_positions_mm(EVEN, 20.0, 0.0))
    before = state.memory.tolist()
    assert preisach.step(EVEN, state, 30.0).memory.tolist() != before
    assert state.memory.tolist() == before
