"""Weights of the Prandtl-Ishlinskii model from a recording of head and tip.

On a known grid of thresholds the model is linear in its weights, so they are the solution of a
non-negative least-squares problem: convex, without a start value, and sparse by nature. The mild
curvature is a further column, the square of the last round's sum.

This is the estimator of the compensators. The workbench has another
(`superposition.fit_prandtl_ishlinskii`), because the two answer different questions. Here the
excitation is our own: the past is known (a long retract), so is how wide a gap can be, a fine grid
is left sparse by non-negativity alone, and curvature is worth a parameter, since the tip follows
the model. There a recording is anybody's: its past is unknown and tried, units are any, and
cross-validation chooses how many plays stand in a ranking with other models.
Source: [Kuhnen-2003] for the grid; [Lawson-1974] for the algorithm (`scipy.optimize.nnls`).
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import get_lapack_funcs, qr
from scipy.optimize import nnls

from opensuction.hysteresis import play
from opensuction.hysteresis import prandtl_ishlinskii as model_of
from opensuction.hysteresis.play_sum import PLAYS
from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii
from opensuction.identification.record import find_turns, read_pair
from opensuction.kernel.errors import InputError

LEAST_SAMPLES = 100
"""Fewest samples: more than the thresholds of the grid."""
USED_SAMPLES = 4000
"""Samples that the fit uses, evenly spread: more change no weight by a thousandth."""
GRID_SHARE = 0.005
"""Distance between neighbouring full widths of the grid, as a share of the head's range."""
WIDEST_SHARE = 0.4
"""Widest full width of the grid, as a share of the head's range: what is wider never opens."""
ROUNDS = 4
"""Rounds for the curvature; each lowers its error a hundredfold."""
LEAST_SHARE = 1e-4
"""Smaller weights, as shares of their sum, are rounding and are left out."""


class PrandtlIshlinskiiFit(NamedTuple):
    """A fitted Prandtl-Ishlinskii model and how well it explains the recording."""

    model: PrandtlIshlinskii
    rmse_mm: float
    samples: int
    well_posed: bool
    """Whether it has a continuous inverse over the recorded depths."""


def fit(head_mm: ArrayLike, tip_mm: ArrayLike) -> PrandtlIshlinskiiFit:
    """Fit weights, slope, offset and curvature in the least-squares sense.

    head_mm, tip_mm: positions at the same instants, shape (n,). The head must have come from a
    long retract: its plays are taken to be at the far end of their slots at the first sample.
    Returns at most `play_sum.PLAYS` plays.
    Raises InputError for records that are not finite rows of equal length, too short, or whose
    tip does not follow the head.
    """
    head, tip = read_pair(("head_mm", "tip_mm"), head_mm, tip_mm, LEAST_SAMPLES)
    range_mm = float(np.ptp(head))
    if not range_mm > 0.0:
        raise InputError(f"head_mm: constant at {head[0]:g}, should move")
    used = np.arange(0, head.size, max(head.size // USED_SAMPLES, 1))
    widths = np.arange(GRID_SHARE, WIDEST_SHARE + 0.5 * GRID_SHARE, GRID_SHARE) * range_mm
    plays = play_positions_mm(head, 0.5 * widths, used)
    columns = np.vstack([head[None, used], plays, np.ones((1, used.size))])
    # A compensation has room for so many plays: where more are found, the grid is made coarser.
    for every in range(1, widths.size):
        grid = np.arange(0, widths.size, every)
        weights, offset_mm, curvature = _solve(columns[[0, *(1 + grid), -1]], tip[used])
        if not weights.sum() > 0.0:
            raise InputError("tip_mm: does not follow head_mm; negate one of them")
        kept = weights[1:] > LEAST_SHARE * weights.sum()
        if np.count_nonzero(kept) <= PLAYS:
            break
    model = PrandtlIshlinskii(
        thresholds_mm=np.ascontiguousarray(0.5 * widths[grid[kept]]),
        weights=np.ascontiguousarray(weights[1:][kept]),
        slope=float(weights[0]),
        offset_mm=offset_mm,
        curvature_per_mm=curvature,
    )
    start = model_of.retracted_positions_mm(model, head[0])
    rest = tip - model_of.simulate(model, head, start)
    return PrandtlIshlinskiiFit(
        model=model,
        rmse_mm=math.sqrt(float(rest @ rest) / rest.size),
        samples=head.size,
        well_posed=model_of.is_well_posed(model, float(tip.max()), float(tip.min())),
    )


def play_positions_mm(
    head_mm: NDArray[np.float64], thresholds_mm: NDArray[np.float64], used: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Positions of every play at some samples of a record that begins after a long retract.

    used: indices of these samples, ascending. Returns shape (thresholds, used).
    """
    # Between two turns of the head a play depends on no sample but the last.
    kept = np.union1d(used, find_turns(head_mm, 0.0))
    wanted = np.searchsorted(kept, used)
    return np.array(
        [
            play.simulate(2.0 * threshold_mm, head_mm[kept], head_mm[0] + threshold_mm)[wanted]
            for threshold_mm in thresholds_mm
        ]
    )


def _solve(
    columns: NDArray[np.float64], target: NDArray[np.float64]
) -> tuple[NDArray[np.float64], float, float]:
    """Weights of the columns (>= 0), offset and curvature (of either sign).

    columns: shape (n, samples), the last of ones. Rotated so that they are a triangle, they make a
    small system of the same solution. From round to round only the bend changes: it adds a row for
    what lies outside their space.
    """
    count = columns.shape[0]
    (factors, scales), triangle = qr(columns.T, mode="raw", check_finite=False)
    multiply = get_lapack_funcs("ormqr", (factors,))

    def rotate(values: NDArray[np.float64]) -> NDArray[np.float64]:
        rotated: NDArray[np.float64] = multiply("L", "T", factors, scales, values[:, None], 1)[0]
        return rotated[:, 0]

    wanted, right_side = rotate(target), np.zeros(count + 1)
    right_side[:-1] = wanted[:count]
    system = np.zeros((count + 1, count + 3))
    system[:-1, :count] = triangle[:count]
    system[:, count] = -system[:, count - 1]  # an offset of either sign
    weights, offset_mm, curvature = np.zeros(count - 1), 0.0, 0.0
    for _ in range(ROUNDS):
        found, _ = nnls(system, right_side)
        weights = found[: count - 1]
        offset_mm = float(found[count - 1] - found[count])
        curvature = float(found[-2] - found[-1])
        inner = weights @ columns[:-1]
        bend = rotate(inner * inner)
        outside = bend[count:]
        length = math.sqrt(float(outside @ outside))
        system[:, -2] = np.append(bend[:count], length)
        system[:, -1] = -system[:, -2]
        right_side[-1] = outside @ wanted[count:] / length if length > 0.0 else 0.0
    return weights, offset_mm, curvature
