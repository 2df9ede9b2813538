"""Least squares with some factors held at 0 or above, from a Gram matrix, started from a guess.

All factors that break a condition change sides at once, and one at a time where that goes in
circles. From the answer to a neighbouring problem, such as the same recording without one block,
two or three small solutions do.
Source: [Portugal-1994], block principal pivoting, with the safeguard of [Judice-1994].
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

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


def solve(gram: Gram, right: Array, bounded: Mask, start: Mask | None = None) -> Bounded:
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
    _, found, failed = lapack.dposv(square.T, right, overwrite_a=True)
    if failed:
        raise InputError(
            f"weights were not found in {right.size} columns (not definite); record more varied "
            "strokes"
        )
    return np.asarray(found, dtype=np.float64)
