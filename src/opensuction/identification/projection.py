"""The modified Dahl model seen as linear: its best other parameters for one decay.

For a fixed decay ``tip = c*head + beta*h + z0*E + y0``, with h the lag of a unit velocity gain
that starts from 0 and E the forgetting of the initial lag z0: four linear unknowns.
Source: Golub and Pereyra, SIAM J. Numer. Anal. 10 (1973) 413 (variable projection).
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from opensuction.hysteresis.modified_dahl import ModifiedDahl, simulate

ROUNDING = 1e-12
"""A hysteresis below this share of the tip's range is rounding."""


DERIVATIVE_STEP = 1e-5
"""Step of the central difference in log(decay): truncation 1e-10, rounding likewise."""


class Recording(NamedTuple):
    """A recording, both positions about their means. Arrays of shape (n,)."""

    head_mm: NDArray[np.float64]
    tip_mm: NDArray[np.float64]
    path_mm: NDArray[np.float64]
    """Head travel since the first sample, both directions counted."""
    head_mean_mm: float
    tip_mean_mm: float


class Projection(NamedTuple):
    """Best linear parameters for one decay."""

    model: ModifiedDahl
    """With the offset for positions about their means."""
    lag_mm: float
    columns: NDArray[np.float64]
    """Head, h and E about their means, shape (3, n)."""
    rest_mm: NDArray[np.float64]
    """What the model leaves of the tip, shape (n,)."""
    squares: float
    """Sum of squares of that rest."""


def centred(head_mm: NDArray[np.float64], tip_mm: NDArray[np.float64]) -> Recording:
    """A recording made ready for projection."""
    head_mean_mm, tip_mean_mm = float(head_mm.mean()), float(tip_mm.mean())
    return Recording(
        head_mm=head_mm - head_mean_mm,
        tip_mm=tip_mm - tip_mean_mm,
        path_mm=np.concatenate([[0.0], np.cumsum(np.abs(np.diff(head_mm)))]),
        head_mean_mm=head_mean_mm,
        tip_mean_mm=tip_mean_mm,
    )


def thinned(
    head_mm: NDArray[np.float64], tip_mm: NDArray[np.float64], samples: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The same recording with about as many samples as asked for, and every turn of the head.

    Between turns a move of the head is monotone, in however many samples it was recorded, so
    the regressors at the samples that stay are those of the full recording.
    """
    moves = np.diff(head_mm)
    moving = np.flatnonzero(moves)
    forth = moves[moving] > 0.0
    turns = moving[1:][forth[1:] != forth[:-1]]
    regular = np.arange(0, head_mm.size, max(head_mm.size // samples, 1))
    kept = np.union1d(np.append(regular, head_mm.size - 1), turns)
    return head_mm[kept], tip_mm[kept]


def project(recording: Recording, decay_per_mm: float) -> Projection:
    """Best slope, velocity gain, initial lag and offset for one decay.

    A gain that is not positive, or no more than rounding of the tip, makes way for the straight
    line: gain and lag 0.
    """
    unit_gain = ModifiedDahl(slope=0.0, velocity_gain=1.0, decay_per_mm=decay_per_mm, offset_mm=0.0)
    columns = np.empty((3, recording.head_mm.size))
    columns[0] = recording.head_mm
    columns[1] = simulate(unit_gain, recording.head_mm, 0.0)
    np.exp(-decay_per_mm * recording.path_mm, out=columns[2])
    means = columns.mean(axis=1)
    columns -= means[:, None]
    factors = least_squares(columns, recording.tip_mm)
    lag_range_mm = float(factors[1] * np.ptp(columns[1]))
    if lag_range_mm <= ROUNDING * float(np.ptp(recording.tip_mm)):
        factors = np.array([least_squares(columns[:1], recording.tip_mm)[0], 0.0, 0.0])
    slope, velocity_gain, lag_mm = (float(factor) for factor in factors)
    rest_mm = recording.tip_mm - factors @ columns
    return Projection(
        model=ModifiedDahl(slope, velocity_gain, decay_per_mm, -float(factors @ means)),
        lag_mm=lag_mm,
        columns=columns,
        rest_mm=rest_mm,
        squares=float(rest_mm @ rest_mm),
    )


def least_squares(columns: NDArray[np.float64], target: NDArray[np.float64]) -> NDArray[np.float64]:
    """Factors that bring ``factors @ columns`` nearest to the target.

    columns: shape (factors, n), each about its mean; target: shape (n,), likewise. Normal
    equations, made safe by centring, by scaling every column to length one, and by a second pass
    over the residuals, which wins back the digits they lose.
    """
    # Row by row: for three long rows five times faster than the matrix product.
    gram = np.array([[one @ two for two in columns] for one in columns])
    lengths = np.sqrt(np.diag(gram))
    lengths[lengths == 0.0] = 1.0
    gram /= np.outer(lengths, lengths)
    factors = np.zeros(lengths.size)
    rest = target
    for _ in range(2):
        factors += np.linalg.lstsq(gram, columns @ rest / lengths, rcond=None)[0] / lengths
        rest = target - factors @ columns
    return factors


def gauss_newton_step(recording: Recording, found: Projection) -> float:
    """Change of log(decay) that the linearised model asks for, the other parameters following.

    Its sign is that of the descent, so it is zero exactly where the sum of squares is stationary.
    """
    slope, velocity_gain, decay_per_mm, offset_mm = found.model
    tips = [
        simulate(
            ModifiedDahl(slope, velocity_gain, decay_per_mm * math.exp(change), offset_mm),
            recording.head_mm,
            found.lag_mm,
        )
        for change in (DERIVATIVE_STEP, -DERIVATIVE_STEP)
    ]
    bend = (tips[0] - tips[1]) / (2.0 * DERIVATIVE_STEP)
    columns = np.vstack([found.columns, bend - bend.mean()])
    return float(least_squares(columns, found.rest_mm)[3])
