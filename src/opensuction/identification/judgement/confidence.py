"""Confidence intervals that hold although neighbouring residuals are alike.

The residuals of a recording are not independent: drift, filters and what the model leaves out last
longer than a sample. Taken as first-order autoregressive noise of correlation rho, the parameters
of a least-squares fit have the covariance ``B J S J' B`` with ``B = (J J')^-1`` and S the noise's
own covariance (the sandwich). The rho of residuals is too small, since the fit has taken its share
of the noise: the rho used is the one whose *expected* residuals have the ratio observed.

An encoder or a laser adds noise that is white. Neighbours are less alike then than the slow part
is, and a rho from neighbours says that its sum dies out sooner than it does. Where the restricted
likelihood, that of the residuals alone, is surely greater for slow and white noise together, both
are taken from where it is greatest.

Those variances are themselves estimates, and rho is their weak part: most parameters feel the
slow share of the noise, which goes with ``1/(1 - rho)^2``. Their scatter, by the delta method from
those of rho and of the innovations' variance, gives each parameter its own degrees of freedom; with
white noise beside it, from the curvature of the restricted likelihood.
Source: [Seber-1989] ch. 6; [White-1980] for the sandwich; [Satterthwaite-1946] and
[Giesbrecht-1985] for the degrees of freedom; [Box-1976] sec. 7.2 for the scatter of rho;
[Harville-1977] for the restricted likelihood.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from opensuction.identification.extremum import find_lowest, find_minimum, find_root
from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import Array

CONFIDENCE = 0.95

STRONGEST = 0.99999
"""Bound on rho: a correlation time of 100,000 samples, longer than any recording resolves."""

LEAST_PIVOT = 1e-10
"""A column of which less than this share is its own is dependent on the others."""

LEAST_FREEDOM = 2.0
"""Fewest degrees of freedom: with less, Student's distribution has no useful quantile."""


SURELY = 10.8
"""Twice the logarithm of the likelihoods' ratio from which white noise is taken to be there: 1 in
2,000 recordings of slow noise alone reaches it, half of a chi-square with one degree of freedom."""

LONGEST_SHARE = 0.2
"""Longest time over which slow noise beside white is alike, as a share of the recording: what lasts
longer cannot be told from what a parameter does."""

PLACES = ((2.9, 0.0), (4.0, -2.0), (4.0, 1.0), (5.3, 0.0), (5.3, -4.0))
"""Logarithms of slow noise and white beside it, as `_noise_at` takes them: where the likeliest is,
the search begins. rho of .9 to .99."""

FLATTEST = 1e-6
"""Least white variance that is looked for, as a share of the slow one's."""

NODES = 40
"""Of Gauss's rule for Student's density, which is smooth."""

RAISED = 16
"""By how much an argument of the gamma function is raised to where its series holds."""

NEWTON_STEPS = 6
"""From 2 to the quantile: of 2 degrees of freedom that is 4.3."""

STEP = 0.02
"""Step of the noise's parameters, logarithms all, for the curvature of the likelihood."""


class Noise(NamedTuple):
    """Slow noise, first-order autoregressive, and white noise beside it."""

    correlation: float
    """rho of neighbouring samples of the slow one."""
    white: float
    """Variance of the white one over that of the slow one."""


class FitUncertainty(NamedTuple):
    """Uncertainty of the parameters of a fit."""

    covariance: Array
    """Shape (p, p)."""
    half_widths: Array
    """Half of each 95 % interval, shape (p,); not a number where it is not determined."""
    correlation: float
    """rho of neighbouring noise samples."""
    freedom: Array
    """Degrees of freedom that each parameter's variance is worth, shape (p,)."""
    white_share: float = 0.0
    """Of the noise's variance; 0 where none is surely there."""


