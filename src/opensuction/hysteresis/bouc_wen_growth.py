"""Growth of the Bouc-Wen memory along one direction of travel: ``du/dd = A - k |u|^m``.

u is the memory counted in the direction of travel, k one number where it grows away from zero
(u > 0) and another where it comes home to zero (u < 0). For m = 1 both pieces are exponentials.
For other m the travel is cut into Taylor steps; near the change of sign, where |u|^m has no
Taylor series, the travel is summed as a series in the state and inverted by Newton's method.
Source: [Jorba-2005] for Taylor steps; the series is that of the hypergeometric function
2F1(1, 1/m; 1 + 1/m; k u^m / A).
"""

import math
from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import Array

TOLERANCE = 1e-14
"""Truncation of one step of the state, as a share of its reach. It contracts afterwards."""

MOST_TERMS = 24
"""Terms of a Taylor step; where they do not suffice the step is shortened."""

MOST_STEPS = 10_000
"""Bound on the Taylor steps of one move; a long move settles after some tens."""

FARTHEST_SHARE = 0.25
"""Travel of a Taylor step over the travel to the change of sign: its series then converges."""

SMALL_SHARE = 0.25
"""Up to this k |u|^m / A the travel is summed as a series in the state: 24 terms at most."""

NEWTON_STEPS = 30
"""Bound on Newton steps of that series' inverse; 3 are usual."""


class Growth(NamedTuple):
    """Coefficients of the growth of the memory."""

    gain: float
    """A, above 0."""
    outward: float
    """k for u > 0, above 0: the state tends to (A/k)^(1/m)."""
    homeward: float
    """k for u < 0."""
    exponent: float
    """m, at least 1."""


@compiled
def _linear_piece(rate: float, gain: float, state: float, travel: float) -> float:
    """Solution of ``du/dd = gain + rate*u``."""
    if rate == 0.0:
        return state + gain * travel
    return state + (gain / rate + state) * math.expm1(rate * travel)


@compiled
def _linear_step(growth: Growth, state: float, travel: float) -> float:
    """The state ``u`` after a travel for m = 1; closed form, in two pieces at most."""
    if state < 0.0:
        rate = growth.homeward
        ratio = rate * state / growth.gain
        if ratio <= -1.0:  # beyond the bound of D > B: never back
            return _linear_piece(rate, growth.gain, state, travel)
        crossing = -state / growth.gain if rate == 0.0 else -math.log1p(ratio) / rate
        if travel <= crossing:
            return _linear_piece(rate, growth.gain, state, travel)
        state, travel = 0.0, travel - crossing
    return _linear_piece(-growth.outward, growth.gain, state, travel)


@compiled
def _bend(growth: Growth, state: float) -> float:
    """The factor k of ``du/dd = A - k |u|^m`` on the state's side of zero."""
    return growth.outward if state > 0.0 else growth.homeward


@compiled
def _travel_from_zero(growth: Growth, state: float) -> float:
    """Travel between zero and a state with ``k |u|^m`` well below A; negative before zero.

    ``u/A * sum_j (k |u|^m / A)^j / (1 + j m)``, the integral of ``du / (A - k |u|^m)``.
    """
    share = _bend(growth, state) * math.pow(abs(state), growth.exponent) / growth.gain
    power, total = 1.0, 1.0
    for j in range(1, 64):
        power *= share
        total += power / (1.0 + j * growth.exponent)
        if abs(power) < TOLERANCE:
            break
    return state * total / growth.gain


@compiled
def _state_near_zero(growth: Growth, travel: float) -> float:
    """Inverse of `_travel_from_zero` by Newton; the slope is the differential equation itself."""
    state = growth.gain * travel
    for _ in range(NEWTON_STEPS):
        rate = growth.gain - _bend(growth, state) * math.pow(abs(state), growth.exponent)
        correction = (_travel_from_zero(growth, state) - travel) * rate
        state -= correction
        if not abs(correction) > TOLERANCE * abs(state):
            break
    return state


@compiled
def _taylor_step(
    growth: Growth, state: float, travel: float, reach: float, terms: Array
) -> tuple[float, float]:
    """The state after a first part of the travel, and how long that part was.

    terms: workspace of shape (2, MOST_TERMS): the terms of ``v = |u|`` and of ``p = v^m``, whose
    series follow one from the other: ``dv = side*(A - k p)``, ``v dp = m p dv``.
    """
    side, bend, size = math.copysign(1.0, state), _bend(growth, state), abs(state)
    power = math.pow(size, growth.exponent)
    fastest = max(growth.gain, abs(growth.gain - bend * power))
    part = min(travel, FARTHEST_SHARE * size / fastest)
    for _ in range(64):  # halvings
        terms[0, 0], terms[1, 0] = size, power
        total, small = size, 0
        for i in range(1, MOST_TERMS):
            source = (growth.gain if i == 1 else 0.0) * part - bend * part * terms[1, i - 1]
            terms[0, i] = side * source / i
            total += terms[0, i]
            small = small + 1 if abs(terms[0, i]) < TOLERANCE * reach else 0
            if small == 2:
                return side * total, part
            convolution = 0.0
            for j in range(i):
                weight = growth.exponent * (i - j) - j
                convolution += weight * terms[0, i - j] * terms[1, j]
            terms[1, i] = convolution / (i * size)
        part *= 0.5
    return math.nan, part


@compiled
def _curved_step(growth: Growth, state: float, travel: float, terms: Array) -> float:
    """The state ``u`` after a travel for any m; error-controlled."""
    reach = math.pow(growth.gain / growth.outward, 1.0 / growth.exponent)
    # Largest state on either side of zero whose travel `_travel_from_zero` sums quickly.
    bend = max(abs(growth.outward), abs(growth.homeward))
    small = math.pow(SMALL_SHARE * growth.gain / bend, 1.0 / growth.exponent)
    for _ in range(MOST_STEPS):
        if travel <= 0.0:
            return state
        long = growth.gain * travel > FARTHEST_SHARE * abs(state)
        if long and -small <= state < small:
            goal = _travel_from_zero(growth, state) + travel
            farthest = _travel_from_zero(growth, small)
            if goal <= farthest:
                return _state_near_zero(growth, goal)
            state, travel = small, goal - farthest
        else:
            state, part = _taylor_step(growth, state, travel, reach, terms)
            travel -= part
            rest = growth.gain - _bend(growth, state) * math.pow(abs(state), growth.exponent)
            if state > 0.0 and abs(rest) < TOLERANCE * growth.gain:
                return state  # saturated: nothing of the travel changes it any more
    return math.nan


@compiled
def step(growth: Growth, state: float, travel: float, terms: Array) -> float:
    """The state after a travel of any length, above 0; to `TOLERANCE` of its limit.

    terms: workspace of shape (2, MOST_TERMS). A state that runs away gives NaN.
    """
    if growth.exponent == 1.0:
        return _linear_step(growth, state, travel)
    return _curved_step(growth, state, travel, terms)
