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

from opensuction.hysteresis import play
from opensuction.hysteresis import prandtl_ishlinskii as model_of
from opensuction.hysteresis.play_sum import PLAYS
from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii
from opensuction.identification import record
from opensuction.identification.record import Folds, Scores, find_turns, read_pair
from opensuction.identification.single_thread import load
from opensuction.kernel.compiled import compiled
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

ROUNDING = 1e-12
"""Raises the square of each column by this share of itself while the plays are chosen: as much as
rounding can leave of a sum of `USED_SAMPLES` products, so that there is a solution always."""


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
    used, widths = _thin(head)
    plays = play_positions_mm(head, 0.5 * widths, used)
    # A compensation has room for so many plays: where more are found, the grid is made coarser.
    for every in range(1, widths.size):
        columns = np.vstack([head[None, used], plays[::every], np.ones((1, used.size))])
        weights, offset_mm, curvature = _solve(columns, tip[used])
        if not weights.sum() > 0.0:
            raise InputError("tip_mm: does not follow head_mm; negate one of them")
        kept = weights[1:] > LEAST_SHARE * weights.sum()
        if np.count_nonzero(kept) <= PLAYS:
            break
    model = PrandtlIshlinskii(
        thresholds_mm=np.ascontiguousarray(0.5 * widths[::every][kept]),
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


def _thin(head_mm: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """The samples that a fit uses, and the widths of its grid."""
    used = np.arange(0, head_mm.size, max(head_mm.size // USED_SAMPLES, 1))
    shares = np.arange(GRID_SHARE, WIDEST_SHARE + 0.5 * GRID_SHARE, GRID_SHARE)
    return used, shares * float(np.ptp(head_mm))


def score(head_mm: NDArray[np.float64], tip_mm: NDArray[np.float64], folds: Folds) -> Scores:
    """Prediction errors of the blocks of a recording from others, fitted on the grid as `fit`.

    head_mm, tip_mm: as of `fit`. folds: of them.
    """
    used, widths = _thin(head_mm)
    columns = np.vstack(
        [head_mm[None, used], play_positions_mm(head_mm, 0.5 * widths, used), np.ones(used.size)]
    )
    tip, owner = tip_mm[used], np.searchsorted(folds.edges, used, side="right") - 1
    samples = np.diff(folds.edges) / np.maximum(np.bincount(owner, minlength=folds.blocks), 1)

    def leave_out(groups: list[list[int]]) -> NDArray[np.float64]:
        squares = np.empty(folds.blocks)
        for group in groups:
            others = ~np.isin(owner, group)
            weights, offset_mm, curvature = _solve(columns[:, others], tip[others])
            inner = weights @ columns[:-1]
            errors = tip - offset_mm - inner * (1.0 + curvature * inner)
            for block in group:
                squares[block] = float(errors[owner == block] @ errors[owner == block])
        return squares * samples

    blocks = leave_out([[block] for block in range(folds.blocks)])
    return Scores(blocks, leave_out(record.list_parts(folds)), head_mm.size)


@compiled
def _simulate_plays(
    thresholds_mm: NDArray[np.float64], head_mm: NDArray[np.float64], wanted: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Positions of plays at the samples ``wanted`` of a record that begins after a long retract."""
    positions_mm = np.empty((thresholds_mm.size, wanted.size))
    for j in range(thresholds_mm.size):
        position_mm, width_mm = head_mm[0] + thresholds_mm[j], 2.0 * thresholds_mm[j]
        done = 0
        for k in range(head_mm.size):
            position_mm = play.step(width_mm, position_mm, head_mm[k])
            if done < wanted.size and wanted[done] == k:
                positions_mm[j, done] = position_mm
                done += 1
    return positions_mm


def play_positions_mm(
    head_mm: NDArray[np.float64], thresholds_mm: NDArray[np.float64], used: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Positions of every play at some samples of a record that begins after a long retract.

    used: indices of these samples, ascending. Returns shape (thresholds, used).
    """
    # Between two turns of the head a play depends on no sample but the last.
    is_kept = np.zeros(head_mm.size, dtype=bool)
    is_kept[used] = is_kept[find_turns(head_mm, 0.0)] = True
    kept = np.flatnonzero(is_kept)
    return _simulate_plays(thresholds_mm, head_mm[kept], np.searchsorted(kept, used))


def _solve(
    columns: NDArray[np.float64], target: NDArray[np.float64]
) -> tuple[NDArray[np.float64], float, float]:
    """Weights of the columns (>= 0), offset and curvature (of either sign).

    columns: shape (n, samples), the last of ones. The normal equations keep their triangle: a
    small system of the same solution, to which each round adds the bend of the last one's sum.
    """
    count = columns.shape[0]
    gram, right_side = np.empty((count + 1, count + 1)), np.append(columns @ target, 0.0)
    gram[:count, :count] = columns @ columns.T
    weights, offset_mm, curvature = _solve_normal(gram[:count, :count], right_side[:count], count)
    for _ in range(ROUNDS - 1):
        inner = weights @ columns[:-1]
        bend = inner * inner
        gram[:count, count] = gram[count, :count] = columns @ bend
        gram[count, count], right_side[count] = bend @ bend, bend @ target
        weights, offset_mm, curvature = _solve_normal(gram, right_side, count)
    return weights, offset_mm, curvature


def _solve_normal(
    gram: NDArray[np.float64], right_side: NDArray[np.float64], count: int
) -> tuple[NDArray[np.float64], float, float]:
    """Solution of normal equations whose first ``count - 1`` factors are not negative."""
    size, lengths = len(gram), np.sqrt(np.maximum(np.diag(gram), np.finfo(np.float64).tiny))
    alike, right_side = gram / np.outer(lengths, lengths), right_side / lengths
    # Columns that cannot be told apart share what is theirs, instead of having no solution.
    linalg = load("scipy.linalg")
    lower = linalg.cholesky(alike + ROUNDING * np.eye(size), lower=True, check_finite=False)
    found, _ = load("scipy.optimize").nnls(
        np.hstack([lower.T, -lower.T[:, count - 1 :]]),
        linalg.solve_triangular(lower, right_side, lower=True, check_finite=False),
    )
    factors = found[:size]
    factors[count - 1 :] -= found[size:]
    # The few columns that are used can be told apart: exactly now.
    used = np.flatnonzero(factors)
    factors[used] = np.linalg.lstsq(alike[np.ix_(used, used)], right_side[used])[0]
    factors /= lengths
    return np.maximum(factors[: count - 1], 0.0), float(factors[count - 1]), factors[count:].sum()