def estimate_spread(jacobian: Array, rest: Array) -> FitUncertainty:
    """Covariance and 95 % intervals of a least-squares fit.

    jacobian: change of the output with each parameter, shape (p, n). rest: residuals, shape (n,).
    A parameter whose column is dependent on the others gets no interval.
    """
    count, samples = jacobian.shape
    lengths = np.sqrt(np.einsum("ij,ij->i", jacobian, jacobian))
    usable = lengths > 0.0
    scaled = jacobian[usable] / lengths[usable, None]
    basis, triangle = np.linalg.qr(scaled.T)
    pivots = np.abs(np.diag(triangle))
    nothing = np.full((count, count), math.nan)
    power = float(rest @ rest)
    dependent = count == 0 or not usable.all() or float(pivots.min()) < LEAST_PIVOT
    if samples <= count or dependent or not power > 0.0:
        exact = power == 0.0 and not dependent and samples > count
        covariance = np.zeros((count, count)) if exact else nothing
        least = np.full(count, LEAST_FREEDOM)
        return FitUncertainty(covariance, np.sqrt(np.diag(covariance)), 0.0, least)
    correlation = _correlation(basis, rest)
    back = np.linalg.inv(triangle)
    mixed = _Mixed.find(basis, rest, correlation)
    if mixed is None:
        spoken_for = basis.T @ _noise_product(basis, correlation)
        variance = power / max(samples - float(np.trace(spoken_for)), 1.0)
        shape = back @ spoken_for @ back.T
        bend = np.diag(back @ (basis.T @ _noise_slope(basis, correlation)) @ back.T)
        freedom = _freedom(samples - count, correlation, bend / np.diag(shape))
        white_share = 0.0
    else:
        correlation = mixed.noise.correlation / (1.0 + mixed.noise.white)
        white_share = mixed.noise.white / (1.0 + mixed.noise.white)
        variance, shape = mixed.variance, mixed.shape(mixed.noise, back)
        freedom = mixed.freedom(back)
    covariance = variance * shape / np.outer(lengths, lengths)
    half_widths = _quantiles(freedom) * np.sqrt(np.maximum(np.diag(covariance), 0.0))
    return FitUncertainty(covariance, half_widths, correlation, freedom, white_share)


def _freedom(spare: int, correlation: float, slopes: Array) -> Array:
    """Degrees of freedom of variances ``v = w / (1 - rho^2) * f(rho)``.

    Twice v^2 over the variance of its estimate. w: variance of the innovations; rho and w are
    estimated independently from ``spare`` samples, with variances ``(1 - rho^2) / spare`` and
    ``2 w^2 / spare``. slopes: of log(f) by rho.
    """
    room = 1.0 - correlation * correlation
    steep = 2.0 * correlation / room + slopes
    return np.maximum(2.0 * spare / (2.0 + room * steep * steep), LEAST_FREEDOM)


def _gamma_ratio(places: Array) -> Array:
    """``gamma(x + 1/2) / gamma(x)`` for x above 0, to 1e-13 of it.

    By its recurrence up to `RAISED` more, and what follows from Stirling's series there.
    """
    ratio = np.ones(places.shape)
    for step in range(RAISED):
        ratio *= (places + step) / (places + step + 0.5)
    large = 1.0 / (places + RAISED)
    square = large * large
    series = large * (
        -1.0 / 8.0 + square * (1.0 / 192.0 + square * (-1.0 / 640.0 + square * 17.0 / 14336.0))
    )
    return np.asarray(ratio * np.sqrt(places + RAISED) * np.exp(series))


def _quantiles(freedom: Array) -> Array:
    """Half of the `CONFIDENCE` interval of Student's distribution, in standard deviations.

    freedom: at least `LEAST_FREEDOM`, shape (p,). The density is integrated, by Gauss's rule of
    `NODES`, and the bound found by Newton's method, to 1e-9 of it.
    """
    height = _gamma_ratio(0.5 * freedom) / np.sqrt(freedom * math.pi)
    nodes, shares = np.polynomial.legendre.leggauss(NODES)
    nodes, shares = 0.5 + 0.5 * nodes, 0.5 * shares
    bound = np.full(freedom.size, 2.0)

    def density(place: Array) -> Array:
        return np.asarray(height * (1.0 + place * place / freedom) ** (-0.5 * freedom - 0.5))

    for _ in range(NEWTON_STEPS):
        half = bound * (shares @ density(np.outer(nodes, bound)))
        bound = bound - (half - 0.5 * CONFIDENCE) / density(bound)
    return bound


