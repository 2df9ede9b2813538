"""Parquet tables, read by pyarrow, which is an optional part: ``opensuction[parquet]``.

Only the columns that are wanted are read. Numbers of any kind become doubles; times that carry a
date or a duration become seconds.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from opensuction.kernel.errors import InputError
from opensuction.recording.array_column import check_finite
from opensuction.recording.bound import MOST_SAMPLES, describe_excess

MAGIC = b"PAR1"
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


def read_names(path: Path) -> tuple[str, ...]:
    """Names of the columns. Raises InputError for a damaged file and for too many rows."""
    with _file(path) as file:
        samples = file.metadata.num_rows
        if samples > MOST_SAMPLES:
            raise InputError(f"{path}: {describe_excess(samples)}")
        if samples == 0:
            raise InputError(f"{path}: has columns and no samples in them")
        return tuple(file.schema_arrow.names)


def read_columns(
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
    ticks = 1
    if pyarrow.types.is_timestamp(kind) or pyarrow.types.is_duration(kind):
        ticks = PER_SECOND[kind.unit]
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
