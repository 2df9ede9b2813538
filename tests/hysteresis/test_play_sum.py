"""Plays in a tuple give the numbers of plays in an array, bit for bit."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.hysteresis import play_sum, prandtl_ishlinskii
from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii
from opensuction.kernel.errors import InputError

THRESHOLDS_MM = np.linspace(0.7, 15.0, 60)
places = st.floats(-150.0, 150.0)


@st.composite
def models(draw: st.DrawFn) -> PrandtlIshlinskii:
    """Models as they are identified: some plays of a grid, none lighter than 0."""
    plays = sorted(draw(st.sets(st.integers(0, 59), min_size=1, max_size=play_sum.PLAYS)))
    weights = draw(st.lists(st.floats(0.0, 0.5), min_size=len(plays), max_size=len(plays)))
    return PrandtlIshlinskii(
        THRESHOLDS_MM[plays],
        np.array(weights),
        slope=draw(st.sampled_from((0.0, 0.05, 0.9))),
        offset_mm=draw(st.sampled_from((0.0, -6.2))),
        curvature_per_mm=draw(st.sampled_from((0.0, 2e-5))),
    )


def slope_of_arrays(
    model: PrandtlIshlinskii, positions: np.ndarray, head_mm: float, direction: float
) -> float:
    """Slope dy/dx when the head moves on in a direction, play by play."""
    slope, inner_mm = model.slope, model.slope * head_mm
    for threshold, weight, position in zip(
        model.thresholds_mm, model.weights, positions, strict=True
    ):
        inner_mm += weight * position
        if threshold + direction * (position - head_mm) <= play_sum.ENGAGED_MM:
            slope += weight
    return float(slope * (1.0 + 2.0 * model.curvature_per_mm * inner_mm))


@given(model=models(), path_mm=st.lists(places, min_size=1, max_size=6), target_mm=places)
def test_every_number_is_that_of_the_arrays(
    model: PrandtlIshlinskii, path_mm: list[float], target_mm: float
) -> None:
    bundled, used = play_sum.bundle(model), model.weights.size
    positions = prandtl_ishlinskii.retracted_positions_mm(model, path_mm[0])
    numbers = play_sum.retracted_positions_mm(bundled, path_mm[0])
    for head_mm in path_mm:
        positions = prandtl_ishlinskii.step(model, positions, head_mm)
        numbers = play_sum.step(bundled, numbers, head_mm)
        assert numbers[:used] == tuple(positions)
        assert set(numbers[used:]) <= {head_mm}
        tip_mm = prandtl_ishlinskii.output_mm(model, positions, head_mm)
        assert play_sum.output_mm(bundled, numbers, head_mm) == tip_mm
        for target in (target_mm, tip_mm, tip_mm + 1e-13, tip_mm + 0.05, tip_mm - 0.05):
            assert play_sum.inverse_step(
                bundled, numbers, head_mm, target
            ) == prandtl_ishlinskii.inverse_step(model, positions, head_mm, target)
        for direction in (-1.0, 1.0):
            assert play_sum.advance_slope(bundled, numbers, head_mm, direction) == slope_of_arrays(
                model, positions, head_mm, direction
            )


@given(model=models(), tip_mm=places)
def test_the_arrays_of_a_bundle_park_and_arrive_as_the_model_does(
    model: PrandtlIshlinskii, tip_mm: float
) -> None:
    again = play_sum.unbundle(play_sum.bundle(model))
    if prandtl_ishlinskii.total_slope(model) > 0.0:
        for direction in (-1.0, 1.0):
            assert prandtl_ishlinskii.saturated_head_mm(
                again, tip_mm, direction
            ) == prandtl_ishlinskii.saturated_head_mm(model, tip_mm, direction)


def test_more_plays_than_there_is_room_for_are_refused() -> None:
    many = PrandtlIshlinskii(np.arange(1.0, 18.0), np.full(17, 0.05), 0.0, 0.0, 0.0)
    with pytest.raises(InputError, match="17 plays, should have at most 16"):
        play_sum.bundle(many)