@compiled
def _sum_both_ways(columns: Array, lead: float, lag: float, one: float, two: float) -> Array:
    """Each column filtered from its first sample on, and from its last one back; their sum.

    columns: shape (n, q). ``y[k] = lead x[k] + lag x[k-1] + one y[k-1] + two y[k-2]``, from rest.
    """
    samples, count = columns.shape
    sums = np.empty((samples, count))
    for column in range(count):
        later, latest = 0.0, 0.0
        for sample in range(samples):
            value = columns[sample, column]
            filtered = later + lead * value
            later = latest + lag * value + one * filtered
            latest = two * filtered
            sums[sample, column] = filtered
        later, latest = 0.0, 0.0
        for sample in range(samples - 1, -1, -1):
            value = columns[sample, column]
            filtered = later + lead * value
            later = latest + lag * value + one * filtered
            latest = two * filtered
            sums[sample, column] += filtered
    return sums


def _noise_product(columns: Array, correlation: float) -> Array:
    """``S @ columns`` for ``S[i, j] = correlation^abs(i-j)``; columns: shape (n, p)."""
    kept = np.ascontiguousarray(columns)
    return np.asarray(_sum_both_ways(kept, 1.0, 0.0, correlation, 0.0) - kept)


def _noise_slope(columns: Array, correlation: float) -> Array:
    """Change of `_noise_product` with the correlation; columns: shape (n, p)."""
    kept = np.ascontiguousarray(columns)
    return _sum_both_ways(kept, 0.0, 1.0, 2.0 * correlation, -correlation * correlation)


def _neighbours(columns: Array) -> Array:
    """``L @ columns``: half the sum of both neighbours; ``r @ L @ r`` is the lag-1 product."""
    sums = np.zeros_like(columns)
    sums[1:] += 0.5 * columns[:-1]
    sums[:-1] += 0.5 * columns[1:]
    return sums


def _correlation(basis: Array, rest: Array) -> float:
    """The rho for which residuals of a fit onto ``basis`` are expected as they were found."""
    samples = rest.size
    observed = float(rest[1:] @ rest[:-1]) / float(rest @ rest)
    beside = _neighbours(basis)
    inner = basis.T @ beside

    def excess(correlation: float) -> float:
        """Ratio of lag-1 product to power expected of the residuals, less the one observed."""
        product = _noise_product(basis, correlation)
        spoken_for = basis.T @ product
        power = samples - float(np.trace(spoken_for))
        lagged = (samples - 1) * correlation - 2.0 * float(np.sum(beside * product))
        lagged += float(np.sum(inner * spoken_for))
        return lagged / max(power, 1e-9 * samples) - observed

    if excess(STRONGEST) <= 0.0:
        return STRONGEST
    if excess(-STRONGEST) >= 0.0:
        return -STRONGEST
    return find_root(excess, -STRONGEST, STRONGEST, width=1e-7)


@compiled
def _whiten(columns: Array, correlation: float, white: float) -> tuple[float, Array]:
    """Logarithm of the noise's determinant, and ``C' V^-1 C`` of the columns, shape (q, q).

    columns: shape (n, q). V is the covariance of both noises, the slow one's variance being 1. One
    pass: what the past tells of a sample is taken from it (a Kalman filter of one state).
    """
    samples, count = columns.shape
    gram = np.zeros((count, count))
    expected, news = np.zeros(count), np.zeros(count)
    spread, log_determinant = 1.0, 0.0
    for sample in range(samples):
        whole = spread + white
        log_determinant += math.log(whole)
        for column in range(count):
            news[column] = columns[sample, column] - expected[column]
            for other in range(column + 1):
                gram[column, other] += news[column] * news[other] / whole
        gain = spread / whole
        for column in range(count):
            expected[column] = correlation * (expected[column] + gain * news[column])
        rest = correlation * correlation * spread * (1.0 - gain)
        spread = rest + 1.0 - correlation * correlation
    for column in range(count):
        for other in range(column):
            gram[other, column] = gram[column, other]
    return log_determinant, gram


