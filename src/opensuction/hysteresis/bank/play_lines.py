"""Plays with a line over each: the one form in which every model of plays drives a head.

A Prandtl-Ishlinskii model has one gain a play, a row of a Preisach triangle a gain for each of its
cells, a play readout likewise, with a slow state beside them. Beyond the recorded range
every line goes on with its mean gain, also a Preisach model's, whose own output stands still there:
a head that is driven goes further than a recording did, and the last cell tells of its own place
only.
Source: [Brokate-1996] ch. 2 for a triangle of relays as rows of plays.

Plays with lines over them as one table of numbers, for a head that is driven tick by tick.

The table holds the model (`PlayLines`), the turning points the memory. Along a travel in one
direction the tip is a polygon of the travel, with a corner where a play engages and one where a
play goes on into its next cell; between them a slow state bends it. Its inverse is therefore found
piece by piece, in at most as many steps as the model has corners, and exactly: to rounding.
Source: [Krasnoselskii-1989]; [Brokate-1996] ch. 2.
"""

import math
from typing import NamedTuple

import numpy as np

from opensuction.hysteresis import modified_dahl
from opensuction.hysteresis.bank import play_readout, turning_point
from opensuction.hysteresis.bank.play_readout import PlayReadout
from opensuction.hysteresis.modified_dahl import ModifiedDahl
from opensuction.hysteresis.play_sum import ENGAGED_MM, Sixteen
from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii
from opensuction.hysteresis.preisach import Preisach
from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import Array

NO_DECAY_MM = 1.0
"""Decay length where no slow state counts."""


class PlayLines(NamedTuple):
    """Plays that a head moves, and what the tip makes of their positions."""

    widths_mm: Array
    """Full width of each play, at least 0; shape (k,)."""
    lows_mm: Array
    """Position at which the first cell of each begins; shape (k,)."""
    cell_mm: float
    """Length of a cell, the same for all, above 0."""
    gains: Array
    """Slope of the line over each play in each of its cells, mm of tip for each mm of play; shape
    (k, m). The first and the last go on beyond their ends."""
    decay_mm: float
    """Travel over which the slow state forgets, above 0."""
    lag: float
    """mm of tip for each mm of the slow state; 0 where there is none."""
    offset_mm: float
    """Tip with every play at its low and the slow state at 0."""


def of_prandtl_ishlinskii(model: PrandtlIshlinskii) -> PlayLines:
    """The model as plays of one cell; its curvature, which is no line over a play, is left out."""
    weights = np.append(model.slope, model.weights)
    return _lean(
        PlayLines(
            widths_mm=np.append(0.0, 2.0 * model.thresholds_mm),
            lows_mm=np.zeros(weights.size),
            cell_mm=1.0,
            gains=weights[:, None],
            decay_mm=NO_DECAY_MM,
            lag=0.0,
            offset_mm=model.offset_mm,
        )
    )


def of_preisach(model: Preisach) -> PlayLines:
    """The rows of the triangle; a row of fewer cells than the first goes on with its mean gain."""
    levels = model.weights_mm.shape[0]
    level_mm = (model.high_mm - model.low_mm) / levels
    counts = levels - np.arange(levels)
    own = np.arange(levels)[None, :] < counts[:, None]
    gains = np.where(own, model.weights_mm, 0.0) / level_mm
    means = gains.sum(axis=1) / counts
    return _extend(
        PlayLines(
            widths_mm=level_mm * np.arange(levels),
            lows_mm=model.low_mm + 0.5 * level_mm * np.arange(levels),
            cell_mm=level_mm,
            gains=np.where(own, gains, means[:, None]),
            decay_mm=NO_DECAY_MM,
            lag=0.0,
            offset_mm=model.offset_mm,
        ),
        means,
    )


