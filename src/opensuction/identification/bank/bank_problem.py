"""Least squares over a bank of plays, solved for any part of a recording from one pass over it.

The sums of products of a recording are kept block by block. Every fit, with any penalty and without
any block, is then a small linear problem: what is left out is a subtraction.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from opensuction.hysteresis.bank import play_bank
from opensuction.hysteresis.bank.play_bank import PlayBank
from opensuction.identification.bank import active_set
from opensuction.identification.bank.active_set import Bounded, Gram, Mask
from opensuction.kernel.record import Array

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
        pairs = np.ix_(inside, inside)
        gram = whole[pairs] if left_out is None else whole[pairs] - left_out[pairs]
        gram /= samples
        gram -= np.outer(means[inside], means[inside])
        if penalty.ndim == 1:
            gram.flat[:: inside.size + 1] += penalty[inside] + jitter
        else:
            gram += penalty[pairs]
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

    found = active_set.solve(Gram(square, product), right, bounded, start)
    return BankSolution(found, aim - float(means @ found.factors))


def squares_left(part: Array, solution: BankSolution) -> float:
    """Sum of squared errors of a solution on a part of a recording."""
    factors = solution.found.factors
    inside = np.append(np.flatnonzero(factors), [factors.size, factors.size + 1])
    vector = np.concatenate([factors, [solution.offset, -1.0]])[inside]
    return max(float(vector @ part[np.ix_(inside, inside)] @ vector), 0.0)


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
    gram = problem.whole[np.ix_(inside, inside)] / samples - np.outer(means, means)
    held = gram + (
        np.diag(penalty[inside]) if penalty.ndim == 1 else penalty[np.ix_(inside, inside)]
    )
    held[np.diag_indices_from(held)] += JITTER * float(np.trace(held)) / max(inside.size, 1)
    return float(np.trace(np.linalg.solve(held, gram)))
