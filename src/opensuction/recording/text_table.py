"""CSV and its relatives: commas, semicolons or tabs, decimal commas, comments, quotes.

The separator is the one that gives the header and the row below it as many cells. A decimal comma
is possible where the separator is not a comma. Lines that begin with ``#`` are comments. Text that
is no UTF-8 is taken for Windows-1252, as spreadsheets of western languages still write it.
"""

import codecs
import csv
import math
from array import array
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import NamedTuple, TextIO

import numpy as np
from numpy.typing import NDArray

from opensuction.kernel.errors import InputError
from opensuction.recording.bound import MOST_SAMPLES, describe_excess

SEPARATORS = (";", "\t", ",")
"""Tried in this order: in text with decimal commas, commas would also cut."""
COMMENT = "#"
UTF8, WINDOWS = "utf-8-sig", "cp1252"
NOTES = {WINDOWS: "is not UTF-8; read as Windows-1252 (cp1252)"}
"""What a person should know of an encoding."""
CHUNK_BYTES = 1 << 20
LONGEST_LINE = 1_000_000
"""Characters of a line; a longer one belongs to another kind of file."""
SHOWN = 40
"""Characters of a cell that a message repeats."""
MISSING = frozenset(("", "na", "n/a", "nan", "null", "none", "-nan", "+nan", "#n/a"))
"""How a missing number is written, in lower case."""


class _Layout(NamedTuple):
    """How a file is cut into cells."""

    separator: str
    names: tuple[str, ...]


def find_encoding(path: Path) -> str:
    """UTF-8 if all of the file is, else Windows-1252."""
    decoder = codecs.getincrementaldecoder("utf-8")()
    try:
        with path.open("rb") as file:
            while chunk := file.read(CHUNK_BYTES):
                decoder.decode(chunk)
            decoder.decode(b"", final=True)
    except UnicodeDecodeError:
        return WINDOWS
    return UTF8


def read_names(path: Path, encoding: str = UTF8) -> tuple[str, ...]:
    """Names of the columns. Raises InputError for text that has no header or no rows."""
    return _read_layout(path, encoding).names


def read_columns(
    path: Path, wanted: Sequence[str], encoding: str = UTF8
) -> dict[str, NDArray[np.float64]]:
    """Numbers of the columns that are wanted; see `table.read_columns`."""
    layout = _read_layout(path, encoding)
    places = [layout.names.index(name) for name in wanted]
    kept = [array("d") for _ in wanted]
    with _text(path, encoding) as file:
        rows = _rows(path, file, layout)
        next(rows)
        parse = _Parser(path, layout)
        for count, (number, row) in enumerate(rows):
            if count == MOST_SAMPLES:
                raise InputError(f"{path}: {describe_excess(count + 1)}")
            for place, column in zip(places, kept, strict=True):
                column.append(parse(number, place, row[place]))
    return {
        name: np.frombuffer(column, dtype=np.float64)
        for name, column in zip(wanted, kept, strict=True)
    }


def _text(path: Path, encoding: str) -> TextIO:
    """The file as text; bytes that are none become surrogates, found line by line."""
    return path.open(encoding=encoding, errors="surrogateescape", newline="")


def _lines(path: Path, file: TextIO) -> Iterator[tuple[int, str]]:
    """Lines that hold something, each with its number."""
    for number, line in enumerate(file, start=1):
        if len(line) > LONGEST_LINE:
            raise InputError(
                f"{path}: line {number} has more than {LONGEST_LINE} characters; this is no table "
                "with one sample in each line"
            )
        if line.isspace() or line.startswith(COMMENT):
            continue
        if not line.isascii() and any("\udc80" <= letter <= "\udcff" for letter in line):
            raise InputError(
                f"{path}: line {number}: neither UTF-8 nor Windows-1252 text; save the file as "
                "UTF-8"
            )
        yield number, line


def _cells(path: Path, line: str, separator: str) -> list[str]:
    try:
        return next(csv.reader([line], delimiter=separator, skipinitialspace=True))
    except csv.Error as error:
        raise InputError(f"{path}: cannot be cut into cells: {error}") from None


def _read_layout(path: Path, encoding: str) -> _Layout:
    """How to cut a file, by its header and the row below."""
    with _text(path, encoding) as file:
        beginning = [line for _, line in islice(_lines(path, file), 2)]
    if not beginning:
        raise InputError(f"{path}: holds no line with values; give a table with a header line")
    cut = {
        separator: [_cells(path, line, separator) for line in beginning] for separator in SEPARATORS
    }
    fitting = [
        separator
        for separator, rows in cut.items()
        if len(rows[0]) > 1 and len({len(row) for row in rows}) == 1
    ]
    most = max(SEPARATORS, key=lambda separator: len(cut[separator][0]))
    separator = fitting[0] if fitting else most
    header = tuple(name.strip() for name in cut[separator][0])
    if all(_is_number(name) for name in header):
        raise InputError(
            f"{path}: the first line is {beginning[0].strip()[:SHOWN]!r}, numbers instead of names "
            "of columns; add a header line such as time_s,head_mm,tip_mm"
        )
    if len(beginning) < 2:
        raise InputError(f"{path}: has a header and no samples below it")
    return _Layout(separator, header)


def _is_number(cell: str) -> bool:
    try:
        float(cell.replace(",", "."))
    except ValueError:
        return cell == ""
    return True


def _rows(path: Path, file: TextIO, layout: _Layout) -> Iterator[tuple[int, list[str]]]:
    """Rows with the number of the line each ends in, the header first."""
    number = 0

    def feed() -> Iterator[str]:
        """The lines, each counted as the reader takes it."""
        nonlocal number
        for at, line in _lines(path, file):
            number = at
            yield line

    width = len(layout.names)
    reader = csv.reader(feed(), delimiter=layout.separator, skipinitialspace=True)
    try:
        for row in reader:
            if len(row) != width:
                raise InputError(
                    f"{path}: line {number}: {len(row)} cells, the header has {width}; complete or "
                    "remove the line"
                )
            yield number, row
    except csv.Error as error:
        raise InputError(f"{path}: line {number}: cannot be cut into cells: {error}") from None


class _Parser:
    """Turns cells into numbers. The first decimal mark that is met is the file's."""

    def __init__(self, path: Path, layout: _Layout) -> None:
        self._path = path
        self._layout = layout
        self._decimal_comma: bool | None = False if layout.separator == "," else None

    def __call__(self, number: int, place: int, cell: str) -> float:
        """Finite number in a cell; InputError with line and column where there is none."""
        if self._decimal_comma is None and ("," in cell or "." in cell):
            self._decimal_comma = "," in cell
        text = cell
        if self._decimal_comma:
            text = "?" if "." in cell else cell.replace(",", ".")
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if math.isfinite(value) and "_" not in cell:
            return value
        where = f"{self._path}: line {number}, column {self._layout.names[place]!r}"
        if cell.strip().lower() in MISSING:
            what = f"{cell.strip()!r} is" if cell.strip() else "an empty cell is"
            raise InputError(f"{where}: {what} no number; fill it or remove the line")
        if math.isinf(value):
            raise InputError(f"{where}: {cell.strip()!r} is not finite; correct or remove the line")
        raise InputError(f"{where}: {cell.strip()[:SHOWN]!r} is not a number{self._mark(cell)}")

    def _mark(self, cell: str) -> str:
        """A hint where the decimal mark may be what is wrong."""
        if self._decimal_comma and "." in cell:
            return "; this file has decimal commas, so no points"
        if self._decimal_comma is False and "," in cell:
            return "; this file has decimal points, so no commas"
        return "; remove text and units from the columns that are read"
