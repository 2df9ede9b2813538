"""A recording as a table on disk: what its columns are called, and the numbers in some of them.

Nothing is guessed: a cell that is no number, a missing one, or a file that is something else is
refused in one line. Only the columns asked for are kept in memory.

A recording from standard input, kept in a file while it is read: tables are read twice.
"""

import hashlib
import re
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from functools import partial
from io import BufferedReader
from pathlib import Path
from stat import S_ISREG
from types import MappingProxyType
from typing import BinaryIO, NamedTuple

import numpy as np
from numpy.typing import NDArray

from opensuction.kernel.errors import InputError
from opensuction.recording import (
    binary_table,
    json_table,
    matlab_table,
    text_table,
    workbook,
)
from opensuction.recording.array_column import LARGEST_TEXT_BYTES, megabytes

KINDS = "a table of columns: CSV text, JSON, Excel, Parquet, NumPy (.npz) or MATLAB (.mat)"

Columns = dict[str, NDArray[np.float64]]
"""Numbers by the name of their column, each of shape (samples,)."""

FullNames = Mapping[str, tuple[str, ...]]
NO_NAMES: FullNames = MappingProxyType({})

FOREIGN = {
    b"PK\x05\x06": "an empty zip archive",
    b"\x93NUMPY": "a single NumPy array; save named ones with numpy.savez",
    b"\xd0\xcf\x11\xe0": "a spreadsheet of an old kind (.xls), or one with a password; save it as "
    ".xlsx without one, or export the sheet as CSV",
    b"\x1f\x8b": "compressed (gzip); unpack it first, or pipe it, unpacked, into -",
    b"\x28\xb5\x2f\xfd": "compressed (zstd); unpack it first, or pipe it, unpacked, into -",
    b"BZh": "compressed (bzip2); unpack it first, or pipe it, unpacked, into -",
    b"\xfd7zXZ": "compressed (xz); unpack it first, or pipe it, unpacked, into -",
    b"ARROW1": "an Arrow file; save it as Parquet or CSV",
    b"\x89HDF": "an HDF5 file that MATLAB did not write; export the columns as CSV or Parquet",
    b"MATLAB": "a MATLAB file of an unknown version; save it with '-v7'",
    b"TDSm": "a TDMS file of LabVIEW; export it as CSV, or write it as .lvm",
    b"\xff\xfe\0\0": "UTF-32 text; save it as UTF-8",
}
"""How files begin that people take for tables, and what to do with them."""

FOREIGN_TEXT = tuple(
    (re.compile(rb"(\xef\xbb\xbf)?\s*" + beginning, re.IGNORECASE), what)
    for beginning, what in (
        (
            rb"version https://git-lfs",
            "a Git LFS pointer that stands for the file; get the file "
            "itself with 'git lfs pull', or download it from the page of the repository",
        ),
        (
            rb"(/annex/objects/|(\.\./)*\.git/annex/)",
            "a git-annex pointer that stands for the file; "
            "get the file itself with 'git annex get'",
        ),
        (
            rb"<(!doctype html|html|head|body)",
            "a web page; download the file that it shows, often called raw, and give that",
        ),
        (rb"<\?xml", "XML; export the columns as CSV"),
        (rb"%PDF-", "a PDF document; export the table in it as CSV"),
    )
)
"""How text begins that is no table, and what to do with it."""

LOOKED_AT_BYTES = 65536
"""Beginning of a file by which text is recognised."""


class Reader(NamedTuple):
    """Reader of a kind of file."""

    names: Callable[[Path], tuple[str, ...]]
    columns: Callable[[Path, Sequence[str], bool], Columns]
    note: str = ""
    full_names: Callable[[Sequence[str]], FullNames] = lambda _: NO_NAMES
    """Of the names that `names` gives; as in `RecordedTable`."""


class RecordedTable(NamedTuple):
    """A file that can be read as a table."""

    path: Path
    names: tuple[str, ...]
    """Of the columns, in their order."""
    read: Callable[[Path, Sequence[str], bool], Columns]
    """Numbers of some columns, NaN for missing ones where they are allowed; see `read_columns`."""
    size_bytes: int
    sha256: str
    """Of the whole file, in hexadecimal: identifies the recording under any name."""
    note: str = ""
    """What a person should know of how it was read."""
    full_names: FullNames = NO_NAMES
    """Names that each shorter one may mean: without the unit that stands in a row below the header,
    without the structures that a field is in."""


