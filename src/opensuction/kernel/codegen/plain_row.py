"""Records to rows and back in plain Python, for what is not done each tick: nothing is compiled.

A compiled `row.writer` that Python calls would be compiled with all that takes the record apart.

Records to what JSON holds and back: every scalar under its dotted path, bit for bit.

JSON writes the shortest digits that read back as the same double; it has no word for the infinite,
which stands there as a text.
"""

import math
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any

import numpy as np

from opensuction.kernel.codegen import row
from opensuction.kernel.compiled import as_python
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array, Record

_reader = cache(row.reader)


def numbers(record: tuple[Any, ...]) -> Iterator[Any]:
    """Every scalar of a record, in the order of `row.columns`; arrays are left out."""
    for value in record:
        if isinstance(value, tuple):
            yield from numbers(value)
        elif not isinstance(value, np.ndarray):
            yield value


def arrays(record: tuple[Any, ...]) -> Iterator[Array]:
    """Every array of a record, in the order in which `row.reader_with_arrays` takes them."""
    for value in record:
        if isinstance(value, tuple):
            yield from arrays(value)
        elif isinstance(value, np.ndarray):
            yield value


def pack(record_type: type, record: tuple[Any, ...]) -> row.Row:
    """A new row that holds a record.

    record: numbers of any kind that stand for those that are declared, such as 30 for 30.0.
    Raises TypeError or ValueError, with the field's name, for one that the row would not give back.
    """
    columns, found = row.layout(record_type), list(numbers(record))
    if len(found) != len(columns):
        raise TypeError(f"{record_type.__name__} is {len(columns)} numbers, not {len(found)}")
    return np.array([_double(*pair) for pair in zip(columns, found, strict=True)], dtype=np.float64)


def _double(column: row.Column, value: Any) -> float:
    """A scalar as a row has it."""
    try:
        if isinstance(value, str):  # float would read it
            raise TypeError
        double = float(value)
        same = column.kind is float or column.kind(double) == value
    except (TypeError, ValueError, OverflowError) as problem:
        raise TypeError(f"{column.name} is {value!r}, no {column.kind.__name__}") from problem
    if not same:
        raise ValueError(f"{column.name} is {value!r}, no {column.kind.__name__} that a row holds")
    return double


def unpack(record_type: type[Record], values: row.Row) -> Record:
    """The record in a row, of Python's own numbers.

    Raises IndexError for a row that is too short, ValueError for nan where it should be whole.
    """
    read: Any = _reader(record_type, checked=False)
    record: Record = as_python(read)(values.tolist())
    return record


NOT_FINITE = {"inf": math.inf, "-inf": -math.inf, "nan": math.nan}
"""Texts that stand for numbers."""
LARGEST_WHOLE = 2**53
"""Of a whole number that a double holds exactly."""
NAMED = 3
"""How many fields a message names."""


def write(record_type: type, record: tuple[Any, ...]) -> dict[str, float | int | bool | str]:
    """Values of a record for JSON. Raises TypeError or ValueError as `plain_row.pack`."""
    values = pack(record_type, record).tolist()
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
    values = [_plain_double(column, found[column.name], where) for column in columns]
    return unpack(record_type, np.array(values))


def _refuse(where: str, problem: str, names: list[str]) -> None:
    if names:
        more = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
        raise InputError(f"{where}: {', '.join(map(repr, names[:NAMED]))}{more}: {problem}")


def _plain_double(column: row.Column, value: object, where: str) -> float:
    """A scalar of JSON as a row has it."""
    if column.kind is float and isinstance(value, str) and value in NOT_FINITE:
        return NOT_FINITE[value]
    kinds = {float: (float, int), int: (int,), bool: (bool,)}[column.kind]
    fits = isinstance(value, kinds) and (column.kind is bool or not isinstance(value, bool))
    if not fits or (isinstance(value, int) and abs(value) > LARGEST_WHOLE):
        kind = {float: "a number", int: "a whole number", bool: "true or false"}[column.kind]
        raise InputError(f"{where}: {column.name} is {value!r:.60}: should be {kind}")
    return float(value)  # type: ignore[arg-type]
