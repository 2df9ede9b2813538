import math

import numpy as np
import pytest

from opensuction.hysteresis.modified_dahl import PUBLISHED, ModifiedDahl, simulate
from opensuction.identification.estimator import recursive
from opensuction.identification.estimator.recursive import RecursiveSettings
from tests.identification.plant import cosine

SETTINGS = RecursiveSettings(
    decay_per_mm=PUBLISHED.decay_per_mm,
    memory_mm=400.0,
    noise_mm=0.1,
    most_spread=1.0,
    least_move_mm=0.0,
)
SPREAD = (0.3, 0.3, 3.0)


def test_a_wrong_start_is_corrected() -> None:
    head_mm = cosine(4000)
    tip_mm = simulate(PUBLISHED, head_mm, 0.0)
    wrong = ModifiedDahl(1.2, 0.5, PUBLISHED.decay_per_mm, 0.0)
    state = recursive.start(wrong, 0.0, float(head_mm[0]), SPREAD)
    state, estimates = recursive.track(SETTINGS, state, head_mm, tip_mm)
    found = recursive.model_of(SETTINGS, state)
    # What is left of the start: the noise told (.1 mm) over the spread, forgotten by 400 of travel.
    assert found[:2] == pytest.approx(PUBLISHED[:2], rel=1e-3)
    assert found.offset_mm == pytest.approx(PUBLISHED.offset_mm, rel=1e-2)
    assert abs(estimates[-1, 3]) < 0.01


def test_without_forgetting_it_is_least_squares() -> None:
    head_mm = cosine(500)
    random = np.random.default_rng(2)
    tip_mm = simulate(PUBLISHED, head_mm, 0.0) + random.normal(0.0, 0.1, head_mm.size)
    patient = SETTINGS._replace(memory_mm=1e12)
    state = recursive.start(PUBLISHED, 0.0, float(head_mm[0]), (1e3, 1e3, 1e3))
    state, _ = recursive.track(patient, state, head_mm, tip_mm)
    unit = simulate(ModifiedDahl(0.0, 1.0, PUBLISHED.decay_per_mm, 0.0), head_mm, 0.0)
    columns = np.stack([head_mm, unit, np.ones(head_mm.size)], axis=1)[1:]
    batch = np.linalg.lstsq(columns, tip_mm[1:], rcond=None)[0]
    # The start is believed with a spread 1e4 times the noise.
    assert np.array([state.slope, state.velocity_gain, state.offset_mm]) == pytest.approx(
        batch, rel=1e-5
    )


def test_a_drift_is_followed() -> None:
    head_mm = cosine(20_000, cycles=10.0)
    drift = np.linspace(0.0, 0.2, head_mm.size)
    random = np.random.default_rng(3)
    noise_mm = random.normal(0.0, 0.1, head_mm.size)
    tip_mm = simulate(PUBLISHED, head_mm, 0.0) + drift * head_mm + noise_mm
    state = recursive.start(PUBLISHED, 0.0, float(head_mm[0]), SPREAD)
    state, estimates = recursive.track(SETTINGS, state, head_mm, tip_mm)
    # It lags by the 400 mm it remembers: a fifth of 2,000 mm over which the slope gains .2.
    behind = PUBLISHED.slope + drift - estimates[:, 0]
    assert np.mean(behind[10_000:]) == pytest.approx(0.04, abs=0.02)
    assert np.std(estimates[10_000:, 3]) < 0.3 * np.std((drift * head_mm)[10_000:])


def test_rest_and_missing_samples_change_nothing() -> None:
    state = recursive.start(PUBLISHED, 1.0, 10.0, SPREAD)
    for head_mm, tip_mm in ((10.0, 5.0), (12.0, math.nan), (math.nan, 3.0), (math.inf, 3.0)):
        assert recursive.step(SETTINGS, state, head_mm, tip_mm) is state or np.array_equal(
            recursive.step(SETTINGS, state, head_mm, tip_mm).covariance, state.covariance
        )


def test_a_motion_that_tells_nothing_does_not_blow_up() -> None:
    head_mm = 50.0 + 1e-3 * np.sin(np.linspace(0.0, 1e4, 200_000))
    tip_mm = simulate(PUBLISHED, head_mm, 0.0)
    state = recursive.start(PUBLISHED, 0.0, 50.0, SPREAD)
    hasty = SETTINGS._replace(memory_mm=1.0)
    state, _ = recursive.track(hasty, state, head_mm, tip_mm)
    assert np.all(np.isfinite(state.covariance))
    assert max(np.diag(state.covariance)[:2]) <= hasty.most_spread**2
    assert state.slope == pytest.approx(PUBLISHED.slope, abs=0.05)


def test_the_old_state_is_kept() -> None:
    state = recursive.start(PUBLISHED, 1.0, 10.0, SPREAD)
    before = state.covariance.copy()
    recursive.step(SETTINGS, state, 20.0, 5.0)
    assert np.array_equal(state.covariance, before)
