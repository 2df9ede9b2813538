"""Every step as SciPy takes it: what a fit found before it was loaded no more is found still."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq, minimize, minimize_scalar

from opensuction.identification.extremum import find_lowest, find_minimum, find_root
from opensuction.kernel.record import Array

CASES = 300


def test_roots_are_those_of_scipy_to_the_last_digit() -> None:
    random = np.random.default_rng(1)
    found = 0
    for _ in range(CASES):
        steep, shift, cubic = (float(each) for each in random.normal(size=3))
        low, high = sorted(float(each) for each in 5.0 * random.normal(size=2))

        def curve(x: float, a: float = steep, b: float = shift, c: float = cubic) -> float:
            return math.tanh(a * x + b) + 0.1 * c * x * x * x + 0.01 * math.sin(30.0 * x)

        if curve(low) * curve(high) < 0.0:
            assert find_root(curve, low, high) == brentq(curve, low, high)
            assert find_root(curve, low, high, 1e-7) == brentq(curve, low, high, xtol=1e-7)
            found += 1
    assert found > CASES // 4


def test_a_root_at_an_end_is_that_end() -> None:
    assert find_root(lambda x: x - 1.0, 1.0, 3.0) == 1.0
    assert find_root(lambda x: x - 3.0, 1.0, 3.0) == 3.0


def test_a_step_that_no_curve_crosses_is_bisected() -> None:
    def step(x: float) -> float:
        return 1.0 if x > 0.3 else -1.0

    assert find_root(step, 0.0, 1.0) == brentq(step, 0.0, 1.0)


def test_no_change_of_sign_is_no_root() -> None:
    with pytest.raises(ValueError, match="no change of sign between 1 and 2"):
        find_root(lambda x: x, 1.0, 2.0)


def test_minima_are_those_of_scipy_to_the_last_digit() -> None:
    random = np.random.default_rng(2)
    for width in (1e-5, 1e-8) * (CASES // 2):
        bend, shift, wave = (float(each) for each in random.normal(size=3))
        low, high = sorted(float(each) for each in 5.0 * random.normal(size=2))

        def curve(x: float, a: float = bend, b: float = shift, c: float = wave) -> float:
            return abs(a) * (x - b) * (x - b) + c * math.sin(3.0 * x) + abs(x - c)

        there = minimize_scalar(
            curve, bounds=(low, high), method="bounded", options={"xatol": width}
        )
        assert find_minimum(curve, low, high, width) == (there.x, there.fun)


def test_a_simplex_ends_where_scipys_does() -> None:
    random = np.random.default_rng(3)
    for case in range(CASES // 3):
        bend, aim, edge = (float(each) for each in random.normal(size=3))

        def valley(at: Array, a: float = bend, b: float = aim, c: float = edge) -> float:
            across = float(at[1]) - a * float(at[0]) ** 2
            return 100.0 * across * across + (b - float(at[0])) ** 2 + abs(c * float(at[0]))

        start = [0.0 if case % 7 == 0 else bend, aim]
        options = {"xatol": 1e-2, "fatol": 1e-2}
        there = minimize(valley, start, method="Nelder-Mead", options=options)
        here = find_lowest(valley, start, width=1e-2, height=1e-2)
        assert here.place.tolist() == there.x.tolist()
        assert here.value == there.fun
