"""Penalties on a residual readout, and how strong the evidence of a recording says they are.

Source: [MacKay-1992] for the evidence; [Eilers-1996] for the penalty on differences.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from opensuction.hysteresis.catalogue.residual_model import CORNERS, DECAYS, SCALES
from opensuction.identification.bank import bank_problem
from opensuction.identification.bank.bank_problem import BankProblem
from opensuction.kernel.record import Array

HEIGHT, BEND = 1e-2, 1e-5
"""[design] Penalty on the mean square of a line, and on that of its slope over the range."""

FADING = 0.003
"""[design] Usual size of what fades, as a share of the output's range."""

SPARED = 1e-9
"""Penalty on line and lag of the modified Dahl model: only so much that they are determined."""

LEAST_SHARE = 0.01
"""Of the likeliest past's share, below which a past is left out."""

LINES = 2 + CORNERS * (1 + len(DECAYS))
"""Factors before what fades: line and lag of the modified Dahl model, then the readout."""


def _penalty(scale: float, fading: float, fades: int) -> Array:
    """Penalty on the factors. scale: of that on the lines; fading: on each part that fades."""
    steps = np.diff(np.eye(CORNERS), axis=0)
    line = HEIGHT * np.eye(CORNERS) / CORNERS + BEND * (CORNERS - 1) * (steps.T @ steps)
    whole = np.diag([SPARED] * LINES + [fading] * fades)
    whole[2:LINES, 2:LINES] = scale * np.kron(np.eye(1 + len(DECAYS)), line)
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
