"""A hysteresis model that is linear in its parameters: fixed elements and a polynomial envelope.

``y = sum_j w_j b_j + p(x)``: each b_j is a Dahl state of a fixed decay length (the lag of [paper]
eq. (3) for beta = 1) or a play of a fixed width, p a polynomial up to the fifth degree. Only the
weights are unknown, so a recording determines them by linear least squares, without a search.
Beyond the range it was made for the polynomial goes on as its tangent and cannot run away.

The modified Dahl model is one Dahl state and a straight line, a Prandtl-Ishlinskii model is plays
and a straight line.

What it cannot represent: loops whose height depends on where in the range they lie (every element
acts the same everywhere; Preisach can), speed, creep; with too many elements for the recording
it represents noise, so choose them by cross-validation.
Source: [paper] eq. (3) and Fig. 5 for the elements; [Bertotti-2006] for superposition and an
anhysteretic part.
"""

import math
from typing import Annotated, NamedTuple

import numpy as np
from annotated_types import Gt

from opensuction.hysteresis import bracket, modified_dahl, play
from opensuction.hysteresis.modified_dahl import ModifiedDahl
from opensuction.hysteresis.play import InverseMove, ModelState
from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import Array

MOST_DOUBLINGS = 60
"""Bound on the doublings with which the inverse looks for a travel that is far enough."""


class Generalised(NamedTuple):
    """Elements and weights of the generalised model, mm to mm."""

    decay_lengths_mm: Array
    """Travel over which each Dahl state forgets, above 0; shape (d,), d may be 0."""
    widths_mm: Array
    """Full width of each play, at least 0; shape (p,), p may be 0."""
    weights: Array
    """mm of output per mm of element, the Dahl states first; shape (d + p,). A positive weight
    of a Dahl state makes the output lag, one of a play moves it along behind a gap."""
    envelope_mm: Array
    """Coefficients c_k of p = sum_k c_k t^k with t the place in the range, -1 at its low end, +1
    at its high end; shape (degree + 1,)."""
    centre_mm: float
    """Middle of the range of the input."""
    half_range_mm: Annotated[float, Gt(0)]
    """Half of that range."""


def on_range(
    low_mm: float,
    high_mm: float,
    decay_lengths_mm: Array,
    widths_mm: Array,
    degree: int,
) -> Generalised:
    """A model for a range of the input with every weight still 0: `basis` and `with_factors`."""
    return Generalised(
        decay_lengths_mm=decay_lengths_mm,
        widths_mm=widths_mm,
        weights=np.zeros(decay_lengths_mm.size + widths_mm.size),
        envelope_mm=np.zeros(degree + 1),
        centre_mm=0.5 * (low_mm + high_mm),
        half_range_mm=0.5 * (high_mm - low_mm),
    )


def with_factors(model: Generalised, factors: Array) -> Generalised:
    """The model whose output is ``basis @ factors``. factors: shape (d + p + degree + 1,)."""
    size = model.weights.size
    return model._replace(weights=factors[:size].copy(), envelope_mm=factors[size:].copy())


@compiled
def start_elements_mm(model: Generalised, head_mm: float, memory_ratio: float) -> Array:
    """Elements after a past summed up in one number.

    memory_ratio: +1.0 after a long advance, -1.0 after a long retract, 0.0 relaxed; between.
    Returns shape (d + p,).
    """
    decays = model.decay_lengths_mm.size
    elements_mm = np.empty(decays + model.widths_mm.size)
    for j in range(decays):
        elements_mm[j] = -memory_ratio * model.decay_lengths_mm[j]
    for j in range(model.widths_mm.size):
        elements_mm[decays + j] = head_mm - 0.5 * memory_ratio * model.widths_mm[j]
    return elements_mm


@compiled
def _move(model: Generalised, elements_mm: Array, head_mm: float, move_mm: float) -> None:
    """Move every element in place by one monotone move that ends at ``head_mm``."""
    decays = model.decay_lengths_mm.size
    for j in range(decays):
        unit = ModifiedDahl(
            slope=0.0,
            velocity_gain=1.0,
            decay_per_mm=1.0 / model.decay_lengths_mm[j],
            offset_mm=0.0,
        )
        elements_mm[j] = modified_dahl.step(unit, elements_mm[j], move_mm)
    for j in range(model.widths_mm.size):
        elements_mm[decays + j] = play.step(model.widths_mm[j], elements_mm[decays + j], head_mm)


@compiled
def _envelope_term(model: Generalised, head_mm: float, degree: int) -> float:
    """``t^degree``, beyond the range its tangent."""
    place = (head_mm - model.centre_mm) / model.half_range_mm
    inside = min(max(place, -1.0), 1.0)
    lower = 1.0
    for _ in range(degree - 1):
        lower *= inside
    return 1.0 if degree == 0 else lower * (inside + degree * (place - inside))


@compiled
def _output_mm(model: Generalised, head_mm: float, elements_mm: Array) -> float:
    """Output for a place of the input and the elements there, mm."""
    total_mm = 0.0
    for j in range(model.weights.size):
        total_mm += model.weights[j] * elements_mm[j]
    for k in range(model.envelope_mm.size):
        total_mm += model.envelope_mm[k] * _envelope_term(model, head_mm, k)
    return total_mm


