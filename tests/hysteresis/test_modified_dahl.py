import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from opensuction.hysteresis.modified_dahl import (
    PUBLISHED,
    ModifiedDahl,
    advance_slope,
    gap_mm,
    gap_move,
    is_monotone,
    move_to,
    output_mm,
    reversal_slope,
    saturation_mm,
    simulate,
    step,
)

directions = st.sampled_from([-1.0, 1.0])

models = st.builds(
    ModifiedDahl,
    slope=st.floats(0.2, 2.0),
    velocity_gain=st.floats(0.0, 2.0),
    decay_per_mm=st.floats(0.005, 1.0),
    offset_mm=st.floats(-20.0, 20.0),
)

lag_ratios = st.floats(-1.5, 1.5)
"""Lag over saturation; beyond one is only ever a start, and must work too."""


def moved(model: ModifiedDahl, head_mm: float, lag_mm: float, move_mm: float) -> float:
    """Tip position after a move."""
    return output_mm(model, head_mm + move_mm, step(model, lag_mm, move_mm))


def test_published_parameters_are_the_papers() -> None:
    assert PUBLISHED._asdict() == {
        "slope": 0.9677,
        "velocity_gain": 0.854,
        "decay_per_mm": 0.077,
        "offset_mm": -7.151,
    }


@pytest.mark.parametrize("speed_mm_per_s", [3.0, 60.0])
@pytest.mark.parametrize("lag_mm", [0.0, 11.0, -4.0])
@pytest.mark.parametrize("move_mm", [35.0, -8.0])
def test_step_solves_the_papers_differential_equation(
    lag_mm: float, move_mm: float, speed_mm_per_s: float
) -> None:
    rate = math.copysign(speed_mm_per_s, move_mm)

    def equation_3(_time_s: float, lag: list[float]) -> list[float]:
        return [-PUBLISHED.velocity_gain * rate - PUBLISHED.decay_per_mm * abs(rate) * lag[0]]

    finely = solve_ivp(equation_3, (0.0, move_mm / rate), [lag_mm], rtol=1e-11, atol=1e-12)
    # The integrator's own tolerance, times its number of steps.
    assert step(PUBLISHED, lag_mm, move_mm) == pytest.approx(finely.y[0, -1], abs=1e-8)


@given(model=models, ratio=lag_ratios, move_mm=st.floats(-300.0, 300.0), part=st.floats(0.0, 1.0))
def test_a_move_in_two_parts_is_the_same_move(
    model: ModifiedDahl, ratio: float, move_mm: float, part: float
) -> None:
    lag_mm = ratio * saturation_mm(model)
    first = step(model, lag_mm, part * move_mm)
    assert step(model, first, move_mm - part * move_mm) == pytest.approx(
        step(model, lag_mm, move_mm), abs=1e-12 * (1.0 + saturation_mm(model))
    )


@given(model=models, ratio=st.floats(-1.0, 1.0), move_mm=st.floats(-1e4, 1e4))
def test_lag_never_leaves_saturation(model: ModifiedDahl, ratio: float, move_mm: float) -> None:
    limit_mm = saturation_mm(model)
    assert abs(step(model, ratio * limit_mm, move_mm)) <= limit_mm * (1.0 + 1e-14)


def test_long_strokes_saturate_and_stay() -> None:
    limit_mm = saturation_mm(PUBLISHED)
    assert limit_mm == pytest.approx(0.854 / 0.077)
    # exp(-0.077 * 600) is 1e-20.
    assert step(PUBLISHED, 3.0, -600.0) == pytest.approx(limit_mm, rel=1e-15)
    assert step(PUBLISHED, 3.0, 600.0) == pytest.approx(-limit_mm, rel=1e-15)
    assert step(PUBLISHED, limit_mm, -5.0) == limit_mm
    branches = [output_mm(PUBLISHED, 40.0, lag) for lag in (limit_mm, -limit_mm)]
    assert gap_mm(PUBLISHED) == pytest.approx(branches[0] - branches[1])


def test_a_million_tiny_moves_are_one_move() -> None:
    head_mm = np.linspace(0.0, 1e-3, 1_000_001)
    tip_mm = simulate(PUBLISHED, head_mm, 5.0)
    # Rounding of a million sums near 5 walks to about 1e-12 (with exp, not expm1, 6e-10).
    assert tip_mm[-1] == pytest.approx(moved(PUBLISHED, 0.0, 5.0, 1e-3), abs=1e-11)


def test_simulation_starts_with_the_given_lag_and_steps_after() -> None:
    head_mm = np.array([2.0, 7.0, 7.0, -1.0])
    lag_mm, expected = 4.0, [output_mm(PUBLISHED, 2.0, 4.0)]
    for k in range(1, head_mm.size):
        lag_mm = step(PUBLISHED, lag_mm, head_mm[k] - head_mm[k - 1])
        expected.append(output_mm(PUBLISHED, head_mm[k], lag_mm))
    assert simulate(PUBLISHED, head_mm, 4.0).tolist() == expected