def of_readout(model: PlayReadout) -> PlayLines:
    """The readout of one input, with its slow state. Raises ValueError for more than one."""
    if model.lags.size > 1:
        raise ValueError(f"{model.lags.size} slow states: at most one has a place here")
    lags = bool(model.lags.size)
    return _extend(
        PlayLines(
            widths_mm=model.widths_mm,
            lows_mm=np.full(model.widths_mm.size, model.low_mm),
            cell_mm=(model.high_mm - model.low_mm) / model.gains.shape[1],
            gains=model.gains,
            decay_mm=float(model.decays_mm[0]) if lags else NO_DECAY_MM,
            lag=float(model.lags[0]) if lags else 0.0,
            offset_mm=model.offset_mm,
        ),
        model.gains.mean(axis=1),
    )


def _extend(lines: PlayLines, beyond: Array) -> PlayLines:
    """With a cell more at either end, which goes on. beyond: gains there, shape (k,)."""
    edge = beyond[:, None]
    return _lean(
        lines._replace(
            lows_mm=lines.lows_mm - lines.cell_mm,
            gains=np.hstack([edge, lines.gains, edge]),
            offset_mm=float(lines.offset_mm - lines.cell_mm * beyond.sum()),
        )
    )


def _lean(lines: PlayLines) -> PlayLines:
    """Without plays that add nothing anywhere; one is kept."""
    kept = np.any(lines.gains != 0.0, axis=1)
    kept[0] |= not kept.any()
    return lines._replace(
        widths_mm=np.ascontiguousarray(lines.widths_mm[kept]),
        lows_mm=np.ascontiguousarray(lines.lows_mm[kept]),
        gains=np.ascontiguousarray(lines.gains[kept]),
    )


def total_slopes(lines: PlayLines) -> Array:
    """Slope of the tip over a long travel in each cell, every play moving; shape (m,)."""
    slopes: Array = lines.gains.sum(axis=0)
    return slopes


def why_not_driven(lines: PlayLines) -> str | None:
    """Reason why no head can be driven by the model; None where one can.

    No gain may count against the head, and wherever all plays move the tip must move. A gap, where
    it does not move at all, is crossed and no reason. A slow state takes up to twice its share from
    the slope, right after a reversal; the play without width must make that good.
    """
    if not all(np.isfinite(np.ravel(field)).all() for field in lines):
        return "it holds a number that is not finite"
    if not (lines.cell_mm > 0.0 and lines.decay_mm > 0.0 and (lines.widths_mm >= 0.0).all()):
        return "its cells, its decay length or a width is no length"
    if (lines.gains < 0.0).any():
        worst = float(lines.gains.min())
        return f"it is not monotone: a gain is {worst:.3g}, none should be below 0"
    if not (total_slopes(lines) > 0.0).all():
        return "its tip stands still somewhere while every play moves"
    lagging = 2.0 * max(lines.lag, 0.0)
    direct = float(lines.gains[lines.widths_mm == 0.0].sum(axis=0).min(initial=np.inf))
    direct = direct if (lines.widths_mm == 0.0).any() else 0.0
    if lagging > 0.0 and not direct > lagging:
        return (
            f"it is not monotone: its slow state takes up to {lagging:.3g} from the slope after a "
            f"reversal, and the play without width has {direct:.3g}"
        )
    return None


Table = Array
"""The first row: length of a cell, offset, decay length, share of the slow state. Every other row
is a play: its width, where its first cell begins, the gains of its m cells, then what its line has
added before each of them. Shape (1 + k, 2 + 2 m)."""
CELL, OFFSET, DECAY, LAG = range(4)
"""Places in the first row."""
WIDTH, LOW, GAINS = range(3)
"""Places in the other rows; what lines have added begins behind the gains."""
CORNER = 1e-9
"""Share of a cell by which a corner counts as passed."""
MOST_DOUBLINGS = 60
"""Bound on the doublings with which a far enough start is looked for."""


