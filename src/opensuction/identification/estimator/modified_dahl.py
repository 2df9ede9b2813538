"""Parameters of the modified Dahl model from a recording of head and tip.

Once the decay is fixed the model is linear (``projection``), so the global optimum is a search
along one axis, the logarithm of the decay: a grid on a thinned recording, a descent in each of its
valleys, and on the full recording the zero of the Gauss-Newton step.
Source: ``projection`` for the method; [paper] III-B for the model and for what is minimised.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from opensuction.hysteresis.catalogue.hysteresis_model import BRIEFEST, LONGEST, SHORTEST
from opensuction.hysteresis.modified_dahl import ModifiedDahl, is_monotone
from opensuction.identification.estimator.projection import (
    CentredRecording,
    DecayTrial,
    Projection,
    centre,
    project,
    try_decay,
)
from opensuction.identification.record import check_motion, read_pair, thin
from opensuction.identification.single_thread import single_threaded
from opensuction.kernel.errors import InputError

LEAST_SAMPLES = 12
"""Fewest samples: five parameters, and something left over to judge them by."""

SEARCH_SAMPLES = 1500
"""Samples that resolve the valleys; only the last steps need the full recording."""

GRID_POINTS, MORE_GRID_POINTS = 20, 30
"""Starting points, and those where the search goes on to `BRIEFEST`; neighbours differ by a factor
of 1.7, valleys are wider than that."""

VALLEY_TOLERANCE = 1e-3
"""Where the descent into a valley of the thinned recording stops, in log(decay)."""

ALIKE = 0.1
"""Valleys of a thinned recording whose sums of squares differ by no more than this share are all
tried on the full one: 1500 samples of noise leave a standard error of .04 in a sum of squares."""

FINAL_TOLERANCE = 1e-9
"""Where the search ends, in log(decay)."""

ALARMING_WAY = 0.05
"""A polish that ends so far from its start, in log(decay), is compared with the start."""

MOST_STEPS = 40
"""Bound on the steps of a descent; four or five are usual."""

FARTHEST_STEP = 0.5
"""Longest step in log(decay): the distance of the grid's points."""

LEAST_RISE = 0.01
"""Share by which the sum of squares must rise towards both bounds for the decay to be determined.
Far above what chance gives in a long recording: neighbouring residuals are alike."""

CHANCE = 16.0
"""n times the share of the squares that three parameters more take from white noise stays below
this in 999 of 1000 recordings (chi-square)."""


def least_rise(samples: int) -> float:
    """Share by which squares must rise for what lowers them to be seen in so many samples."""
    return LEAST_RISE + CHANCE / samples


class _Valley(NamedTuple):
    """End of a descent."""

    log_decay: float
    slope: float
    """By how much less the step asks for at the next log(decay), for each unit of it: 1 where the
    model is linear. The step divided by it is Newton's."""


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


@single_threaded
def fit(
    head_mm: ArrayLike, tip_mm: ArrayLike, names: tuple[str, str] = ("head_mm", "tip_mm")
) -> Fit:
    """Fit the modified Dahl model, initial lag included, in the least-squares sense.

    head_mm, tip_mm: positions at the same instants, shape (n,), any length unit if both share
    it. Timing plays no part: the model is independent of speed. names: of the two in a refusal.

    Velocity gains below zero are excluded: a recording without hysteresis, or whose tip leads
    its head, gets the straight line with a gain of 0, not determined.
    Raises InputError for records that are not finite rows of equal length, too short, constant,
    without a reversal, or with the tip moving against the head.
    """
    head, tip = read_pair(names, head_mm, tip_mm, LEAST_SAMPLES)
    check_motion(names, head, tip)
    range_mm = float(np.ptp(head))
    recording = centre(head, tip)
    across, up = recording.head_mm, recording.tip_mm
    line_squares = float(up @ up) - float(across @ up) ** 2 / float(across @ across)
    for shortest, points in ((SHORTEST, GRID_POINTS), (BRIEFEST, MORE_GRID_POINTS)):
        bounds = (math.log(1.0 / LONGEST / range_mm), math.log(1.0 / shortest / range_mm))
        thinned = centre(*thin(head, tip, SEARCH_SAMPLES))
        valleys, least, at_bounds = _search(thinned, bounds, points)
        polished = [_polish(recording, each, bounds) for each in valleys]
        found = min(polished, key=lambda each: each.squares)
        inside = math.log(found.model.decay_per_mm) < bounds[1] - FINAL_TOLERANCE
        none_seen = line_squares <= (1.0 + LEAST_RISE) * found.squares
        if inside or none_seen:
            break
    slope, velocity_gain, decay_per_mm, offset_mm = found.model
    if slope <= 0.0:
        raise InputError(
            f"{names[1]}: moves against {names[0]} (slope {slope:.4g}), should follow it; "
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
        determined=velocity_gain > 0.0
        and at_bounds > (1.0 + least_rise(thinned.head_mm.size)) * least,
    )


