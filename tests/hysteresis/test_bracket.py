import math
from collections.abc import Callable

import pytest

from opensuction.hysteresis import bracket


def search(function: Callable[[float], float], low: float, high: float) -> tuple[float, int]:
    found = bracket.start(low, function(low), high, function(high))
    while not bracket.is_done(found):
        point = bracket.trial(found)
        assert min(found.near, found.far) <= point <= max(found.near, found.far)
        found = bracket.narrow(found, point, function(point))
        assert found.near_value * found.far_value <= 0.0
    return bracket.root(found), found.trials


@pytest.mark.parametrize(
    ("function", "low", "high", "expected", "most"),
    [
        (lambda x: 2.0 * x - 3.0, 0.0, 100.0, 1.5, 3),
        (lambda x: 3.0 - 2.0 * x, 0.0, 100.0, 1.5, 3),
        (lambda x: x * x * x - 2.0, 0.0, 10.0, 2.0 ** (1.0 / 3.0), 14),
        (lambda x: math.expm1(5.0 * x), -3.0, 2.0, 0.0, 14),
        # A corner at the root, as a play gives it: flat before, steep after.
        (lambda x: x - 7.0 if x > 7.0 else 1e-6 * (x - 7.0), 0.0, 90.0, 7.0, 70),
        (lambda x: 1.0 if x >= 0.3 else -1.0, 0.0, 1.0, 0.3, 60),
    ],
)
def test_the_root_is_found_to_rounding_of_the_farthest_end(
    function: Callable[[float], float], low: float, high: float, expected: float, most: int
) -> None:
    found, trials = search(function, low, high)
    assert found == pytest.approx(expected, abs=3e-16 * high, rel=3e-16)
    assert trials <= most


def test_a_root_at_an_end_needs_no_trial() -> None:
    assert search(lambda x: x, 0.0, 5.0) == (0.0, 0)
    assert search(lambda x: x - 5.0, 0.0, 5.0) == (5.0, 0)
