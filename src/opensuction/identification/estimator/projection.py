"""The modified Dahl model seen as linear: its best other parameters for one decay.

For a fixed decay ``tip = c*head + beta*h + z0*E + y0``, with h the lag of a unit velocity gain
that starts from 0 and E the forgetting of the initial lag z0: four linear unknowns. Two roads lead
to them: `try_decay`, one compiled pass that sums the normal equations and never keeps a column, for
the search; `project`, with columns and residuals, for the last word.
Source: [Golub-1973] (variable projection).
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from opensuction.hysteresis.modified_dahl import ModifiedDahl
from opensuction.identification.estimator.linear import solve, solve_least_squares
from opensuction.kernel.compiled import compiled

ROUNDING = 1e-12
"""A hysteresis below this share of the tip's range is rounding."""

SUMS = 7
"""Columns of the normal equations: head, h, E, dh and dE (by log(decay)), 1, tip."""

FORGOTTEN = 1e-14
"""[design] Where less than this is left of the initial lag, E and dE are rounding beside the other
columns: they are 0 from there on."""


class CentredRecording(NamedTuple):
    """A recording, both positions about their means. Arrays of shape (n,)."""

    head_mm: NDArray[np.float64]
    tip_mm: NDArray[np.float64]
    head_mean_mm: float
    tip_mean_mm: float


class DecayTrial(NamedTuple):
    """Result of a trial of one decay: `try_decay`."""

    squares: float
    """Sum of squares left, from the normal equations: without its last digits."""
    step: float
    """Change of log(decay) that the linearised model asks for, the other parameters following. Its
    sign is that of the descent: zero exactly where the sum of squares is stationary."""


class Projection(NamedTuple):
    """Best linear parameters for one decay."""

    model: ModifiedDahl
    """With the offset for positions about their means."""
    lag_mm: float
    squares: float
    """Sum of squares of what the model leaves of the tip."""


def centre(head_mm: NDArray[np.float64], tip_mm: NDArray[np.float64]) -> CentredRecording:
    """A recording made ready for projection."""
    head_mean_mm, tip_mean_mm = float(head_mm.mean()), float(tip_mm.mean())
    return CentredRecording(
        head_mm=head_mm - head_mean_mm,
        tip_mm=tip_mm - tip_mean_mm,
        head_mean_mm=head_mean_mm,
        tip_mean_mm=tip_mean_mm,
    )


class _Lags(NamedTuple):
    """The columns that remember, at one sample."""

    h: float
    forgotten: float
    """E: what is left of the initial lag."""
    dh: float
    d_forgotten: float
    """Derivatives of both by log(decay)."""


@compiled
def _move_lags(lags: _Lags, decay_per_mm: float, move_mm: float) -> _Lags:
    """The columns after a move that is not 0.

    ``h <- h e - s (1 - e)/alpha`` and ``E <- E e`` with ``e = exp(-alpha |dx|)``, their derivatives
    by log(alpha) likewise: one exponential.
    """
    share = decay_per_mm * abs(move_mm)
    left = math.exp(-share)
    reach = math.copysign(1.0 / decay_per_mm, move_mm)
    return _Lags(
        h=(lags.h + reach) * left - reach,
        forgotten=left * lags.forgotten,
        # The slope of (h + s/alpha) e - s/alpha by log(alpha).
        dh=left * (lags.dh - reach - share * (lags.h + reach)) + reach,
        d_forgotten=left * (lags.d_forgotten - share * lags.forgotten),
    )


@compiled
def _add(sums: NDArray[np.float64], values: NDArray[np.float64]) -> None:
    """Add a row to the upper triangle of ``sums``: the one that has as many places.

    An assignment to a slice would say it in a line, but takes 3 s to compile: its error message
    alone is made of as much machine code as the rest of the estimator.
    """
    row = SUMS - values.size
    for k in range(values.size):
        sums[row, row + k] += values[k]


