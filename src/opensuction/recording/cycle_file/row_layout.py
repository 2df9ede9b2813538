"""Rows of doubles as protobuf messages of one length, many at once.

Every field is written, zero or not, and has a fixed length: so each number has its place, and a
table is packed and read with one assignment for each run of neighbours. Message by message it would
take a hundred times as long.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from opensuction.recording.cycle_file.row_schema import KINDS, SchemaColumn, Tree, tree_of

Bytes = NDArray[np.uint8]
Table = NDArray[np.float64]

FIXED, VARINT, LENGTH = 1, 0, 2
"""Protobuf's wire types that are used."""
FORMATS: dict[type, str] = {float: "<f8", int: "<i8", bool: "u1"}


class _Run(NamedTuple):
    """Columns of one kind whose places follow each other at one distance."""

    kind: type
    first: int
    """Column."""
    length: int
    at: int
    """Place of the first number."""
    step: int


class Layout(NamedTuple):
    """Layout of a row's numbers in a message."""

    columns: tuple[SchemaColumn, ...]
    template: Bytes
    """A row of zeros."""
    runs: tuple[_Run, ...]
    is_number: NDArray[np.bool_]
    """Of each byte: it belongs to a number, and is no part of the description."""

    @property
    def size(self) -> int:
        """Bytes of a message."""
        return self.template.size


def _varint(value: int) -> bytes:
    out = bytearray()
    while value > 0x7F:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes((*out, value))


def _place(node: Tree, columns: Sequence[SchemaColumn], places: dict[int, int], at: int) -> bytes:
    """A message of zeros. places: taken down for each column, from ``at`` on."""
    out = bytearray()
    for number, child in enumerate(node.values(), start=1):
        if isinstance(child, dict):
            # Its length stands before it and moves it: known from a first, idle placing.
            size = len(_place(child, columns, {}, 0))
            out += _varint(number << 3 | LENGTH) + _varint(size)
            out += _place(child, columns, places, at + len(out))
            continue
        narrow = columns[child].kind is bool
        out += _varint(number << 3 | (VARINT if narrow else FIXED))
        places[child] = at + len(out)
        out += bytes(1 if narrow else 8)
    return bytes(out)


def layout_of(columns: Sequence[SchemaColumn]) -> Layout:
    """Layout of the message that `row_schema.describe` describes."""
    for column in columns:
        if column.kind not in KINDS:
            raise ValueError(f"column {column.name} is {column.kind}")
    places: dict[int, int] = {}
    template = _place(tree_of(columns), columns, places, 0)
    runs: list[_Run] = []
    for index, column in enumerate(columns):
        last = runs[-1] if runs else None
        if last is not None and last.kind is column.kind:
            step = last.step or places[index] - last.at
            if step > 0 and last.at + last.length * step == places[index]:
                runs[-1] = last._replace(length=last.length + 1, step=step)
                continue
        runs.append(_Run(column.kind, index, 1, places[index], 0))
    is_number = np.zeros(len(template), np.bool_)
    for index, column in enumerate(columns):
        is_number[places[index] : places[index] + (1 if column.kind is bool else 8)] = True
    return Layout(tuple(columns), np.frombuffer(template, np.uint8), tuple(runs), is_number)


def _view(run: _Run, rows: Bytes, at: int) -> NDArray[np.generic]:
    """The numbers of a run in some rows, at a place."""
    return np.ndarray(
        (len(rows), run.length),
        FORMATS[run.kind],
        buffer=rows,
        offset=at + run.at,
        strides=(rows.strides[0], run.step),
    )


def pack(layout: Layout, table: Table, rows: Bytes, at: int) -> None:
    """Write the messages of a table's rows.

    table: shape (rows, columns). rows: written; shape (rows, bytes), contiguous, the message of a
    row from the byte ``at`` on.
    """
    rows[:, at : at + layout.size] = layout.template
    for run in layout.runs:
        numbers = table[:, run.first : run.first + run.length]
        if run.kind is bool:
            numbers = numbers != 0.0
        _view(run, rows, at)[:] = numbers


def unpack(layout: Layout, rows: Bytes, at: int) -> Table:
    """The table that `pack` wrote. Raises ValueError for rows of another layout."""
    described = (rows[0, at : at + layout.size] == layout.template) | layout.is_number
    if not described.all():
        raise ValueError("a row is not laid out as its description says")
    table = np.empty((len(rows), len(layout.columns)))
    for run in layout.runs:
        table[:, run.first : run.first + run.length] = _view(run, rows, at)
    return table
