"""Play readout: a smooth line over each play of a bank, and lags that fade with travel.

``y = y_0 + sum_k F_k(p_k) + sum_s w_s h_s``: each p_k is a play of a known width, F_k a line with
corners at evenly spaced places of its position, h_s a Dahl state of a known decay length (a slow
state: it forgets over many strokes). With one cell a play it is a Prandtl-Ishlinskii model; with
gains that change along the range its loops change with it, as a Preisach model's do, but its plays
may be as narrow as the gap asks for. Beyond the range that it was made for every line goes on as it
ends.

What it cannot represent: speed and creep (nothing in it knows time), minor loops of equal input
that differ by more than its plays tell. It has hundreds of gains: they are held together by a
penalty on their differences and above 0 where the output must follow the input
(`identification.bank`).
Source: [Krasnoselskii-1989]; [Brokate-1996] ch. 2; [Eilers-1996] for the penalty on differences.
"""

import math
from typing import NamedTuple

import numpy as np

from opensuction.hysteresis import bracket, modified_dahl, play
from opensuction.hysteresis.bank import play_bank
from opensuction.hysteresis.bank.play_bank import PlayBank
from opensuction.hysteresis.modified_dahl import ModifiedDahl
from opensuction.hysteresis.play import InverseMove, ModelState
from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import Array

MOST_DOUBLINGS = 60
"""Bound on the doublings with which the inverse looks for a travel that is far enough."""


class PlayReadout(NamedTuple):
    """Parameters of the model, mm to mm."""

    low_mm: float
    """Low end of the range of the input."""
    high_mm: float
    """High end of that range, above the low one."""
    widths_mm: Array
    """Full width of each play, at least 0; shape (k,)."""
    gains: Array
    """Slope of the line over each play in each of its cells, mm of output per mm of play; shape
    (k, m): the range is cut into m cells."""
    decays_mm: Array
    """Travel over which each slow state forgets, above 0; shape (s,), s may be 0."""
    lags: Array
    """mm of output per mm of slow state; shape (s,). Above 0 it makes the output lag."""
    offset_mm: float
    """Output with every play at the low end and every slow state at 0."""


@compiled
def cell_mm(model: PlayReadout) -> float:
    """Length of a cell, mm."""
    cells = float(model.gains.shape[1])
    return (model.high_mm - model.low_mm) / cells


@compiled
def bank_of(model: PlayReadout) -> PlayBank:
    """The model's plays and their cells."""
    rows = model.widths_mm.size
    return PlayBank(
        widths_mm=model.widths_mm,
        lows_mm=np.full(rows, model.low_mm),
        cell_mm=cell_mm(model),
        cells=np.full(rows, model.gains.shape[1]),
        inputs=np.zeros(rows, dtype=np.int64),
        goes_on=True,
    )


@compiled
def start_elements_mm(model: PlayReadout, head_mm: float, memory_ratio: float) -> Array:
    """Plays, then slow states, after a past summed up in one number.

    memory_ratio: +1.0 after a long advance, -1.0 after a long retract, 0.0 relaxed; between.
    Returns shape (k + s,).
    """
    rows = model.widths_mm.size
    elements_mm = np.empty(rows + model.decays_mm.size)
    for row in range(rows):
        elements_mm[row] = head_mm - 0.5 * memory_ratio * model.widths_mm[row]
    for j in range(model.decays_mm.size):
        elements_mm[rows + j] = -memory_ratio * model.decays_mm[j]
    return elements_mm


@compiled
def step_lag(decay_mm: float, lag_mm: float, move_mm: float) -> float:
    """A slow state after one monotone move."""
    unit = ModifiedDahl(slope=0.0, velocity_gain=1.0, decay_per_mm=1.0 / decay_mm, offset_mm=0.0)
    return modified_dahl.step(unit, lag_mm, move_mm)


@compiled
def _move(model: PlayReadout, elements_mm: Array, head_mm: float, move_mm: float) -> None:
    """Move every element in place by one monotone move that ends at ``head_mm``."""
    rows = model.widths_mm.size
    for row in range(rows):
        elements_mm[row] = play.step(model.widths_mm[row], elements_mm[row], head_mm)
    for j in range(model.decays_mm.size):
        elements_mm[rows + j] = step_lag(model.decays_mm[j], elements_mm[rows + j], move_mm)


@compiled
def _sums_mm(model: PlayReadout) -> Array:
    """Output of each play at the low end of each of its cells, shape (k, m)."""
    sums_mm = np.zeros(model.gains.shape)
    rows, cells = model.gains.shape
    for row in range(rows):
        for cell in range(1, cells):
            sums_mm[row, cell] = sums_mm[row, cell - 1] + model.gains[row, cell - 1] * cell_mm(
                model
            )
    return sums_mm


@compiled
def _output_mm(
    model: PlayReadout, bank: PlayBank, sums_mm: Array, head_mm: float, elements_mm: Array
) -> float:
    """Output for the elements; not a number for an input that is none."""
    if not math.isfinite(head_mm):
        return math.nan
    rows = model.widths_mm.size
    total_mm = model.offset_mm
    for row in range(rows):
        placed = play_bank.find_place(bank, row, elements_mm[row])
        gain = model.gains[row, placed.cell]
        total_mm += sums_mm[row, placed.cell] + placed.share * bank.cell_mm * gain
    for j in range(model.lags.size):
        total_mm += model.lags[j] * elements_mm[rows + j]
    return total_mm


@compiled
def output_mm(model: PlayReadout, state: ModelState) -> float:
    """Output in a state, mm."""
    return _output_mm(model, bank_of(model), _sums_mm(model), state.head_mm, state.memory)