def tabulate(lines: PlayLines) -> Table:
    """The table of a model."""
    rows, cells = lines.gains.shape
    table = np.zeros((1 + rows, 2 + 2 * cells))
    table[0, :4] = lines.cell_mm, lines.offset_mm, lines.decay_mm, lines.lag
    table[1:, WIDTH], table[1:, LOW] = lines.widths_mm, lines.lows_mm
    table[1:, GAINS : GAINS + cells] = lines.gains
    added = np.cumsum(lines.gains[:, :-1], axis=1) * lines.cell_mm
    table[1:, GAINS + cells + 1 :] = added
    return table


def to_lines(table: Table) -> PlayLines:
    """The model of a table."""
    cells = _cells(table)
    return PlayLines(
        widths_mm=table[1:, WIDTH].copy(),
        lows_mm=table[1:, LOW].copy(),
        cell_mm=float(table[0, CELL]),
        gains=table[1:, GAINS : GAINS + cells].copy(),
        decay_mm=float(table[0, DECAY]),
        lag=float(table[0, LAG]),
        offset_mm=float(table[0, OFFSET]),
    )


@compiled
def _cells(table: Table) -> int:
    return int((table.shape[1] - GAINS) // 2)


@compiled
def positions_mm(table: Table, turns: Sixteen, head_mm: float) -> Array:
    """Position of each play that the head's turns and its place leave it in, shape (k,)."""
    values, count = turning_point.list_turns(turns)
    positions = np.empty(table.shape[0] - 1)
    for row in range(positions.size):
        half_mm = 0.5 * table[row + 1, WIDTH]
        position = values[0] + half_mm
        for k in range(1, count):
            position = min(max(position, values[k] - half_mm), values[k] + half_mm)
        positions[row] = min(max(position, head_mm - half_mm), head_mm + half_mm)
    return positions


@compiled
def output_mm(table: Table, positions: Array, lag_mm: float) -> float:
    """Tip for positions of the plays and the slow state, mm."""
    cells, cell_mm = _cells(table), table[0, CELL]
    tip_mm = table[0, OFFSET] + table[0, LAG] * lag_mm
    for row in range(positions.size):
        above_mm = positions[row] - table[row + 1, LOW]
        cell = min(max(math.floor(above_mm / cell_mm), 0), cells - 1)
        before_mm = table[row + 1, GAINS + cells + cell]
        tip_mm += before_mm + table[row + 1, GAINS + cell] * (above_mm - cell * cell_mm)
    return float(tip_mm)


@compiled
def step_lag(table: Table, lag_mm: float, move_mm: float) -> float:
    """The slow state after one monotone move of the head; it stays where none counts."""
    if table[0, LAG] == 0.0:
        return lag_mm
    return play_readout.step_lag(float(table[0, DECAY]), lag_mm, move_mm)


@compiled
def _pull_mm(table: Table, lag_mm: float, direction: float) -> float:
    """Tip that the slow state still takes from a long travel in a direction."""
    return float(table[0, LAG] * (direction * lag_mm + table[0, DECAY]))


@compiled
def _piece(
    table: Table, positions: Array, head_mm: float, direction: float, travel_mm: float
) -> tuple[float, float]:
    """Slope of the tip after a travel from the head's position, and how far it goes on so.

    Of the plays alone. positions: at the head's position.
    """
    cells, cell_mm = _cells(table), table[0, CELL]
    slope, further_mm = 0.0, math.inf
    here_mm = head_mm + direction * travel_mm
    for row in range(positions.size):
        half_mm = 0.5 * table[row + 1, WIDTH]
        left_mm = half_mm + direction * (positions[row] - head_mm) - travel_mm
        if left_mm > ENGAGED_MM:
            further_mm = min(further_mm, left_mm)
            continue
        place = (here_mm - direction * half_mm - table[row + 1, LOW]) / cell_mm
        if direction > 0.0:
            cell = min(max(math.floor(place + CORNER), 0), cells - 1)
            ahead = cell + 1.0 - place if cell < cells - 1 else math.inf
        else:
            cell = min(max(math.ceil(place - CORNER) - 1, 0), cells - 1)
            ahead = place - cell if cell > 0 else math.inf
        further_mm = min(further_mm, ahead * cell_mm)
        slope += table[row + 1, GAINS + cell]
    return slope, further_mm


@compiled
def advance_slope(
    table: Table, positions: Array, head_mm: float, lag_mm: float, direction: float
) -> float:
    """Slope of the tip when the head moves on from here in one direction."""
    slope, _ = _piece(table, positions, head_mm, direction, 0.0)
    return float(slope - _pull_mm(table, lag_mm, direction) / table[0, DECAY])


@compiled
def inverse_step(
    table: Table, positions: Array, head_mm: float, lag_mm: float, target_mm: float
) -> float:
    """Head move that brings the tip to a target: the shortest there is, signed mm; exact.

    positions, head_mm, lag_mm: where plays, head and slow state are now. A gap is crossed for the
    first target beyond it. The model must be one that can be driven (`play_lines.why_not_driven`).
    """
    missing_mm = target_mm - output_mm(table, positions, lag_mm)
    if not (missing_mm != 0.0 and math.isfinite(missing_mm)):
        return 0.0
    direction = math.copysign(1.0, missing_mm)
    needed_mm, travel_mm = abs(missing_mm), 0.0
    pull_mm, decay_mm = _pull_mm(table, lag_mm, direction), table[0, DECAY]
    for _ in range(positions.size * (_cells(table) + 1) + 1):
        slope, further_mm = _piece(table, positions, head_mm, direction, travel_mm)
        left = math.expm1(-further_mm / decay_mm) if pull_mm != 0.0 else 0.0
        gained_mm = pull_mm * left
        if slope > 0.0:
            gained_mm += slope * further_mm
        if gained_mm >= needed_mm and slope > 0.0:
            return direction * (travel_mm + _last_piece(slope, pull_mm, decay_mm, needed_mm))
        if further_mm == math.inf:
            break
        needed_mm -= gained_mm
        pull_mm *= 1.0 + left
        travel_mm += further_mm
    return 0.0


@compiled
def _last_piece(slope: float, pull_mm: float, decay_mm: float, needed_mm: float) -> float:
    """Travel along one piece that gains what is needed."""
    if pull_mm == 0.0:
        return needed_mm / slope
    bent = ModifiedDahl(slope, 0.0, 1.0 / decay_mm, 0.0)
    return modified_dahl.far_root_mm(bent, pull_mm, needed_mm)


@compiled
def turns_after_travel(direction: float, head_mm: float) -> Sixteen:
    """Turns of a head at the end of a long travel in one direction."""
    if direction > 0.0:
        return turning_point.AFTER_ADVANCE
    return turning_point.after_retract(head_mm)


@compiled
def simulate(table: Table, head_mm: Array) -> Array:
    """Tip positions for a record of head positions that begins after a long retract, shape (n,)."""
    tips_mm = np.empty(head_mm.size)
    here_mm, lag_mm = head_mm[0], float(table[0, DECAY])
    turns = turning_point.after_retract(here_mm)
    for k in range(head_mm.size):
        turns = turning_point.step(turns, here_mm, head_mm[k])
        lag_mm = step_lag(table, lag_mm, head_mm[k] - here_mm)
        here_mm = head_mm[k]
        tips_mm[k] = output_mm(table, positions_mm(table, turns, here_mm), lag_mm)
    return tips_mm


@compiled
def saturated_head_mm(table: Table, tip_mm: float, direction: float) -> float:
    """Head at the end of a long travel that brought the tip to a position.

    direction: of that travel, +1.0 towards the carina, -1.0 back.
    """
    lag_mm, reach_mm = -direction * table[0, DECAY], 1.0
    for _ in range(MOST_DOUBLINGS):
        start_mm = -direction * reach_mm
        positions = positions_mm(table, turns_after_travel(direction, start_mm), start_mm)
        if direction * (tip_mm - output_mm(table, positions, lag_mm)) >= 0.0:
            break
        reach_mm *= 2.0
    return float(start_mm + inverse_step(table, positions, start_mm, lag_mm, tip_mm))
