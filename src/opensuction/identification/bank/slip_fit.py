"""A Maxwell-slip model from a recording: linear least squares, its complexity by cross-validation.

Tried are every past, no drag and drag behind either lag, each with every penalty; the simplest that
is not surely worse than the best is taken, as everywhere. Where the element of the longest reach
holds most of the loop, the same is done with longer ones.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from opensuction.hysteresis.bank import maxwell_slip
from opensuction.hysteresis.bank.maxwell_slip import MaxwellSlip
from opensuction.hysteresis.catalogue.slip_model import LAGS, REACHES, RIDGES, WIDE_REACHES, guess
from opensuction.identification import fold
from opensuction.identification.bank import bank_problem, bank_trial
from opensuction.identification.bank.bank_problem import BankProblem
from opensuction.identification.bank.bank_trial import PASTS, BankTrial, Scaled
from opensuction.identification.fold import Folds, Scores
from opensuction.identification.single_thread import single_threaded
from opensuction.kernel.record import Array

TOP = 0.995
"""Quantile of the speeds that counts as the highest: a glitch is none."""

ROUGH_RIDGE = RIDGES[2]
"""Penalty with which the past is chosen."""


WIDE_SHARE = 0.5
"""[design] Share of the loop in the element of the longest reach from which longer ones are
tried."""


class SlipFit(NamedTuple):
    """A Maxwell-slip model of a recording."""

    record: MaxwellSlip
    past: float
    """Memory ratio before the first sample."""
    scores: Scores
    freedom: float
    """Effective number of factors."""


def _gather(columns: Array, target: Array, edges: NDArray[np.int64]) -> BankProblem:
    """The sums of products of a recording, block by block. columns: the last one is 1."""
    table = np.column_stack([columns, target])
    blocks = zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True)
    sums = np.array([table[first:end].T @ table[first:end] for first, end in blocks])
    return bank_problem.pose(sums, np.zeros(columns.shape[1] - 1, dtype=np.bool_))


def _variances(problem: BankProblem) -> Array:
    """Of each factor's column."""
    whole, samples = problem.whole, float(problem.whole[-2, -2])
    means = whole[-2, :-2] / samples
    return np.asarray(np.maximum(np.diagonal(whole)[:-2] / samples - means * means, 0.0))


def _write(
    record: MaxwellSlip, factors: Array, offset: float, scaled: Scaled, period_s: float
) -> MaxwellSlip:
    """The model in the recording's own units. record: of ranges of 1 and periods of 1."""
    range_, height = float(scaled.ranges[0]), scaled.range_
    found = maxwell_slip.with_factors(record, height * np.append(factors, offset))
    slope = found.slope / range_
    return MaxwellSlip(
        slope=slope,
        reaches_mm=range_ * found.reaches_mm,
        gains=found.gains / range_,
        speeds_mm_s=range_ / period_s * found.speeds_mm_s,
        drags_mm=found.drags_mm,
        lag_s=period_s * found.lag_s,
        period_s=period_s,
        offset_mm=scaled.mean + found.offset_mm - slope * float(scaled.lows[0]),
    )


@single_threaded
def fit(input_: Array, output: Array, folds: Folds, period_s: float | None) -> SlipFit:
    """A Maxwell-slip model of a recording.

    input_, output: shape (n,). folds: of the recording. period_s: time between samples; None where
    they are not even: without drag. Raises InputError where no factors are found.
    """
    usual = _fit(input_, output, folds, period_s, REACHES)
    shares = maxwell_slip.share_out(usual.record)
    if shares[-1] <= WIDE_SHARE:
        return usual
    wide = _fit(input_, output, folds, period_s, WIDE_REACHES)
    return (usual, wide)[fold.choose_simplest([usual.scores.blocks, wide.scores.blocks])]


def _fit(
    input_: Array, output: Array, folds: Folds, period_s: float | None, reaches: Array
) -> SlipFit:
    """A Maxwell-slip model with these reaches, as shares of the input's range."""
    scaled = bank_trial.scale(input_[None], output)
    place = scaled.inputs[0]

    def pose(record: MaxwellSlip, past: float) -> BankProblem:
        elements = maxwell_slip.start_elements_mm(record, float(place[0]), past)
        columns = maxwell_slip.basis(record, place, elements)
        return _gather(columns, scaled.output, folds.edges)

    def left(problem: BankProblem) -> float:
        found = bank_problem.fit(problem, ROUGH_RIDGE * _variances(problem))
        return bank_problem.squares_left(problem.whole, found)

    still = guess(1.0, reaches=reaches)
    past = min(PASTS, key=lambda ratio: left(pose(still, ratio)))
    drags = [(0.0, 1.0)]
    if period_s is not None:
        for lag in LAGS:
            speeds = np.abs(maxwell_slip.find_speeds(place, lag, 1.0))
            drags.append((float(np.quantile(speeds, TOP)), lag))
    records = [guess(1.0, top_speed, lag, reaches=reaches) for top_speed, lag in drags]
    tried: list[tuple[MaxwellSlip, BankTrial, float]] = []
    for record in records:
        problem = pose(record, past)
        for ridge in RIDGES:
            trial = bank_trial.evaluate(problem, ridge * _variances(problem), folds)
            freedom = bank_problem.freedom(problem, trial.penalty, trial.solution)
            tried.append((record, trial, freedom))
    tried.sort(key=lambda each: each[2])
    chosen = fold.choose_simplest([trial.blocks for _, trial, _ in tried])
    record, trial, freedom = tried[chosen]
    found = trial.solution
    clock_s = 1.0 if period_s is None else period_s
    return SlipFit(
        record=_write(record, found.found.factors, found.offset, scaled, clock_s),
        past=past,
        scores=bank_trial.score(trial, folds, scaled.range_),
        freedom=freedom,
    )
