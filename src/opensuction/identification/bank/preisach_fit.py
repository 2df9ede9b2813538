"""A Preisach model from a recording, its levels and its penalty by cross-validation.

Source: [Mayergoyz-1991] for the triangle.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from opensuction.hysteresis.bank.play_bank import PlayBank
from opensuction.hysteresis.catalogue.play_family import CELL_RIDGES, LEVELS, MARGIN
from opensuction.hysteresis.preisach import Preisach, from_factors
from opensuction.identification.bank import bank_problem
from opensuction.identification.bank.bank_problem import PASTS, BankProblem, BankTrial, Mask
from opensuction.identification.record import Folds, Scores, choose_simplest
from opensuction.identification.single_thread import single_threaded
from opensuction.kernel.record import Array

PAST_LEVELS = 10
"""Levels with which the past is looked for."""


THINNED_FROM = 15_000
"""[design] Samples from which every second one counts, and penalties are tried only next to the
one that was best on the coarser grid: a stroke then has hundreds of samples, whose noise hardly
moves the weights, and the time is that of sums and trials."""


class PreisachFit(NamedTuple):
    """A Preisach model of a recording."""

    record: Preisach
    past: float
    scores: Scores
    freedom: float
    """Effective number of cells."""


@single_threaded
def fit(input_: Array, output: Array, folds: Folds) -> PreisachFit:
    """A Preisach model of a recording, its levels and its penalty by cross-validation.

    input_, output: shape (n,). folds: of the recording. Raises InputError where no weights are
    found.
    """
    scaled = bank_problem.scale(input_[None], output)
    nothing = np.empty((0, output.size))
    every = 2 if output.size >= THINNED_FROM else 1

    def gather(levels: int, past: float) -> Array:
        bank = _triangle(levels)
        starts = scaled.inputs[0, 0] - 0.5 * past * bank.widths_mm
        edges, target = folds.edges, scaled.output
        return bank_problem.gather(bank, scaled.inputs, starts, nothing, target, edges, every)

    def pose(levels: int, past: float) -> BankProblem:
        sums = gather(levels, past)
        return bank_problem.pose(sums, np.ones(sums.shape[1] - 2, dtype=np.bool_))

    def left(problem: BankProblem) -> float:
        solution = bank_problem.fit(problem, _cell_penalty(problem, CELL_RIDGES[-1]))
        return bank_problem.squares_left(problem.whole, solution)

    past = min(PASTS, key=lambda trial: left(pose(PAST_LEVELS, trial)))
    tried: list[tuple[int, BankTrial]] = []
    best = 0
    for levels in LEVELS:
        problem = pose(levels, past)
        passive = _refine(tried[-1], levels) if tried else None
        first = max(best - 1, 0) if every > 1 else 0
        trials = _try_ridges(problem, CELL_RIDGES[first:], folds, passive, every > 1)
        totals = [float(each.blocks.sum()) for each in trials]
        best = first + totals.index(min(totals))
        tried += [(levels, each) for each in trials]
    levels, chosen = tried[choose_simplest([each.blocks for _, each in tried])]
    low, range_ = float(scaled.lows[0]), float(scaled.ranges[0])
    factors = np.append(chosen.solution.found.factors, chosen.solution.offset) * scaled.range_
    factors[-1] += scaled.mean
    return PreisachFit(
        record=from_factors(low - MARGIN * range_, low + (1.0 + MARGIN) * range_, levels, factors),
        past=past,
        scores=_count_all(bank_problem.score(chosen, folds, scaled.range_), every),
        freedom=bank_problem.freedom(chosen.problem, chosen.penalty, chosen.solution),
    )


def _count_all(scores: Scores, every: int) -> Scores:
    """Errors of all samples, from those of the samples that counted."""
    return scores._replace(blocks=every * scores.blocks, parts=every * scores.parts)


def _try_ridges(
    problem: BankProblem, ridges: Sequence[float], folds: Folds, passive: Mask | None, brief: bool
) -> list[BankTrial]:
    """Candidates of one grid, from the strongest penalty on; if brief until one predicts worse."""
    trials: list[BankTrial] = []
    for ridge in ridges:
        trials.append(bank_problem.evaluate(problem, _cell_penalty(problem, ridge), folds, passive))
        passive = trials[-1].solution.found.passive
        if brief and len(trials) > 1 and trials[-1].blocks.sum() > trials[-2].blocks.sum():
            break
    return trials


def _refine(tried: tuple[int, BankTrial], fine: int) -> Mask:
    """Cells that are likely not held at 0, from those of a triangle of fewer levels."""
    coarse, passive = tried[0], tried[1].solution.found.passive
    square = np.zeros((coarse, coarse), dtype=np.bool_)
    rows, places = np.indices(square.shape)
    square[rows + places < coarse] = passive
    row, place = np.indices((fine, fine))
    inside = row + place < fine
    above = row[inside] * coarse // fine
    beside = np.minimum(place[inside] * coarse // fine, coarse - 1 - above)
    return np.asarray(square[above, beside])


def _triangle(levels: int) -> PlayBank:
    """The rows of a triangle over the range and its margins."""
    level = (1.0 + 2.0 * MARGIN) / levels
    rows = np.arange(levels)
    widths: Array = level * rows.astype(np.float64)
    return PlayBank(
        widths_mm=widths,
        lows_mm=0.5 * widths - MARGIN,
        cell_mm=level,
        cells=levels - rows,
        inputs=np.zeros(levels, dtype=np.int64),
        goes_on=False,
    )


def _cell_penalty(problem: BankProblem, ridge: float) -> Array:
    """A ridge on cells, shape (k,); one that no sample passes is held at 0 by it."""
    whole = problem.whole
    samples = float(whole[-2, -2])
    variances = np.diag(whole)[:-2] / samples - (whole[:-2, -2] / samples) ** 2
    least = 1e-6 * float(variances.max(initial=1e-12))
    return np.asarray(ridge * np.maximum(variances, least))