@pytest.mark.parametrize("direction", [-1.0, 1.0])
def test_published_reversal_dips_and_returns(direction: float) -> None:
    lag_mm = direction * saturation_mm(PUBLISHED)
    start_mm = output_mm(PUBLISHED, 50.0, lag_mm)
    travel_mm = np.linspace(0.0, 20.0, 200_001)
    gained_mm = direction * (simulate(PUBLISHED, 50.0 + direction * travel_mm, lag_mm) - start_mm)
    deepest = int(np.argmin(gained_mm))
    assert round(-gained_mm[deepest], 2) == 2.47
    assert round(travel_mm[deepest], 2) == 7.38
    assert round(direction * gap_move(PUBLISHED, lag_mm, direction), 2) == 16.48
    # The target "no further than now" is the far side of the gap, never the start.
    assert move_to(PUBLISHED, 50.0, lag_mm, start_mm, direction) == pytest.approx(
        gap_move(PUBLISHED, lag_mm, direction)
    )


def test_published_reversal_starts_the_wrong_way() -> None:
    lag_mm = saturation_mm(PUBLISHED)
    assert reversal_slope(PUBLISHED) == pytest.approx(-0.7403)
    assert advance_slope(PUBLISHED, lag_mm, 1.0) == pytest.approx(reversal_slope(PUBLISHED))
    assert not is_monotone(PUBLISHED)
    assert is_monotone(PUBLISHED._replace(velocity_gain=0.48))


@given(model=models, ratio=lag_ratios, direction=directions)
def test_advance_slope_is_the_slope_of_the_output(
    model: ModifiedDahl, ratio: float, direction: float
) -> None:
    lag_mm, move_mm = ratio * saturation_mm(model), direction * 1e-6
    slope = (moved(model, 0.0, lag_mm, move_mm) - moved(model, 0.0, lag_mm, 0.0)) / move_mm
    # Curvature over 1e-6 mm, and the rounding of outputs of up to 600 mm divided by it.
    assert advance_slope(model, lag_mm, direction) == pytest.approx(slope, abs=1e-5)


@given(
    model=models,
    ratio=lag_ratios,
    head_mm=st.floats(-100.0, 100.0),
    ahead_mm=st.floats(0.0, 200.0),
    direction=directions,
)
def test_the_inverse_reaches_every_target_ahead(
    model: ModifiedDahl, ratio: float, head_mm: float, ahead_mm: float, direction: float
) -> None:
    lag_mm = ratio * saturation_mm(model)
    target_mm = output_mm(model, head_mm, lag_mm) + direction * ahead_mm
    move_mm = move_to(model, head_mm, lag_mm, target_mm, direction)
    assert direction * move_mm >= 0.0
    # Ten roundings of the largest number on the way.
    size_mm = 100.0 + 200.0 + 2.0 * saturation_mm(model) + abs(move_mm)
    assert moved(model, head_mm, lag_mm, move_mm) == pytest.approx(target_mm, abs=2e-15 * size_mm)
    # Beyond the gap, where the tip follows the head again.
    assert advance_slope(model, step(model, lag_mm, move_mm), direction) >= -1e-6


@given(model=models, direction=directions, share=st.floats(1e-18, 1.0))
def test_the_inverse_reaches_into_the_dip_but_not_below(
    model: ModifiedDahl, direction: float, share: float
) -> None:
    assume(model.slope < 1.99 * model.velocity_gain)
    lag_mm = direction * saturation_mm(model)
    start_mm = output_mm(model, 0.0, lag_mm)
    bottom_move = move_to(model, 0.0, lag_mm, start_mm - direction * 1e4, direction)
    bottom_mm = moved(model, 0.0, lag_mm, bottom_move)
    lag_there = step(model, lag_mm, bottom_move)
    assert advance_slope(model, lag_there, direction) == pytest.approx(0.0, abs=1e-9)
    # Also hair-close to the tangent point, where Newton's steps only halve the error.
    target_mm = bottom_mm + share * (start_mm - bottom_mm)
    move_mm = move_to(model, 0.0, lag_mm, target_mm, direction)
    assert abs(move_mm) >= abs(bottom_move)
    size_mm = 4.0 * saturation_mm(model) + abs(move_mm) + 20.0
    assert moved(model, 0.0, lag_mm, move_mm) == pytest.approx(target_mm, abs=2e-15 * size_mm)


@given(ratio=st.floats(-1.0, 1.0), behind_mm=st.floats(0.0, 100.0), direction=directions)
def test_a_target_behind_a_monotone_curve_asks_for_no_move(
    ratio: float, behind_mm: float, direction: float
) -> None:
    model = ModifiedDahl(slope=0.95, velocity_gain=0.4, decay_per_mm=0.08, offset_mm=-6.0)
    lag_mm = ratio * saturation_mm(model)
    target_mm = output_mm(model, 20.0, lag_mm) - direction * behind_mm
    assert move_to(model, 20.0, lag_mm, target_mm, direction) == 0.0
    assert gap_move(model, lag_mm, direction) == 0.0