@compiled
def output_mm(model: Generalised, state: ModelState) -> float:
    """Output in a state, mm."""
    return _output_mm(model, state.head_mm, state.memory)


@compiled
def step(model: Generalised, state: ModelState, move_mm: float) -> ModelState:
    """State after one monotone move of the input, of any size; exact. The old one is kept."""
    head_mm = state.head_mm + move_mm
    elements_mm = state.memory.copy()
    _move(model, elements_mm, head_mm, move_mm)
    return ModelState(head_mm=head_mm, memory=elements_mm)


@compiled
def simulate(model: Generalised, head_mm: Array, elements_mm: Array) -> Array:
    """Outputs for a whole record of inputs.

    head_mm: shape (n,), finite; each step between samples is one monotone move.
    elements_mm: elements at the first sample, shape (d + p,); not changed; plays are brought
    within their slots there. Returns mm, shape (n,).
    """
    elements = elements_mm.copy()
    outputs_mm = np.empty(head_mm.size)
    for k in range(head_mm.size):
        _move(model, elements, head_mm[k], head_mm[k] - head_mm[max(k - 1, 0)])
        outputs_mm[k] = _output_mm(model, head_mm[k], elements)
    return outputs_mm


@compiled
def basis(model: Generalised, head_mm: Array, elements_mm: Array) -> Array:
    """The matrix that makes the model linear: ``simulate`` is ``basis @ factors``.

    head_mm, elements_mm: as for `simulate`. Columns: Dahl states, plays (both mm), then t^0,
    t^1 ... of the envelope (no unit). Returns shape (n, d + p + degree + 1); the factors are the
    weights, then the coefficients of the envelope.
    """
    elements = elements_mm.copy()
    size = elements.size
    columns = np.empty((head_mm.size, size + model.envelope_mm.size))
    for k in range(head_mm.size):
        _move(model, elements, head_mm[k], head_mm[k] - head_mm[max(k - 1, 0)])
        for j in range(size):
            columns[k, j] = elements[j]
        for j in range(model.envelope_mm.size):
            columns[k, size + j] = _envelope_term(model, head_mm[k], j)
    return columns


def least_slope(model: Generalised) -> float:
    """A bound below every slope dy/dx, in any state within saturation and at any place.

    A Dahl state has a slope from -2 (after a saturated reversal) to 0, a play from 0 to 1
    (without width always 1). Where no weight is negative the bound is attained: at a reversal
    after a long stroke.
    """
    slope = np.polynomial.Polynomial(model.envelope_mm).deriv()
    bends = slope.deriv().roots() if slope.degree() > 0 else np.empty(0)
    bends = bends[np.abs(bends.imag) < 1e-9].real
    places = np.concatenate([[-1.0, 1.0], bends[np.abs(bends) < 1.0]])
    decays = model.decay_lengths_mm.size
    dahl = float(np.minimum(-2.0 * model.weights[:decays], 0.0).sum())
    weights = model.weights[decays:]
    plays = float(np.where(model.widths_mm > 0.0, np.minimum(weights, 0.0), weights).sum())
    return float(slope(places).min()) / model.half_range_mm + dahl + plays


def is_monotone(model: Generalised) -> bool:
    """True where the output surely follows the input everywhere, so that an inverse exists.

    With weights of both signs it may say no where a finer look at the states would say yes.
    """
    return least_slope(model) > 0.0


@compiled
def _missing_mm(
    model: Generalised,
    state: ModelState,
    target_mm: float,
    move_mm: float,
    trial_mm: Array,
) -> float:
    """Output less target after a move, mm. trial_mm: workspace of the elements' shape."""
    for k in range(trial_mm.size):  # no slice: its assignment takes seconds to compile
        trial_mm[k] = state.memory[k]
    head_mm = state.head_mm + move_mm
    _move(model, trial_mm, head_mm, move_mm)
    return _output_mm(model, head_mm, trial_mm) - target_mm


@compiled
def inverse_step(model: Generalised, state: ModelState, target_mm: float) -> InverseMove:
    """Move of the input that brings the output to a target, to rounding; by bracketing.

    Every target is reached where the model `is_monotone`: ask that once. Of another model the
    move is one of several, or, where none was found, 0 and not reached.
    """
    trial_mm = np.empty(state.memory.size)
    missing_mm = target_mm - output_mm(model, state)
    direction = math.copysign(1.0, missing_mm)
    near, near_value, far, far_value = 0.0, -abs(missing_mm), 0.0, -abs(missing_mm)
    for k in range(MOST_DOUBLINGS):
        if far_value >= 0.0 or not math.isfinite(missing_mm):
            break
        near, near_value = far, far_value
        far = abs(missing_mm) * (2.0**k)
        far_value = direction * _missing_mm(model, state, target_mm, direction * far, trial_mm)
    if not far_value >= 0.0:
        return InverseMove(move_mm=0.0, reached=False)
    search = bracket.start(near, near_value, far, far_value)
    while not bracket.is_done(search):
        travel = bracket.trial(search)
        value = direction * _missing_mm(model, state, target_mm, direction * travel, trial_mm)
        search = bracket.narrow(search, travel, value)
    return InverseMove(move_mm=direction * bracket.root(search), reached=True)
