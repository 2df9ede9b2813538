"""Rate at which filtered noise crosses a threshold: closed forms, and an exact count by the filter.

White noise that went through filters of first order is a Gaussian process. It crosses a level of
u standard deviations upwards ``arccos(rho) / (2 pi) exp(-u^2 / 2)`` times a sample, rho being the
correlation of two samples that follow one another (Rice). That is an upper bound of false trips:
no crossing is required to last.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

DT_S = 0.001
TICKS_PER_H = 3.6e6
ROOT_3 = math.sqrt(3.0)
"""Largest value of an evenly distributed number of mean 0 and variance 1."""
LENGTHS = 30.0
"""Time constants after which an answer to a single sample is over."""
Array = npt.NDArray[np.float64]


class Filter(NamedTuple):
    """What a filter makes of white noise."""

    ratio: float
    """Standard deviation behind it over that before it."""
    likeness: float
    """Correlation of two samples that follow one another."""


WHITE = Filter(ratio=1.0, likeness=0.0)
"""Nothing is filtered."""


def share(time_s: float) -> float:
    """Share of a new sample in a filter of first order of the core."""
    return DT_S / (time_s + DT_S)


def _pulse(times_s: tuple[float, ...]) -> Array:
    length = round(LENGTHS * sum(times_s) / DT_S) + 2
    values = np.zeros(length)
    values[0] = 1.0
    for time_s in times_s:
        values = _follow(values, share(time_s))
    return values


def _follow(values: Array, part: float) -> Array:
    found, last = np.empty_like(values), 0.0
    for i, value in enumerate(values):
        last += part * (value - last)
        found[i] = last
    return found


def _judge(answer: Array) -> Filter:
    power = float(answer @ answer)
    return Filter(math.sqrt(power), float(answer[1:] @ answer[:-1]) / power)


def low_pass(*times_s: float) -> Filter:
    """Filters of first order, one after the other."""
    return _judge(_pulse(times_s)) if times_s else WHITE


def rate(before_s: float, window_s: float) -> Filter:
    """Value behind a filter less its average over a window, for each second of the window."""
    smooth = _pulse((before_s, window_s))
    smooth[:] = 0.0
    smooth[0] = 1.0
    smooth = _follow(smooth, share(before_s))
    found = _judge(smooth - _follow(smooth, share(window_s)))
    return Filter(found.ratio / window_s, found.likeness)


def crossings_per_h(likeness: float, sigmas: float) -> float:
    """Upward crossings of a level an hour; half of all ticks where it is below the mean."""
    if sigmas <= 0.0:
        return 0.5 * TICKS_PER_H
    per_tick = math.acos(likeness) / (2.0 * math.pi)
    return TICKS_PER_H * per_tick * math.exp(-0.5 * sigmas * sigmas)


def even_beyond(sigmas: float) -> float:
    """Share of evenly distributed samples beyond a level, one way."""
    return min(max(0.5 * (1.0 - sigmas / ROOT_3), 0.0), 1.0)


def runs_per_h(probability: float, ticks: int) -> float:
    """How often an hour so many samples in a row are out, each by chance; an upper bound."""
    return TICKS_PER_H * float(probability**ticks)


def hum(rms: float, frequency_hz: float, time_s: float) -> float:
    """RMS of a hum behind a filter of first order."""
    part, angle = share(time_s), 2.0 * math.pi * frequency_hz * DT_S
    kept = 1.0 - part
    return rms * part / math.sqrt(1.0 - 2.0 * kept * math.cos(angle) + kept * kept)