@compiled
def _sum_remembering(  # noqa: PLR0915 - one pass, every sum in a register
    head_mm: NDArray[np.float64], tip_mm: NDArray[np.float64], decay_per_mm: float
) -> tuple[NDArray[np.float64], int, _Lags]:
    """Sums of products of every two columns, up to where the initial lag is forgotten.

    Returns their upper triangle, shape (SUMS, SUMS), how many samples they are of, and the lags.
    """
    lags = _Lags(h=0.0, forgotten=1.0, dh=0.0, d_forgotten=0.0)
    s01 = s02 = s03 = s04 = s11 = s12 = s13 = s14 = s15 = s16 = 0.0
    s22 = s23 = s24 = s25 = s26 = s33 = s34 = s35 = s36 = 0.0
    s44 = s45 = s46 = s00 = s05 = s06 = s66 = s56 = 0.0
    last_mm, samples = head_mm[0], 0
    while samples < head_mm.size and lags.forgotten > FORGOTTEN:
        x, y = head_mm[samples], tip_mm[samples]
        samples += 1
        move_mm = x - last_mm
        last_mm = x
        if move_mm != 0.0:
            lags = _move_lags(lags, decay_per_mm, move_mm)
        h, forgotten, dh, d_forgotten = lags
        s00 += x * x
        s01 += x * h
        s02 += x * forgotten
        s03 += x * dh
        s04 += x * d_forgotten
        s05 += x
        s06 += x * y
        s11 += h * h
        s12 += h * forgotten
        s13 += h * dh
        s14 += h * d_forgotten
        s15 += h
        s16 += h * y
        s22 += forgotten * forgotten
        s23 += forgotten * dh
        s24 += forgotten * d_forgotten
        s25 += forgotten
        s26 += forgotten * y
        s33 += dh * dh
        s34 += dh * d_forgotten
        s35 += dh
        s36 += dh * y
        s44 += d_forgotten * d_forgotten
        s45 += d_forgotten
        s46 += d_forgotten * y
        s56 += y
        s66 += y * y
    sums = np.zeros((SUMS, SUMS))
    _add(sums, np.array([s00, s01, s02, s03, s04, s05, s06]))
    _add(sums, np.array([s11, s12, s13, s14, s15, s16]))
    _add(sums, np.array([s22, s23, s24, s25, s26]))
    _add(sums, np.array([s33, s34, s35, s36]))
    _add(sums, np.array([s44, s45, s46]))
    _add(sums, np.array([float(head_mm.size), s56]))
    sums[6, 6] = s66
    return sums, samples, lags


@compiled
def _add_forgetful(
    sums: NDArray[np.float64],
    head_mm: NDArray[np.float64],
    tip_mm: NDArray[np.float64],
    decay_per_mm: float,
    first: int,
    lags: _Lags,
) -> None:
    """Add the samples from ``first`` on, in which nothing is left of the initial lag.

    Half as many sums: on a recording of many strokes most samples are such.
    """
    s00 = s01 = s03 = s05 = s06 = s11 = s13 = s15 = s16 = 0.0
    s33 = s35 = s36 = s56 = s66 = 0.0
    last_mm = head_mm[first - 1]
    for k in range(first, head_mm.size):
        x, y = head_mm[k], tip_mm[k]
        move_mm = x - last_mm
        last_mm = x
        if move_mm != 0.0:
            lags = _move_lags(lags, decay_per_mm, move_mm)
        h, dh = lags.h, lags.dh
        s00 += x * x
        s01 += x * h
        s03 += x * dh
        s05 += x
        s06 += x * y
        s11 += h * h
        s13 += h * dh
        s15 += h
        s16 += h * y
        s33 += dh * dh
        s35 += dh
        s36 += dh * y
        s56 += y
        s66 += y * y
    _add(sums, np.array([s00, s01, 0.0, s03, 0.0, s05, s06]))
    _add(sums, np.array([s11, 0.0, s13, 0.0, s15, s16]))
    _add(sums, np.array([s33, 0.0, s35, s36]))
    _add(sums, np.array([0.0, s56]))
    sums[6, 6] += s66


@compiled
def _sum_products(
    head_mm: NDArray[np.float64], tip_mm: NDArray[np.float64], decay_per_mm: float
) -> NDArray[np.float64]:
    """Sums of products of every two columns, upper triangle, shape (SUMS, SUMS)."""
    sums, samples, lags = _sum_remembering(head_mm, tip_mm, decay_per_mm)
    if samples < head_mm.size:
        _add_forgetful(sums, head_mm, tip_mm, decay_per_mm, samples, lags)
    return sums


