"""A bank of plays, each read out by a line with corners: positions, places, sums of products.

Where a play stands says which two corners of its line count, and by how much: a sample touches two
numbers of a play, however many cells its line has. The sums of products that a least-squares fit
asks for are therefore gathered corner by corner and block by block, in one pass, and turned into
those of the cells afterwards: a cell's column is the sum of the corners behind it.
Where many samples in a row find every play in the same cell, their products are summed in a small
square first.
Source: [Krasnoselskii-1989] for the plays; [Brokate-1996] ch. 2 for a Preisach triangle as rows of
such plays.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from opensuction.hysteresis import play
from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import Array


class PlayBank(NamedTuple):
    """Plays and the cells that their positions are cut into."""

    widths_mm: Array
    """Full width of each play, at least 0; shape (k,)."""
    lows_mm: Array
    """Position at which the first cell of each begins; shape (k,)."""
    cell_mm: float
    """Length of a cell, the same for all, above 0."""
    cells: NDArray[np.int64]
    """How many cells each play has, at least 1; shape (k,)."""
    inputs: NDArray[np.int64]
    """Which of several inputs moves each play; shape (k,)."""
    goes_on: bool
    """Whether the first and the last cell reach on beyond their ends; else the line is level
    there."""


class Placed(NamedTuple):
    """Place of a play in its cells."""

    cell: int
    share: float
    """Of that cell that lies behind it: from 0 to 1, beyond where the bank `goes_on`."""


@compiled
def find_place(bank: PlayBank, row: int, position_mm: float) -> Placed:
    """Cell and share for a position of one play."""
    last = bank.cells[row] - 1
    place = (position_mm - bank.lows_mm[row]) / bank.cell_mm
    cell = min(max(int(np.floor(place)), 0), last)
    share = place - cell
    if not bank.goes_on:
        share = min(max(share, 0.0), 1.0)
    return Placed(cell, share)


@compiled
def sum_products(
    bank: PlayBank,
    heads_mm: Array,
    positions_mm: Array,
    others: Array,
    edges: NDArray[np.int64],
    every: int,
) -> Array:
    """Sums of products of every two columns, block by block.

    heads_mm: every input, shape (inputs, n). positions_mm: plays before the first sample, shape
    (k,). others: columns of another kind, shape (c, n). edges: first sample of each block and the
    end, shape (b + 1,). every: which samples count, 1 for all; the plays see each. Columns: the
    cells of every play, of each the share that lies behind the play, from 0 to 1; then the others.
    Returns shape (b, columns, columns).
    """
    rows, extra = bank.widths_mm.size, others.shape[0]
    places, values = np.empty(2 * rows + extra, dtype=np.int64), np.empty(2 * rows + extra)
    first = 0
    for row in range(rows):
        places[2 * row], places[2 * row + 1] = first, first + 1
        first += bank.cells[row] + 1
    for j in range(extra):
        places[2 * rows + j] = first + j
    positions, run = positions_mm.copy(), np.zeros((values.size, values.size))
    corners = np.zeros((first + extra, first + extra))
    sums = np.zeros((edges.size - 1, first - rows + extra, first - rows + extra))
    for block in range(edges.size - 1):
        for k in range(edges[block], edges[block + 1]):
            for row in range(rows):
                head_mm = heads_mm[bank.inputs[row], k]
                positions[row] = play.step(bank.widths_mm[row], positions[row], head_mm)
            if k % every == 0:
                first = 0
                moved = False
                for row in range(rows):
                    placed = find_place(bank, row, positions[row])
                    values[2 * row], values[2 * row + 1] = 1.0 - placed.share, placed.share
                    moved = moved or places[2 * row] != first + placed.cell
                    first += bank.cells[row] + 1
                if moved:
                    _end_run(corners, places, run)
                    _place(bank, positions, places)
                values[2 * rows :] = others[:, k]
                _add_to_run(run, values)
        _end_run(corners, places, run)
        _to_cells(bank, corners, sums[block])
        corners[:] = 0.0
    return sums


@compiled
def _place(bank: PlayBank, positions_mm: Array, places: NDArray[np.int64]) -> None:
    """Set the two corners between which each play stands. places: shape (2 k + others,)."""
    first = 0
    for row in range(positions_mm.size):
        corner = first + find_place(bank, row, positions_mm[row]).cell
        places[2 * row], places[2 * row + 1] = corner, corner + 1
        first += bank.cells[row] + 1


@compiled
def _add_to_run(run: Array, values: Array) -> None:
    """Add the products of one sample to those of a run of samples in the same cells."""
    for i in range(values.size):
        one = values[i]
        if one != 0.0:
            for j in range(i, values.size):
                run[i, j] += one * values[j]


@compiled
def _end_run(corners: Array, places: NDArray[np.int64], run: Array) -> None:
    """Add the products of a run to the upper triangle of its block, and empty it."""
    for i in range(places.size):
        for j in range(i, places.size):
            corners[places[i], places[j]] += run[i, j]
            run[i, j] = 0.0


@compiled
def add_products(sums: Array, block: int, places: NDArray[np.int64], values: Array) -> None:
    """Add the products of one sample to the upper triangle of its block."""
    for i in range(places.size):
        for j in range(i, places.size):
            sums[block, places[i], places[j]] += values[i] * values[j]


@compiled
def mirror(sums: Array) -> None:
    """Fill the lower triangle from the upper one; sums: shape (k, k)."""
    for i in range(sums.shape[0]):
        for j in range(i):
            sums[i, j] = sums[j, i]


@compiled
def _add_up(bank: PlayBank, line: Array, cells: Array) -> None:
    """Sums of cells from those of corners: each is the one behind it and a corner more.

    line: of the corners and the others; cells: filled, shorter by one for each play.
    """
    corner, cell = 0, 0
    for count in bank.cells:
        behind = 0.0
        for k in range(count - 1, -1, -1):
            behind += line[corner + k + 1]
            cells[cell + k] = behind
        corner += count + 1
        cell += count
    for k in range(cells.size - cell):
        cells[cell + k] = line[corner + k]


@compiled
def _to_cells(bank: PlayBank, corners: Array, cells: Array) -> None:
    """Sums of products of cells, from those of corners, of which only the upper triangle is given.

    corners: the rest of it is filled; cells: filled, shorter by one each way for each play.
    """
    mirror(corners)
    corner, cell = 0, 0
    for count in bank.cells:
        line = np.zeros(corners.shape[0])
        for k in range(count - 1, -1, -1):
            for j in range(line.size):
                line[j] += corners[corner + k + 1, j]
            _add_up(bank, line, cells[cell + k])
        corner += count + 1
        cell += count
    for k in range(cells.shape[0] - cell):
        _add_up(bank, corners[corner + k], cells[cell + k])


@compiled
def basis(bank: PlayBank, head_mm: Array, positions_mm: Array) -> Array:
    """Columns of the cells for a record of inputs: the share of each behind its play.

    head_mm: shape (n,); positions_mm: plays before the first sample, shape (k,). Returns shape
    (n, cells of all plays).
    """
    positions = positions_mm.copy()
    columns = np.zeros((head_mm.size, bank.cells.sum()))
    for k in range(head_mm.size):
        first = 0
        for row in range(positions.size):
            positions[row] = play.step(bank.widths_mm[row], positions[row], head_mm[k])
            placed = find_place(bank, row, positions[row])
            for cell in range(placed.cell):
                columns[k, first + cell] = 1.0
            columns[k, first + placed.cell] = placed.share
            first += bank.cells[row]
    return columns
