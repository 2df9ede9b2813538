"""Tables of a recording written for other programs: CSV by this one, Parquet by pyarrow.

Row after row, so that memory does not grow with the recording.
"""

import csv
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from opensuction.kernel.errors import InputError
from opensuction.recording.cycle_file.row_schema import SchemaColumn, Table

FORMATS = ("csv", "parquet")
TIME = SchemaColumn("time_s", float)
"""First column of every table: since the recording's beginning."""


class Sheet(NamedTuple):
    """A table that is being written."""

    path: Path
    add: Callable[[NDArray[np.float64], Table], None]
    """Takes times in s, and rows of the columns that are wanted."""
    close: Callable[[], None]


def _cells(kind: type, numbers: NDArray[np.float64]) -> list[str]:
    """Cells that give back the same numbers: whole ones and flags without a point."""
    if kind is float:
        return [repr(one) for one in numbers.tolist()]
    return [str(int(one)) for one in numbers.tolist()]


def _open_csv(path: Path, columns: Sequence[SchemaColumn]) -> Sheet:
    file = path.open("x", encoding="utf-8", newline="")
    kinds = [TIME.kind, *(column.kind for column in columns)]
    csv.writer(file).writerow([TIME.name, *(column.name for column in columns)])

    def add(times_s: NDArray[np.float64], table: Table) -> None:
        cells = [_cells(kind, one) for kind, one in zip(kinds, (times_s, *table.T), strict=True)]
        file.writelines(f"{','.join(row)}\n" for row in zip(*cells, strict=True))

    return Sheet(path, add, file.close)


def require_parquet(asked: str = "--format parquet", instead: str = "--format csv") -> Any:
    """Pyarrow. Raises InputError where it is not installed.

    asked, instead: the option that needs it, and the one that does not.
    """
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        raise InputError(
            f"{asked} needs pyarrow: pip install 'opensuction[parquet]', or take {instead}"
        ) from None
    return pyarrow


def _open_parquet(path: Path, columns: Sequence[SchemaColumn]) -> Sheet:
    pyarrow = require_parquet()
    kinds = {float: pyarrow.float64(), int: pyarrow.int64(), bool: pyarrow.bool_()}
    all_columns = [TIME, *columns]
    schema = pyarrow.schema([(column.name, kinds[column.kind]) for column in all_columns])
    writer = pyarrow.parquet.ParquetWriter(path, schema, compression="zstd")

    def add(times_s: NDArray[np.float64], table: Table) -> None:
        arrays = [
            pyarrow.array(numbers.astype(column.kind), kinds[column.kind])
            for column, numbers in zip(all_columns, (times_s, *table.T), strict=True)
        ]
        writer.write_table(pyarrow.Table.from_arrays(arrays, schema=schema))

    return Sheet(path, add, writer.close)


@contextmanager
def named(path: Path) -> Iterator[None]:
    """A failure to write names the file: it was opened before, and has no name of its own."""
    try:
        yield
    except OSError as error:
        raise OSError(error.errno, error.strerror, path.name) from None


def open_sheet(path: Path, columns: Sequence[SchemaColumn], form: str) -> Sheet:
    """A new table. form: of `FORMATS`. What it does raises OSError where it cannot be written."""
    with named(path):
        sheet = _open_parquet(path, columns) if form == "parquet" else _open_csv(path, columns)

    def add(times_s: NDArray[np.float64], table: Table) -> None:
        with named(path):
            sheet.add(times_s, table)

    def close() -> None:
        with named(path):
            sheet.close()

    return Sheet(path, add, close)
