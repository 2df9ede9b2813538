"""Roots and minima of functions that are evaluated one point at a time, in plain Python.

The steps of `scipy.optimize`, to the last digit: `brentq`, `minimize_scalar` with bounds and
`minimize` by Nelder and Mead. A fit takes some ten to a hundred of them, and loading that package
would take as long as the rest of the fit.
Source: [Brent-1973] ch. 4 and 5; [Nelder-1965].
"""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from opensuction.kernel.record import Array

Function = Callable[[float], float]

ROOT_WIDTH = 2e-12
"""Width of the bracket at which a root is known, in the unit of the point."""

RELATIVE_ROOT_WIDTH = 4.0 * 2.0**-52
"""The same as a share of the point."""

MOST_ROOT_STEPS = 100
MOST_MINIMUM_STEPS = 500

GOLDEN = 0.5 * (3.0 - math.sqrt(5.0))
"""Share of the golden section."""

ROUNDING = math.sqrt(2.2e-16)
"""Nearer to one another than this share of a point a function's values at its minimum are alike."""

SIMPLEX_SHARE = 0.05
"""Size of the first simplex, as a share of each coordinate."""

SIMPLEX_WIDTH = 0.00025
"""Its size along a coordinate that is 0."""

SIMPLEX_STEPS = 200
"""Most steps of a simplex, and most evaluations, for each coordinate."""


def _interpolate(
    last: tuple[float, float], point: tuple[float, float], other: tuple[float, float]
) -> float:
    """Step from ``point`` to the root of the curve through three points, or through two.

    Each with its value; infinite where there is none.
    """
    if last[0] == other[0]:
        return -point[1] * (point[0] - last[0]) / (point[1] - last[1])
    to_last = (last[1] - point[1]) / (last[0] - point[0])
    to_other = (other[1] - point[1]) / (other[0] - point[0])
    steep = to_other * to_last * (other[1] - last[1])
    if steep == 0.0:
        return math.inf
    return -point[1] * (other[1] * to_other - last[1] * to_last) / steep


class Minimum(NamedTuple):
    """Place at which a function of one variable is least, and its value there."""

    place: float
    value: float


def find_root(function: Function, low: float, high: float, width: float = ROOT_WIDTH) -> float:
    """Root between two points at which the function's signs differ; by Brent's method.

    width: of the bracket at which the root is known. Raises ValueError where the signs are alike.
    """
    last, point, other = low, high, 0.0
    at_last, at_point, at_other = function(last), function(point), 0.0
    if at_last == 0.0:
        return last
    if at_point == 0.0:
        return point
    if (at_last < 0.0) == (at_point < 0.0):
        raise ValueError(f"no change of sign between {low:g} and {high:g}")
    before = step = 0.0
    for _ in range(MOST_ROOT_STEPS):
        if at_last != 0.0 and (at_last < 0.0) != (at_point < 0.0):
            other, at_other = last, at_last
            before = step = point - last
        if abs(at_other) < abs(at_point):
            last, point, other = point, other, point
            at_last, at_point, at_other = at_point, at_other, at_point
        least = (width + RELATIVE_ROOT_WIDTH * abs(point)) / 2.0
        half = (other - point) / 2.0
        if at_point == 0.0 or abs(half) < least:
            return point
        tried = math.inf
        if abs(before) > least and abs(at_point) < abs(at_last):
            tried = _interpolate((last, at_last), (point, at_point), (other, at_other))
        if 2.0 * abs(tried) < min(abs(before), 3.0 * abs(half) - least):
            before, step = step, tried
        else:
            before = step = half
        last, at_last = point, at_point
        point += step if abs(step) > least else math.copysign(least, half)
        at_point = function(point)
    raise ValueError(f"no root within {MOST_ROOT_STEPS} steps between {low:g} and {high:g}")


