"""The only place that flattens a record to columns.

Trace, recorder, replay and plots name a column by the dotted path of its field. The writer of a
record type is generated once as straight-line code: no loop over fields survives compilation.
"""

import keyword
from collections.abc import Callable, Iterable
from functools import cache
from typing import Annotated, Any, NamedTuple, get_args, get_origin, get_type_hints

import numpy as np
from annotated_types import Len

from opensuction.kernel.compiled import compiled_generated
from opensuction.kernel.record import Array

Row = Array
SCALARS = (float, int, bool)
SIZED = "Annotated[tuple[float, ...], Len(n, n)]"


def define(lines: Iterable[str], about: str, **scope: Any) -> Any:
    """The function that some lines of source define, compiled into whoever calls it.

    lines: of one ``def``. about: names the source in messages. scope: what the lines refer to.
    """
    names: dict[str, Any] = dict(scope)
    known = set(names)
    exec(compile("\n".join(lines) + "\n", f"<{about}>", "exec"), names)  # noqa: S102
    (name,) = set(names) - known - {"__builtins__"}
    return compiled_generated(names[name])


def _tuple_of(elements: Iterable[str]) -> str:
    """Source of a tuple of these elements."""
    return f"({', '.join(elements)},)"


class Column(NamedTuple):
    """One scalar of a record."""

    name: str
    """Dotted path; a number of a tuple has its place there as its name."""
    source: str
    """The same as an expression: ``plays_mm[3]``."""
    kind: type
    """``float``, ``int`` or ``bool``."""


def _length(kind: Any) -> int | None:
    """Length that a tuple field declares; None for what is no such field."""
    if get_origin(kind) is not Annotated or get_args(kind)[0] != tuple[float, ...]:
        return None
    lengths = [one for one in kind.__metadata__ if isinstance(one, Len)]
    if len(lengths) != 1 or lengths[0].min_length != lengths[0].max_length:
        return None
    return lengths[0].min_length


@cache
def _hints(record_type: type) -> dict[str, Any]:
    """Types of a record's fields by name: a sized tuple as it is declared, all else plain."""
    declared = get_type_hints(record_type, include_extras=True)
    plain = get_type_hints(record_type)
    return {
        name: kind if _length(kind) is not None else plain[name] for name, kind in declared.items()
    }


@cache
def layout(record_type: type) -> tuple[Column, ...]:
    """Every scalar in a record type, in order; arrays are left out.

    record_type: a NamedTuple whose fields are scalars, arrays, tuples that declare their length
    (`SIZED`) or NamedTuples of these. Raises TypeError for a field of any other type.
    """
    found: list[Column] = []
    for name, kind in _hints(record_type).items():
        length = _length(kind)
        if keyword.iskeyword(name):
            raise TypeError(f"{record_type.__name__}.{name} is a keyword")
        if kind in SCALARS:
            found.append(Column(name, name, kind))
        elif length is not None:
            found.extend(Column(f"{name}.{i}", f"{name}[{i}]", float) for i in range(length))
        elif hasattr(kind, "_fields"):
            inner = layout(kind)
            found.extend(Column(f"{name}.{i.name}", f"{name}.{i.source}", i.kind) for i in inner)
        elif get_origin(kind) is not np.ndarray:
            raise TypeError(
                f"{record_type.__name__}.{name} is {kind}: not a scalar, array, record, {SIZED}"
            )
    return tuple(found)


@cache
def columns(record_type: type) -> tuple[str, ...]:
    """Dotted paths of every scalar in a record type, in order; see `layout`."""
    return tuple(column.name for column in layout(record_type))


def _head(signature: str, record_type: type, size: int, *, checked: bool) -> list[str]:
    """First lines of a function with an argument ``row``, whose size it looks at or trusts."""
    if not checked:
        return [f"def {signature}:"]
    return [
        f"def {signature}:",
        f"    if row.size < {size}:",
        f"        raise IndexError('a row of {record_type.__name__} has {size} columns')",
    ]


