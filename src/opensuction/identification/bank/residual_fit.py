"""A residual readout from a recording: modified Dahl model, readout and what fades, together.

All lines have one penalty, on their height and on their slope. How strong it is, the recording says
by its evidence: the likelihood of the recording when every factor is drawn from what the penalty
allows. That needs no block to be left out, so that a recording of one stroke and back is served,
too, and the line and the lag of the modified Dahl model are spared: a penalty without bound leaves
that model alone. Which past the lags began with, a long advance, a long retract or rest, a
recording that settles while it begins does not say surely: the mean of the three fits is taken, by
their evidence, and its beginning left to what fades.
Source: [MacKay-1992] for the evidence.

Penalties on a residual readout, and how strong the evidence of a recording says they are.

Source: [MacKay-1992] for the evidence; [Eilers-1996] for the penalty on differences.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from opensuction.hysteresis.bank import play_bank
from opensuction.hysteresis.bank.play_readout import step_lag
from opensuction.hysteresis.bank.residual_readout import ResidualReadout, find_corner
from opensuction.hysteresis.catalogue.readout_model import (
    CORNERS,
    FADES,
    RESIDUAL_DECAYS,
    SCALES,
    guess,
)
from opensuction.identification.bank import bank_problem
from opensuction.identification.bank.bank_problem import PASTS, BankProblem, BankSolution
from opensuction.identification.record import Folds, Scores, list_parts
from opensuction.identification.single_thread import single_threaded
from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import Array

HEIGHT, BEND = 1e-2, 1e-5
"""[design] Penalty on the mean square of a line, and on that of its slope over the range."""

FADING = 0.003
"""[design] Usual size of what fades, as a share of the output's range."""

SPARED = 1e-9
"""Penalty on line and lag of the modified Dahl model: only so much that they are determined."""

LEAST_SHARE = 0.01
"""Of the likeliest past's share, below which a past is left out."""

LINES = 2 + CORNERS * (1 + len(RESIDUAL_DECAYS))
"""Factors before what fades: line and lag of the modified Dahl model, then the readout."""


def _penalty(scale: float, fading: float, fades: int) -> Array:
    """Penalty on the factors. scale: of that on the lines; fading: on each part that fades."""
    steps = np.diff(np.eye(CORNERS), axis=0)
    line = HEIGHT * np.eye(CORNERS) / CORNERS + BEND * (CORNERS - 1) * (steps.T @ steps)
    whole = np.diag([SPARED] * LINES + [fading] * fades)
    whole[2:LINES, 2:LINES] = scale * np.kron(np.eye(1 + len(RESIDUAL_DECAYS)), line)
    return whole


class Weighed(NamedTuple):
    """Evidence of a recording for a penalty."""

    surprise: float
    """Twice the negative logarithm of the evidence, but for a constant."""
    noise: float
    """Variance of what is left, its penalty included."""


def weigh(problem: BankProblem, penalty: Array) -> Weighed:
    """Evidence of a penalty, the noise's variance at its best."""
    whole = problem.whole
    samples = float(whole[-2, -2])
    means, aim = whole[:-2, -2] / samples, float(whole[-1, -2]) / samples
    gram = whole[:-2, :-2] / samples - np.outer(means, means) + penalty
    right = whole[:-2, -1] / samples - aim * means
    factor = np.linalg.cholesky(gram)
    inside = np.linalg.solve(factor, right)
    power = float(whole[-1, -1]) / samples - aim * aim
    noise = max(power - float(inside @ inside), bank_problem.JITTER * power)
    spread = 2.0 * float(np.log(np.diag(factor)).sum()) - float(np.linalg.slogdet(penalty)[1])
    return Weighed(samples * math.log(noise) + spread, noise)


class WeighedPast(NamedTuple):
    """A past with the penalty of the greatest evidence for it."""

    ratio: float
    """Memory ratio before the first sample."""
    problem: BankProblem
    penalty: Array
    weighed: Weighed
    share: float = 1.0
    """Of the mean over all pasts."""


def choose_penalty(ratio: float, problem: BankProblem, fades: int, noise: float) -> WeighedPast:
    """A past from its problem. noise: variance for which what fades is held to its usual size."""
    fading = noise / (float(problem.whole[-2, -2]) * FADING * FADING)
    tried = [_penalty(scale, fading, fades) for scale in SCALES]
    weighed = [weigh(problem, penalty) for penalty in tried]
    best = min(range(len(tried)), key=lambda place: weighed[place].surprise)
    return WeighedPast(ratio, problem, tried[best], weighed[best])


