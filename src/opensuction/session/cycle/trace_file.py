"""The time series of a run as a file of its own: CSV or Parquet, a row for each tick."""

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np

from opensuction.kernel.codegen import row
from opensuction.kernel.errors import InputError
from opensuction.recording.cycle_file import table_export
from opensuction.recording.cycle_file.row_schema import SchemaColumn
from opensuction.recording.cycle_file.table_export import FORMATS, TIME
from opensuction.simulation.closed_loop import TraceRow
from opensuction.simulation.trace import Columns

BLOCK_ROWS = 5000
"""Rows that are written at once."""

TABLE_COLUMNS = tuple(
    SchemaColumn(one.name, one.kind) for one in row.layout(TraceRow) if one.name != TIME.name
)
"""Columns beside the time, with what their numbers stand for."""


def _form(file: Path) -> str:
    return file.suffix.removeprefix(".")


def check(file: Path, force: bool) -> None:
    """Refuse a file that cannot be meant, before anything is played; raises InputError.

    force: a file that is there may be replaced.
    """
    if _form(file) not in FORMATS:
        raise InputError(
            f"--trace {file}: should end in {' or '.join(f'.{one}' for one in FORMATS)}"
        )
    if _form(file) == "parquet":
        table_export.require_parquet(f"--trace {file}", f"--trace {file.with_suffix('.csv')}")
    if file.is_dir():
        raise InputError(f"--trace {file}: this is a folder; name a file")
    if not file.parent.is_dir():
        raise InputError(f"--trace {file}: there is no folder {file.parent}; make it first")
    if file.exists() and not force:
        raise InputError(f"--trace {file}: is there already; name another one or add --force")


@contextmanager
def reserve(file: Path, force: bool) -> Iterator[None]:
    """A file of this name is this run's from now on: made empty, or there and to be replaced.

    One that was made here and is empty goes again on any exception. Raises InputError for a file
    that cannot be meant; OSError where none can be written there.
    """
    check(file, force)
    is_new = not file.exists()
    if is_new:
        try:
            file.touch(exist_ok=False)
        except FileExistsError:  # another command was faster
            check(file, force)
            is_new = False
    try:
        yield
    except BaseException:
        with suppress(OSError):
            if is_new and file.stat().st_size == 0:
                file.unlink()
        raise


@contextmanager
def place(file: Path) -> Iterator[Path]:
    """A file beside it to write into; it becomes ``file`` at the end, or vanishes.

    Raises OSError, with the file's name, where none can be written there.
    """
    try:
        folder = tempfile.TemporaryDirectory(prefix=f".{file.name}-", dir=file.parent)
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(file)) from None
    with folder:
        aside = Path(folder.name) / file.name
        yield aside
        aside.replace(file)


def fill(file: Path, columns: Columns) -> None:
    """Write a trace into a new file. Raises OSError, with its name, where it cannot be written."""
    sheet = table_export.open_sheet(file, TABLE_COLUMNS, _form(file))
    try:
        times_s = columns[TIME.name]
        for first in range(0, times_s.size, BLOCK_ROWS):
            piece = slice(first, first + BLOCK_ROWS)
            table = np.column_stack([columns[one.name][piece] for one in TABLE_COLUMNS])
            sheet.add(times_s[piece], table)
    finally:
        sheet.close()
