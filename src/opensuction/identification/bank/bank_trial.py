"""Trials of a fit to a bank of plays: what is common to the play readout and the Preisach model.

Candidates are tried from the simplest on; the simplest that is not surely worse than the best is
taken, by one standard error of the difference between the blocks left out, so that a poor
recording gets a simple model.
Source: [Breiman-1984] sec. 3.4.3 for the rule of one standard error.
"""

from typing import NamedTuple

import numpy as np

from opensuction.identification import fold
from opensuction.identification.bank import bank_problem
from opensuction.identification.bank.active_set import Mask
from opensuction.identification.bank.bank_problem import BankProblem, BankSolution
from opensuction.identification.fold import Folds, Scores
from opensuction.kernel.record import Array

PASTS = (-1.0, 0.0, 1.0)
"""Memory ratios tried: after a long retract, at rest, after a long advance."""


class Scaled(NamedTuple):
    """A recording with every range 1."""

    inputs: Array
    """Shape (inputs, n), from 0 to 1."""
    lows: Array
    ranges: Array
    output: Array
    """About its mean, its range 1."""
    mean: float
    range_: float


def scale(inputs: Array, output: Array) -> Scaled:
    """A recording with every range 1. inputs: shape (inputs, n); output: shape (n,)."""
    lows, ranges = inputs.min(axis=1), np.ptp(inputs, axis=1)
    mean, range_ = float(output.mean()), float(np.ptp(output))
    scaled = np.ascontiguousarray((inputs - lows[:, None]) / ranges[:, None])
    return Scaled(scaled, lows, ranges, (output - mean) / range_, mean, range_)


class BankTrial(NamedTuple):
    """A candidate."""

    problem: BankProblem
    penalty: Array
    solution: BankSolution
    blocks: Array


def evaluate(
    problem: BankProblem, penalty: Array, folds: Folds, passive: Mask | None = None
) -> BankTrial:
    """A candidate: its factors from all blocks, its errors on those left out.

    passive: of a neighbouring candidate, from which the search begins.
    """
    solution = bank_problem.fit(problem, penalty, passive)
    groups = [[block] for block in range(folds.blocks)]
    blocks = bank_problem.leave_out(problem, penalty, groups, solution.found.passive)
    return BankTrial(problem, penalty, solution, blocks)


def choose_penalty(problem: BankProblem, penalties: list[Array], folds: Folds) -> BankTrial:
    """The simplest penalty that is not surely worse than the best; neighbours stand together."""
    tried: list[BankTrial] = []
    for penalty in penalties:
        passive = tried[-1].solution.found.passive if tried else None
        tried.append(evaluate(problem, penalty, folds, passive))
    tried.sort(key=lambda each: bank_problem.freedom(each.problem, each.penalty, each.solution))
    return tried[fold.choose_simplest([each.blocks for each in tried])]


def score(chosen: BankTrial, folds: Folds, range_: float) -> Scores:
    """Errors of a candidate in units of the output, whose range is given."""
    parts = fold.list_parts(folds)
    start = chosen.solution.found.passive
    apart = bank_problem.leave_out(chosen.problem, chosen.penalty, parts, start)
    samples = int(folds.edges[-1])
    return Scores(range_ * range_ * chosen.blocks, range_ * range_ * apart, samples)
