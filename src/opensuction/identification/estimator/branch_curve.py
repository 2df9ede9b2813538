"""The two branches of a recorded loop: as a table of head positions, and as parallel lines.

A branch is recorded where the head has gone on in one direction for longer than the gap is wide;
before that the tip is still between the branches.
"""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from opensuction.control.backlash_inverse import Curves
from opensuction.hysteresis import play
from opensuction.identification.extremum import find_minimum
from opensuction.identification.record import read_pair
from opensuction.kernel.compiled import compiled
from opensuction.kernel.errors import InputError

LEAST_SAMPLES = 100
"""Fewest samples: several for each entry of the table."""
USED_SAMPLES = 4000
"""Samples that the fits use, evenly spread."""
ENTRIES = 40
"""Entries of the table: 2 to 5 mm apart."""
TURNED_SHARE = 0.3
"""Share of the head's range after a turn that belongs to no branch: wider than any gap here."""
WIDEST_SHARE = 0.5
"""Widest backlash that is looked for, as a share of the head's range."""


def _read(head_mm: ArrayLike, tip_mm: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    head, tip = read_pair(("head_mm", "tip_mm"), head_mm, tip_mm, LEAST_SAMPLES)
    if not np.ptp(head) > 0.0:
        raise InputError(f"head_mm: constant at {head[0]:g}, should move")
    every = max(head.size // USED_SAMPLES, 1)
    return head[::every], tip[::every]


def _fit_line(x: NDArray[np.float64], y: NDArray[np.float64]) -> tuple[float, float]:
    """Slope and offset of the straight line that is nearest to ``y`` over ``x``."""
    x_mean, y_mean = float(x.mean()), float(y.mean())
    centred = x - x_mean
    slope = float(centred @ y) / float(centred @ centred)
    return slope, y_mean - slope * x_mean


def fit_parallel(head_mm: ArrayLike, tip_mm: ArrayLike) -> Curves:
    """One backlash width: the single play that fits the recording best, as two parallel lines.

    head_mm, tip_mm: positions at the same instants, shape (n,), from a long retract on.
    Raises InputError for bad records, or a tip that does not follow the head.
    """
    head, tip = _read(head_mm, tip_mm)
    range_mm = float(np.ptp(head))

    def line(width_mm: float) -> tuple[float, float, float]:
        """Sum of squares, gain and offset of the best line over the play of one width."""
        moved = play.simulate(width_mm, head, head[0] + 0.5 * width_mm)
        gain, offset = _fit_line(moved, tip)
        rest = tip - gain * moved - offset
        return float(rest @ rest), gain, offset

    found = find_minimum(lambda width_mm: line(width_mm)[0], 0.0, WIDEST_SHARE * range_mm)
    _, gain, offset_mm = line(found.place)
    if not gain > 0.0:
        raise InputError("tip_mm: does not follow head_mm; negate one of them")
    first_mm, spacing_mm = float(tip.min()), float(np.ptp(tip))
    heads = (first_mm + np.array([0.0, spacing_mm]) - offset_mm) / gain
    half_mm = 0.5 * found.place
    return Curves(first_mm, spacing_mm, heads + half_mm, heads - half_mm)


def fit_table(head_mm: ArrayLike, tip_mm: ArrayLike) -> Curves:
    """Head position over tip depth on either branch, from the samples that lie on one.

    head_mm, tip_mm: as for `fit_parallel`. Depths that a branch does not reach are continued with
    the branch's mean slope. Raises InputError where a branch is not in the recording.
    """
    head, tip = _read(head_mm, tip_mm)
    depths = np.linspace(float(tip.min()), float(tip.max()), ENTRIES)
    inwards, outwards = (_fit_branch(head, tip, depths, sign) for sign in (1.0, -1.0))
    return Curves(
        first_mm=float(depths[0]),
        spacing_mm=float(depths[1] - depths[0]),
        inwards_mm=inwards,
        outwards_mm=outwards,
    )


@compiled
def _travel_mm(head: NDArray[np.float64], sign: float) -> NDArray[np.float64]:
    """Travel of the head in one direction since it last went the other way."""
    travelled = np.zeros(head.size)
    for k in range(1, head.size):
        step = sign * (head[k] - head[k - 1])
        travelled[k] = travelled[k - 1] + step if step >= 0.0 else 0.0
    return travelled


def _fit_branch(
    head: NDArray[np.float64],
    tip: NDArray[np.float64],
    depths: NDArray[np.float64],
    sign: float,
) -> NDArray[np.float64]:
    on = _travel_mm(head, sign) > TURNED_SHARE * float(np.ptp(head))
    if np.count_nonzero(on) < 2 or not np.ptp(tip[on]) > 0.0:
        word = "inwards" if sign > 0.0 else "outwards"
        raise InputError(f"head_mm: no long travel {word} to take that branch from")
    spacing = depths[1] - depths[0]
    slope, middle = _fit_line(tip[on], head[on])
    curve: NDArray[np.float64] = slope * depths + middle
    # The mean of what lies next to an entry, along the mean slope to the entry's own depth.
    nearest = np.rint((tip[on] - depths[0]) / spacing).astype(np.int64)
    counts = np.bincount(nearest, minlength=depths.size)
    above = np.bincount(nearest, head[on] - slope * tip[on] - middle, minlength=depths.size)
    known = counts > 0
    curve[known] += above[known] / counts[known]
    first, last = int(np.argmax(known)), depths.size - 1 - int(np.argmax(known[::-1]))
    curve[:first] += curve[first] - (slope * depths[first] + middle)
    curve[last + 1 :] += curve[last] - (slope * depths[last] + middle)
    if not math.isfinite(float(curve.sum())):
        raise InputError("tip_mm: the branches could not be recorded")
    return np.ascontiguousarray(curve)
