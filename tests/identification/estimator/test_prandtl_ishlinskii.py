import numpy as np
import pytest

from opensuction.hysteresis import play
from opensuction.hysteresis import prandtl_ishlinskii as pi
from opensuction.hysteresis.play_sum import PLAYS
from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii
from opensuction.identification.estimator import prandtl_ishlinskii as estimator
from opensuction.kernel.errors import InputError
from tests.hysteresis import distributed_play
from tests.identification.plant import HEAD_MM, TIME_S


def simulated(model: PrandtlIshlinskii) -> np.ndarray:
    return pi.simulate(model, HEAD_MM, pi.retracted_positions_mm(model, HEAD_MM[0]))


def test_a_model_on_the_grid_is_found_exactly() -> None:
    # The grid is every 0.5 mm of full width for a range of 100 mm.
    truth = PrandtlIshlinskii(np.array([8.0, 10.0]), np.array([0.4, 0.5]), 0.05, -6.0, 2e-5)
    found = estimator.fit(HEAD_MM, simulated(truth))
    assert found.rmse_mm < 1e-6
    np.testing.assert_allclose(found.model.thresholds_mm, truth.thresholds_mm, atol=1e-9)
    np.testing.assert_allclose(found.model.weights, truth.weights, atol=1e-5)
    assert found.model.slope == pytest.approx(0.05, abs=1e-5)
    assert found.model.offset_mm == pytest.approx(-6.0, abs=1e-4)
    assert found.model.curvature_per_mm == pytest.approx(2e-5, rel=1e-3)
    assert found.well_posed


def test_more_plays_than_a_compensation_has_room_for_are_fitted_on_a_coarser_grid() -> None:
    thresholds = 0.25 * np.arange(24.0, 54.0)
    truth = PrandtlIshlinskii(thresholds, np.linspace(0.02, 0.04, 30), 0.05, -6.0, 0.0)
    tip = simulated(truth)
    found = estimator.fit(HEAD_MM, tip)
    assert PLAYS // 2 < found.model.weights.size <= PLAYS
    # Every second width: a play stands for its neighbour a quarter of a millimetre away.
    np.testing.assert_allclose(np.diff(found.model.thresholds_mm), 0.5, atol=1e-9)
    assert found.rmse_mm < 0.01


def test_the_paper_s_plant_is_fitted_to_its_noise() -> None:
    """A distributed play, 0.1 mm of noise: the modified Dahl model leaves 0.84 mm [calc-plant]."""
    noise = 0.1 * np.random.default_rng(1).standard_normal(TIME_S.size)
    widths = np.random.default_rng(2).normal(20.0, 3.0, 200)
    start = distributed_play.retracted_positions_mm(widths, 0.0)
    clean = distributed_play.simulate(widths, 0.95, -6.2, HEAD_MM, start)
    found = estimator.fit(HEAD_MM, clean + noise)
    model = found.model
    tip = simulated(model)
    assert np.sqrt(np.mean(np.square(tip - clean))) < 0.02
    assert found.rmse_mm == pytest.approx(0.1, rel=0.05)
    mean_width_mm = pi.gap_mm(model) / pi.total_slope(model)
    assert mean_width_mm == pytest.approx(float(np.mean(widths)), abs=0.2)
    assert (model.weights > 0.0).all()


def test_bad_recordings_are_refused() -> None:
    with pytest.raises(InputError, match="constant"):
        estimator.fit(np.zeros(200), np.arange(200.0))
    with pytest.raises(InputError, match="negate"):
        estimator.fit(HEAD_MM, -HEAD_MM)
    with pytest.raises(InputError, match="at least 100"):
        estimator.fit(HEAD_MM[:50], HEAD_MM[:50])


def test_a_recording_of_two_depths_alone_is_explained_though_it_tells_no_plays_apart() -> None:
    head = np.where(np.arange(2000) // 100 % 2, 100.0, 0.0)
    tip = 0.9 * play.simulate(10.0, head, head[0] + 5.0) - 3.0
    found = estimator.fit(head, tip)
    assert found.rmse_mm < 1e-3
    assert (found.model.weights > 0.0).all()