def share_out(pasts: Sequence[WeighedPast], blocks: int) -> list[WeighedPast]:
    """The pasts with their shares of a mean, those of hardly any left out.

    Neighbouring residuals are alike, and a recording that settles while it begins may look like one
    with another past: evidence by the sample is far too sure. As many pieces count as there are
    blocks; between pasts it then decides where they fit differently, and else the mean is taken.
    """
    samples = float(pasts[0].problem.whole[-2, -2])
    surprises = np.array([each.weighed.surprise for each in pasts]) * blocks / samples
    shares = np.exp(-0.5 * (surprises - surprises.min()))
    shares[shares < LEAST_SHARE] = 0.0
    shares /= shares.sum()
    return [
        each._replace(share=float(share))
        for each, share in zip(pasts, shares, strict=True)
        if share > 0.0
    ]


FIRST_NOISE = 1e-3
"""Noise, as a share of the output's range, with which the first fit begins; the second knows it."""


class ResidualFit(NamedTuple):
    """A residual readout of a recording."""

    record: ResidualReadout
    elements: Array
    """Its elements at the first sample, shape (1 + s + f,): the lags, then what fades."""
    scores: Scores
    freedom: float
    """Effective number of factors."""


@compiled
def _sum_products(
    input_: Array,
    beside: Array,
    lengths: Array,
    past: float,
    fades: Array,
    edges: NDArray[np.int64],
) -> Array:
    """Sums of products of every two columns, block by block.

    input_: from 0 to 1, shape (n,). beside: columns of ones and of the target, shape (2, n).
    lengths: of the lags, the model's own first, shape (1 + s,). past: memory ratio before the first
    sample. fades: shape (f,). Columns: the
    input, its own lag, corners, corners times each further lag, what fades, then those beside.
    """
    lags, fading = lengths.size, fades.size
    size = 2 + CORNERS * lags + fading + 2
    sums = np.zeros((edges.size - 1, size, size))
    elements, left = -past * lengths, np.ones(fading)
    places = np.empty(2 + 2 * lags + fading + 2, dtype=np.int64)
    values = np.empty(places.size)
    places[0], places[1] = 0, 1
    for j in range(fading + 2):
        places[2 + 2 * lags + j] = 2 + CORNERS * lags + j
    for block in range(edges.size - 1):
        for k in range(edges[block], edges[block + 1]):
            move = input_[k] - input_[max(k - 1, 0)]
            at = find_corner(0.0, 1.0, CORNERS, input_[k])
            for j in range(lags):
                elements[j] = step_lag(lengths[j], elements[j], move)
                ratio = 1.0 if j == 0 else elements[j] / lengths[j]
                places[2 + 2 * j] = 2 + CORNERS * j + at.first
                places[3 + 2 * j] = 3 + CORNERS * j + at.first
                values[2 + 2 * j] = (1.0 - at.share) * ratio
                values[3 + 2 * j] = at.share * ratio
            values[0], values[1] = input_[k], elements[0] / lengths[0]
            for j in range(fading):
                left[j] *= math.exp(-abs(move) / fades[j])
                values[2 + 2 * lags + j] = left[j]
            for j in range(2):
                values[2 + 2 * lags + fading + j] = beside[j, k]
            play_bank.add_products(sums, block, places, values)
        play_bank.mirror(sums[block])
    return sums


def _solve_without(group: list[int], past: WeighedPast) -> BankSolution:
    """Factors without some blocks."""
    problem, penalty = past.problem, past.penalty
    start, part = np.ones(penalty.shape[0], dtype=np.bool_), problem.sums[group].sum(axis=0)
    return bank_problem.solve(problem.whole, part, penalty, problem.bounded, start)


def _average(pasts: Sequence[WeighedPast], found: Sequence[BankSolution]) -> tuple[Array, float]:
    """Mean factors and mean offset over all pasts."""
    shares = [past.share for past in pasts]
    factors = np.average([each.found.factors for each in found], axis=0, weights=shares)
    return np.asarray(factors), float(np.average([each.offset for each in found], weights=shares))


def _take_mean(
    problem: BankProblem, pasts: Sequence[WeighedPast], found: Sequence[BankSolution]
) -> tuple[Array, float]:
    """Mean factors and offset, but what fades, which is found beside them.

    problem: of lags that begin with the mean of the pasts.
    """
    factors, offset = _average(pasts, found)
    whole, places = problem.whole, [*range(LINES), factors.size, factors.size + 1]
    known = np.concatenate([factors[:LINES], [offset, -1.0]])
    gram = (whole[:-2, :-2] + float(whole[-2, -2]) * pasts[0].penalty)[LINES:, LINES:]
    factors[LINES:] = np.linalg.solve(gram, -whole[LINES:-2, places] @ known)
    return factors, offset


