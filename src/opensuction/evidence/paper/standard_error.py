"""Standard errors of the difference of two numbers, from the scatter of both.

A tolerance is exceeded by chance in one case of twenty: it is the standard error times the quantile
of Student's t, its degrees of freedom by Welch and Satterthwaite.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.stats import norm, t

CHANCE = 0.05
"""Share of equal pairs that a tolerance takes for different."""
GRID = 4001
"""Points at which a largest value's distribution is integrated."""


class Uncertainty(NamedTuple):
    """Of the difference of two numbers, in their unit."""

    standard_error: float
    tolerance: float


def _combined(variances: Sequence[float], degrees: Sequence[float]) -> Uncertainty:
    """From the variance of each number and the degrees of freedom that it is known with."""
    total = math.fsum(variances)
    if total == 0.0:
        return Uncertainty(0.0, 0.0)
    freedom = total**2 / math.fsum(v * v / d for v, d in zip(variances, degrees, strict=True))
    error = math.sqrt(total)
    return Uncertainty(error, error * float(t.ppf(1.0 - 0.5 * CHANCE, freedom)))


def of_means(*samples: Sequence[float]) -> Uncertainty:
    """Of the difference of the means of two samples."""
    return _combined(
        [float(np.var(sample, ddof=1)) / len(sample) for sample in samples],
        [len(sample) - 1.0 for sample in samples],
    )


def of_spreads(*samples: Sequence[float]) -> Uncertainty:
    """Of the difference of the standard deviations of two samples, taken as normal."""
    degrees = [len(sample) - 1.0 for sample in samples]
    spreads = [float(np.var(sample, ddof=1)) for sample in samples]
    halves = [value / (2.0 * freedom) for value, freedom in zip(spreads, degrees, strict=True)]
    return _combined(halves, degrees)


def of_one(sample: Sequence[float]) -> Uncertainty:
    """Of one number and the mean of a sample, the one being one more draw of the same."""
    drawn = float(np.var(sample, ddof=1))
    return _combined([drawn * (1.0 + 1.0 / len(sample))], [len(sample) - 1.0])


def of_same_mean(sample: Sequence[float], others: int) -> Uncertainty:
    """Of a mean of ``others`` values and that of a sample, both scattered like the sample."""
    drawn = float(np.var(sample, ddof=1))
    return _combined([drawn * (1.0 / others + 1.0 / len(sample))], [len(sample) - 1.0])


def of_largest(*samples: Sequence[float]) -> Uncertainty:
    """Of the difference of the largest absolute values of two samples, taken as normal."""
    return _combined(
        [_largest_variance(sample) for sample in samples],
        [len(sample) - 1.0 for sample in samples],
    )


def _largest_variance(sample: Sequence[float]) -> float:
    """Variance of the largest absolute value of as many normal draws."""
    mean, spread = float(np.mean(sample)), float(np.std(sample, ddof=1))
    values = np.linspace(0.0, abs(mean) + 8.0 * spread, GRID)
    below = norm.cdf(values, mean, spread) - norm.cdf(-values, mean, spread)
    share = np.diff(below ** len(sample))
    centre = 0.5 * (values[1:] + values[:-1])
    largest = float(np.sum(share * centre))
    return float(np.sum(share * (centre - largest) ** 2))


def of_counts(first: int, second: int, trials: int) -> Uncertainty:
    """Of the difference of two counts out of as many trials each.

    Two successes and failures more are reckoned than were seen, so that none or all is not taken
    for certain. Source: [Agresti-1998].
    """
    shares = [(count + 2.0) / (trials + 4.0) for count in (first, second)]
    return _combined([trials * p * (1.0 - p) for p in shares], [trials - 1.0] * 2)
