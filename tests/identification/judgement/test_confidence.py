import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.special import stdtrit

from opensuction.hysteresis.catalogue.duhem_family import MODIFIED_DAHL_FORM as FORM
from opensuction.hysteresis.catalogue.hysteresis_model import ranges_of
from opensuction.hysteresis.modified_dahl import PUBLISHED, simulate
from opensuction.identification.estimator import modified_dahl
from opensuction.identification.estimator.linear import jacobian
from opensuction.identification.judgement import confidence
from opensuction.identification.judgement.confidence import estimate_spread
from tests.identification.plant import cosine, noise

TRUE = np.array([*PUBLISHED, 2.0])
LENGTH_S = 30.0


def coverage(
    rate_hz: float, correlation_s: float, recordings: int, seed: int, white_mm: float = 0.0
) -> list[float]:
    """Share of recordings whose interval holds the truth, for each of the five parameters.

    white_mm: of white noise beside the slow one of .3 mm.
    """
    samples = int(LENGTH_S * rate_hz)
    head_mm = cosine(samples, cycles=3.0)
    tip_mm = simulate(PUBLISHED, head_mm, 2.0)
    correlation = math.exp(-1.0 / (rate_hz * correlation_s)) if correlation_s > 0.0 else 0.0
    # Every case draws its own noise: else one unlucky draw shows in all of them.
    random = np.random.default_rng(
        [seed, int(rate_hz), round(1000.0 * correlation_s), round(1000.0 * white_mm)]
        if white_mm > 0.0
        else [seed, int(rate_hz), round(1000.0 * correlation_s)]
    )
    held = np.zeros(TRUE.size)
    for _ in range(recordings):
        measured = tip_mm + 0.3 * noise(random, samples, correlation)
        if white_mm > 0.0:
            measured = measured + white_mm * random.normal(size=samples)
        found = modified_dahl.fit(head_mm, measured)
        vector = np.array([*found.model, found.lag_mm])
        rows = jacobian(FORM, vector, head_mm, ranges_of(head_mm, measured))
        rest = measured - FORM.simulate(vector, head_mm)
        held += np.abs(vector - TRUE) <= estimate_spread(rows, rest).half_widths
    return [float(share) for share in held / recordings]


@pytest.mark.parametrize("correlation_s", [pytest.param(0.0, marks=pytest.mark.soak), 0.2])
def test_intervals_hold_the_truth_as_often_as_they_say(correlation_s: float) -> None:
    shares = coverage(50.0, correlation_s, 120, seed=8)
    # 120 recordings: a standard error of 2 %; the mean of five parameters a little less.
    assert min(shares) >= 0.88
    assert np.mean(shares) == pytest.approx(0.95, abs=0.04)


@pytest.mark.parametrize(
    ("correlation_s", "white_mm"), [(0.2, 0.3), pytest.param(1.0, 0.09, marks=pytest.mark.soak)]
)
def test_white_noise_beside_the_slow_one_is_not_taken_for_its_end(
    correlation_s: float, white_mm: float
) -> None:
    """As much of it as of the slow one, and a third: taken as slow alone they held .5 and .7."""
    shares = coverage(50.0, correlation_s, 120, 8, white_mm)
    assert min(shares) >= 0.88
    assert np.mean(shares) == pytest.approx(0.95, abs=0.04)


@pytest.mark.soak
@pytest.mark.parametrize("white_mm", [0.0, 0.09, 0.3, 0.9])
@pytest.mark.parametrize("correlation", [0.9, 0.95, 0.99])
def test_intervals_hold_with_slow_and_white_noise(correlation: float, white_mm: float) -> None:
    correlation_s = -0.01 / math.log(correlation)
    shares = coverage(100.0, correlation_s, 200, 3, white_mm)
    # A share of 200 has a standard error of 1.5 %.
    assert min(shares) >= 0.90
    assert np.mean(shares) <= 0.98


@pytest.mark.soak
@pytest.mark.parametrize("rate_hz", [100.0, 1000.0])
@pytest.mark.parametrize("correlation_s", [0.0, 0.02, 0.05, 0.1, 0.2])
def test_intervals_hold_in_five_hundred_recordings(rate_hz: float, correlation_s: float) -> None:
    shares = coverage(rate_hz, correlation_s, 500, seed=9)
    folder = Path("runs") / "soak"
    folder.mkdir(parents=True, exist_ok=True)
    name = f"coverage-{rate_hz:g}-hz-{correlation_s:g}-s.json"
    (folder / name).write_text(json.dumps(shares) + "\n")
    # Each parameter, in each case: a share of 500 has a standard error of 1 %.
    assert shares == pytest.approx([0.95] * TRUE.size, abs=0.03)


def test_white_noise_gives_the_textbooks_interval() -> None:
    random = np.random.default_rng(1)
    columns = np.stack([np.ones(2000), np.linspace(-1.0, 1.0, 2000)])
    rest = random.normal(0.0, 2.0, 2000)
    rest -= np.linalg.lstsq(columns.T, rest, rcond=None)[0] @ columns
    found = estimate_spread(columns, rest)
    sigma = math.sqrt(float(rest @ rest) / 1998)
    textbook = 1.961 * sigma * np.sqrt(np.diag(np.linalg.inv(columns @ columns.T)))
    # The correlation found in white noise is 0 within 1/sqrt(2000), which moves the result by 4 %.
    assert found.half_widths == pytest.approx(textbook, rel=0.08)
    assert found.correlation == pytest.approx(0.0, abs=0.05)