def find_minimum(function: Function, low: float, high: float, width: float = 1e-5) -> Minimum:
    """Minimum between two points, by Brent's method; a local one where there are several.

    width: within which its place is known.
    """
    best = second = third = low + GOLDEN * (high - low)
    at_best = at_second = at_third = function(best)
    step = before = 0.0
    for _ in range(MOST_MINIMUM_STEPS - 1):
        middle = 0.5 * (low + high)
        least = ROUNDING * abs(best) + width / 3.0
        if abs(best - middle) <= 2.0 * least - 0.5 * (high - low):
            break
        is_golden = True
        if abs(before) > least:
            one = (best - second) * (at_best - at_third)
            two = (best - third) * (at_best - at_second)
            rise = (best - third) * two - (best - second) * one
            two = 2.0 * (two - one)
            rise, two = -rise if two > 0.0 else rise, abs(two)
            one, before = before, step
            inside = two * (low - best) < rise < two * (high - best)
            if inside and abs(rise) < abs(0.5 * two * one):
                is_golden = False
                step = rise / two
                point = best + step
                if point - low < 2.0 * least or high - point < 2.0 * least:
                    step = least if middle >= best else -least
        if is_golden:
            before = (low if best >= middle else high) - best
            step = GOLDEN * before
        point = best + math.copysign(max(abs(step), least), step if step != 0.0 else 1.0)
        value = function(point)
        if value <= at_best:
            low, high = (best, high) if point >= best else (low, best)
            third, at_third, second, at_second = second, at_second, best, at_best
            best, at_best = point, value
        else:
            low, high = (point, high) if point < best else (low, point)
            if value <= at_second or second == best:
                third, at_third, second, at_second = second, at_second, point, value
            elif value <= at_third or third in (best, second):
                third, at_third = point, value
    return Minimum(best, at_best)


class Lowest(NamedTuple):
    """Place at which a function of several variables is least, and its value there."""

    place: Array
    value: float


def find_lowest(
    function: Callable[[Array], float], start: Sequence[float], width: float, height: float
) -> Lowest:
    """Minimum from a start by the simplex of Nelder and Mead; a local one where there are several.

    width, height: of places and of values, within which it is known.
    """
    first = np.array(start, dtype=np.float64)
    count = first.size
    simplex = np.tile(first, (count + 1, 1))
    for k in range(count):
        simplex[k + 1, k] = (1.0 + SIMPLEX_SHARE) * first[k] if first[k] != 0.0 else SIMPLEX_WIDTH
    values = np.array([function(place) for place in simplex])
    evaluations, most = count + 1, SIMPLEX_STEPS * count
    for _ in range(most - 1):
        order = np.argsort(values)
        simplex, values = simplex[order], values[order]
        wide = float(np.max(np.abs(simplex[1:] - simplex[0])))
        if evaluations >= most or (
            wide <= width and float(np.max(np.abs(values[0] - values[1:]))) <= height
        ):
            break
        middle = np.add.reduce(simplex[:-1], 0) / count
        place = 2.0 * middle - simplex[-1]
        value = function(place)
        evaluations += 1
        if value < values[-2] and value >= values[0]:
            simplex[-1], values[-1] = place, value
            continue
        if value < values[0]:
            other = 3.0 * middle - 2.0 * simplex[-1]
            limit = value
        elif value < values[-1]:
            other = 1.5 * middle - 0.5 * simplex[-1]
            limit = value
        else:
            other = 0.5 * middle + 0.5 * simplex[-1]
            limit = float(values[-1])
        at_other = function(other)
        evaluations += 1
        if at_other < limit or (values[0] <= value < values[-1] and at_other == limit):
            simplex[-1], values[-1] = other, at_other
        elif value < values[0]:
            simplex[-1], values[-1] = place, value
        else:
            for k in range(1, count + 1):
                simplex[k] = simplex[0] + 0.5 * (simplex[k] - simplex[0])
                values[k] = function(simplex[k])
            evaluations += count
    order = np.argsort(values)
    return Lowest(simplex[order[0]], float(values[order[0]]))
