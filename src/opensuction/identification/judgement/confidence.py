"""Confidence intervals that hold although neighbouring residuals are alike.

The residuals of a recording are not independent: drift, filters and what the model leaves out last
longer than a sample. Taken as first-order autoregressive noise of correlation rho, the parameters
of a least-squares fit have the covariance ``B J S J' B`` with ``B = (J J')^-1`` and S the noise's
own covariance (the sandwich). The rho of residuals is too small, since the fit has taken its share
of the noise: the rho used is the one whose *expected* residuals have the ratio observed.

Those variances are themselves estimates, and rho is their weak part: most parameters feel the
slow share of the noise, which goes with ``1/(1 - rho)^2``. Their scatter, by the delta method from
those of rho and of the innovations' variance, gives each parameter its own degrees of freedom.
Source: [Seber-1989] ch. 6; [White-1980] for the sandwich; [Satterthwaite-1946] and
[Giesbrecht-1985] for the degrees of freedom; [Box-1976] sec. 7.2 for the scatter of rho.
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq
from scipy.special import stdtrit

from opensuction.kernel.record import Array

CONFIDENCE = 0.95

STRONGEST = 0.99999
"""Bound on rho: a correlation time of 100,000 samples, longer than any recording resolves."""

LEAST_PIVOT = 1e-10
"""A column of which less than this share is its own is dependent on the others."""

LEAST_FREEDOM = 2.0
"""Fewest degrees of freedom: with less, Student's distribution has no useful quantile."""


class Spread(NamedTuple):
    """How uncertain the parameters of a fit are."""

    covariance: Array
    """Shape (p, p)."""
    half_widths: Array
    """Half of each 95 % interval, shape (p,); not a number where it is not determined."""
    correlation: float
    """rho of neighbouring noise samples."""
    freedom: Array
    """Degrees of freedom that each parameter's variance is worth, shape (p,)."""


def estimate_spread(jacobian: Array, rest: Array) -> Spread:
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
        return Spread(covariance, np.sqrt(np.diag(covariance)), 0.0, least)
    correlation = _correlation(basis, rest)
    spoken_for = basis.T @ _noise_product(basis, correlation)
    variance = power / max(samples - float(np.trace(spoken_for)), 1.0)
    back = np.linalg.inv(triangle)
    shape = back @ spoken_for @ back.T
    covariance = variance * shape / np.outer(lengths, lengths)
    bend = np.diag(back @ (basis.T @ _noise_slope(basis, correlation)) @ back.T)
    freedom = _freedom(samples - count, correlation, bend / np.diag(shape))
    quantiles = stdtrit(freedom, 0.5 + 0.5 * CONFIDENCE)
    half_widths = quantiles * np.sqrt(np.maximum(np.diag(covariance), 0.0))
    return Spread(covariance, half_widths, correlation, freedom)


def _freedom(spare: int, correlation: float, slopes: Array) -> Array:
    """Degrees of freedom of variances ``v = w / (1 - rho^2) * f(rho)``.

    Twice v^2 over the variance of its estimate. w: variance of the innovations; rho and w are
    estimated independently from ``spare`` samples, with variances ``(1 - rho^2) / spare`` and
    ``2 w^2 / spare``. slopes: of log(f) by rho.
    """
    room = 1.0 - correlation * correlation
    steep = 2.0 * correlation / room + slopes
    return np.maximum(2.0 * spare / (2.0 + room * steep * steep), LEAST_FREEDOM)


def _noise_product(columns: Array, correlation: float) -> Array:
    """``S @ columns`` for ``S[i, j] = correlation^abs(i-j)``; columns: shape (n, p)."""
    from scipy.signal import lfilter

    pole = [1.0, -correlation]
    forth: Array = lfilter([1.0], pole, columns, axis=0)
    back: Array = lfilter([1.0], pole, columns[::-1], axis=0)[::-1]
    return forth + back - columns


def _noise_slope(columns: Array, correlation: float) -> Array:
    """Change of `_noise_product` with the correlation; columns: shape (n, p)."""
    from scipy.signal import lfilter

    poles = [1.0, -2.0 * correlation, correlation * correlation]
    forth: Array = lfilter([0.0, 1.0], poles, columns, axis=0)
    back: Array = lfilter([0.0, 1.0], poles, columns[::-1], axis=0)[::-1]
    return forth + back


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
    return float(brentq(excess, -STRONGEST, STRONGEST, xtol=1e-7))