@compiled
def try_decay(
    head_mm: NDArray[np.float64], tip_mm: NDArray[np.float64], decay_per_mm: float
) -> DecayTrial:
    """Try one decay: squares that it leaves, and step to a better one. Positions about their means.

    A gain that is not positive makes way for the straight line, whose step is 0.
    """
    sums = _sum_products(head_mm, tip_mm, decay_per_mm)
    samples = sums[5, 5]
    gram = np.empty((SUMS, SUMS))
    for i in range(SUMS):
        for j in range(i, SUMS):
            left = sums[i, 5] if i < 5 else sums[5, i]
            right = sums[j, 5] if j < 5 else sums[5, j]
            gram[i, j] = sums[i, j] - left * right / samples
            gram[j, i] = gram[i, j]
    factors = solve(gram[:3, :3], gram[:3, 6])
    if not factors[1] > 0.0:
        squares = gram[6, 6] - gram[0, 6] * gram[0, 6] / gram[0, 0]
        return DecayTrial(squares=max(squares, 0.0), step=0.0)
    squares = gram[6, 6]
    for i in range(3):
        squares -= factors[i] * gram[i, 6]
    # The fourth column: how the output bends with log(decay), the other parameters held.
    normal, right_side = np.empty((4, 4)), np.empty(4)
    for i in range(3):
        for j in range(3):
            normal[i, j] = gram[i, j]
        normal[i, 3] = factors[1] * gram[i, 3] + factors[2] * gram[i, 4]
        normal[3, i] = normal[i, 3]
        right_side[i] = gram[i, 6]
    normal[3, 3] = (
        factors[1] * factors[1] * gram[3, 3]
        + 2.0 * factors[1] * factors[2] * gram[3, 4]
        + factors[2] * factors[2] * gram[4, 4]
    )
    right_side[3] = factors[1] * gram[3, 6] + factors[2] * gram[4, 6]
    for i in range(4):  # the rest's share of each column
        for j in range(3):
            right_side[i] -= normal[i, j] * factors[j]
    return DecayTrial(squares=max(squares, 0.0), step=solve(normal, right_side)[3])


@compiled
def _columns(head_mm: NDArray[np.float64], decay_per_mm: float) -> NDArray[np.float64]:
    """Head, h and E, shape (3, n): one exponential for both, and no rounding in a small move."""
    columns = np.empty((3, head_mm.size))
    h, forgotten, last_mm = 0.0, 1.0, head_mm[0]
    for k in range(head_mm.size):
        move_mm = head_mm[k] - last_mm
        last_mm = head_mm[k]
        lost = math.expm1(-decay_per_mm * abs(move_mm))
        h += (h + math.copysign(1.0 / decay_per_mm, move_mm)) * lost
        forgotten += forgotten * lost
        columns[0, k] = head_mm[k]
        columns[1, k] = h
        columns[2, k] = forgotten
    return columns


def project(recording: CentredRecording, decay_per_mm: float) -> Projection:
    """Best slope, velocity gain, initial lag and offset for one decay.

    A gain that is not positive, or no more than rounding of the tip, makes way for the straight
    line: gain and lag 0.
    """
    columns = _columns(recording.head_mm, decay_per_mm)
    means = columns.mean(axis=1)
    columns -= means[:, None]
    factors = solve_least_squares(columns, recording.tip_mm)
    lag_range_mm = float(factors[1] * np.ptp(columns[1]))
    if lag_range_mm <= ROUNDING * float(np.ptp(recording.tip_mm)):
        factors = np.array([solve_least_squares(columns[:1], recording.tip_mm)[0], 0.0, 0.0])
    slope, velocity_gain, lag_mm = (float(factor) for factor in factors)
    rest_mm = recording.tip_mm - factors @ columns
    return Projection(
        model=ModifiedDahl(slope, velocity_gain, decay_per_mm, -float(factors @ means)),
        lag_mm=lag_mm,
        squares=float(rest_mm @ rest_mm),
    )