def open_table(path: Path, sheet: str | None = None) -> RecordedTable:
    """Table in a file, its numbers not yet read.

    sheet: of an Excel workbook; None: the one that has rows of numbers. Raises InputError for a
    file that is missing, no file, not readable, too large, or no table.
    """
    try:
        status = path.stat()
        if path.is_dir():
            raise InputError(f"{path}: is a folder; give the path of {KINDS}")
        if not S_ISREG(status.st_mode):
            raise InputError(f"{path}: is a device or a pipe; give the path of {KINDS}")
        with path.open("rb") as file:
            return _open(path, file, status.st_size, sheet)
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; give the path of {KINDS}") from None
    except PermissionError:
        raise InputError(f"{path}: may not be read; change its permissions") from None
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise InputError(f"{path}: cannot be read: {reason}") from None


BINARY = {
    binary_table.PARQUET_TABLE_MAGIC: Reader(
        binary_table.read_names_parquet_table, binary_table.read_columns_parquet_table
    ),
    matlab_table.MAGIC: Reader(
        matlab_table.read_names, matlab_table.read_columns, full_names=matlab_table.short_names
    ),
    matlab_table.MAGIC_73: Reader(
        matlab_table.read_names_73,
        matlab_table.read_columns_73,
        full_names=matlab_table.short_names,
    ),
}
"""Kinds of files by how they begin."""

ARCHIVE = Reader(binary_table.read_names_npz_table, binary_table.read_columns_npz_table)


def _open(path: Path, file: BufferedReader, size_bytes: int, sheet: str | None) -> RecordedTable:
    head = file.read(LOOKED_AT_BYTES)
    if not head:
        raise InputError(f"{path}: is empty; give the path of {KINDS}")
    if sheet is not None and not head.startswith(binary_table.NPZ_TABLE_MAGIC):
        raise InputError(f"{path}: is no Excel workbook (.xlsx), so leave out --sheet")
    reader = _choose_reader(path, head, size_bytes, sheet)
    names = reader.names(path)
    file.seek(0)
    digest = hashlib.file_digest(file, "sha256").hexdigest()
    full_names = reader.full_names(names)
    return RecordedTable(path, names, reader.columns, size_bytes, digest, reader.note, full_names)


def _choose_reader(path: Path, head: bytes, size_bytes: int, wanted: str | None) -> Reader:
    """Reader of a file by its beginning. Raises InputError for what is no table."""
    for start, reader in BINARY.items():
        if head.startswith(start):
            return reader
    if head.startswith(binary_table.NPZ_TABLE_MAGIC):
        if binary_table.find_kind(path) == "npz":
            if wanted is not None:
                raise InputError(f"{path}: is a NumPy archive, so leave out --sheet")
            return ARCHIVE
        sheet = workbook.read_sheet(path, wanted)
        return _read_text(path, lambda: nullcontext(iter(sheet.lines)), sheet.note, decimal=".")
    _refuse_foreign(path, head)
    if size_bytes > LARGEST_TEXT_BYTES:
        raise InputError(
            f"{path}: is {megabytes(size_bytes)} MB, above the limit of "
            f"{megabytes(LARGEST_TEXT_BYTES)} MB for text; keep only the columns and the "
            "cycles that matter, or save it as Parquet"
        )
    if json_table.BEGINNING.match(_decode(head)):
        found = json_table.read_table(path)
        read = partial(json_table.read_columns, table=found)
        return Reader(lambda _: found.names, read, found.note)
    lines, note = text_table.lines_of(path)
    return _read_text(path, lines, note)


def _read_text(path: Path, lines: text_table.Lines, note: str, decimal: str = "") -> Reader:
    """Reader of a table of text, also of a sheet's; decimal: mark of its decimals, "" unknown."""
    layout = text_table.read_layout(path, lines)._replace(decimal=decimal)
    full_names: dict[str, tuple[str, ...]] = {}
    for short, name in zip(layout.short_names, layout.names, strict=True):
        full_names[short] = (*full_names.get(short, ()), name)
    return Reader(
        lambda _: layout.names,
        partial(text_table.read_columns, lines=lines, layout=layout),
        "; ".join(filter(None, (note, layout.note))),
        lambda _: full_names,
    )


