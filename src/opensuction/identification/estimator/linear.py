"""Models that are linear in their parameters, their complexity chosen by cross-validation.

A recording is cut into blocks; each is predicted from all others, and the design (which elements,
how fine a grid, how strong a penalty) that predicts best is kept. Everything is done on sums of
products a block, so that leaving a block out is a subtraction and not another pass.
Source: [Stone-1974] for cross-validation; [Racine-2000] for blocks where neighbours are alike;
[Hoerl-1970] for the penalty; [Lawson-1974] ch. 23 for weights that are not negative.
"""

import math
from collections.abc import Callable, Iterable
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.optimize import nnls

from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array

BLOCKS = 20
"""Blocks of a cross-validation: short enough that what one holds is seen elsewhere too."""

JITTER = 1e-12
"""Added to a scaled Gram matrix so that it has a Cholesky triangle in spite of rounding."""


class Design(NamedTuple):
    """One way to write a recording as a sum of columns."""

    columns: Array
    """Shape (k, n), without the column of ones: the offset is fitted to every design."""
    penalty: float
    """Ridge, as a share of each column's variance."""
    spared: int
    """How many of the last columns are not penalised."""


class LinearFit(NamedTuple):
    """The design that was chosen and its factors."""

    chosen: int
    """Place of the design among those offered."""
    factors: Array
    """Of its columns, shape (k,)."""
    offset: float
    cross_validation: float
    """Root mean square error of the blocks left out."""


Products = tuple[Array, Array, Array]
"""Sums of products for every block: of the columns, shape (blocks, k, k), of columns and target,
shape (blocks, k), and of the target, shape (blocks,)."""


def cut_blocks(samples: int, count: int = BLOCKS) -> list[slice]:
    """Neighbouring blocks of nearly equal length that together are the recording."""
    edges = np.linspace(0, samples, min(count, samples) + 1).astype(int)
    return [slice(int(a), int(b)) for a, b in pairwise(edges)]


def sum_products(columns: Array, target: Array) -> Products:
    """Sums of products block by block; columns, shape (k, n), and target about their means."""
    parts = [(columns[:, cut], target[cut]) for cut in cut_blocks(target.size)]
    return (
        np.array([part @ part.T for part, _ in parts]),
        np.array([part @ aim for part, aim in parts]),
        np.array([aim @ aim for _, aim in parts]),
    )


def solve_free(gram: Array, right: Array) -> Array:
    """Least squares from a Gram matrix; the smallest solution where it is singular."""
    lengths = np.sqrt(np.maximum(np.diag(gram), 0.0))
    lengths[lengths == 0.0] = 1.0
    scaled = gram / np.outer(lengths, lengths)
    found = np.linalg.lstsq(scaled, right / lengths, rcond=1e-14)[0]
    return np.asarray(found / lengths, dtype=np.float64)


def solve_nonnegative(gram: Array, right: Array) -> Array:
    """Least squares with factors >= 0, from a Gram matrix by its Cholesky triangle.

    Raises InputError where the algorithm does not end.
    """
    lengths = np.sqrt(np.diag(gram))
    lengths[lengths == 0.0] = 1.0
    scaled = gram / np.outer(lengths, lengths)
    try:
        triangle = np.linalg.cholesky(scaled + JITTER * right.size * np.eye(right.size)).T
        aim = np.linalg.solve(triangle.T, right / lengths)
        found = nnls(triangle, aim, maxiter=50 * right.size)[0]
    except (np.linalg.LinAlgError, RuntimeError) as failed:
        raise InputError(
            f"weights of at least 0 were not found in {right.size} columns ({failed}); "
            "record more varied strokes"
        ) from None
    return np.asarray(found / lengths, dtype=np.float64)


Solve = Callable[[Array, Array], Array]


def fit(designs: Iterable[Design], target: Array, solve: Solve) -> LinearFit:
    """The design that predicts best the blocks left out, and its factors from all of them.

    target: shape (n,). solve: `solve_free` or `solve_nonnegative`.
    """
    best: LinearFit | None = None
    mean = float(target.mean())
    for place, design in enumerate(designs):
        means = design.columns.mean(axis=1)
        columns = design.columns - means[:, None]
        sums = sum_products(columns, target - mean)
        gram, right = sums[0].sum(axis=0), sums[1].sum(axis=0)
        ridge = design.penalty * np.diag(gram)
        ridge[ridge.size - design.spared :] = 0.0
        error = _left_out_error(sums, gram + np.diag(ridge), right, target.size, solve)
        if best is None or error < best.cross_validation:
            factors = solve(gram + np.diag(ridge), right)
            best = LinearFit(
                chosen=place,
                factors=factors,
                offset=mean - float(factors @ means),
                cross_validation=error,
            )
    if best is None:
        raise ValueError("no design to choose from")
    return best


def _left_out_error(sums: Products, gram: Array, right: Array, samples: int, solve: Solve) -> float:
    """Root mean square error of every block, predicted from the others."""
    total = 0.0
    for part, aim, power in zip(*sums, strict=True):
        factors = solve(gram - part, right - aim)
        total += power - 2.0 * float(factors @ aim) + float(factors @ part @ factors)
    return math.sqrt(max(total, 0.0) / samples)


def estimate_left_out_error(jacobian: Array, rest: Array) -> float:
    """Cross-validation error of a fitted nonlinear model, one Gauss-Newton step for each block.

    jacobian: shape (p, n), without the rows of the state at the first sample: that is known from
    the first block alone. rest: residuals, shape (n,). The step is what leaving a block out
    changes; for a linear model it is exact.
    """
    lengths = np.sqrt(np.einsum("ij,ij->i", jacobian, jacobian))
    columns = jacobian[lengths > 0.0] / lengths[lengths > 0.0, None]
    gram: Array = columns @ columns.T
    total = 0.0
    for cut in cut_blocks(rest.size):
        part = columns[:, cut]
        change = solve_free(gram - part @ part.T, part @ rest[cut])
        left = rest[cut] + change @ part
        total += float(left @ left)
    return math.sqrt(total / rest.size)
