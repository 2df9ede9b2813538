import numpy as np
import pytest

from opensuction.hysteresis.modified_dahl import PUBLISHED, ModifiedDahl, simulate
from opensuction.identification.estimator.projection import (
    centred,
    least_squares,
    project,
    thinned,
    trial,
    turns,
)

# Strokes of 40 mm with ripples, some of them between two samples that thinning would keep.
HEAD = 20.0 * np.sin(np.linspace(0.0, 20.0, 9000)) + 0.8 * np.sin(np.linspace(0.0, 900.0, 9000))


def test_thinning_keeps_the_lag_of_every_sample_that_stays() -> None:
    index = np.arange(HEAD.size, dtype=np.float64)
    head_mm, kept = thinned(HEAD, index, samples=300)
    assert 300 <= kept.size < 1200
    full_mm = simulate(PUBLISHED, HEAD, 2.0)
    assert simulate(PUBLISHED, head_mm, 2.0) == pytest.approx(full_mm[kept.astype(int)], abs=1e-11)
    assert np.ptp(head_mm) == np.ptp(HEAD)


def test_thinning_a_short_recording_changes_nothing() -> None:
    head_mm, tip_mm = thinned(HEAD[:50], HEAD[50:100], samples=300)
    assert np.array_equal(head_mm, HEAD[:50])
    assert np.array_equal(tip_mm, HEAD[50:100])


def test_projection_at_the_right_decay_finds_everything_else() -> None:
    tip_mm = simulate(PUBLISHED, HEAD, 2.0)
    recording = centred(HEAD, tip_mm)
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
    recording = centred(HEAD, tip_mm)
    for decay_per_mm in (0.002, 0.06, 0.077, 5.0):
        found = trial(recording.head_mm, recording.tip_mm, decay_per_mm)
        # Normal equations lose the square of tip over residual: 1e-16 * 1e4.
        expected = project(recording, decay_per_mm).squares
        assert found.squares == pytest.approx(expected, rel=1e-9)


def test_the_step_points_to_the_optimum_from_both_sides() -> None:
    recording = centred(HEAD, simulate(PUBLISHED, HEAD, 2.0))
    for factor in (0.9, 1.1):
        found = trial(recording.head_mm, recording.tip_mm, factor * PUBLISHED.decay_per_mm)
        # Gauss-Newton converges quadratically on exact data: a tenth off becomes a hundredth.
        assert factor * np.exp(found.step) == pytest.approx(1.0, abs=0.01)


def test_turns_are_found_but_for_the_small_ones() -> None:
    head_mm = np.array([0.0, 0.0, 5.0, 9.0, 8.9, 9.5, 3.0, 3.0, 4.0])
    assert turns(head_mm, 0.0).tolist() == [3, 4, 5, 7]
    assert turns(head_mm, 0.5).tolist() == [5, 7]
    assert turns(np.zeros(5), 0.0).size == 0


def test_a_trembling_head_is_thinned_all_the_same() -> None:
    random = np.random.default_rng(5)
    head_mm, _ = thinned(HEAD + random.normal(0.0, 0.02, HEAD.size), HEAD, samples=300)
    assert head_mm.size < 4 * 300 + 2


def test_least_squares_of_nearly_equal_columns_keeps_its_digits() -> None:
    one = HEAD - HEAD.mean()
    other = np.cos(np.linspace(0.0, 7.0, HEAD.size))
    # Alike to 1e-5: normal equations alone see 1e-10 and keep six digits of the factors.
    columns = np.stack([one, one + 1e-5 * np.ptp(one) * (other - other.mean())])
    factors = least_squares(columns, np.array([3.0, -2.0]) @ columns)
    assert factors == pytest.approx([3.0, -2.0], rel=1e-9)


def test_least_squares_leaves_an_empty_column_alone() -> None:
    columns = np.stack([HEAD - HEAD.mean(), np.zeros(HEAD.size)])
    assert least_squares(columns, 2.0 * columns[0]) == pytest.approx([2.0, 0.0])


def test_a_negative_gain_makes_way_for_the_line() -> None:
    leading = simulate(ModifiedDahl(1.0, 0.3, 0.1, 0.0), HEAD, 0.0)
    found = project(centred(leading, HEAD), 0.1)
    assert found.model.velocity_gain == 0.0
    assert found.lag_mm == 0.0
    slope = float(np.polyfit(leading, HEAD, 1)[0])
    assert found.model.slope == pytest.approx(slope, rel=1e-9)