def writer(record_type: type, *, checked: bool = True) -> Callable[[Row, Any], None]:
    """Compiled ``write(row, record)`` that puts every scalar of a record into its column.

    row: array of at least ``len(columns(record_type))`` numbers. checked: a shorter one is refused;
    else whoever calls it answers for that. What may raise keeps references counted, in every tick.
    """
    found = layout(record_type)
    lines = [
        *_head("write(row, record)", record_type, len(found), checked=checked),
        *(f"    row[{i}] = record.{column.source}" for i, column in enumerate(found)),
    ]
    write: Callable[[Row, Any], None] = define(lines, f"row of {record_type.__name__}")
    return write


def table_writer(record_type: type) -> Callable[[Array, int, Any], None]:
    """Compiled ``write(table, number, record)``, a `writer` for a row of a table.

    table: two-dimensional, a row with at least as many columns; neither that nor the number is
    checked here. A `writer` on ``table[number]`` would make a view in every tick: to count its
    references a processor waits until all that it has written before is in its caches.
    """
    found = layout(record_type)
    lines = [
        "def write(table, number, record):",
        *(f"    table[number, {i}] = record.{column.source}" for i, column in enumerate(found)),
    ]
    write: Callable[[Array, int, Any], None] = define(lines, f"table of {record_type.__name__}")
    return write


def _rebuilt(
    record_type: type,
    scope: dict[str, Any],
    first: int,
    at: str = "",
    arrays: list[str] | None = None,
) -> tuple[str, int]:
    """Source that builds a record from the columns from ``first`` on, and the column after it.

    at: what stands before a column's number. arrays: takes the names of arguments that hold the
    record's arrays; without it a record with one is refused.
    """
    constructor = f"record_{len(scope)}"
    scope[constructor] = record_type
    parts = []
    for name, kind in _hints(record_type).items():
        length = _length(kind)
        if kind is bool:
            parts.append(f"{name}=row[{at}{first}] != 0.0")
        elif kind is int:
            parts.append(f"{name}=int(row[{at}{first}])")
        elif kind is float:
            parts.append(f"{name}=row[{at}{first}]")
        elif length is not None:
            numbers = (f"row[{at}{first + i}]" for i in range(length))
            parts.append(f"{name}={_tuple_of(numbers)}")
            first += length
            continue
        elif hasattr(kind, "_fields"):
            inner, first = _rebuilt(kind, scope, first, at, arrays)
            parts.append(f"{name}={inner}")
            continue
        elif arrays is not None and get_origin(kind) is np.ndarray:
            arrays.append(f"array_{len(arrays)}")
            parts.append(f"{name}={arrays[-1]}")
            continue
        else:
            raise TypeError(f"{record_type.__name__}.{name} is {kind}: a row does not hold it")
        first += 1
    return f"{constructor}({', '.join(parts)})", first


def reader(record_type: type, *, checked: bool = True) -> Callable[[Row], Any]:
    """Compiled ``read(row)`` that gives the record that a `writer` put into a row.

    record_type, checked: as for `writer`, without arrays. Integers beyond 2**53 do not come back
    exactly.
    """
    scope: dict[str, Any] = {}
    built, size = _rebuilt(record_type, scope, 0)
    lines = [
        *_head("read(row)", record_type, size, checked=checked),
        f"    return {built}",
    ]
    read: Callable[[Row], Any] = define(lines, f"record {record_type.__name__}", **scope)
    return read


def reader_with_arrays(record_type: type) -> Callable[..., Any]:
    """Compiled ``read(row, *arrays)`` for a record that has arrays, too: they become its own.

    Unchecked, as for `reader`.
    """
    scope: dict[str, Any] = {}
    arrays: list[str] = []
    built, _ = _rebuilt(record_type, scope, 0, arrays=arrays)
    lines = [f"def read({', '.join(['row', *arrays])}):", f"    return {built}"]
    read: Callable[..., Any] = define(lines, f"record with arrays {record_type.__name__}", **scope)
    return read


def table_reader(record_type: type) -> Callable[[Array, int], Any]:
    """Compiled ``read(row, number)``: as a `reader`, from a row of a table, without a view.

    row: the table, unchecked as for a `table_writer`.
    """
    scope: dict[str, Any] = {}
    built, _ = _rebuilt(record_type, scope, 0, "number, ")
    lines = ["def read(row, number):", f"    return {built}"]
    read: Callable[[Array, int], Any] = define(
        lines, f"record in a table of {record_type.__name__}", **scope
    )
    return read
