import numpy as np
import pytest

from opensuction.hysteresis.modified_dahl import PUBLISHED, ModifiedDahl, simulate
from opensuction.identification.estimator.projection import (
    centre,
    project,
    try_decay,
)
from tests.identification.plant import RIPPLED


def test_projection_at_the_right_decay_finds_everything_else() -> None:
    tip_mm = simulate(PUBLISHED, RIPPLED, 2.0)
    recording = centre(RIPPLED, tip_mm)
    found = project(recording, PUBLISHED.decay_per_mm)
    assert found.model[:3] == pytest.approx(PUBLISHED[:3], rel=1e-10)
    offset_mm = (
        found.model.offset_mm + recording.tip_mean_mm - found.model.slope * recording.head_mean_mm
    )
    assert offset_mm == pytest.approx(PUBLISHED.offset_mm, rel=1e-10)
    assert found.lag_mm == pytest.approx(2.0, rel=1e-9)
    assert found.squares == pytest.approx(0.0, abs=1e-15)


def test_one_pass_agrees_with_columns_and_residuals() -> None:
    tip_mm = simulate(PUBLISHED, RIPPLED, 2.0) + np.random.default_rng(3).normal(
        0.0, 0.2, RIPPLED.size
    )
    recording = centre(RIPPLED, tip_mm)
    for decay_per_mm in (0.002, 0.06, 0.077, 5.0):
        found = try_decay(recording.head_mm, recording.tip_mm, decay_per_mm)
        # Normal equations lose the square of tip over residual: 1e-16 * 1e4.
        expected = project(recording, decay_per_mm).squares
        assert found.squares == pytest.approx(expected, rel=1e-9)


def test_the_step_points_to_the_optimum_from_both_sides() -> None:
    recording = centre(RIPPLED, simulate(PUBLISHED, RIPPLED, 2.0))
    for factor in (0.9, 1.1):
        found = try_decay(recording.head_mm, recording.tip_mm, factor * PUBLISHED.decay_per_mm)
        # Gauss-Newton converges quadratically on exact data: a tenth off becomes a hundredth.
        assert factor * np.exp(found.step) == pytest.approx(1.0, abs=0.01)


def test_a_negative_gain_makes_way_for_the_line() -> None:
    leading = simulate(ModifiedDahl(1.0, 0.3, 0.1, 0.0), RIPPLED, 0.0)
    found = project(centre(leading, RIPPLED), 0.1)
    assert found.model.velocity_gain == 0.0
    assert found.lag_mm == 0.0
    slope = float(np.polyfit(leading, RIPPLED, 1)[0])
    assert found.model.slope == pytest.approx(slope, rel=1e-9)
