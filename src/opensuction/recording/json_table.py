"""JSON: records, rows or columns of numbers, or lines that are a record each.

What is no table itself may hold one under a key, as an answer of a web service does; so may the
``split`` and ``columns`` of pandas. Text that is a number or a date is read as in other tables.
"""

import json
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from opensuction.kernel.errors import InputError
from opensuction.recording.array_column import check_finite, check_shape, megabytes
from opensuction.recording.column_unit import seconds_in_name
from opensuction.recording.instant import is_instant, read_instant
from opensuction.recording.text_layout import SHOWN, is_missing, name_columns

BEGINNING = re.compile(rb"(\xef\xbb\xbf)?\s*(\{|\[\s*([\[{\"]|\]|[-+.\deE]+\s*,))")
"""How JSON begins, and no header of a text table."""
LARGEST_BYTES = 200_000_000
"""All of it is held in memory, where it takes ten times as much."""
REMEDY = (
    'give records, as in [{"t_s": 0, "head_mm": 1.5}, ...], or columns, as in {"t_s": [0, ...], '
    '"head_mm": [1.5, ...]}'
)
LARGEST_NUMBER = 1e308
"""JSON's whole numbers have no bound."""
SPLIT = {"columns", "data"}
"""Keys by which pandas writes names and rows apart."""

Columns = dict[str, list[Any]]


class JsonTable(NamedTuple):
    """A table with the cells of its columns."""

    names: tuple[str, ...]
    cells: tuple[list[Any], ...]
    """Of each column, as they are written."""
    note: str
    """What a person should know of where it was found."""


def read_table(path: Path) -> JsonTable:
    """The table in a file. Raises InputError for what is no JSON, and for JSON without a table."""
    size_bytes = path.stat().st_size
    if size_bytes > LARGEST_BYTES:
        raise InputError(
            f"{path}: is {megabytes(size_bytes)} MB, above the limit of "
            f"{megabytes(LARGEST_BYTES)} MB for JSON; save it as CSV or Parquet"
        )
    content = path.read_bytes()
    try:
        text = content.decode(json.detect_encoding(content))
    except UnicodeDecodeError:
        raise InputError(f"{path}: is JSON and not UTF-8; save it as UTF-8") from None
    found = _parse(path, text)
    columns, note = _find_columns(found), ""
    if isinstance(found, dict) and len(columns or ()) < 2:
        inner = {key: table for key, one in found.items() if (table := _find_columns(one))}
        if len(inner) > 1:
            raise InputError(
                f"{path}: holds a table under each of {', '.join(map(repr, inner))}; save one of "
                "them in a file of its own"
            )
        if inner:
            ((key, columns),) = inner.items()
            note = f"its columns are read from {key!r}"
    if not columns:
        raise InputError(f"{path}: is JSON without a table of numbers; {REMEDY}")
    # Half of a letter of UTF-16 can be written in JSON, and nowhere else.
    names = [key.encode(errors="replace").decode() for key in columns]
    return JsonTable(name_columns(names, len(names)), tuple(columns.values()), note)


def read_columns(
    path: Path, wanted: Sequence[str], allow_missing: bool, table: JsonTable
) -> dict[str, NDArray[np.float64]]:
    """Numbers of the columns that are wanted; see `table.read_columns`."""
    found = {}
    for name in wanted:
        cells = table.cells[table.names.index(name)]
        check_shape(path, name, (len(cells),))
        numbers = np.array(
            [_read_cell(path, name, row, cell) for row, cell in enumerate(cells, start=1)]
        )
        check_finite(path, name, numbers, allow_missing)
        found[name] = numbers
    return found


def _parse(path: Path, text: str) -> Any:
    """All of a text, or each of its lines, as JSON. Raises InputError where neither is."""
    try:
        return json.loads(text.removeprefix("\ufeff"))
    except (ValueError, RecursionError) as error:
        whole = error
    records = []
    for number, line in enumerate(text.split("\n"), start=1):
        if not line.strip():
            continue
        try:
            records.append(json.loads(line))
        except (ValueError, RecursionError) as error:
            first = whole if not records else error
            place = getattr(first, "lineno", 1) if not records else number
            why = getattr(first, "msg", "nested too deep, or a number too long")
            raise InputError(
                f"{path}: line {place}: is damaged or incomplete JSON ({why}); save it again"
            ) from None
    return records


