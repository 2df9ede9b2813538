"""Pulse oximeter: shows the arterial saturation late and smoothed.

Blood needs seconds from the lung to the finger, and the instrument averages: what a person reads
during suction is the patient before it. The display shows the mean of a window of the recent past.
"""

from typing import NamedTuple

import numpy as np

from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import Array

SAMPLE_S = 0.5
"""Interval of the display."""
MEMORY = 96
"""Samples remembered: 48 s, more than the longest delay and average together."""


class Oximeter(NamedTuple):
    """Delay and averaging, in samples of the display."""

    delay_samples: int
    """From lung to finger."""
    average_samples: int


class Sample(NamedTuple):
    """Saturation since the latest sample of the display."""

    sum_s: float
    """Integral of the saturation."""
    elapsed_s: float


class OximeterState(NamedTuple):
    """State of the oximeter."""

    history: Array
    """Saturation of past samples as a ring, shape (MEMORY,); never written, only replaced."""
    latest: int
    """Place of the latest sample in the ring."""
    sample: Sample
    shown_percent: float


BEGUN = Sample(sum_s=0.0, elapsed_s=0.0)


def of_delay(delay_s: float, average_s: float) -> Oximeter:
    """Oximeter with a delay and an averaging window, cut to what it can remember."""
    average = min(max(round(average_s / SAMPLE_S), 1), MEMORY // 2)
    delay = min(max(round(delay_s / SAMPLE_S), 0), MEMORY - average)
    return Oximeter(delay_samples=delay, average_samples=average)


def at_rest(saturation: float) -> OximeterState:
    """State after a long time at one saturation (0 to 1)."""
    return OximeterState(
        history=np.full(MEMORY, saturation),
        latest=0,
        sample=BEGUN,
        shown_percent=100.0 * saturation,
    )


@compiled
def integrate(sample: Sample, saturation: float, dt_s: float) -> Sample:
    """Advance by one step at a given arterial saturation (0 to 1)."""
    return Sample(sum_s=sample.sum_s + saturation * dt_s, elapsed_s=sample.elapsed_s + dt_s)


@compiled
def is_due(sample: Sample, dt_s: float) -> bool:
    """True where the display takes a sample after this step."""
    return sample.elapsed_s >= SAMPLE_S - 0.5 * dt_s


@compiled
def show(oximeter: Oximeter, state: OximeterState, sample: Sample) -> OximeterState:
    """Take a sample that is due, and show the mean of those of the window."""
    history = state.history.copy()
    latest = (state.latest + 1) % MEMORY
    history[latest] = sample.sum_s / sample.elapsed_s
    total = 0.0
    for i in range(oximeter.average_samples):
        total += history[(latest - oximeter.delay_samples - i) % MEMORY]
    return OximeterState(
        history=history,
        latest=latest,
        sample=BEGUN,
        shown_percent=100.0 * total / oximeter.average_samples,
    )


@compiled
def step(oximeter: Oximeter, state: OximeterState, saturation: float, dt_s: float) -> OximeterState:
    """Advance by one step at a given arterial saturation (0 to 1)."""
    sample = integrate(state.sample, saturation, dt_s)
    if is_due(sample, dt_s):
        return show(oximeter, state, sample)
    return state._replace(sample=sample)
