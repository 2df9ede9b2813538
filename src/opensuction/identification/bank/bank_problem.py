"""Least squares over a bank of plays, solved for any part of a recording from one pass over it.

The sums of products of a recording are kept block by block. Every fit, with any penalty and without
any block, is then a small linear problem: what is left out is a subtraction.

Trials of a fit to a bank of plays: what is common to the play readout and the Preisach model.

Candidates are tried from the simplest on; the simplest that is not surely worse than the best is
taken, by one standard error of the difference between the blocks left out, so that a poor
recording gets a simple model.
Source: [Breiman-1984] sec. 3.4.3 for the rule of one standard error.

Least squares with some factors held at 0 or above, from a Gram matrix, started from a guess.

All factors that break a condition change sides at once, and one at a time where that goes in
circles. From the answer to a neighbouring problem, such as the same recording without one block,
two or three small solutions do.
Source: [Portugal-1994], block principal pivoting, with the safeguard of [Judice-1994].
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from opensuction.hysteresis.bank import play_bank
from opensuction.hysteresis.bank.play_bank import PlayBank
from opensuction.identification import record
from opensuction.identification.record import Folds, Scores
from opensuction.identification.single_thread import load
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array

PIVOTS_EACH = 4
"""Bound on the exchanges for each factor: some ten in all are usual."""

PATIENCE = 3
"""Exchanges of all at once without progress before they are made one at a time."""

TOLERANCE = 1e-10
"""Of a condition, as a share of the largest right side."""

Mask = NDArray[np.bool_]


class Gram(NamedTuple):
    """A positive definite matrix, of which only what is asked for is ever formed."""

    square: Callable[[NDArray[np.int64]], Array]
    """Its rows and columns at some places."""
    product: Callable[[NDArray[np.int64], Array], Array]
    """Its product with factors at some places, the others being 0; shape (k,)."""


class Bounded(NamedTuple):
    """A solution."""

    factors: Array
    passive: Mask
    """Which factors are free to be what they are; the others are held at 0."""


def solve_bounded(gram: Gram, right: Array, bounded: Mask, start: Mask | None = None) -> Bounded:
    """Factors with the least ``f @ gram @ f - 2 f @ right``, those ``bounded`` at least 0.

    start: the passive set of a neighbouring problem; None: all of them. Raises InputError where the
    matrix is not definite or the exchanges do not end.
    """
    passive = np.ones(right.size, dtype=np.bool_) if start is None else start | ~bounded
    least, patience = right.size + 1, PATIENCE
    tolerance = TOLERANCE * max(float(np.abs(right).max(initial=0.0)), 1e-300)
    for _ in range(PATIENCE + PIVOTS_EACH * right.size):
        factors = np.zeros(right.size)
        inside = np.flatnonzero(passive)
        slope = -right
        if inside.size:
            factors[inside] = _solve_free(gram.square(inside), right[inside])
            slope = gram.product(inside, factors[inside]) - right
        below = factors < -TOLERANCE * float(np.abs(factors).max(initial=0.0))
        wrong = (passive & bounded & below) | (~passive & (slope < -tolerance))
        count = int(np.count_nonzero(wrong))
        if count == 0:
            factors[bounded] = np.maximum(factors[bounded], 0.0)
            return Bounded(factors, passive)
        if count < least:
            least, patience = count, PATIENCE
        elif patience > 0:
            patience -= 1
        else:
            last = int(np.flatnonzero(wrong)[-1])
            wrong = np.zeros(right.size, dtype=np.bool_)
            wrong[last] = True
        passive = passive ^ wrong
    raise InputError(
        f"weights of at least 0 were not found in {right.size} columns; record more varied strokes"
    )


def _solve_free(square: Array, right: Array) -> Array:
    """Factors that are free; the square, symmetric, is overwritten."""
    _, found, failed = load("scipy.linalg").lapack.dposv(square.T, right, overwrite_a=True)
    if failed:
        raise InputError(
            f"weights were not found in {right.size} columns (not definite); record more varied "
            "strokes"
        )
    return np.asarray(found, dtype=np.float64)


JITTER = 1e-11
"""Added to every diagonal, as a share of its mean, so that rounding leaves the matrix definite."""


class BankProblem(NamedTuple):
    """Sums of products of a recording: cells, other columns, 1 and the target."""

    sums: Array
    """Shape (blocks, k + 2, k + 2) for k factors."""
    whole: Array
    """Of all blocks, shape (k + 2, k + 2)."""
    bounded: Mask
    """Factors that are held at 0 or above, shape (k,)."""


def pose(sums: Array, bounded: Mask) -> BankProblem:
    """A problem from its sums. sums: as `gather` returns them; bounded: shape (k,)."""
    return BankProblem(sums, sums.sum(axis=0), bounded)


class BankSolution(NamedTuple):
    """Factors of a recording or of a part of it."""

    found: Bounded
    offset: float


def gather(
    bank: PlayBank,
    inputs: Array,
    positions: Array,
    others: Array,
    target: Array,
    edges: NDArray[np.int64],
    every: int = 1,
) -> Array:
    """The sums of a problem; a factor of a cell is output for the whole of the cell.

    inputs: shape (inputs, n). positions: plays before the first sample. others: further columns,
    shape (c, n). target: shape (n,). edges: of the blocks. every: as `play_bank.sum_products` takes
    it.
    """
    beside = np.ascontiguousarray(np.vstack([others, np.ones(target.size), target]))
    return play_bank.sum_products(bank, inputs, positions, beside, edges, every)


def _part(matrix: Array, places: NDArray[np.int64]) -> Array:
    """Rows and columns of a matrix at some places: in half the time of an index by pairs."""
    return matrix.take(places, axis=0).take(places, axis=1)


def solve(
    whole: Array,
    left_out: Array | None,
    penalty: Array,
    bounded: Mask,
    start: Mask | None = None,
) -> BankSolution:
    """Factors of a recording without a part of it.

    whole, left_out: sums of the recording and of the part, shape (k + 2, k + 2); None: of no part.
    penalty: added to the sums of products a sample, shape (k, k), or (k,) where it is diagonal.
    start: as `active_set.solve` takes it.
    """

    def take(places: NDArray[np.int64] | int) -> Array:
        """Rows of what is left of the sums."""
        return whole[places] if left_out is None else whole[places] - left_out[places]

    ones, aims = take(-2), take(-1)
    samples = max(float(ones[-2]), 1.0)
    means, aim = ones[:-2] / samples, float(ones[-1]) / samples
    right = aims[:-2] / samples - aim * means
    ridge = penalty if penalty.ndim == 1 else np.diagonal(penalty)
    jitter = JITTER * float((np.diagonal(whole)[:-2] / samples + ridge).mean())

    def square(inside: NDArray[np.int64]) -> Array:
        """The Gram matrix about the means, of some factors."""
        gram = _part(whole, inside)
        if left_out is not None:
            gram -= _part(left_out, inside)
        gram /= samples
        gram -= np.outer(means[inside], means[inside])
        if penalty.ndim == 1:
            gram.flat[:: inside.size + 1] += penalty[inside] + jitter
        else:
            gram += _part(penalty, inside)
            gram.flat[:: inside.size + 1] += jitter
        return gram

    def product(inside: NDArray[np.int64], factors: Array) -> Array:
        """The Gram matrix times some factors; rounding of the diagonal left out."""
        total = factors @ whole[inside]
        if left_out is not None:
            total -= factors @ left_out[inside]
        product = total[:-2] / samples - float(factors @ means[inside]) * means
        if penalty.ndim == 1:
            product[inside] += factors * penalty[inside]
            return product
        return np.asarray(product + factors @ penalty[inside])

    found = solve_bounded(Gram(square, product), right, bounded, start)
    return BankSolution(found, aim - float(means @ found.factors))


def squares_left(part: Array, solution: BankSolution) -> float:
    """Sum of squared errors of a solution on a part of a recording."""
    factors = solution.found.factors
    inside = np.append(np.flatnonzero(factors), [factors.size, factors.size + 1])
    vector = np.concatenate([factors, [solution.offset, -1.0]])[inside]
    return max(float(vector @ _part(part, inside) @ vector), 0.0)


def fit(problem: BankProblem, penalty: Array, start: Mask | None = None) -> BankSolution:
    """Factors of the whole recording. start: passive set of a fit with another penalty."""
    return solve(problem.whole, None, penalty, problem.bounded, start)


def leave_out(
    problem: BankProblem, penalty: Array, groups: Sequence[Sequence[int]], start: Mask
) -> Array:
    """Sum of squared errors of every block, predicted without the group that it is in.

    groups: places of the blocks in each. start: passive set of the whole recording.
    """
    left = np.empty(len(problem.sums))
    for group in groups:
        part = problem.sums[group[0]] if len(group) == 1 else problem.sums[list(group)].sum(axis=0)
        found = solve(problem.whole, part, penalty, problem.bounded, start)
        for block in group:
            left[block] = squares_left(problem.sums[block], found)
    return left


def freedom(problem: BankProblem, penalty: Array, solution: BankSolution) -> float:
    """Effective number of factors: how many a fit without penalty would need to do as much."""
    samples = float(problem.whole[-2, -2])
    inside = np.flatnonzero(solution.found.factors)
    means = problem.whole[inside, -2] / samples
    gram = _part(problem.whole, inside) / samples - np.outer(means, means)
    held = gram + (np.diag(penalty[inside]) if penalty.ndim == 1 else _part(penalty, inside))
    held[np.diag_indices_from(held)] += JITTER * float(np.trace(held)) / max(inside.size, 1)
    return float(np.trace(np.linalg.solve(held, gram)))


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
    solution = fit(problem, penalty, passive)
    groups = [[block] for block in range(folds.blocks)]
    blocks = leave_out(problem, penalty, groups, solution.found.passive)
    return BankTrial(problem, penalty, solution, blocks)


def choose_penalty(problem: BankProblem, penalties: list[Array], folds: Folds) -> BankTrial:
    """The simplest penalty that is not surely worse than the best; neighbours stand together."""
    tried: list[BankTrial] = []
    for penalty in penalties:
        passive = tried[-1].solution.found.passive if tried else None
        tried.append(evaluate(problem, penalty, folds, passive))
    tried.sort(key=lambda each: freedom(each.problem, each.penalty, each.solution))
    return tried[record.choose_simplest([each.blocks for each in tried])]


def score(chosen: BankTrial, folds: Folds, range_: float) -> Scores:
    """Errors of a candidate in units of the output, whose range is given."""
    parts = record.list_parts(folds)
    start = chosen.solution.found.passive
    apart = leave_out(chosen.problem, chosen.penalty, parts, start)
    samples = int(folds.edges[-1])
    return Scores(range_ * range_ * chosen.blocks, range_ * range_ * apart, samples)