@compiled
def step(model: PlayReadout, state: ModelState, move_mm: float) -> ModelState:
    """State after one monotone move of the input, of any size; exact. The old one is kept."""
    head_mm = state.head_mm + move_mm
    elements_mm = state.memory.copy()
    _move(model, elements_mm, head_mm, move_mm)
    return ModelState(head_mm=head_mm, memory=elements_mm)


@compiled
def simulate(model: PlayReadout, head_mm: Array, elements_mm: Array) -> Array:
    """Outputs for a whole record of inputs.

    head_mm: shape (n,), finite; each step between samples is one monotone move. elements_mm:
    elements at the first sample, shape (k + s,); not changed; plays are brought within their slots
    there. Returns mm, shape (n,).
    """
    elements, bank, sums_mm = elements_mm.copy(), bank_of(model), _sums_mm(model)
    outputs_mm = np.empty(head_mm.size)
    for k in range(head_mm.size):
        _move(model, elements, head_mm[k], head_mm[k] - head_mm[max(k - 1, 0)])
        outputs_mm[k] = _output_mm(model, bank, sums_mm, head_mm[k], elements)
    return outputs_mm


def lag_columns(decays_mm: Array, head_mm: Array, lags_mm: Array) -> Array:
    """Slow states for a whole record of inputs, from those at its first sample; shape (s, n)."""
    columns = np.empty((decays_mm.size, head_mm.size))
    for j, decay_mm in enumerate(decays_mm):
        unit = ModifiedDahl(0.0, 1.0, 1.0 / float(decay_mm), 0.0)
        columns[j] = modified_dahl.simulate(unit, head_mm, float(lags_mm[j]))
    return columns


def basis(model: PlayReadout, head_mm: Array, elements_mm: Array) -> Array:
    """The matrix that makes the model linear: ``simulate`` is ``basis @ factors``.

    Columns: mm of each play's travel through each of its cells, play by play, then the slow states
    in mm, then 1 for the offset. Returns shape (n, k*m + s + 1); the factors are the gains, the
    lags and the offset.
    """
    rows = model.widths_mm.size
    cells = cell_mm(model) * play_bank.basis(bank_of(model), head_mm, elements_mm[:rows])
    lags = lag_columns(model.decays_mm, head_mm, elements_mm[rows:]).T
    return np.hstack([cells, lags, np.ones((head_mm.size, 1))])


def with_factors(model: PlayReadout, factors: Array) -> PlayReadout:
    """The model whose output is ``basis @ factors``. factors: shape (k*m + s + 1,)."""
    cells = model.gains.size
    return model._replace(
        gains=factors[:cells].reshape(model.gains.shape).copy(),
        lags=factors[cells:-1].copy(),
        offset_mm=float(factors[-1]),
    )


@compiled
def is_rising(model: PlayReadout) -> bool:
    """True where the output never moves the wrong way.

    A slow state has a slope from -2, after a saturated reversal, to 0: what lags must be made good
    by the play without width, wherever in the range it is.
    """
    lagging = 0.0
    for j in range(model.lags.size):
        lagging += 2.0 * max(model.lags[j], 0.0)
    for row in range(model.gains.shape[0]):
        for cell in range(model.gains.shape[1]):
            if not model.gains[row, cell] >= 0.0:
                return False
    if lagging == 0.0:
        return True
    for cell in range(model.gains.shape[1]):
        direct = 0.0
        for row in range(model.gains.shape[0]):
            if model.widths_mm[row] == 0.0:
                direct += model.gains[row, cell]
        if not direct > lagging:
            return False
    return True


def is_monotone(model: PlayReadout) -> bool:
    """True where the output follows the input at once everywhere and the right way."""
    direct = model.gains[model.widths_mm == 0.0].sum(axis=0)
    return bool((direct > 0.0).all()) and bool(is_rising(model))


@compiled
def _missing_mm(
    model: PlayReadout,
    sums_mm: Array,
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
    return _output_mm(model, bank_of(model), sums_mm, head_mm, trial_mm) - target_mm


@compiled
def inverse_step(model: PlayReadout, state: ModelState, target_mm: float) -> InverseMove:
    """Move of the input that brings the output to a target, to rounding; by bracketing.

    A gap is crossed where there is one. Refused, a move of 0, where the output may move the wrong
    way (`is_rising`), and where no travel reaches the target.
    """
    sums_mm, trial_mm = _sums_mm(model), np.empty(state.memory.size)
    missing_mm = target_mm - output_mm(model, state)
    if not (is_rising(model) and math.isfinite(missing_mm)):
        return InverseMove(move_mm=0.0, reached=False)
    direction = math.copysign(1.0, missing_mm)
    near, near_value, far, far_value = 0.0, -abs(missing_mm), 0.0, -abs(missing_mm)
    for k in range(MOST_DOUBLINGS):
        if far_value >= 0.0:
            break
        near, near_value = far, far_value
        far = abs(missing_mm) * (2.0**k)
        move_mm = direction * far
        far_value = direction * _missing_mm(model, sums_mm, state, target_mm, move_mm, trial_mm)
    if not far_value >= 0.0:
        return InverseMove(move_mm=0.0, reached=False)
    search = bracket.start(near, near_value, far, far_value)
    while not bracket.is_done(search):
        travel = bracket.trial(search)
        move_mm = direction * travel
        value = direction * _missing_mm(model, sums_mm, state, target_mm, move_mm, trial_mm)
        search = bracket.narrow(search, travel, value)
    return InverseMove(move_mm=direction * bracket.root(search), reached=True)
