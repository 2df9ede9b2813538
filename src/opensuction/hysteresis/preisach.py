"""The Preisach model, discretised: a triangle of relays, exact for its grid.

A relay with thresholds (a, b) switches up when the input rises to a, down when it falls to
b <= a. The grid cuts the range of the input into levels of one height. The cell (k, l) of the
triangle holds the relays with ``a - b`` of k levels and b between level l and l + 1, spread
evenly along it, so that the output is continuous, not a staircase. A relay is up exactly where
the play of full width ``a - b`` has reached its middle; the relays of row k therefore are one
polygon, run through by one play. So the memory of all levels*(levels + 1)/2 cells is one play for
each row: bounded, exact, and one step costs no more than ``levels`` operations.

What it cannot represent: loops of equal input that differ in shape by their level of output (its
minor loops are congruent), an output beyond its grid (there it stays where it is), gaps of other
widths than whole levels, speed, creep. It has hundreds of weights: it asks for recordings with
many inner loops, and for weights held at 0 or above.
Source: [Preisach-1935]; [Mayergoyz-1991]; [Brokate-1996] ch. 2 for rows as plays.
"""

import math
from typing import NamedTuple

import numpy as np

from opensuction.hysteresis import bracket, play
from opensuction.hysteresis.play import InverseMove, ModelState
from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import Array


class Preisach(NamedTuple):
    """A weighted triangle of relays, mm to mm."""

    low_mm: float
    """Low end of the grid: below, every relay is down."""
    high_mm: float
    """High end of the grid, above the low one: beyond, every relay is up."""
    weights_mm: Array
    """Output that the relays of each cell add when they are up; shape (levels, levels), of which
    the triangle ``k + l < levels`` counts: k the gap of its relays, l where it lies, in levels."""
    offset_mm: float
    """Output with every relay down."""


@compiled
def level_mm(model: Preisach) -> float:
    """Height of one level of the grid, mm."""
    levels = float(model.weights_mm.shape[0])
    return (model.high_mm - model.low_mm) / levels


@compiled
def start_positions_mm(model: Preisach, head_mm: float, memory_ratio: float) -> Array:
    """Memory after a past summed up in one number.

    memory_ratio: +1.0 after a long advance, -1.0 after a long retract, 0.0 relaxed (shaken by
    ever smaller strokes); between. Returns shape (levels,).
    """
    positions_mm = np.empty(model.weights_mm.shape[0])
    for k in range(positions_mm.size):
        positions_mm[k] = head_mm - 0.5 * memory_ratio * k * level_mm(model)
    return positions_mm


@compiled
def _place(model: Preisach, row: int, position_mm: float) -> float:
    """Number of cells of a row that are up, in fractions; position of the row's play in levels."""
    cells = model.weights_mm.shape[0] - row
    place = (position_mm - model.low_mm) / level_mm(model) - 0.5 * row
    return min(max(place, 0.0), float(cells))


@compiled
def _sums_mm(model: Preisach) -> Array:
    """Output of the first l cells of each row, shape (levels, levels + 1)."""
    levels = model.weights_mm.shape[0]
    sums_mm = np.zeros((levels, levels + 1))
    for k in range(levels):
        for j in range(levels - k):
            sums_mm[k, j + 1] = sums_mm[k, j] + model.weights_mm[k, j]
    return sums_mm


@compiled
def _output_mm(
    model: Preisach,
    sums_mm: Array,
    head_mm: float,
    positions_mm: Array,
) -> float:
    """Output for the plays' positions; not a number for an input that is none."""
    if not math.isfinite(head_mm):
        return math.nan
    total_mm = model.offset_mm
    for k in range(positions_mm.size):
        place = _place(model, k, positions_mm[k])
        cell = min(int(place), positions_mm.size - k - 1)
        total_mm += sums_mm[k, cell] + (place - cell) * model.weights_mm[k, cell]
    return total_mm


@compiled
def output_mm(model: Preisach, state: ModelState) -> float:
    """Output in a state, mm."""
    return _output_mm(model, _sums_mm(model), state.head_mm, state.memory)


@compiled
def _move(model: Preisach, positions_mm: Array, head_mm: float) -> None:
    """Move every row's play in place by one monotone move that ends at ``head_mm``."""
    for k in range(positions_mm.size):
        positions_mm[k] = play.step(k * level_mm(model), positions_mm[k], head_mm)


@compiled
def step(model: Preisach, state: ModelState, move_mm: float) -> ModelState:
    """State after one monotone move of the input, of any size; exact. The old one is kept."""
    head_mm = state.head_mm + move_mm
    positions_mm = state.memory.copy()
    _move(model, positions_mm, head_mm)
    return ModelState(head_mm=head_mm, memory=positions_mm)


