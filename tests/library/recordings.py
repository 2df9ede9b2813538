"""Recordings that the library's tests are fitted to."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from opensuction.hysteresis.play import simulate

Array = NDArray[np.float64]


def strokes(samples: int = 600) -> Array:
    """To and fro over 0 to 100 with an inner loop, so that every model sees reversals."""
    corners = [0.0, 100.0, 20.0, 70.0, 0.0, 100.0, 40.0, 90.0, 0.0]
    x: Array = np.interp(np.linspace(0.0, 8.0, samples), np.arange(9.0), corners)
    return x


def bench(samples: int = 600) -> tuple[Array, Array]:
    """Head and tip of plays with a share that follows at once, and a little noise."""
    x = strokes(samples)
    gaps = [simulate(width, x, 0.0) for width in (6.0, 10.0, 14.0)]
    noise = np.random.default_rng(7).normal(0.0, 0.05, samples)
    return x, 0.3 * x + 0.2 * np.sum(gaps, axis=0) - 4.0 + noise


def wrist(samples: int = 600) -> tuple[NDArray[Any], Array]:
    """Two inputs, shape (samples, 2), and an output that both drive."""
    x, y = bench(samples)
    other = 20.0 * np.sin(np.linspace(0.0, 25.0, samples))
    return np.column_stack([x, other]), y + 0.4 * simulate(3.0, other, 0.0)