class _Mixed(NamedTuple):
    """Slow and white noise, as the residuals of a fit tell them."""

    basis: Array
    columns: Array
    """The basis and the residuals, shape (n, p + 1)."""
    noise: Noise
    variance: float
    """Of the slow one."""

    @classmethod
    def find(cls, basis: Array, rest: Array, alone: float) -> "_Mixed | None":
        """Maximise the restricted likelihood; None where slow noise alone is as likely.

        alone: rho of the residuals taken as slow noise alone.
        """
        columns = np.column_stack((basis, rest))
        strongest = math.exp(-1.0 / (LONGEST_SHARE * rest.size))
        unmixed = find_minimum(
            lambda at: cls._unlikeliness(columns, _noise_at(at, -math.inf))[0],
            _logit(-STRONGEST),
            _logit(STRONGEST),
        )

        def unlikeliness(at: Sequence[float] | Array) -> float:
            return cls._unlikeliness(columns, _noise_at(at[0], at[1], 0.0, strongest))[0]

        begin = min(([_logit(max(alone, 0.5)), -3.0], *PLACES), key=unlikeliness)
        found = find_lowest(unlikeliness, begin, width=1e-2, height=1e-2)
        if not unmixed.value - found.value > SURELY:
            return None
        noise = _noise_at(float(found.place[0]), float(found.place[1]), 0.0, strongest)
        variance = cls._unlikeliness(columns, noise)[1]
        return cls(basis, columns, noise, variance)

    @staticmethod
    def _unlikeliness(columns: Array, noise: Noise) -> tuple[float, float]:
        """Minus twice the logarithm of the restricted likelihood, and the slow one's variance.

        That variance is the most likely one; what is the same for all noises is left out.
        """
        log_determinant, gram = _whiten(columns, noise.correlation, noise.white)
        count = gram.shape[0] - 1
        spare = columns.shape[0] - count
        inner, beside = gram[:count, :count], gram[:count, count]
        power = float(gram[count, count] - beside @ np.linalg.solve(inner, beside))
        variance = max(power, 1e-300) / spare
        sign, log_inner = np.linalg.slogdet(inner)
        if not sign > 0.0:
            return math.inf, variance
        return log_determinant + float(log_inner) + spare * math.log(variance), variance

    def shape(self, noise: Noise, back: Array) -> Array:
        """Covariance of the scaled parameters for slow noise of variance 1, shape (p, p)."""
        product = _noise_product(self.basis, noise.correlation) + noise.white * self.basis
        return np.asarray(back @ (self.basis.T @ product) @ back.T)

    def freedom(self, back: Array) -> Array:
        """Degrees of freedom of each parameter's variance, shape (p,)."""
        spare = self.columns.shape[0] - back.shape[0]
        at = np.array([_logit(self.noise.correlation), math.log(self.noise.white)])
        steps = [np.zeros(2), STEP * np.eye(2)[0], STEP * np.eye(2)[1]]

        def twice(moved: Array) -> float:
            return self._unlikeliness(self.columns, _noise_at(*(at + moved).tolist()))[0]

        def diagonal(moved: Array) -> Array:
            noise = _noise_at(*(at + moved).tolist())
            variance = self._unlikeliness(self.columns, noise)[1]
            logarithms: Array = np.log(variance * np.diag(self.shape(noise, back)))
            return logarithms

        # The variance is where the likelihood is greatest for each rho and share: what is left are
        # two, and its own scatter.
        curve = np.empty((2, 2))
        middle = twice(steps[0])
        for one, first in enumerate(steps[1:]):
            for two, second in enumerate(steps[1:]):
                if one == two:
                    curve[one, two] = twice(first) - 2.0 * middle + twice(-first)
                else:
                    ends = twice(first + second) + twice(-first - second)
                    curve[one, two] = (ends - twice(first - second) - twice(second - first)) / 4.0
        curve /= 2.0 * STEP * STEP
        slopes = np.stack([(diagonal(step) - diagonal(-step)) / (2.0 * STEP) for step in steps[1:]])
        values, vectors = np.linalg.eigh(curve)
        if not values[0] > 0.0:
            return np.full(back.shape[0], LEAST_FREEDOM)
        turned = vectors.T @ slopes
        scatter = 2.0 / spare + np.sum(turned * turned / values[:, None], axis=0)
        freedom: Array = np.maximum(2.0 / scatter, LEAST_FREEDOM)
        return freedom


def _logit(correlation: float) -> float:
    return math.log((1.0 + correlation) / max(1.0 - correlation, 1.0 - STRONGEST))


def _noise_at(
    place: float, log_white: float, least: float = -STRONGEST, most: float = STRONGEST
) -> Noise:
    """Noise by logarithms that may take any value."""
    correlation = min(max(math.tanh(0.5 * place), least), most)
    return Noise(correlation, math.exp(min(max(log_white, math.log(FLATTEST)), 14.0)))
