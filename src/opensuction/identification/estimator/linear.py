"""Models that are linear in their parameters, their complexity chosen by cross-validation.

A recording is cut into blocks; each is predicted from all others, and of the designs (which
elements, how fine a grid, how strong a penalty) the simplest that is not surely worse than the best
is kept. Everything is done on sums of
products a block, so that leaving a block out is a subtraction and not another pass.
Source: [Stone-1974] for cross-validation; [Racine-2000] for blocks where neighbours are alike;
[Hoerl-1970] for the penalty; [Lawson-1974] ch. 23 for weights that are not negative.

Normal equations of a least-squares fit, solved so that dependent columns do no harm.

Residual of a model against a recording, and the derivative of its output by each parameter.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

import numpy as np

from opensuction.hysteresis.catalogue.hysteresis_model import Ranges, VectorForm
from opensuction.identification import record
from opensuction.identification.record import Folds, Scores
from opensuction.identification.single_thread import load
from opensuction.kernel.compiled import compiled
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array

DIFFERENCE = 1e-5
"""Step of the central differences, as a share of the parameter."""


def squares(form: VectorForm, vector: Array, input_: Array, output: Array) -> float:
    """Sum of squares of a vector, shape (p,); infinite where the model has no answer."""
    rest = form.simulate(vector, input_) - output
    total = float(rest @ rest)
    return total if math.isfinite(total) else math.inf


def jacobian(form: VectorForm, vector: Array, input_: Array, ranges: Ranges) -> Array:
    """Change of the output with each parameter, central differences inside the limits.

    ranges: of the recording. Returns shape (p, n). A parameter at its limit is taken as given: a
    row of zeros.
    """
    rows = np.zeros((vector.size, input_.size))
    widths = np.diff(form.bounds(ranges), axis=1).ravel()
    for place, (low, high) in enumerate(form.limits(ranges)):
        step = DIFFERENCE * max(abs(float(vector[place])), 1e-3 * float(widths[place]))
        if vector[place] - step < low or vector[place] + step > high:
            continue
        ahead, behind = vector.copy(), vector.copy()
        ahead[place] += step
        behind[place] -= step
        rows[place] = (form.simulate(ahead, input_) - form.simulate(behind, input_)) / (2.0 * step)
    return rows


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
    scores: Scores


Products = tuple[Array, Array, Array]
"""Sums of products for every block: of the columns, shape (blocks, k, k), of columns and target,
shape (blocks, k), and of the target, shape (blocks,)."""


def sum_products(columns: Array, target: Array, folds: Folds) -> Products:
    """Sums of products block by block; columns, shape (k, n), and target about their means."""
    parts = [(columns[:, cut], target[cut]) for cut in folds.cuts]
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
        found = load("scipy.optimize").nnls(triangle, aim, maxiter=50 * right.size)[0]
    except (np.linalg.LinAlgError, RuntimeError) as failed:
        raise InputError(
            f"weights of at least 0 were not found in {right.size} columns ({failed}); "
            "record more varied strokes"
        ) from None
    return np.asarray(found / lengths, dtype=np.float64)


Solve = Callable[[Array, Array], Array]


class _Tried(NamedTuple):
    """A design with what its choice asks for."""

    place: int
    size: int
    penalty: float
    sums: Products
    gram: Array
    """Of the whole recording, with the penalty."""
    means: Array
    blocks: Array
    """Sum of squared errors of each block, predicted from all others."""


def fit(
    designs: Iterable[Design], target: Array, solve: Solve, folds: Folds | None = None
) -> LinearFit:
    """The simplest design that predicts the blocks left out not surely worse than the best.

    target: shape (n,). solve: `solve_free` or `solve_nonnegative`. folds: of the recording; None:
    blocks of equal length. Simpler is one of fewer columns, then one of a stronger penalty. Its
    factors are those of all blocks.
    """
    cut = record.cut_evenly(target.size) if folds is None else folds
    tried, mean = [], float(target.mean())
    for place, design in enumerate(designs):
        means = design.columns.mean(axis=1)
        sums = sum_products(design.columns - means[:, None], target - mean, cut)
        gram = sums[0].sum(axis=0)
        ridge = design.penalty * np.diag(gram)
        ridge[ridge.size - design.spared :] = 0.0
        held = gram + np.diag(ridge)
        blocks = _leave_out(sums, held, solve, [[block] for block in range(cut.blocks)])
        tried.append(_Tried(place, means.size, design.penalty, sums, held, means, blocks))
    if not tried:
        raise ValueError("no design to choose from")
    tried.sort(key=lambda each: (each.size, -each.penalty))
    best = tried[record.choose_simplest([each.blocks for each in tried])]
    factors = solve(best.gram, best.sums[1].sum(axis=0))
    parts = _leave_out(best.sums, best.gram, solve, record.list_parts(cut))
    return LinearFit(
        chosen=best.place,
        factors=factors,
        offset=mean - float(factors @ best.means),
        scores=Scores(best.blocks, parts, target.size),
    )


def _leave_out(sums: Products, gram: Array, solve: Solve, groups: Sequence[Sequence[int]]) -> Array:
    """Sum of squared errors of every block, predicted without the group that it is in."""
    right = sums[1].sum(axis=0)
    left = np.empty(len(sums[0]))
    for group in groups:
        part, aim = (each[list(group)].sum(axis=0) for each in sums[:2])
        factors = solve(gram - part, right - aim)
        for block in group:
            own, along, power = (each[block] for each in sums)
            error = float(power) - 2.0 * float(factors @ along) + float(factors @ own @ factors)
            left[block] = max(error, 0.0)
    return left


def estimate_left_out(jacobian: Array, rest: Array, folds: Folds | None = None) -> Scores:
    """Cross-validation of a fitted nonlinear model, one Gauss-Newton step for what is left out.

    jacobian: shape (p, n), without the rows of the state at the first sample: that is known from
    the first block alone. rest: residuals, shape (n,). folds: as `fit` takes them. The step is what
    leaving a block out changes; for a linear model it is exact.
    """
    cut = record.cut_evenly(rest.size) if folds is None else folds
    lengths = np.sqrt(np.einsum("ij,ij->i", jacobian, jacobian))
    columns = jacobian[lengths > 0.0] / lengths[lengths > 0.0, None]
    gram: Array = columns @ columns.T
    owner = np.repeat(np.arange(cut.blocks), np.diff(cut.edges))

    def leave_out(groups: Sequence[Sequence[int]]) -> Array:
        """Sum of squared errors of every block, predicted without the group that it is in."""
        squares = np.empty(rest.size)
        for group in groups:
            chosen = np.isin(owner, group)
            part = columns[:, chosen]
            change = solve_free(gram - part @ part.T, part @ rest[chosen])
            squares[chosen] = (rest[chosen] + change @ part) ** 2
        sums: Array = np.add.reduceat(squares, cut.edges[:-1])
        return sums

    single = [[block] for block in range(cut.blocks)]
    return Scores(leave_out(single), leave_out(record.list_parts(cut)), rest.size)
