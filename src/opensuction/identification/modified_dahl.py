"""Parameters of the modified Dahl model from a recording of head and tip.

Once the decay is fixed the model is linear (``projection``), so the global optimum is a search
along one axis, the logarithm of the decay: a grid, a bounded minimiser in each of its valleys,
and the zero of the Gauss-Newton step to machine precision.
Source: ``projection`` for the method; paper.txt section III-B for the model
and for what is minimised.
"""

import math
from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq, minimize_scalar

from opensuction.hysteresis.modified_dahl import ModifiedDahl, is_monotone
from opensuction.identification.projection import (
    Projection,
    Recording,
    centred,
    gauss_newton_step,
    project,
    thinned,
)
from opensuction.identification.record import checked_pair
from opensuction.kernel.errors import InputError

LEAST_SAMPLES = 12
"""Fewest samples: five parameters, and something left over to judge them by."""

LEAST_REVERSAL_RATIO = 0.05
"""Smallest reversal of the head, as a share of its range, that can show a hysteresis."""

SLOWEST_DECAY = 0.05
"""Bound on decay times range. Below, slope and velocity gain grow and cancel: a flat ridge."""

FASTEST_DECAY = 1000.0
"""Bound on decay times range. Above, a reversal is over within a thousandth of the range and
only the quotient of velocity gain and decay still shows: the other flat ridge."""

SEARCH_SAMPLES = 4000
"""Samples that tell the valleys apart; only the last steps need the full recording."""

GRID_POINTS = 20
"""Starting points; neighbours differ by a factor of 1.7, valleys are wider than that."""

VALLEY_TOLERANCE = 1e-3
"""Where the minimiser of a valley stops, in log(decay)."""

FIRST_REACH = 0.02
"""First try at a bracket of the full recording's optimum, in log(decay); doubled as needed."""

FINAL_TOLERANCE = 1e-10
"""Where the search ends, in log(decay)."""

LEAST_RISE = 0.01
"""Share by which the sum of squares must rise towards both bounds for the decay to be determined.
Far above the rise of 4/n that chance gives: neighbouring residuals of a recording are alike."""


class Fit(NamedTuple):
    """A fitted modified Dahl model and how well it explains the recording."""

    model: ModifiedDahl
    lag_mm: float
    """Lag at the first sample."""
    rmse_mm: float
    samples: int
    well_posed: bool
    """Whether the model has a continuous inverse (c > 2 beta)."""
    determined: bool
    """Whether the recording determines the decay. If not, slope, gain and decay trade against one
    another along a ridge of equal fits: the curve can be used, the numbers mean little."""


def fit(head_mm: ArrayLike, tip_mm: ArrayLike) -> Fit:
    """Fit the modified Dahl model, initial lag included, in the least-squares sense.

    head_mm, tip_mm: positions at the same instants, shape (n,), any length unit if both share
    it. Timing plays no part: the model is independent of speed.

    Velocity gains below zero are excluded: a recording without hysteresis, or whose tip leads
    its head, gets the straight line with a gain of 0, not determined.
    Raises InputError for records that are not finite rows of equal length, too short, constant,
    without a reversal, or with the tip moving against the head.
    """
    head, tip = checked_pair(("head_mm", "tip_mm"), head_mm, tip_mm, LEAST_SAMPLES)
    range_mm = _checked_range_mm(head, tip)
    bounds = (math.log(SLOWEST_DECAY / range_mm), math.log(FASTEST_DECAY / range_mm))
    bottom = _search(centred(*thinned(head, tip, SEARCH_SAMPLES)), bounds)
    recording = centred(head, tip)
    found = _polish(recording, bottom, bounds)
    at_bounds = min(project(recording, math.exp(bound)).squares for bound in bounds)
    slope, velocity_gain, decay_per_mm, offset_mm = found.model
    if slope <= 0.0:
        raise InputError(
            f"tip_mm: moves against head_mm (slope {slope:.4g}), should follow it; "
            "negate one of them"
        )
    offset_mm += recording.tip_mean_mm - slope * recording.head_mean_mm
    model = ModifiedDahl(slope, velocity_gain, decay_per_mm, offset_mm)
    return Fit(
        model=model,
        lag_mm=found.lag_mm,
        rmse_mm=math.sqrt(found.squares / tip.size),
        samples=tip.size,
        well_posed=bool(is_monotone(model)),
        determined=velocity_gain > 0.0 and at_bounds > (1.0 + LEAST_RISE) * found.squares,
    )


