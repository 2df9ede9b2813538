"""Tolerances against what chance does: equal pairs are told apart in one case of twenty."""

import numpy as np
import pytest

from opensuction.evidence.paper import claim
from opensuction.evidence.paper.paper_contact import STOPPED_MM
from opensuction.evidence.paper.paper_tracking import AFTER_MM, BEFORE_MM

DRAWS = 2000
RANDOM = np.random.default_rng(7)


def test_standard_errors_of_the_paper_s_own_trials() -> None:
    """Table I: .477 / sqrt(5); Table II: .500 / sqrt(15), and .22 for a distance's five."""
    same = [0.0, 0.0]
    assert claim.of_means(BEFORE_MM, same).standard_error == pytest.approx(0.213, abs=1e-3)
    assert claim.of_means(AFTER_MM, same).standard_error == pytest.approx(0.0675, abs=1e-3)
    errors = [value - at for at, row in STOPPED_MM.items() for value in row]
    assert claim.of_means(errors, same).standard_error == pytest.approx(0.129, abs=1e-3)
    # Five trials cannot tell their mean error of .26 to .41 mm from zero.
    for at, row in STOPPED_MM.items():
        assert claim.of_means(row, same).tolerance > np.mean(row) - at


def test_five_and_five_of_one_kind_are_told_apart_in_one_case_of_twenty() -> None:
    """2,000 pairs; the standard error of that share is half a percent, Welch's t is near exact."""
    missed = 0
    for first, second in RANDOM.normal(size=(DRAWS, 2, 5)) * [[1.0], [3.0]]:
        found = claim.of_means(first, second)
        missed += abs(np.mean(first) - np.mean(second)) > found.tolerance
    assert 0.03 <= missed / DRAWS <= 0.065


def test_one_more_draw_lies_within_its_tolerance_in_19_cases_of_20() -> None:
    missed = 0
    for drawn in RANDOM.normal(size=(DRAWS, 6)):
        found = claim.of_one(drawn[:5])
        missed += abs(drawn[5] - np.mean(drawn[:5])) > found.tolerance
    assert missed / DRAWS == pytest.approx(0.05, abs=0.015)


def test_spread_of_five_is_known_to_a_third_of_itself_and_zero_lies_within() -> None:
    found = claim.of_spreads(BEFORE_MM, BEFORE_MM)
    spread = float(np.std(BEFORE_MM, ddof=1))
    assert found.standard_error == pytest.approx(0.5 * spread)
    assert found.tolerance > spread


def test_largest_of_15_scatters_as_drawn_ones_do() -> None:
    """Against the standard deviation of 4,000 drawn largest values, known to a hundredth."""
    drawn = RANDOM.normal(0.35, 0.5, (4000, 15))
    sample = drawn[0] - drawn[0].mean()
    sample = 0.35 + 0.5 * sample / sample.std(ddof=1)
    expected = np.abs(drawn).max(axis=1).std() * np.sqrt(2.0)
    found = claim.of_largest(sample, sample)
    assert found.standard_error == pytest.approx(expected, rel=0.05)


def test_all_of_15_is_not_certain() -> None:
    found = claim.of_counts(15, 15, 15)
    assert 2.0 < found.tolerance < 5.0


def test_no_scatter_has_no_tolerance() -> None:
    assert claim.of_means([1.0, 1.0], [1.0, 1.0]).tolerance == 0.0
