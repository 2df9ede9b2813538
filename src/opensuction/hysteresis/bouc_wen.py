"""The Bouc-Wen model in its standard form, with error control where no closed form exists.

Standard form, with the input x, the memory zeta and the output y (the paper's Theta):
``dzeta = A dx - B |dx| |zeta|^(m-1) zeta - D dx |zeta|^m``, ``y = a_x x + a_zeta zeta + y_0``.

Erratum. The paper's eq. (6) prints the term of B without its last zeta. So printed, B does not
bend the loop but shifts it to one side; the literature has the factor, as has this module. The
text says six parameters and lists seven; the scale of zeta is free: six are independent.

In the direction of travel s the state ``u = s*zeta`` obeys ``du/dd = A - k |u|^m`` with d the
travel, k = B + D where u > 0 and k = D - B where u < 0: one scalar equation without time, so the
model is independent of speed. ``bouc_wen_growth`` solves it, for m = 1 in closed form, else with
error control.

What it cannot represent: a gap with corners (a play), an output that depends on where in its
range the input is, minor loops that close (it drifts in them), and, for D > B as printed in the
paper, a start far outside the loop (the state then runs away, see `is_well_posed`).
Source: [paper] eqs. (5) and (6); [Wen-1976]; [Ikhouane-2007] for boundedness.

Growth of the Bouc-Wen memory along one direction of travel: ``du/dd = A - k |u|^m``.

u is the memory counted in the direction of travel, k one number where it grows away from zero
(u > 0) and another where it comes home to zero (u < 0). For m = 1 both pieces are exponentials.
For other m the travel is cut into Taylor steps; near the change of sign, where |u|^m has no
Taylor series, the travel is summed as a series in the state and inverted by Newton's method.
Source: [Jorba-2005] for Taylor steps; the series is that of the hypergeometric function
2F1(1, 1/m; 1 + 1/m; k u^m / A).
"""

import math
from typing import Annotated, NamedTuple

import numpy as np
from annotated_types import Ge, Gt

from opensuction.hysteresis import bracket
from opensuction.hysteresis.play import InverseMove
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
def grow(growth: Growth, state: float, travel: float, terms: Array) -> float:
    """The state after a travel of any length, above 0; to `TOLERANCE` of its limit.

    terms: workspace of shape (2, MOST_TERMS). A state that runs away gives NaN.
    """
    if growth.exponent == 1.0:
        return _linear_step(growth, state, travel)
    return _curved_step(growth, state, travel, terms)


class BoucWen(NamedTuple):
    """Parameters of the Bouc-Wen model, input in mm to output in mm."""

    input_gain: Annotated[float, Gt(0)]
    """A: mm of memory per mm of input where the memory is zero."""
    dissipation: Annotated[float, Gt(0)]
    """B: the part of the bend that takes work, mm^-m."""
    bend: float
    """D: the part that gives it back, mm^-m; B + D above 0."""
    exponent: Annotated[float, Ge(1)]
    """m: 1 bends at once, large ones bend late and sharply."""
    slope: float
    """a_x: mm of output per mm of input."""
    memory_gain: float
    """a_zeta: mm of output per mm of memory."""
    offset_mm: float
    """Theta_0: output for input and memory at 0."""


PUBLISHED = BoucWen(
    input_gain=1.925,
    dissipation=0.091,
    bend=1.663,
    exponent=1.009,
    slope=0.925,
    memory_gain=-0.4533,
    offset_mm=-7.097,
)
"""The paper's identified parameters (section III-B), in the standard form. Taken as printed, in
mm, their loop is 0.99 mm wide and forgets within a millimetre, where the modified Dahl model's is
22.18 mm: they cannot give the fit of .80 mm that the paper reports for them."""


@compiled
def saturation_mm(model: BoucWen) -> float:
    """Memory after a long advance, (A / (B + D))^(1/m), mm; minus that after a long retract."""
    share = model.input_gain / (model.dissipation + model.bend)
    return math.pow(share, 1.0 / model.exponent)


@compiled
def gap_mm(model: BoucWen) -> float:
    """Distance of the retracting above the advancing branch, mm of output; negative below."""
    return -2.0 * model.memory_gain * saturation_mm(model)


@compiled
def is_well_posed(model: BoucWen) -> bool:
    """True where the memory stays within its saturation for every input: A, B, B + D > 0.

    With D > B that holds for a start within (A / (D - B))^(1/m), which is beyond saturation;
    with D <= B for any start. Source: [Ikhouane-2007] ch. 2.
    """
    signs = model.input_gain > 0.0 and model.dissipation > 0.0
    return signs and model.dissipation + model.bend > 0.0 and model.exponent >= 1.0


