"""Records to what JSON holds and back: every scalar under its dotted path, bit for bit.

JSON writes the shortest digits that read back as the same double; it has no word for the infinite,
which stands there as a text.
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from opensuction.kernel.codegen import plain_row, row
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Record

NOT_FINITE = {"inf": math.inf, "-inf": -math.inf, "nan": math.nan}
"""Texts that stand for numbers."""
LARGEST_WHOLE = 2**53
"""Of a whole number that a double holds exactly."""
NAMED = 3
"""How many fields a message names."""


def write(record_type: type, record: tuple[Any, ...]) -> dict[str, float | int | bool | str]:
    """Values of a record for JSON. Raises TypeError or ValueError as `plain_row.pack`."""
    values = plain_row.pack(record_type, record).tolist()
    columns = row.layout(record_type)
    return {column.name: _plain(column, one) for column, one in zip(columns, values, strict=True)}


def _plain(column: row.Column, value: float) -> float | int | bool | str:
    if column.kind is float and not math.isfinite(value):
        return str(value)
    plain: float | int | bool = column.kind(value)
    return plain


def read(record_type: type[Record], found: object, where: str) -> Record:
    """The record that `write` made this of.

    where: opens the message. Raises InputError for a field that is missing, not known, or of
    another kind.
    """
    if not isinstance(found, Mapping):
        raise InputError(f"{where} is no object of fields")
    columns = row.layout(record_type)
    names = [column.name for column in columns]
    _refuse(where, "not there", [name for name in names if name not in found])
    _refuse(where, "not known", [name for name in found if name not in set(names)])
    values = [_double(column, found[column.name], where) for column in columns]
    return plain_row.unpack(record_type, np.array(values))


def _refuse(where: str, problem: str, names: list[str]) -> None:
    if names:
        more = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
        raise InputError(f"{where}: {', '.join(map(repr, names[:NAMED]))}{more}: {problem}")


def _double(column: row.Column, value: object, where: str) -> float:
    """A scalar of JSON as a row has it."""
    if column.kind is float and isinstance(value, str) and value in NOT_FINITE:
        return NOT_FINITE[value]
    kinds = {float: (float, int), int: (int,), bool: (bool,)}[column.kind]
    fits = isinstance(value, kinds) and (column.kind is bool or not isinstance(value, bool))
    if not fits or (isinstance(value, int) and abs(value) > LARGEST_WHOLE):
        kind = {float: "a number", int: "a whole number", bool: "true or false"}[column.kind]
        raise InputError(f"{where}: {column.name} is {value!r:.60}: should be {kind}")
    return float(value)  # type: ignore[arg-type]