def _search(
    recording: CentredRecording, bounds: tuple[float, float], points: int
) -> tuple[list[_Valley], float, float]:
    """Candidates for the optimum, from a thinned recording.

    Returns every valley nearly as deep as the deepest, the sum of squares there, and the lower of
    those at the two bounds.
    """
    grid = np.linspace(*bounds, points)
    heights = np.array(
        [try_decay(recording.head_mm, recording.tip_mm, decay).squares for decay in np.exp(grid)]
    )
    starts = {int(np.argmin(heights))}
    inner = heights[1:-1]
    starts.update(1 + np.flatnonzero((inner <= heights[:-2]) & (inner <= heights[2:])))
    found = []
    for start in starts:
        around = (float(grid[max(start - 1, 0)]), float(grid[min(start + 1, points - 1)]))
        valley = _descend(recording, _Valley(float(grid[start]), 1.0), around, VALLEY_TOLERANCE)
        found.append((_trial(recording, valley.log_decay).squares, valley))
    least = min(found)[0]
    close = [valley for squares, valley in found if squares <= least * (1.0 + ALIKE)]
    return close, least, float(min(heights[0], heights[-1]))


def _trial(recording: CentredRecording, log_decay: float) -> DecayTrial:
    return try_decay(recording.head_mm, recording.tip_mm, math.exp(log_decay))


def _polish(
    recording: CentredRecording, bottom: _Valley, bounds: tuple[float, float]
) -> Projection:
    """The full recording's optimum next to the bottom of a valley, to ``FINAL_TOLERANCE``."""
    polished = _descend(recording, bottom, bounds, FINAL_TOLERANCE).log_decay
    found = project(recording, math.exp(polished))
    if abs(polished - bottom.log_decay) > ALARMING_WAY:  # descent: only a stationary point
        other = project(recording, math.exp(bottom.log_decay))
        found = other if other.squares < found.squares else found
    return found


def _descend(
    recording: CentredRecording, start: _Valley, bounds: tuple[float, float], tolerance: float
) -> _Valley:
    """The log(decay) near the start where the descent ends: a zero of its step, or a bound.

    Newton by the slope of the start, then secants. The sum of squares is flat at its bottom to half
    the digits of a double; the step crosses zero there with all of them. A bracket keeps every
    trial between the last points on either side of the zero.
    """
    low, high = bounds
    here, slope = start
    step = _trial(recording, here).step
    before, step_before = here, 0.0
    for _ in range(MOST_STEPS):
        low, high = (here, high) if step > 0.0 else (low, here)
        gone = here - before
        if step_before != 0.0:
            slope = (step_before - step) / gone if (step_before - step) * gone > 0.0 else 1.0
        way = min(max(step / slope, -FARTHEST_STEP), FARTHEST_STEP)
        # A secant leaves an error of about the product of the last two: no need to look at it.
        left = abs(way) * max(abs(way), abs(gone)) if step_before != 0.0 else abs(way)
        if min(left, abs(way)) <= tolerance:
            return _Valley(min(max(here + way, bounds[0]), bounds[1]), slope)
        before, step_before = here, step
        here = here + way
        if not low < here < high:
            end = low if way < 0.0 else high
            if end in bounds:
                here = end
                if before == end:
                    return _Valley(end, 1.0)
            else:
                here = 0.5 * (low + high)
        step = _trial(recording, here).step
    return _Valley(here, 1.0)
