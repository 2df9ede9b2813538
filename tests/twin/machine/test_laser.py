import numpy as np
from numpy.typing import NDArray

from opensuction.kernel import random_stream
from opensuction.twin.machine import tip_sensor
from opensuction.twin.machine.tip_sensor import Laser, LaserState
from opensuction.twin.preset import NOISE_PURPOSE

SAMPLES = 40_000
"""Noise figures below are known to 1 / sqrt(SAMPLES) = 0.5 % of their scale."""


def noise(seed: int, run: int, samples: int = SAMPLES) -> NDArray[np.float64]:
    stream = random_stream.stream(seed, NOISE_PURPOSE + run)
    state = LaserState(reading_mm=0.0, spare=0.0, has_spare=False, stream=stream)
    readings = np.empty(samples)
    for k in range(samples):
        state = tip_sensor.step_laser(Laser(noise_mm=0.08), state, 5.0)
        readings[k] = state.reading_mm
    return readings - 5.0


def correlation(one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    return float(np.corrcoef(one, other)[0, 1])


def test_noise_has_its_rms_and_is_white() -> None:
    readings = noise(seed=3, run=2)
    # Four standard errors everywhere.
    assert abs(np.std(readings) / 0.08 - 1.0) < 4.0 / np.sqrt(2.0 * SAMPLES)
    assert abs(np.mean(readings)) < 4.0 * 0.08 / np.sqrt(SAMPLES)
    for lag in (1, 2, 3, 10, 100):
        assert abs(correlation(readings[lag:], readings[:-lag])) < 4.0 / np.sqrt(SAMPLES)


def test_runs_and_seeds_have_independent_noise() -> None:
    base = noise(seed=3, run=2)
    assert np.array_equal(base[:100], noise(seed=3, run=2, samples=100))
    for seed, run in ((3, 1), (3, 3), (4, 2)):
        other = noise(seed=seed, run=run)
        for lag in (0, 1, 2):
            bound = 4.0 / np.sqrt(SAMPLES)
            assert abs(correlation(base[lag:], other[: SAMPLES - lag])) < bound


def test_no_noise_reads_the_tip() -> None:
    state = LaserState(0.0, 0.0, False, random_stream.stream(1, NOISE_PURPOSE))
    for tip in (3.0, 4.0, -1.0):
        state = tip_sensor.step_laser(Laser(noise_mm=0.0), state, tip)
        assert state.reading_mm == tip
