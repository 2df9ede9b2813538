"""Pulse oximeter: shows the arterial saturation late and smoothed.

Blood needs seconds from the lung to the finger, and the instrument averages: what a person reads
during suction is the patient before it. The display shows the mean of a window of the recent past.
"""

from typing import NamedTuple

import numpy as np

from opensuction.kernel.array import Array
from opensuction.kernel.compiled import compiled

SAMPLE_S = 0.5
"""Interval of the display."""
MEMORY = 96
"""Samples remembered: 48 s, more than the longest delay and average together."""


class Oximeter(NamedTuple):
    """Delay and averaging, in samples of the display."""

    delay_samples: int
    """From lung to finger."""
    average_samples: int


class OximeterState(NamedTuple):
    """State of the oximeter."""

    history: Array
    """Saturation of past samples as a ring, shape (MEMORY,); never written, only replaced."""
    latest: int
    """Place of the latest sample in the ring."""
    sum_s: float
    """Integral of the saturation since then."""
    elapsed_s: float
    """Time since then."""
    shown_percent: float


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
        sum_s=0.0,
        elapsed_s=0.0,
        shown_percent=100.0 * saturation,
    )


@compiled
def step(oximeter: Oximeter, state: OximeterState, saturation: float, dt_s: float) -> OximeterState:
    """Advance by one step at a given arterial saturation (0 to 1)."""
    sum_s = state.sum_s + saturation * dt_s
    elapsed_s = state.elapsed_s + dt_s
    if elapsed_s < SAMPLE_S - 0.5 * dt_s:
        return state._replace(sum_s=sum_s, elapsed_s=elapsed_s)
    history = state.history.copy()
    latest = (state.latest + 1) % MEMORY
    history[latest] = sum_s / elapsed_s
    total = 0.0
    for i in range(oximeter.average_samples):
        total += history[(latest - oximeter.delay_samples - i) % MEMORY]
    return OximeterState(
        history=history,
        latest=latest,
        sum_s=0.0,
        elapsed_s=0.0,
        shown_percent=100.0 * total / oximeter.average_samples,
    )
