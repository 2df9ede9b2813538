"""Normal equations of a least-squares fit, solved so that dependent columns do no harm."""

import math

import numpy as np

from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import Array

LEAST_PIVOT = 1e-13
"""A column of which less than this share is its own (of its square) is left out."""


@compiled
def _factorise(gram: Array) -> Array:
    """Lower triangle of a matrix with ones on its diagonal; dependent rows get a pivot of 0."""
    lower = np.zeros(gram.shape)
    for i in range(gram.shape[0]):
        for j in range(i + 1):
            value = gram[i, j]
            for m in range(j):
                value -= lower[i, m] * lower[j, m]
            if i == j:
                lower[i, i] = math.sqrt(value) if value > LEAST_PIVOT else 0.0
            elif lower[j, j] > 0.0:
                lower[i, j] = value / lower[j, j]
    return lower


@compiled
def _substitute(lower: Array, right: Array) -> Array:
    """Solution of ``lower @ lower.T @ factors = right``, rows without a pivot left at 0."""
    size = right.size
    forward, factors = np.zeros(size), np.zeros(size)
    for i in range(size):
        if lower[i, i] > 0.0:
            value = right[i]
            for m in range(i):
                value -= lower[i, m] * forward[m]
            forward[i] = value / lower[i, i]
    for i in range(size - 1, -1, -1):
        if lower[i, i] > 0.0:
            value = forward[i]
            for m in range(i + 1, size):
                value -= lower[m, i] * factors[m]
            factors[i] = value / lower[i, i]
    return factors


@compiled
def solve(gram: Array, right: Array) -> Array:
    """Solution of symmetric normal equations by Cholesky; dependent columns get a factor of 0.

    gram: shape (k, k); right: shape (k,). Columns are scaled to length one first.
    """
    size = right.size
    lengths, scaled = np.ones(size), np.empty(gram.shape)
    for i in range(size):
        if gram[i, i] > 0.0:
            lengths[i] = math.sqrt(gram[i, i])
    for i in range(size):
        for j in range(size):
            scaled[i, j] = gram[i, j] / (lengths[i] * lengths[j])
    factors = _substitute(_factorise(scaled), right / lengths)
    return factors / lengths


def solve_least_squares(columns: Array, target: Array) -> Array:
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
