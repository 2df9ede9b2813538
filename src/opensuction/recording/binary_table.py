"""MATLAB files: variables that are rows or columns of numbers, each a column of the recording.

A matrix gives its columns by MATLAB's own names, ``x(:,1)``, or its rows where these are longer.
Versions 5 to 7 are read by SciPy, version 7.3, which is HDF5, by h5py, an optional part:
``opensuction[matlab]``. Structures, cells and tables are refused with what would do.

NumPy archives (``.npz``): named arrays, each a column. Pickled objects are never loaded.

Parquet tables, read by pyarrow, which is an optional part: ``opensuction[parquet]``.

Only the columns that are wanted are read. Numbers of any kind become doubles; times that carry a
date or a duration become seconds.
"""

import zipfile
import zlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from opensuction.kernel.errors import InputError
from opensuction.recording.array_column import (
    MOST_SAMPLES,
    check_finite,
    check_shape,
    describe_excess,
    is_row,
    read_numbers,
    write_shape,
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


MAGIC = b"MATLAB 5.0"
MAGIC_73 = b"MATLAB 7.3"
"""How MATLAB's files begin, the first of versions 5 to 7."""

NUMERIC = frozenset(
    (
        *("double", "single", "logical"),
        *(f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)),
    )
)
"""Classes of variables whose values are numbers."""
MOST_PARTS = 100
"""Columns of a matrix that holds signals; one with more is a picture or a table of another kind."""


class _Variable(NamedTuple):
    """A variable of a file, its values not yet read."""

    name: str
    shape: tuple[int, ...]
    kind: str
    """MATLAB's class."""


def _name_parts(one: _Variable) -> list[str]:
    """Names of what is read of a variable: of itself, or of a matrix the columns or the rows."""
    if one.kind not in NUMERIC or len(one.shape) != 2 or is_row(one.shape):
        return [one.name]
    rows, columns = one.shape
    if rows == columns or min(one.shape) > MOST_PARTS:
        return [one.name]
    places = range(1, min(one.shape) + 1)
    return [f"{one.name}(:,{at})" if rows > columns else f"{one.name}({at},:)" for at in places]


def _read_part(
    path: Path, name: str, variables: Sequence[_Variable], load: Callable[[str], NDArray[Any]]
) -> NDArray[Any]:
    """Values of a variable, or of a part of it, as `_name_parts` calls it; raises InputError."""
    for one in variables:
        parts = _name_parts(one)
        if name in parts and len(parts) > 1:
            values, place = load(one.name), parts.index(name)
            return values[:, place] if one.shape[0] > one.shape[1] else values[place]
    _check(path, name, variables)
    return load(name)


def _remedy(path: Path) -> str:
    return (
        "in MATLAB, give each column a name of its own and save them: x = data.x; "
        f"save('{path.name}', 'x', 'y')"
    )


@contextmanager
def _whole(path: Path) -> Iterator[None]:
    """Whatever a reader raises in here says that the file is damaged."""
    try:
        yield
    except InputError:
        raise
    except Exception:  # both readers raise almost anything for bytes that are not what they seem
        raise InputError(f"{path}: is a damaged or incomplete MATLAB file; save it again") from None


def _list(variables: Sequence[_Variable]) -> str:
    return ", ".join(f"{one.name} ({write_shape(one.shape)} {one.kind})" for one in variables)


def _names(path: Path, variables: Sequence[_Variable]) -> tuple[str, ...]:
    """Names of all variables. Raises InputError where none is a row of numbers."""
    parts = [_name_parts(one) for one in variables]
    if not any(
        len(names) > 1 or (one.kind in NUMERIC and is_row(one.shape))
        for names, one in zip(parts, variables, strict=True)
    ):
        held = f"holds {_list(variables)}" if variables else "holds no variables"
        raise InputError(f"{path}: {held}, no row or column of numbers; {_remedy(path)}")
    return tuple(name for names in parts for name in names)


def _check(path: Path, name: str, variables: Sequence[_Variable]) -> None:
    """Refuse a variable that is no row of numbers; raises InputError."""
    one = next(one for one in variables if one.name == name)
    if one.kind not in NUMERIC:
        raise InputError(
            f"{path}: {name!r} is a {one.kind} of {write_shape(one.shape)}, should be a row or "
            f"column of numbers; the file has {_list(variables)}: {_remedy(path)}"
        )
    check_shape(path, name, one.shape)


def _variables_5(path: Path) -> list[_Variable]:
    from scipy.io import whosmat

    with _whole(path):
        return [_Variable(*one) for one in whosmat(path)]


def read_names(path: Path) -> tuple[str, ...]:
    """Names of the variables. Raises InputError for a damaged file, and one without numbers."""
    return _names(path, _variables_5(path))


def read_columns(
    path: Path, wanted: Sequence[str], allow_missing: bool = False
) -> dict[str, NDArray[np.float64]]:
    """Numbers of the columns that are wanted; see `table.read_columns`."""
    from scipy.io import loadmat

    variables = _variables_5(path)

    @cache
    def load(name: str) -> NDArray[Any]:
        values: NDArray[Any] = loadmat(path, variable_names=[name])[name]
        return values

    with _whole(path):
        parts = {name: _read_part(path, name, variables, load) for name in wanted}
        return {name: read_numbers(path, name, row, allow_missing) for name, row in parts.items()}


@contextmanager
def _open_73(path: Path) -> Iterator[Any]:
    """The file, open. Raises InputError where h5py is not installed or cannot make it out."""
    try:
        import h5py
    except ImportError:
        raise InputError(
            f"{path}: is a MATLAB 7.3 file, which needs h5py: pip install 'opensuction[matlab]', "
            "or save it in MATLAB with '-v7'"
        ) from None
    with _whole(path), h5py.File(path, "r") as file:
        yield file


def _variables_73(file: Any) -> list[_Variable]:
    """The variables of an open file; what lies in other files is none."""
    import h5py

    found = []
    for name in file:
        if name.startswith("#") or not isinstance(file.get(name, getlink=True), h5py.HardLink):
            continue
        item = file[name]
        kind = item.attrs.get("MATLAB_class", b"unknown class")
        words = kind.decode() if isinstance(kind, bytes) else str(kind)
        if not isinstance(item, h5py.Dataset):
            found.append(_Variable(name, (1, 1), words))
        elif not item.external:
            # Axes come in reverse.
            found.append(_Variable(name, item.shape[::-1], words))
    return found


def read_names_73(path: Path) -> tuple[str, ...]:
    """As `read_names`, of a file of version 7.3."""
    with _open_73(path) as file:
        return _names(path, _variables_73(file))


def read_columns_73(
    path: Path, wanted: Sequence[str], allow_missing: bool = False
) -> dict[str, NDArray[np.float64]]:
    """As `read_columns`, of a file of version 7.3."""
    with _open_73(path) as file:
        variables = _variables_73(file)

        @cache
        def load(name: str) -> NDArray[Any]:
            values: NDArray[Any] = file[name][()].T
            return values

        parts = {name: _read_part(path, name, variables, load) for name in wanted}
        return {name: read_numbers(path, name, row, allow_missing) for name, row in parts.items()}
