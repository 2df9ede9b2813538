import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from opensuction.hysteresis import play, play_sum
from opensuction.hysteresis import prandtl_ishlinskii as pi
from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii

moves = st.lists(st.floats(-60.0, 60.0), min_size=1, max_size=8)


@st.composite
def models(draw: st.DrawFn) -> PrandtlIshlinskii:
    count = draw(st.integers(1, 8))
    widths = draw(st.lists(st.floats(0.1, 20.0), min_size=count, max_size=count))
    weights = draw(st.lists(st.floats(0.0, 1.0), min_size=count, max_size=count))
    slope = draw(st.sampled_from([0.0, 0.05, 0.5]))
    assume(slope + sum(weights) > 0.05)
    return PrandtlIshlinskii(
        np.sort(np.array(widths)),
        np.array(weights),
        slope,
        draw(st.floats(-10.0, 10.0)),
        draw(st.floats(-1e-4, 1e-4)),
    )


def led(model: PrandtlIshlinskii, path: list[float]) -> tuple[np.ndarray, float]:
    """Plays and head after a path from a retract at 0."""
    plays, head = pi.retracted_positions_mm(model, 0.0), 0.0
    for move in path:
        head += move
        plays = pi.step(model, plays, head)
    return plays, head


def test_one_play_of_weight_one_is_the_play() -> None:
    model = PrandtlIshlinskii(np.array([6.0]), np.array([1.0]), 0.0, 0.0, 0.0)
    head = 30.0 * np.sin(np.linspace(0.0, 12.0, 400))
    expected = play.simulate(12.0, head, 6.0)
    np.testing.assert_allclose(pi.simulate(model, head, np.array([6.0])), expected, atol=1e-12)


def test_the_inverse_of_one_play_crosses_its_gap() -> None:
    model = PrandtlIshlinskii(np.array([6.0]), np.array([0.5]), 0.0, 0.0, 0.0)
    plays = pi.retracted_positions_mm(model, 0.0)
    # 12 mm of gap, then 2 mm of head for each of tip.
    assert pi.inverse_step(model, plays, 0.0, 3.0 + 1.0) == pytest.approx(12.0 + 2.0)
    assert pi.inverse_step(model, plays, 0.0, 3.0 - 1.0) == pytest.approx(-2.0)
    assert pi.inverse_step(model, plays, 0.0, 3.0) == 0.0
    assert pi.gap_mm(model) == pytest.approx(6.0)
    assert pi.gap_mm(model) / pi.total_slope(model) == pytest.approx(12.0)


@given(model=models(), path=moves, target=st.floats(-80.0, 80.0))
def test_the_inverse_reaches_its_target(
    model: PrandtlIshlinskii, path: list[float], target: float
) -> None:
    plays, head = led(model, path)
    move = pi.inverse_step(model, plays, head, target)
    reached = pi.output_mm(model, pi.step(model, plays, head + move), head + move)
    assert reached == pytest.approx(target, abs=1e-8)
    # And by the shortest way: anything less falls short of it.
    if abs(move) > 1e-6:
        less = head + 0.999 * move
        short = pi.output_mm(model, pi.step(model, plays, less), less)
        assert math.copysign(1.0, move) * (target - short) >= -1e-9


@given(model=models(), path=moves, move=st.floats(-50.0, 50.0))
def test_a_move_in_two_parts_is_the_move(
    model: PrandtlIshlinskii, path: list[float], move: float
) -> None:
    plays, head = led(model, path)
    whole = pi.step(model, plays, head + move)
    parts = pi.step(model, pi.step(model, plays, head + 0.3 * move), head + move)
    np.testing.assert_allclose(parts, whole, atol=1e-9)


@given(model=models(), path=moves)
def test_the_tip_never_moves_against_the_head(model: PrandtlIshlinskii, path: list[float]) -> None:
    plays, head = led(model, path)
    before = pi.output_mm(model, plays, head)
    for direction in (1.0, -1.0):
        there = head + direction
        after = pi.output_mm(model, pi.step(model, plays, there), there)
        assert direction * (after - before) >= -1e-12
        bundled = play_sum.bundle(model), play_sum.padded(plays)
        assert play_sum.advance_slope(*bundled, head, direction) >= 0.0


@given(model=models(), tip=st.floats(-50.0, 80.0), direction=st.sampled_from([1.0, -1.0]))
def test_a_long_travel_ends_on_its_branch(
    model: PrandtlIshlinskii, tip: float, direction: float
) -> None:
    head = float(pi.saturated_head_mm(model, tip, direction))
    plays = pi.step(model, pi.retracted_positions_mm(model, 0.0), head - direction * 1000.0)
    assert pi.output_mm(model, pi.step(model, plays, head), head) == pytest.approx(tip, abs=1e-7)


def test_stepping_leaves_the_old_positions_alone() -> None:
    model = PrandtlIshlinskii(np.array([2.0, 5.0]), np.array([0.5, 0.4]), 0.0, 0.0, 0.0)
    plays = pi.retracted_positions_mm(model, 0.0)
    before = plays.copy()
    pi.step(model, plays, 30.0)
    np.testing.assert_array_equal(plays, before)


def test_what_is_not_well_posed_is_told() -> None:
    good = PrandtlIshlinskii(np.array([2.0, 5.0]), np.array([0.5, 0.4]), 0.0, -6.0, 2e-5)
    assert pi.is_well_posed(good, 100.0, -100.0)
    assert not pi.is_well_posed(good._replace(weights=np.array([0.5, -0.1])), 100.0, 0.0)
    assert not pi.is_well_posed(good._replace(weights=np.zeros(2)), 100.0, 0.0)
    # A gain that turns negative at depth: 1 + 4 kappa (y - y_0) below 0.
    assert not pi.is_well_posed(good._replace(curvature_per_mm=-0.003), 100.0, 0.0)


def test_scaled_widths_scale_the_gap_and_nothing_else() -> None:
    model = PrandtlIshlinskii(np.array([2.0, 5.0]), np.array([0.5, 0.4]), 0.0, -6.0, 2e-5)
    wide = pi.scale_widths(model, 1.3)
    assert pi.gap_mm(wide) == pytest.approx(1.3 * pi.gap_mm(model))
    assert pi.total_slope(wide) == pi.total_slope(model)
