"""NumPy archives (``.npz``): named arrays, each a column. Pickled objects are never loaded.

Parquet tables, read by pyarrow, which is an optional part: ``opensuction[parquet]``.

Only the columns that are wanted are read. Numbers of any kind become doubles; times that carry a
date or a duration become seconds.
"""

import zipfile
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from opensuction.kernel.errors import InputError
from opensuction.recording.array_column import (
    MOST_SAMPLES,
    check_finite,
    describe_excess,
    read_numbers,
)
from opensuction.recording.column_unit import seconds_in_name

PARQUET_TABLE_MAGIC = b"PAR1"
"""How a Parquet file begins."""

PER_SECOND = {"s": 1, "ms": 1_000, "us": 1_000_000, "ns": 1_000_000_000}
"""Ticks of Parquet's units of time."""


def _file(path: Path) -> Any:
    """The file, open; InputError where pyarrow is not installed or cannot make it out."""
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        raise InputError(
            f"{path}: is Parquet, which needs pyarrow: pip install 'opensuction[parquet]', or "
            "save the table as CSV"
        ) from None
    try:
        return pyarrow.parquet.ParquetFile(path)
    except pyarrow.ArrowInvalid:
        raise InputError(
            f"{path}: begins like Parquet and is damaged or incomplete; save it again"
        ) from None


def read_names_parquet_table(path: Path) -> tuple[str, ...]:
    """Names of the columns. Raises InputError for a damaged file and for too many rows."""
    with _file(path) as file:
        samples = file.metadata.num_rows
        if samples > MOST_SAMPLES:
            raise InputError(f"{path}: {describe_excess(samples)}")
        if samples == 0:
            raise InputError(f"{path}: has columns and no samples in them")
        return tuple(file.schema_arrow.names)


def read_columns_parquet_table(
    path: Path, wanted: Sequence[str], allow_missing: bool = False
) -> dict[str, NDArray[np.float64]]:
    """Numbers of the columns that are wanted; see `table.read_columns`."""
    import pyarrow

    with _file(path) as file:
        try:
            table = file.read(columns=list(wanted))
        except (pyarrow.ArrowException, OSError):
            raise InputError(f"{path}: is damaged or incomplete; save it again") from None
    return {name: _read_numbers(path, name, table.column(name), allow_missing) for name in wanted}


def _read_numbers(path: Path, name: str, column: Any, allow_missing: bool) -> NDArray[np.float64]:
    """One column as finite doubles, missing ones NaN where they are allowed."""
    import pyarrow
    import pyarrow.compute

    kind = column.type
    ticks = 1.0
    if pyarrow.types.is_timestamp(kind) or pyarrow.types.is_duration(kind):
        ticks = PER_SECOND[kind.unit] * seconds_in_name(name)
        column = column.cast(pyarrow.int64())
        if column.null_count < len(column):
            column = pyarrow.compute.subtract(column, column.drop_null()[0])
    elif not (
        pyarrow.types.is_integer(kind)
        or pyarrow.types.is_floating(kind)
        or pyarrow.types.is_decimal(kind)
    ):
        raise InputError(f"{path}: column {name!r} holds {kind}, should hold numbers")
    # Not safe, so that integers beyond 2**53 are rounded instead of refused.
    values = column.cast(pyarrow.float64(), safe=False).to_numpy(zero_copy_only=False)
    numbers: NDArray[np.float64] = np.ascontiguousarray(values, dtype=np.float64) / ticks
    check_finite(path, name, numbers, allow_missing)
    return numbers


NPZ_TABLE_MAGIC = b"PK\x03\x04"
"""How any zip archive begins."""
SUFFIX = ".npy"
WIDEST_BYTES = 16
"""Of a number, as NumPy stores the widest; what an array may take unpacked is known before."""
HEADING_BYTES = 65536

DAMAGED = (zipfile.BadZipFile, zlib.error, OSError, EOFError, KeyError, NotImplementedError)
"""What comes of an archive that is cut off, altered or packed in another way."""


def find_kind(path: Path) -> str:
    """Kind of a zip archive: ``npz`` if it holds arrays and nothing else, ``xlsx`` a workbook.

    Raises InputError for any other, with what would do.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            names = archive.namelist()
            kept = archive.read("mimetype") if "mimetype" in names else b""
    except (*DAMAGED, RuntimeError):  # raised for a password
        raise InputError(
            f"{path}: is a zip archive or a spreadsheet, damaged or incomplete; save it again"
        ) from None
    if names and all(name.endswith(SUFFIX) for name in names):
        return "npz"
    if "xl/workbook.xml" in names:
        return "xlsx"
    if b"opendocument" in kept or "xl/workbook.bin" in names:
        raise InputError(f"{path}: is a spreadsheet; save it as .xlsx, or export the sheet as CSV")
    raise InputError(f"{path}: is a zip archive; unpack it first, and give the file in it")


def read_names_npz_table(path: Path) -> tuple[str, ...]:
    """Names of the arrays."""
    with zipfile.ZipFile(path) as archive:
        return tuple(name.removesuffix(SUFFIX) for name in archive.namelist())


def read_columns_npz_table(
    path: Path, wanted: Sequence[str], allow_missing: bool = False
) -> dict[str, NDArray[np.float64]]:
    """Numbers of the columns that are wanted; see `table.read_columns`."""
    try:
        with np.load(path, allow_pickle=False) as archive:
            sizes = {one.filename: one.file_size for one in archive.zip.infolist()}
            values = {name: _read(path, name, archive, sizes) for name in wanted}
    except (*DAMAGED, MemoryError):  # an array that says it is larger than the memory
        raise InputError(f"{path}: is damaged or incomplete; save it again") from None
    return {name: read_numbers(path, name, row, allow_missing) for name, row in values.items()}


def _read(
    path: Path, name: str, archive: np.lib.npyio.NpzFile, sizes: dict[str, int]
) -> NDArray[np.generic]:
    size_bytes = sizes.get(f"{name}{SUFFIX}", 0)
    if size_bytes > WIDEST_BYTES * MOST_SAMPLES + HEADING_BYTES:
        raise InputError(f"{path}: {name!r} {describe_excess(size_bytes // WIDEST_BYTES)}")
    try:
        values: NDArray[np.generic] = archive[name]
    except ValueError as error:
        if "pickle" in str(error):
            raise InputError(
                f"{path}: {name!r} holds Python objects, whose loading could run code; save it "
                "as an array of numbers"
            ) from None
        raise InputError(f"{path}: {name!r} is damaged; save it again") from None
    return values
