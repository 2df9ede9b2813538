"""Recordings with noise, drawn by a seed, that tests of identification share."""

import math

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter
from scipy.stats import norm

from opensuction.hysteresis.modified_dahl import ModifiedDahl, simulate
from tests.hysteresis import distributed_play

Array = NDArray[np.float64]
PERIOD_S = 20.0
"""Of the bench's excitation."""
TIME_S = np.arange(0.0, 2.0 * PERIOD_S, 0.01)
HEAD_MM = 50.0 * (1.0 - np.cos(2.0 * np.pi * TIME_S / PERIOD_S))
"""The bench's excitation over 100 mm, 100 samples a second."""
RIPPLED = 20.0 * np.sin(np.linspace(0.0, 20.0, 9000)) + 0.8 * np.sin(np.linspace(0.0, 900.0, 9000))
"""Strokes of 40 mm with ripples, some of them between two samples that thinning would keep."""


def cosine(samples: int, cycles: float = 2.0, stroke_mm: float = 100.0) -> Array:
    """The excitation of the bench: from 0 to the stroke and back, without corners."""
    return 0.5 * stroke_mm * (1.0 - np.cos(np.linspace(0.0, 2.0 * math.pi * cycles, samples)))


def paper_plant(samples: int = 40_000) -> tuple[Array, Array]:
    """The distributed play nearest to the paper's plant on the paper's excitation.

    40 widths at the quantiles of N(20, 3) mm, gain 0.95, two periods of 20 s. The paper found
    .9677, .854, .077, -7.151, RMSE .8301 mm.
    """
    widths_mm = 20.0 + 3.0 * norm.ppf((np.arange(40) + 0.5) / 40.0)
    head_mm = cosine(samples)
    return head_mm, distributed_play.simulate(widths_mm, 0.95, -6.2, head_mm, np.zeros(40))


def noise(random: np.random.Generator, samples: int, correlation: float) -> Array:
    """Noise of variance one: white, or first-order autoregressive from its steady state."""
    if correlation == 0.0:
        return random.normal(size=samples)
    drive = random.normal(size=samples) * math.sqrt(1.0 - correlation**2)
    drive[0] = random.normal()
    values: Array = lfilter([1.0], [1.0, -correlation], drive)
    return values


def drawn(seed: int, samples: int) -> tuple[Array, Array]:
    """A plant of either kind, its stroke, excitation and noise drawn by the seed."""
    random = np.random.default_rng(seed)
    stroke_mm = random.uniform(20.0, 120.0)
    cycles = random.uniform(1.0, 4.0)
    head_mm = cosine(samples, cycles, stroke_mm) + 0.1 * stroke_mm * np.sin(
        np.linspace(0.0, 2.0 * math.pi * random.uniform(5.0, 9.0), samples)
    )
    if seed % 2:
        widths_mm = random.uniform(0.05, 0.4) * stroke_mm * random.uniform(0.5, 1.5, 8)
        start_mm = random.uniform(-0.5, 0.5) * widths_mm
        tip_mm = distributed_play.simulate(widths_mm, 0.9, -5.0, head_mm, start_mm)
    else:
        decay_per_mm = random.uniform(1.0, 40.0) / stroke_mm
        gain = random.uniform(0.1, 0.9)
        lag_mm = random.uniform(-1.0, 1.0) * gain / decay_per_mm
        model = ModifiedDahl(random.uniform(0.7, 1.2), gain, decay_per_mm, -5.0)
        tip_mm = simulate(model, head_mm, lag_mm)
    level_mm = stroke_mm * 10.0 ** random.uniform(-4.0, -2.0)
    correlation = random.choice([0.0, 0.9])
    return head_mm, tip_mm + level_mm * noise(random, samples, float(correlation))
