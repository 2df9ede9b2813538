"""A bank of plays, each read out by a line with corners: positions, places, sums of products.

Where a play stands says which two corners of its line count, and by how much: a sample touches two
numbers of a play, however many cells its line has. The sums of products that a least-squares fit
asks for are therefore gathered corner by corner and block by block, in one pass, and turned into
those of the cells (`to_cells`) afterwards: a cell's column is the sum of the corners behind it.
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
    """Where in its cells a play stands."""

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
) -> Array:
    """Sums of products of every two columns, block by block.

    heads_mm: every input, shape (inputs, n). positions_mm: plays before the first sample, shape
    (k,). others: columns of another kind, shape (c, n). edges: first sample of each block and the
    end, shape (b + 1,). Columns: the corners of every play (a play of m cells has m + 1), then the
    others. Returns shape (b, columns, columns).
    """
    rows, extra = bank.widths_mm.size, others.shape[0]
    firsts = np.zeros(rows + 1, dtype=np.int64)
    for row in range(rows):
        firsts[row + 1] = firsts[row] + bank.cells[row] + 1
    size = firsts[rows] + extra
    sums = np.zeros((edges.size - 1, size, size))
    positions = positions_mm.copy()
    places = np.empty(2 * rows + extra, dtype=np.int64)
    values = np.empty(places.size)
    for j in range(extra):
        places[2 * rows + j] = firsts[rows] + j
    for block in range(edges.size - 1):
        for k in range(edges[block], edges[block + 1]):
            for row in range(rows):
                head_mm = heads_mm[bank.inputs[row], k]
                positions[row] = play.step(bank.widths_mm[row], positions[row], head_mm)
                placed = find_place(bank, row, positions[row])
                places[2 * row] = firsts[row] + placed.cell
                places[2 * row + 1] = firsts[row] + placed.cell + 1
                values[2 * row] = 1.0 - placed.share
                values[2 * row + 1] = placed.share
            for j in range(extra):
                values[2 * rows + j] = others[j, k]
            _add_products(sums, block, places, values)
    return sums + _mirror(sums)


@compiled
def _add_products(sums: Array, block: int, places: NDArray[np.int64], values: Array) -> None:
    """Add the products of one sample to the upper triangle of its block."""
    for i in range(places.size):
        for j in range(i, places.size):
            sums[block, places[i], places[j]] += values[i] * values[j]


@compiled
def _mirror(sums: Array) -> Array:
    """The lower triangle of every block, from its upper one; the diagonal 0."""
    lower = np.zeros(sums.shape)
    blocks, size, _ = sums.shape
    for block in range(blocks):
        for i in range(size):
            for j in range(i):
                lower[block, i, j] = sums[block, j, i]
    return lower


@compiled
def _gather(bank: PlayBank, sums: Array, cells: Array) -> None:
    """Fill one block's sums of cells, row by row, from those of its corners.

    Cells run from the last to the first of a play: each is the one behind it and a corner more.
    """
    size = sums.shape[1]
    first_corner, first_cell = 0, 0
    for play_row in range(bank.cells.size):
        count = bank.cells[play_row]
        for cell in range(count - 1, -1, -1):
            for j in range(size):
                behind = cells[first_cell + cell + 1, j] if cell < count - 1 else 0.0
                cells[first_cell + cell, j] = behind + sums[first_corner + cell + 1, j]
        first_corner += count + 1
        first_cell += count
    for k in range(cells.shape[0] - first_cell):
        for j in range(size):
            cells[first_cell + k, j] = sums[first_corner + k, j]


@compiled
def to_cells(bank: PlayBank, sums: Array) -> Array:
    """Sums of products of the cells' columns from those of the corners.

    sums: as `sum_products` returns them. The column of a cell is the share of it that lies behind
    the play, from 0 to 1: the sum of the corners behind it. Returns shape (b, columns, columns)
    with one column less for each play.
    """
    blocks, size, _ = sums.shape
    fewer = size - bank.cells.size
    half, turned = np.empty((fewer, size)), np.empty((size, fewer))
    cells = np.empty((blocks, fewer, fewer))
    for block in range(blocks):
        _gather(bank, sums[block], half)
        for i in range(fewer):
            for j in range(size):
                turned[j, i] = half[i, j]
        _gather(bank, turned, cells[block])  # symmetric: its rows are its columns
    return cells


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
