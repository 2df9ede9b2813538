"""A data set that equations describe, small enough to know its figures by heart."""

from collections.abc import Mapping

import numpy as np

from opensuction.evidence.leaderboard.data_set import DataSet, halves
from opensuction.kernel.record import Array

SAMPLES = 400
RIPPLE = 0.1
"""By which the output of the second half is off the line, up and down in turn."""


def motion() -> Array:
    """Eight strokes to and fro within -1 and 1."""
    return np.sin(np.linspace(0.0, 8.0 * np.pi, SAMPLES))


def line() -> Mapping[str, Array]:
    """Output 2 x + 1 in the first half, with the ripple in the second."""
    x = motion()
    ripple = np.where(np.arange(SAMPLES) % 2 == 0, RIPPLE, -RIPPLE)
    ripple[: SAMPLES // 2] = 0.0
    return {"x": x, "y": 2.0 * x + 1.0 + ripple}


PERCENT = f"{100.0 * RIPPLE / np.ptp(line()['y']):.3g}"
"""Of the range, what a straight line leaves."""

LINE = DataSet(
    name="line",
    title="a line with a ripple",
    inputs=("x",),
    output="y",
    split=halves(0, SAMPLES),
    sampling="even",
    licence="CC0",
    source="equations",
    generate=line,
    simulated=True,
)
