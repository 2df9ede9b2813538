"""Root of a continuous function between two points, one trial at a time.

The caller evaluates the function: at `trial`, and gives the value to `narrow`. So one search
serves every model in compiled code, which cannot pass functions as arguments.

Method: inverse quadratic interpolation where the last three points allow it, bisection where
they do not: fast on smooth curves, safe at the corners of a play.
Source: [Chandrupatla-1997].
"""

import math
from typing import NamedTuple

from opensuction.kernel.compiled import compiled

MOST_TRIALS = 120
"""Bound on trials: 10 are usual; where every interpolation fails 53 bisections do it."""

RELATIVE_WIDTH = 1.0e-16
"""The root is known once the bracket is narrower than this share of what it began with: for a
travel that starts at 0 that is the rounding of the farthest point."""


class Bracket(NamedTuple):
    """Two points with values of opposite sign, and the point left last."""

    near: float
    near_value: float
    far: float
    far_value: float
    left: float
    left_value: float
    share: float
    """Where the next trial lies between ``near`` (0) and ``far`` (1)."""
    least_width: float
    trials: int


@compiled
def start(low: float, low_value: float, high: float, high_value: float) -> Bracket:
    """A bracket around a root: the two values differ in sign, or one is 0."""
    return Bracket(
        near=low,
        near_value=low_value,
        far=high,
        far_value=high_value,
        left=high,
        left_value=high_value,
        share=0.5,
        least_width=RELATIVE_WIDTH * max(abs(low), abs(high)),
        trials=0,
    )


@compiled
def trial(bracket: Bracket) -> float:
    """Next point to evaluate."""
    return bracket.near + bracket.share * (bracket.far - bracket.near)


@compiled
def root(bracket: Bracket) -> float:
    """The best point so far: that of the smaller value."""
    is_near = abs(bracket.near_value) <= abs(bracket.far_value)
    return bracket.near if is_near else bracket.far


@compiled
def is_done(bracket: Bracket) -> bool:
    """True once the root is known to rounding, or the trials are used up."""
    exact = bracket.near_value == 0.0 or bracket.far_value == 0.0
    wide = abs(bracket.far - bracket.near) > 2.0 * bracket.least_width
    return exact or not wide or bracket.trials >= MOST_TRIALS


@compiled
def _interpolate_share(near: Bracket) -> float:
    """Zero of the inverse parabola through three points; 0.5 where it cannot be trusted."""
    if near.left == near.far or near.left_value == near.far_value:
        return 0.5
    place = (near.near - near.far) / (near.left - near.far)
    height = (near.near_value - near.far_value) / (near.left_value - near.far_value)
    if not (0.0 < place < 1.0 and 1.0 - math.sqrt(1.0 - place) < height < math.sqrt(place)):
        return 0.5
    one, two, three = near.near_value, near.far_value, near.left_value
    stretch = (near.left - near.near) / (near.far - near.near)
    return one / (two - one) * three / (two - three) + stretch * one / (three - one) * two / (
        three - two
    )


@compiled
def narrow(bracket: Bracket, point: float, value: float) -> Bracket:
    """The bracket after an evaluation at its trial point."""
    far, far_value = bracket.far, bracket.far_value
    left, left_value = bracket.near, bracket.near_value
    if (value > 0.0) != (bracket.near_value > 0.0):
        far, far_value = bracket.near, bracket.near_value
        left, left_value = bracket.far, bracket.far_value
    unaimed = bracket._replace(
        near=point,
        near_value=value,
        far=far,
        far_value=far_value,
        left=left,
        left_value=left_value,
        trials=bracket.trials + 1,
    )
    width = abs(far - point)
    # Never nearer to an end than the width that ends the search.
    least = min(bracket.least_width / width, 0.5) if width > 0.0 else 0.5
    return unaimed._replace(share=min(max(_interpolate_share(unaimed), least), 1.0 - least))