def _decode(head: bytes) -> bytes:
    """The beginning of a text as UTF-8, where it is UTF-16; else as it is."""
    if head.startswith(text_table.UTF16_MARKS):
        return head.decode("utf-16", errors="ignore").encode(errors="ignore")
    return head


def _refuse_foreign(path: Path, head: bytes) -> None:
    for start, what in FOREIGN.items():
        if head.startswith(start):
            raise InputError(f"{path}: is {what}")
    head = _decode(head)
    if b"\0" in head:
        raise InputError(f"{path}: is a binary file; give the path of {KINDS}")
    for beginning, what in FOREIGN_TEXT:
        if beginning.match(head):
            raise InputError(f"{path}: is {what}")


def find_name(table: RecordedTable, name: str) -> str:
    """The name of a column as the table has it, of one that a person typed; the same if none is.

    Raises InputError for one that may mean several, with all of them.
    """
    for typed in (name, " ".join(name.split())):
        if typed in table.names:
            return typed
        found = table.full_names.get(typed, ())
        if len({*found}) > 1:
            raise InputError(
                f"{table.path}: column {typed!r} may be {' or '.join(found)}; give one of them"
            )
        if found:
            return found[0]
    return name


def read_columns(
    table: RecordedTable, wanted: Sequence[str], skip_missing: bool = False
) -> tuple[Columns, int]:
    """The numbers of some columns by name, each of shape (samples,), all finite.

    wanted: names that the table has, each once in it. skip_missing: rows in which one of them has
    no number are left out instead of refused.
    Returns the columns and how many rows were left out.
    Raises InputError for a cell that is empty, no number or not finite, with its line; for a name
    that two columns share; for more rows than the bound; for columns of different lengths.
    """
    for name in wanted:
        if table.names.count(name) > 1:
            raise InputError(
                f"{table.path}: {table.names.count(name)} columns are called {name!r}; rename "
                "all but one"
            )
    found = table.read(table.path, tuple(dict.fromkeys(wanted)), skip_missing)
    first, *others = found.items()
    for name, values in others:
        if values.size != first[1].size:
            raise InputError(
                f"{table.path}: {first[0]!r} has {first[1].size} samples, {name!r} {values.size}; "
                "they should be as many"
            )
    if not skip_missing:
        return found, 0
    whole = np.isfinite([*found.values()]).all(axis=0)
    if not whole.any():
        raise InputError(
            f"{table.path}: none of its {whole.size} rows has a number in each of "
            f"{', '.join(map(repr, found))}; choose columns that were recorded together"
        )
    kept = {name: values[whole] for name, values in found.items()}
    return kept, whole.size - int(whole.sum())


DASH = Path("-")
"""How a person asks for it."""
NAME = "standard input"
"""How messages and results call it."""
PIECE_BYTES = 1 << 20


def _copy(stream: BinaryIO, path: Path) -> None:
    """All of a stream into a file. Raises InputError for more than a recording may have."""
    size_bytes = 0
    try:
        with path.open("wb") as file:
            while piece := stream.read(PIECE_BYTES):
                size_bytes += len(piece)
                if size_bytes > LARGEST_TEXT_BYTES:
                    raise InputError(
                        f"{NAME}: more than {megabytes(LARGEST_TEXT_BYTES)} MB, above the limit; "
                        "keep only the columns and the cycles that matter"
                    )
                file.write(piece)
    except OSError as error:
        raise OSError(error.errno, error.strerror, NAME) from None


@contextmanager
def spool() -> Iterator[Path]:
    """A file with all that standard input holds; refusals in here call it by `NAME`.

    Raises InputError where nothing can come. An error of the disk is raised as it is.
    """
    stream = None if sys.stdin is None else sys.stdin.buffer
    if stream is None or stream.isatty():
        raise InputError(f"{NAME}: nothing is piped in; give the path of {KINDS}, or pipe one in")
    with tempfile.TemporaryDirectory(prefix="opensuction-") as folder:
        path = Path(folder) / NAME
        _copy(stream, path)
        try:
            yield path
        except InputError as refused:
            raise InputError(str(refused).replace(str(path), NAME)) from None