@compiled
def is_passive(model: BoucWen) -> bool:
    """True where no excursion gives more work than the memory had stored: -B <= D <= B.

    Stored is ``zeta^2 / 2A``; what a move dissipates is ``|zeta|^m (B |zeta dx| + D zeta dx) / A``.
    The published parameters break it. Source: [Ikhouane-2007] ch. 2.
    """
    return is_well_posed(model) and abs(model.bend) <= model.dissipation


@compiled
def least_slope(model: BoucWen) -> float:
    """Smallest slope dy/dx within saturation.

    dzeta/dx is 0 at saturation, A at zero and 2 A B / (B + D) right after a saturated reversal,
    and monotone between.
    """
    reversed_share = 2.0 * model.dissipation / (model.dissipation + model.bend)
    steepest = model.memory_gain * model.input_gain * max(1.0, reversed_share)
    return model.slope + min(0.0, steepest)


@compiled
def is_monotone(model: BoucWen) -> bool:
    """True where the output always follows the input, so that a continuous inverse exists."""
    return is_well_posed(model) and least_slope(model) > 0.0


@compiled
def _step(model: BoucWen, memory_mm: float, move_mm: float, terms: Array) -> float:
    """`step` with a workspace of shape (2, MOST_TERMS)."""
    if not (math.isfinite(move_mm) and math.isfinite(memory_mm)):
        return math.nan
    if move_mm == 0.0:
        return memory_mm
    direction = math.copysign(1.0, move_mm)
    growth = Growth(
        gain=model.input_gain,
        outward=model.bend + model.dissipation,
        homeward=model.bend - model.dissipation,
        exponent=model.exponent,
    )
    return direction * grow(growth, direction * memory_mm, abs(move_mm), terms)


@compiled
def step(model: BoucWen, memory_mm: float, move_mm: float) -> float:
    """Memory zeta after one monotone move of the input, of any size.

    Closed form for m = 1; otherwise every part of the move is exact to
    `bouc_wen_growth.TOLERANCE` of the saturation. The model must be well posed; a memory that runs
    away (D > B, start far outside the loop) and input that is not finite give NaN.
    Source: the standard form of [paper] eq. (6).
    """
    return _step(model, memory_mm, move_mm, np.empty((2, MOST_TERMS)))


@compiled
def output_mm(model: BoucWen, input_mm: float, memory_mm: float) -> float:
    """Output for an input and a memory, mm. Source: [paper] eq. (5)."""
    return model.slope * input_mm + model.memory_gain * memory_mm + model.offset_mm


@compiled
def simulate(model: BoucWen, input_mm: Array, memory_mm: float) -> Array:
    """Outputs for a whole record of inputs.

    input_mm: shape (n,), finite; each step between samples is one monotone move.
    memory_mm: memory at the first sample. Returns mm, shape (n,).
    """
    outputs_mm = np.empty(input_mm.size)
    terms = np.empty((2, MOST_TERMS))
    for k in range(input_mm.size):
        if k > 0:
            memory_mm = _step(model, memory_mm, input_mm[k] - input_mm[k - 1], terms)
        outputs_mm[k] = output_mm(model, input_mm[k], memory_mm)
    return outputs_mm


@compiled
def inverse_step(
    model: BoucWen, input_mm: float, memory_mm: float, target_mm: float
) -> InverseMove:
    """Move of the input that brings the output to a target, to rounding.

    input_mm, memory_mm: where the input is now, and the memory there, within saturation.
    Every target is reached where the model is monotone; of another the move is 0, not reached.
    """
    missing = target_mm - output_mm(model, input_mm, memory_mm)
    if not (is_monotone(model) and math.isfinite(missing)):
        return InverseMove(move_mm=0.0, reached=False)
    direction = math.copysign(1.0, missing)
    terms = np.empty((2, MOST_TERMS))
    # The output gains at least the least slope; a millionth more makes rounding harmless.
    farthest = abs(missing) / least_slope(model) * 1.000001
    search = bracket.start(0.0, -abs(missing), farthest, abs(missing))
    while not bracket.is_done(search):
        travel = bracket.trial(search)
        memory = _step(model, memory_mm, direction * travel, terms)
        reached_mm = output_mm(model, input_mm + direction * travel, memory)
        search = bracket.narrow(search, travel, direction * (reached_mm - target_mm))
    return InverseMove(move_mm=direction * bracket.root(search), reached=True)
