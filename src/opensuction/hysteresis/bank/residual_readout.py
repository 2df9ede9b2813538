"""Residual readout: a modified Dahl model, and a smooth readout of what it leaves.

``y = c x + beta h + y_0 + g(x) + sum_s G_s(x) h_s + sum_f e_f``: h is the unit lag of the modified
Dahl model, g and G_s are lines with corners at evenly spaced places of the input, h_s lags of known
decay lengths. What a gear, a spool or a bend adds at one place and takes back at the next is g
where both ways share it, and G_s where they do not. e_f is what the time before the first sample
has left: it fades with travel, moves by nothing else, and is 0 for a past told as a ratio alone.
Beyond the range that it was made for g and G_s stay as they end, and the line goes on.

What it cannot represent: speed and creep (nothing in it knows time), minor loops that close. Its
lags make no promise that the output moves the right way: it predicts and drives nothing.
Source: [paper] eqs. (3) and (4) for the model beneath; [Eilers-1996] for lines held by a penalty.
"""

import math
from typing import NamedTuple

import numpy as np

from opensuction.hysteresis.bank.play_readout import step_lag
from opensuction.hysteresis.play import InverseMove, ModelState
from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import Array


class ResidualReadout(NamedTuple):
    """Parameters of the model, mm to mm."""

    low_mm: float
    """Low end of the range of the input."""
    high_mm: float
    """High end of that range, above the low one."""
    slope: float
    """Output per input of the model beneath."""
    velocity_gain: float
    """How fast its lag follows the input."""
    decay_per_mm: float
    """Inverse of the travel over which its lag forgets, above 0."""
    offset_mm: float
    """Output for input, lags and what fades at 0, but for `curve_mm`."""
    curve_mm: Array
    """What the place adds at each corner; shape (m,), at least two corners, evenly spaced."""
    decays_mm: Array
    """Travel over which each further lag forgets, above 0; shape (s,)."""
    gains: Array
    """mm of output per mm of each further lag, at each corner; shape (s, m)."""
    fades_mm: Array
    """Travel over which each part of what was before the recording fades, above 0; shape (f,)."""


class Corner(NamedTuple):
    """Place of an input between two corners."""

    first: int
    """The corner before it."""
    share: float
    """Of the way to the next one, from 0 to 1."""


@compiled
def find_corner(low: float, high: float, corners: int, place: float) -> Corner:
    """The corners on both sides of a place; beyond the range those at its end."""
    spacing = (high - low) / (corners - 1)
    way = (place - low) / spacing
    first = min(max(int(np.floor(way)), 0), corners - 2)
    return Corner(first, min(max(way - first, 0.0), 1.0))


@compiled
def start_elements_mm(model: ResidualReadout, _head_mm: float, memory_ratio: float) -> Array:
    """The model's own lag, further lags and what fades, after a past summed up in one number.

    memory_ratio: +1.0 after a long advance, -1.0 after a long retract, 0.0 relaxed; between.
    Returns shape (1 + s + f,); nothing that fades.
    """
    further = model.decays_mm.size
    elements_mm = np.zeros(1 + further + model.fades_mm.size)
    elements_mm[0] = -memory_ratio / model.decay_per_mm
    for j in range(further):
        elements_mm[1 + j] = -memory_ratio * model.decays_mm[j]
    return elements_mm


@compiled
def _move(model: ResidualReadout, elements_mm: Array, move_mm: float) -> None:
    """Move every element in place by one monotone move."""
    further = model.decays_mm.size
    elements_mm[0] = step_lag(1.0 / model.decay_per_mm, elements_mm[0], move_mm)
    for j in range(further):
        elements_mm[1 + j] = step_lag(model.decays_mm[j], elements_mm[1 + j], move_mm)
    for j in range(model.fades_mm.size):
        elements_mm[1 + further + j] *= math.exp(-abs(move_mm) / model.fades_mm[j])


