import numpy as np
import pytest

from opensuction.hysteresis.modified_dahl import PUBLISHED, ModifiedDahl, simulate
from opensuction.identification.estimator.projection import (
    centre,
    project,
    try_decay,
)

# Strokes of 40 mm with ripples, some of them between two samples that thinning would keep.
HEAD = 20.0 * np.sin(np.linspace(0.0, 20.0, 9000)) + 0.8 * np.sin(np.linspace(0.0, 900.0, 9000))


def test_projection_at_the_right_decay_finds_everything_else() -> None:
    tip_mm = simulate(PUBLISHED, HEAD, 2.0)
    recording = centre(HEAD, tip_mm)
    found = project(recording, PUBLISHED.decay_per_mm)
    assert found.model[:3] == pytest.approx(PUBLISHED[:3], rel=1e-10)
    offset_mm = (
        found.model.offset_mm + recording.tip_mean_mm - found.model.slope * recording.head_mean_mm
    )
    assert offset_mm == pytest.approx(PUBLISHED.offset_mm, rel=1e-10)
    assert found.lag_mm == pytest.approx(2.0, rel=1e-9)
    assert found.squares == pytest.approx(0.0, abs=1e-15)


def test_one_pass_agrees_with_columns_and_residuals() -> None:
    tip_mm = simulate(PUBLISHED, HEAD, 2.0) + np.random.default_rng(3).normal(0.0, 0.2, HEAD.size)
    recording = centre(HEAD, tip_mm)
    for decay_per_mm in (0.002, 0.06, 0.077, 5.0):
        found = try_decay(recording.head_mm, recording.tip_mm, decay_per_mm)
        # Normal equations lose the square of tip over residual: 1e-16 * 1e4.
        expected = project(recording, decay_per_mm).squares
        assert found.squares == pytest.approx(expected, rel=1e-9)


def test_the_step_points_to_the_optimum_from_both_sides() -> None:
    recording = centre(HEAD, simulate(PUBLISHED, HEAD, 2.0))
    for factor in (0.9, 1.1):
        found = try_decay(recording.head_mm, recording.tip_mm, factor * PUBLISHED.decay_per_mm)
        # Gauss-Newton converges quadratically on exact data: a tenth off becomes a hundredth.
        assert factor * np.exp(found.step) == pytest.approx(1.0, abs=0.01)


def test_a_negative_gain_makes_way_for_the_line() -> None:
    leading = simulate(ModifiedDahl(1.0, 0.3, 0.1, 0.0), HEAD, 0.0)
    found = project(centre(leading, HEAD), 0.1)
    assert found.model.velocity_gain == 0.0
    assert found.lag_mm == 0.0
    slope = float(np.polyfit(leading, HEAD, 1)[0])
    assert found.model.slope == pytest.approx(slope, rel=1e-9)
