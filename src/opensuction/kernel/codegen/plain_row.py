"""Records to rows and back in plain Python, for what is not done each tick: nothing is compiled.

A compiled `row.writer` that Python calls would be compiled with all that takes the record apart.
"""

from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np

from opensuction.kernel.codegen import row
from opensuction.kernel.compiled import as_python
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