def _settle(problem: BankProblem, factors: Array) -> BankProblem:
    """The problem with what fades known, and taken from the target."""
    size = problem.whole.shape[0]
    kept = [*range(LINES), size - 2, size - 1]
    turn = np.zeros((size, len(kept)))
    turn[kept, range(len(kept))] = 1.0
    turn[LINES : size - 2, -1] = -factors[LINES:]
    return bank_problem.pose(turn.T @ problem.sums @ turn, problem.bounded[:LINES])


def _score(
    problem: BankProblem,
    pasts: Sequence[WeighedPast],
    found: Sequence[BankSolution],
    mean: Array,
    folds: Folds,
) -> Scores:
    """Errors of what is left out, the output's range being 1.

    problem: of lags that begin with the mean of the pasts. found: of the whole recording, for each
    past; mean: what is made of them. What fades is seen at the beginning alone. Where that is left
    out it is taken as the whole recording tells it, as every other model's memory at the first
    sample is.
    """
    known = [
        past._replace(
            problem=_settle(past.problem, one.found.factors), penalty=past.penalty[:LINES, :LINES]
        )
        for past, one in zip(pasts, found, strict=True)
    ]

    def leave_out(groups: list[list[int]]) -> Array:
        left = np.empty(folds.blocks)
        for group in groups:
            begins = 0 in group
            solved = [_solve_without(group, past) for past in (known if begins else pasts)]
            factors, offset = _average(pasts, solved)
            faded = mean[LINES:] if begins else factors[LINES:]
            vector = np.concatenate([factors[:LINES], faded, [offset, -1.0]])
            left[group] = np.maximum(problem.sums[group] @ vector @ vector, 0.0)
        return left

    single = [[block] for block in range(folds.blocks)]
    return Scores(leave_out(single), leave_out(list_parts(folds)), int(folds.edges[-1]))


@single_threaded
def fit(
    input_: Array, output: Array, folds: Folds, decay: float, fading: bool = True
) -> ResidualFit:
    """A residual readout of a recording.

    input_, output: shape (n,). folds: of the recording. decay: of the modified Dahl model, one over
    a travel in units of the input. fading: whether what was before the recording may fade in it;
    without, it is taken to be the same all along, as is best where another recording is to be
    predicted. Raises InputError where no factors are found.
    """
    scaled = bank_problem.scale(input_[None], output)
    low, range_ = float(scaled.lows[0]), float(scaled.ranges[0])
    fades = FADES if fading else ()
    record = guess(low, low + range_, decay, fades)
    lengths = np.array([1.0 / (decay * range_), *RESIDUAL_DECAYS])
    beside = np.array([np.ones(output.size), scaled.output])

    def pose(past: float) -> BankProblem:
        sums = _sum_products(
            scaled.inputs[0], beside, lengths, past, np.array(fades, dtype=float), folds.edges
        )
        return bank_problem.pose(sums, np.zeros(sums.shape[1] - 2, dtype=np.bool_))

    problems = {past: pose(past) for past in PASTS}
    first = choose_penalty(0.0, problems[0.0], len(fades), FIRST_NOISE * FIRST_NOISE)
    noise = first.weighed.noise
    pasts = [choose_penalty(*item, len(fades), noise) for item in problems.items()]
    pasts = share_out(pasts, folds.blocks)
    found = [bank_problem.fit(each.problem, each.penalty) for each in pasts]
    past = sum(each.share * each.ratio for each in pasts)
    mean = pose(past)
    factors, offset = _take_mean(mean, pasts, found)
    scores = _score(mean, pasts, found, factors, folds)
    freedoms = [
        each.share * bank_problem.freedom(each.problem, each.penalty, one)
        for each, one in zip(pasts, found, strict=True)
    ]
    factors *= scaled.range_
    lines = factors[2:LINES].reshape(lengths.size, CORNERS)
    slope, square = float(factors[0]) / range_, scaled.range_ * scaled.range_
    return ResidualFit(
        record=record._replace(
            slope=slope,
            velocity_gain=float(factors[1]) * decay,
            offset_mm=scaled.mean + scaled.range_ * offset - slope * low,
            curve_mm=lines[0].copy(),
            gains=lines[1:] / record.decays_mm[:, None],
        ),
        elements=np.concatenate([-past * range_ * lengths, factors[LINES:]]),
        scores=scores._replace(blocks=square * scores.blocks, parts=square * scores.parts),
        freedom=sum(freedoms),
    )