@compiled
def simulate(model: Preisach, head_mm: Array, positions_mm: Array) -> Array:
    """Outputs for a whole record of inputs.

    head_mm: shape (n,), finite; each step between samples is one monotone move.
    positions_mm: memory before the first sample, shape (levels,); not changed; brought within
    its slots there. Returns mm, shape (n,).
    """
    positions, sums_mm = positions_mm.copy(), _sums_mm(model)
    outputs_mm = np.empty(head_mm.size)
    for k in range(head_mm.size):
        _move(model, positions, head_mm[k])
        outputs_mm[k] = _output_mm(model, sums_mm, head_mm[k], positions)
    return outputs_mm


@compiled
def basis(model: Preisach, head_mm: Array, positions_mm: Array) -> Array:
    """The matrix that makes the model linear: ``simulate`` is ``basis @ factors``.

    model: gives the grid; its weights do not matter. head_mm, positions_mm: as for `simulate`.
    Columns, without unit: the share of each cell that is up, from 0 to 1, row by row of the
    triangle, then 1 for the offset. Returns shape (n, cells + 1).
    """
    levels = model.weights_mm.shape[0]
    positions = positions_mm.copy()
    columns = np.empty((head_mm.size, levels * (levels + 1) // 2 + 1))
    for i in range(head_mm.size):
        _move(model, positions, head_mm[i])
        column = 0
        for k in range(levels):
            place = _place(model, k, positions[k])
            for j in range(levels - k):
                columns[i, column] = min(max(place - j, 0.0), 1.0)
                column += 1
        columns[i, column] = 1.0
    return columns


def from_factors(low_mm: float, high_mm: float, levels: int, factors: Array) -> Preisach:
    """The model whose output is ``basis @ factors``. factors: mm, shape (cells + 1,)."""
    weights_mm = np.zeros((levels, levels))
    rows, places = np.indices(weights_mm.shape)
    weights_mm[rows + places < levels] = factors[:-1]
    return Preisach(low_mm, high_mm, weights_mm, offset_mm=float(factors[-1]))


@compiled
def is_rising(model: Preisach) -> bool:
    """True where no cell counts against the input: the output then never moves the wrong way."""
    levels = model.weights_mm.shape[0]
    for k in range(levels):
        for j in range(levels - k):
            if not model.weights_mm[k, j] >= 0.0:
                return False
    return True


def is_monotone(model: Preisach) -> bool:
    """True where the output follows the input at once everywhere on the grid.

    That is the row without a gap: each of its cells above 0, and none of the others below.
    """
    return bool((model.weights_mm[0] > 0.0).all()) and is_rising(model)


@compiled
def _missing_mm(
    model: Preisach,
    sums_mm: Array,
    state: ModelState,
    target_mm: float,
    move_mm: float,
    trial_mm: Array,
) -> float:
    """Output less target after a move, mm. trial_mm: workspace of shape (levels,)."""
    for k in range(trial_mm.size):  # no slice: its assignment takes seconds to compile
        trial_mm[k] = state.memory[k]
    head_mm = state.head_mm + move_mm
    _move(model, trial_mm, head_mm)
    return _output_mm(model, sums_mm, head_mm, trial_mm) - target_mm


@compiled
def inverse_step(model: Preisach, state: ModelState, target_mm: float) -> InverseMove:
    """Move of the input that brings the output to a target, to rounding; by bracketing.

    A gap is crossed where there is one. A target beyond all relays up or down is not reached: the
    move ends at that end of the grid. With a cell below 0 the inverse is refused: a move of 0.
    """
    sums_mm, trial_mm = _sums_mm(model), np.empty(state.memory.size)
    missing_mm = target_mm - _output_mm(model, sums_mm, state.head_mm, state.memory)
    if not (is_rising(model) and math.isfinite(missing_mm)):
        return InverseMove(move_mm=0.0, reached=False)
    direction = math.copysign(1.0, missing_mm)
    end_mm = model.high_mm if direction > 0.0 else model.low_mm
    far = max(direction * (end_mm - state.head_mm), 0.0)
    value = direction * _missing_mm(model, sums_mm, state, target_mm, direction * far, trial_mm)
    if value < 0.0:
        return InverseMove(move_mm=direction * far, reached=False)
    search = bracket.start(0.0, -abs(missing_mm), far, value)
    while not bracket.is_done(search):
        travel = bracket.trial(search)
        move_mm = direction * travel
        value = direction * _missing_mm(model, sums_mm, state, target_mm, move_mm, trial_mm)
        search = bracket.narrow(search, travel, value)
    return InverseMove(move_mm=direction * bracket.root(search), reached=True)