def test_both_noises_are_told_apart() -> None:
    """Of slow noise with rho .95 and half as much white: shares of the variance, and rho."""
    random = np.random.default_rng(5)
    columns = np.stack([np.ones(3000), np.linspace(-1.0, 1.0, 3000)])
    shares, correlations = [], []
    for _ in range(40):
        rest = noise(random, 3000, 0.95) + 0.5 * random.normal(size=3000)
        rest = rest - np.linalg.lstsq(columns.T, rest, rcond=None)[0] @ columns
        found = estimate_spread(columns, rest)
        shares.append(found.white_share)
        correlations.append(found.correlation)
    assert np.mean(shares) == pytest.approx(0.2, abs=0.02)
    assert np.mean(correlations) == pytest.approx(0.8 * 0.95, abs=0.02)


def test_white_noise_alone_has_no_slow_one_beside_it() -> None:
    random = np.random.default_rng(6)
    columns = np.stack([np.ones(1000), np.linspace(-1.0, 1.0, 1000)])
    shares = []
    for _ in range(60):
        rest = random.normal(size=1000)
        rest = rest - np.linalg.lstsq(columns.T, rest, rcond=None)[0] @ columns
        shares.append(estimate_spread(columns, rest).white_share)
    assert shares == [0.0] * 60


def test_the_correlation_is_not_biased_by_the_fit() -> None:
    random = np.random.default_rng(2)
    columns = np.stack([np.linspace(-1.0, 1.0, 300) ** k for k in range(6)])
    found, plain = [], []
    for _ in range(200):
        rest = noise(random, 300, 0.9)
        rest = rest - np.linalg.lstsq(columns.T, rest, rcond=None)[0] @ columns
        found.append(estimate_spread(columns, rest).correlation)
        plain.append(float(rest[1:] @ rest[:-1]) / float(rest @ rest))
    # The plain estimate is .05 too small; two standard errors of the mean are .005.
    assert np.mean(found) == pytest.approx(0.9, abs=0.015)
    assert np.mean(plain) < 0.87


@pytest.mark.parametrize(
    ("samples", "correlation"),
    [
        (1000, 0.9),
        *(
            pytest.param(*one, marks=pytest.mark.soak)
            for one in ((500, 0.0), (1000, 0.5), (2000, 0.9))
        ),
    ],
)
def test_the_freedom_is_what_the_scatter_of_the_variances_says(
    samples: int, correlation: float
) -> None:
    random = np.random.default_rng(4)
    place = np.linspace(-1.0, 1.0, samples)
    # Two that feel the slow share of the noise, and one that feels the fastest.
    columns = np.stack([np.ones(samples), place, (-1.0) ** np.arange(samples)])
    variances, freedoms = [], []
    for _ in range(400):
        rest = noise(random, samples, correlation)
        rest = rest - np.linalg.lstsq(columns.T, rest, rcond=None)[0] @ columns
        found = estimate_spread(columns, rest)
        variances.append(np.diag(found.covariance))
        freedoms.append(found.freedom)
    scatter = 2.0 * np.mean(variances, axis=0) ** 2 / np.var(variances, axis=0)
    # 400 variances tell their own variance to 7 % and more where they are skew.
    assert np.median(freedoms, axis=0) == pytest.approx(scatter, rel=0.3)


def test_dependent_columns_and_exact_fits_are_told_apart() -> None:
    one = np.linspace(-1.0, 1.0, 50)
    rest = np.random.default_rng(3).normal(size=50)
    assert np.all(np.isnan(estimate_spread(np.stack([one, 2.0 * one]), rest).half_widths))
    assert estimate_spread(np.stack([one, one**2]), np.zeros(50)).half_widths == pytest.approx(
        [0.0, 0.0]
    )


@pytest.mark.parametrize("correlation", [-0.9, 0.0, 0.3, confidence.STRONGEST])
def test_noise_is_summed_as_scipys_filters_do_to_the_last_digit(correlation: float) -> None:
    columns, _ = np.linalg.qr(np.random.default_rng(4).normal(size=(400, 5)))

    def both_ways(zeros: list[float], poles: list[float]) -> tuple[Any, Any]:
        forth = lfilter(zeros, poles, columns, axis=0)
        return forth, lfilter(zeros, poles, columns[::-1], axis=0)[::-1]

    forth, back = both_ways([1.0], [1.0, -correlation])
    found = confidence._noise_product(columns, correlation)
    np.testing.assert_array_equal(found, forth + back - columns)
    forth, back = both_ways([0.0, 1.0], [1.0, -2.0 * correlation, correlation * correlation])
    np.testing.assert_array_equal(confidence._noise_slope(columns, correlation), forth + back)


def test_ratio_of_gamma_functions_half_apart() -> None:
    places = np.array([0.5, 1.0, 1.75, 4.0, 15.5, 80.0])
    there = [math.gamma(place + 0.5) / math.gamma(place) for place in places]
    np.testing.assert_allclose(confidence._gamma_ratio(places), there, rtol=1e-13)
    assert confidence._gamma_ratio(np.array([1e8]))[0] == pytest.approx(1e4, rel=1e-8)


def test_quantiles_are_those_of_student() -> None:
    freedom = np.array([2.0, 2.1, 3.0, 5.0, 10.0, 33.3, 100.0, 1e3, 1e4, 1e5])
    there = stdtrit(freedom, 0.975)
    np.testing.assert_allclose(confidence._quantiles(freedom), there, rtol=1e-9)