def _find_columns(found: Any) -> Columns | None:
    """Cells by column of what is a table of numbers, None of anything else."""
    columns: Columns | None = None
    if isinstance(found, list) and len(found) == 1 and isinstance(found[0], dict):
        columns = _find_columns(found[0])
    elif _is_list_of(dict, found):
        columns = _join_records(found)
    elif _is_list_of(list, found):
        named = all(isinstance(cell, str) for cell in found[0])
        columns = _join_rows(found[0] if named else [], found[named:])
    elif isinstance(found, dict) and found.keys() >= SPLIT and _is_list_of(list, found["data"]):
        names = found["columns"] if isinstance(found["columns"], list) else []
        columns = _join_rows([*map(str, names)], found["data"])
    elif isinstance(found, dict):
        columns = {key: cells for key, cells in found.items() if _is_list_of_cells(cells)}
        if not columns and _are_indexed([*found.values()]):
            if all(map(str.isdecimal, found)):  # written row by row
                return _find_columns([*found.values()])
            columns = {key: [*cells.values()] for key, cells in found.items()}
    return columns if columns and any(map(_has_numbers, columns.values())) else None


def _is_list_of(kind: type, found: Any) -> bool:
    return isinstance(found, list) and bool(found) and all(isinstance(one, kind) for one in found)


def _is_list_of_cells(found: Any) -> bool:
    return isinstance(found, list) and not any(isinstance(one, list | dict) for one in found)


def _are_indexed(columns: Sequence[Any]) -> bool:
    """True for columns whose cells stand under the same keys, as pandas writes a data frame."""
    return (
        _is_list_of(dict, columns)
        and all(one.keys() == columns[0].keys() for one in columns)
        and all(_is_list_of_cells([*one.values()]) for one in columns)
    )


def _has_numbers(cells: Iterable[Any]) -> bool:
    return any(
        (isinstance(cell, int | float) and not isinstance(cell, bool))
        or (isinstance(cell, str) and _read_text("", cell) is not None)
        for cell in cells
    )


def _join_records(records: Sequence[dict[str, Any]]) -> Columns:
    """Columns of records, those of a record in a record as ``outer.inner``; lacking ones None."""
    flat = []
    for record in records:
        cells: dict[str, Any] = {}
        for key, cell in record.items():
            inner = cell.items() if isinstance(cell, dict) else ()
            cells.update({f"{key}.{name}": one for name, one in inner} if inner else {key: cell})
        flat.append(cells)
    names = dict.fromkeys(name for cells in flat for name in cells)
    return {name: [cells.get(name) for cells in flat] for name in names}


def _join_rows(names: Sequence[str], rows: Sequence[list[Any]]) -> Columns | None:
    """Columns of rows that are as long as one another, called by number without names."""
    width = len(rows[0]) if rows else 0
    if any(len(row) != width for row in rows) or len(names) not in (0, width):
        return None
    called = name_columns(names, width)
    return dict(zip(called, map(list, zip(*rows, strict=True)), strict=True))


def _read_text(name: str, cell: str) -> float | None:
    """Number of a cell that is text: NaN of a missing one, None of what is no number."""
    if is_missing(cell):
        return np.nan
    try:
        if is_instant(cell):
            return read_instant(cell) / seconds_in_name(name)
        return float(cell) if "_" not in cell else None
    except (ValueError, OverflowError):
        return None


def _read_cell(path: Path, name: str, row: int, cell: Any) -> float:
    """Number of a cell, NaN of a missing one. Raises InputError for what is no number."""
    number: float | None = None
    if cell is None:
        return np.nan
    if isinstance(cell, str):
        number = _read_text(name, cell)
    elif isinstance(cell, int | float) and not isinstance(cell, bool):
        number = float(cell) if cell != cell or abs(cell) < LARGEST_NUMBER else None
    if number is None:
        shown = json.dumps(cell, ensure_ascii=False)[:SHOWN]
        raise InputError(f"{path}: row {row}, column {name!r}: {shown} is not a finite number")
    return number
