"""Maxwell-slip model: a line over the deflection of each of some slipping elements, and drag.

``y = y_0 + c x + sum_k L_k(d_k) + sum_q D_q clip(v/v_q, -1, 1)``: d_k is the deflection of an
element that sticks until it is deflected by its reach and then slips; L_k is a line over it with
corners at evenly spaced deflections; v is the speed of the input behind a first-order lag. The
first sums are the force of rubbing surfaces as it comes up after a reversal, stiff or slack at
first and unlike on the two ways; the last is what friction makes of speed. A magnetorheological
damper, a friction damper with backlash and a joint whose oil drags are of this kind.

It knows time: a step is one sample of ``period_s``. Without drag it knows none.

What it cannot represent: loops that change with the place in the range, creep. Its output may move
the wrong way after a reversal: it predicts and drives nothing.
Source: [Iwan-1966] for the elements; [Al-Bender-2005] for lines and speed.
"""

import math
from typing import NamedTuple

import numpy as np

from opensuction.hysteresis import play
from opensuction.hysteresis.play import InverseMove, ModelState
from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import Array


class MaxwellSlip(NamedTuple):
    """Parameters of the model, mm to mm."""

    slope: float
    """Output per input with every element slipping."""
    reaches_mm: Array
    """Deflection at which each element slips, above 0; shape (k,)."""
    gains: Array
    """Slope of the line over an element in each cell of its deflection, from the one at which it
    slips backward to the one at which it slips forward, mm of output per mm; shape (k, m)."""
    speeds_mm_s: Array
    """Speed from which each drag grows no more, above 0; shape (q,), q may be 0."""
    drags_mm: Array
    """Output that each drag adds from there on; shape (q,)."""
    lag_s: float
    """Time constant behind which the speed is taken, above 0."""
    period_s: float
    """Time between samples, above 0."""
    offset_mm: float
    """Output at input 0 and rest with every element slipping backward."""


@compiled
def start_elements_mm(model: MaxwellSlip, head_mm: float, memory_ratio: float) -> Array:
    """Position of each element's foot, then the lagging input, after a past told by one number.

    memory_ratio: +1.0 after a long advance, -1.0 after a long retract, 0.0 relaxed; between. The
    input has come to rest. Returns shape (k + 1,), without drag (k,).
    """
    rows = model.reaches_mm.size
    elements_mm = np.full(rows + min(model.speeds_mm_s.size, 1), head_mm)
    for row in range(rows):
        elements_mm[row] -= memory_ratio * model.reaches_mm[row]
    return elements_mm


@compiled
def find_speeds(head_mm: Array, lag_s: float, period_s: float) -> Array:
    """Speeds of a record of inputs behind a first-order lag, mm/s; shape (n,), as ``head_mm``."""
    speeds_mm_s = np.empty(head_mm.size)
    share, lagging_mm = -math.expm1(-period_s / lag_s), head_mm[0]
    for k in range(head_mm.size):
        lagging_mm += share * (head_mm[k] - lagging_mm)
        speeds_mm_s[k] = (head_mm[k] - lagging_mm) / lag_s
    return speeds_mm_s


@compiled
def _move(model: MaxwellSlip, elements_mm: Array, head_mm: float) -> None:
    """Move every element in place by one sample that ends at ``head_mm``."""
    rows = model.reaches_mm.size
    for row in range(rows):
        elements_mm[row] = play.step(2.0 * model.reaches_mm[row], elements_mm[row], head_mm)
    if model.speeds_mm_s.size > 0:
        share = -math.expm1(-model.period_s / model.lag_s)
        elements_mm[rows] += share * (head_mm - elements_mm[rows])


@compiled
def _fill_columns(model: MaxwellSlip, head_mm: float, elements_mm: Array, row: Array) -> None:
    """Write what each factor multiplies: the input, travel through each cell, drags, 1."""
    elements, cells = model.gains.shape
    row[0] = head_mm
    for k in range(elements):
        reach_mm = model.reaches_mm[k]
        cell_mm = 2.0 * reach_mm / cells
        gone_mm = head_mm - elements_mm[k] + reach_mm
        for cell in range(cells):
            inside_mm = min(max(gone_mm - cell * cell_mm, 0.0), cell_mm)
            row[1 + k * cells + cell] = inside_mm
    first = 1 + elements * cells
    for q in range(model.speeds_mm_s.size):
        speed_mm_s = (head_mm - elements_mm[elements]) / model.lag_s
        row[first + q] = min(max(speed_mm_s / model.speeds_mm_s[q], -1.0), 1.0)
    row[first + model.speeds_mm_s.size] = 1.0