def _checked_range_mm(head: NDArray[np.float64], tip: NDArray[np.float64]) -> float:
    """Range of the head; InputError where the records cannot show a hysteresis."""
    range_mm = float(np.ptp(head))
    for name, record in (("head_mm", head), ("tip_mm", tip)):
        if not np.ptp(record) > 0.0:
            raise InputError(f"{name}: constant at {record[0]:g}, should move")
    back = float(np.max(np.maximum.accumulate(head) - head))
    forth = float(np.max(head - np.minimum.accumulate(head)))
    if min(back, forth) < LEAST_REVERSAL_RATIO * range_mm:
        raise InputError(
            f"head_mm: reverses by {min(back, forth):.4g} of a range of {range_mm:.4g}, at least "
            f"{LEAST_REVERSAL_RATIO:.0%} are needed to see a hysteresis"
        )
    return range_mm


def _search(recording: Recording, bounds: tuple[float, float]) -> float:
    """The log(decay) of the deepest valley, to ``VALLEY_TOLERANCE``."""

    def squares(log_decay: float) -> float:
        return project(recording, math.exp(log_decay)).squares

    grid = [float(point) for point in np.linspace(*bounds, GRID_POINTS)]
    heights = [squares(point) for point in grid]
    bottoms = [min(zip(heights, grid, strict=True))]
    for k in range(1, GRID_POINTS - 1):
        if heights[k] <= min(heights[k - 1], heights[k + 1]):
            valley = minimize_scalar(
                squares,
                bounds=(grid[k - 1], grid[k + 1]),
                method="bounded",
                options={"xatol": VALLEY_TOLERANCE},
            )
            bottoms.append((float(valley.fun), float(valley.x)))
    return min(bottoms)[1]


def _polish(recording: Recording, bottom: float, bounds: tuple[float, float]) -> Projection:
    """The full recording's optimum next to the log(decay) ``bottom``, to ``FINAL_TOLERANCE``.

    The sum of squares is flat at its bottom to half the digits of a double; its descent, the
    Gauss-Newton step, crosses zero there with all of them.
    """

    @cache
    def step(log_decay: float) -> float:
        return gauss_newton_step(recording, project(recording, math.exp(log_decay)))

    left = _bracket_end(step, bottom, -1.0, bounds[0])
    right = _bracket_end(step, bottom, 1.0, bounds[1])
    if step(left) > 0.0 > step(right):
        polished = brentq(step, left, right, xtol=FINAL_TOLERANCE)
    else:  # at a bound, or a straight line, whose step is 0 everywhere
        polished = left if step(left) < 0.0 else right
    trials = [project(recording, math.exp(each)) for each in (polished, bottom)]
    # At a tie within rounding the zero of the step is the better place.
    return trials[0] if trials[0].squares <= trials[1].squares * (1.0 + 1e-9) else trials[1]


def _bracket_end(step: Callable[[float], float], bottom: float, side: float, bound: float) -> float:
    """Nearest point tried on one side (-1.0, +1.0) from which the descent leads back."""
    reach = FIRST_REACH
    end = bottom
    while end != bound:
        end = max(bottom - reach, bound) if side < 0.0 else min(bottom + reach, bound)
        if side * step(end) < 0.0:
            break
        reach *= 2.0
    return end