@compiled
def _output_mm(model: ResidualReadout, head_mm: float, elements_mm: Array) -> float:
    """Output for the elements; not a number for an input that is none."""
    if not math.isfinite(head_mm):
        return math.nan
    further = model.decays_mm.size
    at = find_corner(model.low_mm, model.high_mm, model.curve_mm.size, head_mm)
    before, behind = 1.0 - at.share, at.share
    total_mm: float = model.offset_mm + model.slope * head_mm
    total_mm += model.velocity_gain * elements_mm[0]
    total_mm += before * model.curve_mm[at.first] + behind * model.curve_mm[at.first + 1]
    for j in range(further):
        gain = before * model.gains[j, at.first] + behind * model.gains[j, at.first + 1]
        total_mm += gain * elements_mm[1 + j]
    for j in range(model.fades_mm.size):
        total_mm += elements_mm[1 + further + j]
    return total_mm


@compiled
def output_mm(model: ResidualReadout, state: ModelState) -> float:
    """Output in a state, mm."""
    return _output_mm(model, state.head_mm, state.memory)


@compiled
def step(model: ResidualReadout, state: ModelState, move_mm: float) -> ModelState:
    """State after one monotone move of the input, of any size; exact. The old one is kept."""
    elements_mm = state.memory.copy()
    _move(model, elements_mm, move_mm)
    return ModelState(head_mm=state.head_mm + move_mm, memory=elements_mm)


@compiled
def simulate(model: ResidualReadout, head_mm: Array, elements_mm: Array) -> Array:
    """Outputs for a whole record of inputs.

    head_mm: shape (n,), finite; each step between samples is one monotone move. elements_mm:
    elements at the first sample, shape (1 + s + f,); not changed. Returns mm, shape (n,).
    """
    elements = elements_mm.copy()
    outputs_mm = np.empty(head_mm.size)
    for k in range(head_mm.size):
        _move(model, elements, head_mm[k] - head_mm[max(k - 1, 0)])
        outputs_mm[k] = _output_mm(model, head_mm[k], elements)
    return outputs_mm


def basis(model: ResidualReadout, head_mm: Array, elements_mm: Array) -> Array:
    """The matrix that makes the model linear, its decays known: ``basis @ factors``.

    elements_mm: with nothing that fades. Columns: the input, the model's own lag, the share of each
    corner, each further lag times that share, 1. Returns shape (n, 3 + (1 + s) m).
    """
    corners, further = model.curve_mm.size, model.decays_mm.size
    columns = np.zeros((head_mm.size, 3 + (1 + further) * corners))
    columns[:, 0], columns[:, -1] = head_mm, 1.0
    elements = elements_mm.copy()
    for k, place_mm in enumerate(head_mm.tolist()):
        _move(model, elements, place_mm - float(head_mm[max(k - 1, 0)]))
        at = find_corner(model.low_mm, model.high_mm, corners, place_mm)
        columns[k, 1] = elements[0]
        for j, element in enumerate([1.0, *elements[1 : 1 + further]]):
            first = 2 + j * corners + at.first
            columns[k, first : first + 2] = (1.0 - at.share) * element, at.share * element
    return columns


def with_factors(model: ResidualReadout, factors: Array) -> ResidualReadout:
    """The model whose output is ``basis @ factors``. factors: shape (3 + (1 + s) m,)."""
    corners = model.curve_mm.size
    lines = factors[2:-1].reshape(-1, corners)
    return model._replace(
        slope=float(factors[0]),
        velocity_gain=float(factors[1]),
        offset_mm=float(factors[-1]),
        curve_mm=lines[0].copy(),
        gains=lines[1:].copy(),
    )


def refuse_inverse(_model: ResidualReadout, _state: ModelState, _target_mm: float) -> InverseMove:
    """No move: the output of a readout of lags may move the wrong way after any reversal."""
    return InverseMove(move_mm=0.0, reached=False)