@compiled
def _output_mm(model: MaxwellSlip, head_mm: float, elements_mm: Array, row: Array) -> float:
    """Output for the elements; not a number for an input that is none. row: workspace."""
    if not math.isfinite(head_mm):
        return math.nan
    _fill_columns(model, head_mm, elements_mm, row)
    elements, cells = model.gains.shape
    total_mm = model.offset_mm + model.slope * head_mm
    for k in range(elements):
        for cell in range(cells):
            total_mm += model.gains[k, cell] * row[1 + k * cells + cell]
    for q in range(model.drags_mm.size):
        total_mm += model.drags_mm[q] * row[1 + elements * cells + q]
    return total_mm


@compiled
def _workspace(model: MaxwellSlip) -> Array:
    """Room for the columns of one sample."""
    return np.empty(2 + model.gains.size + model.speeds_mm_s.size)


@compiled
def output_mm(model: MaxwellSlip, state: ModelState) -> float:
    """Output in a state, mm."""
    return _output_mm(model, state.head_mm, state.memory, _workspace(model))


@compiled
def step(model: MaxwellSlip, state: ModelState, move_mm: float) -> ModelState:
    """State one sample later, after one monotone move of the input. The old one is kept."""
    head_mm = state.head_mm + move_mm
    elements_mm = state.memory.copy()
    _move(model, elements_mm, head_mm)
    return ModelState(head_mm=head_mm, memory=elements_mm)


@compiled
def simulate(model: MaxwellSlip, head_mm: Array, elements_mm: Array) -> Array:
    """Outputs for a whole record of inputs, one each ``period_s``.

    head_mm: shape (n,), finite. elements_mm: as `start_elements_mm` gives them, at the first
    sample; not changed; feet are brought within reach there. Returns mm, shape (n,).
    """
    elements, row = elements_mm.copy(), _workspace(model)
    outputs_mm = np.empty(head_mm.size)
    for k in range(head_mm.size):
        _move(model, elements, head_mm[k])
        outputs_mm[k] = _output_mm(model, head_mm[k], elements, row)
    return outputs_mm


@compiled
def basis(model: MaxwellSlip, head_mm: Array, elements_mm: Array) -> Array:
    """The matrix that makes the model linear: ``simulate`` is ``basis @ factors``.

    Columns: the input, mm of each element's travel through each of its cells, element by element,
    then each drag's share of what it adds at most, then 1. Returns shape (n, k*m + q + 2).
    """
    elements, row = elements_mm.copy(), _workspace(model)
    columns = np.empty((head_mm.size, row.size))
    for k in range(head_mm.size):
        _move(model, elements, head_mm[k])
        _fill_columns(model, head_mm[k], elements, row)
        for j in range(row.size):
            columns[k, j] = row[j]
    return columns


def with_factors(model: MaxwellSlip, factors: Array) -> MaxwellSlip:
    """The model whose output is ``basis @ factors``. factors: shape (k*m + q + 2,)."""
    cells = model.gains.size
    return model._replace(
        slope=float(factors[0]),
        gains=factors[1 : 1 + cells].reshape(model.gains.shape).copy(),
        drags_mm=factors[1 + cells : -1].copy(),
        offset_mm=float(factors[-1]),
    )


def share_out(model: MaxwellSlip) -> Array:
    """Share of each element in the loop, by what it adds when it slips, shape (elements,)."""
    heights: Array = np.sqrt(np.mean(model.gains * model.gains, axis=1)) * model.reaches_mm
    return heights / max(float(heights.sum()), 1e-300)


def refuse_inverse(_model: MaxwellSlip, _state: ModelState, _target_mm: float) -> InverseMove:
    """No move: the output of slipping elements may move the wrong way after any reversal."""
    return InverseMove(move_mm=0.0, reached=False)
