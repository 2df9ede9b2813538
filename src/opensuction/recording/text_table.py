"""CSV and its relatives: any usual separator, decimal commas, comments, quotes, missing cells.

How a text is cut into cells is found by `text_layout`. Decimal commas are told from points by the
first number that has either; thousands separators are read where they cannot be decimal marks.
Text that is no UTF-8 is taken for Windows-1252, as spreadsheets of western languages still write
it.
"""

import codecs
import math
import re
from array import array
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from opensuction.kernel.errors import InputError
from opensuction.recording import text_layout
from opensuction.recording.array_column import MOST_SAMPLES, describe_excess, describe_missing
from opensuction.recording.column_unit import seconds_in_name
from opensuction.recording.instant import is_date, is_instant, read_instant
from opensuction.recording.text_layout import COMMENTS, LONGEST_LINE, SHOWN, Layout

UTF8, UTF16, WINDOWS = "utf-8-sig", "utf-16", "cp1252"
UTF16_MARKS = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
NOTES = {WINDOWS: "is not UTF-8; read as Windows-1252 (cp1252)"}
"""What a person should know of an encoding."""
Lines = Callable[[], AbstractContextManager[Iterator[tuple[int, str]]]]
"""Gives the lines of a table that hold something, each with its number, from the first on."""
CHUNK_BYTES = 1 << 20
MINUS = "\u2212"
"""The sign that typesetters use; spreadsheets of some languages write it."""
_GROUPED = re.compile(r"[+-]?[1-9]\d{0,2}([., '\u00a0\u202f\u2019])\d{3}(?:\1\d{3})*(?:([.,])\d*)?")
"""A number with thousands separators, the first group; the second is its decimal mark."""
_FORTRAN = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)d[+-]?\d{1,3}", re.IGNORECASE)
"""A number as Fortran writes its doubles."""
_REMARK = re.compile(
    r"((?=[^#]*\d)(?:[\s\d.,;|+\-edt:/]|nan|inf)*(?:[\d.fn]\s+(?=#\D)|[,;|\t]\s*(?=#\s)))"
    r"#(?!n/a|[a-z\d/]+[!?])",
    re.IGNORECASE,
)
"""The numbers of a row and what begins a remark behind them; ``#5`` and ``#N/A`` are cells."""
_BLANKS = " '\u00a0\u202f\u2019"
"""Thousands separators that are never decimal marks."""


def find_encoding(path: Path) -> str:
    """Encoding of a text: UTF-16 with its mark, UTF-8 if all of the file is, else Windows-1252.

    Raises InputError for damaged UTF-16.
    """
    with path.open("rb") as file:
        encoding = UTF16 if file.read(2) in UTF16_MARKS else UTF8
        decoder = codecs.getincrementaldecoder(encoding)()
        file.seek(0)
        try:
            while chunk := file.read(CHUNK_BYTES):
                decoder.decode(chunk)
            decoder.decode(b"", final=True)
        except UnicodeDecodeError:
            if encoding == UTF16:
                raise InputError(f"{path}: is damaged UTF-16 text; save it as UTF-8") from None
            return WINDOWS
    return encoding


def lines_of(path: Path) -> tuple[Lines, str]:
    """Lines of a text file, and what a person should know of its encoding.

    Raises InputError for text in no known encoding.
    """
    encoding = find_encoding(path)
    return partial(_open_lines, path, encoding), NOTES.get(encoding, "")


@contextmanager
def _open_lines(path: Path, encoding: str) -> Iterator[Iterator[tuple[int, str]]]:
    # Bytes that are no text become surrogates, found line by line.
    with path.open(encoding=encoding, errors="surrogateescape", newline="") as file:
        yield _read_lines(path, file)


def read_layout(path: Path, lines: Lines) -> Layout:
    """Layout of a text's cells. Raises InputError for text that is no table."""
    with lines() as opened:
        return text_layout.find_layout(path, opened)


def read_columns(
    path: Path,
    wanted: Sequence[str],
    allow_missing: bool,
    lines: Lines,
    layout: Layout,
) -> dict[str, NDArray[np.float64]]:
    """Numbers of the columns that are wanted; see `table.read_columns`.

    layout: as `read_layout` found it.
    """
    places = [layout.names.index(name) for name in wanted]
    kept = [array("d") for _ in wanted]
    count = 0
    with lines() as opened:
        parse = _Parser(path, layout)
        for number, row in _rows(path, opened, layout):
            if count == MOST_SAMPLES:
                raise InputError(f"{path}: {describe_excess(count + 1)}")
            count += 1
            for place, column in zip(places, kept, strict=True):
                column.append(parse(number, place, row[place]))
    parse.check(count, allow_missing)
    return {
        name: np.frombuffer(column, dtype=np.float64)
        for name, column in zip(wanted, kept, strict=True)
    }


def _read_lines(path: Path, file: Iterable[str]) -> Iterator[tuple[int, str]]:
    """Lines that hold something, each with its number."""
    for number, line in enumerate(file, start=1):
        if len(line) > LONGEST_LINE:
            raise InputError(
                f"{path}: line {number} has more than {LONGEST_LINE} characters; this is no table "
                "with one sample in each line"
            )
        if line.isspace():
            continue
        if "#" in line and (remarked := _REMARK.match(line)):
            line = remarked[1].rstrip(" ") + "\n"  # noqa: PLW2901 - as if it had none
        if line.isascii():
            yield number, line
            continue
        if any("\udc80" <= letter <= "\udcff" for letter in line):
            raise InputError(
                f"{path}: line {number}: neither UTF-8 nor Windows-1252 text; save the file as "
                "UTF-8"
            )
        yield number, line.replace(MINUS, "-")


def _rows(
    path: Path, opened: Iterator[tuple[int, str]], layout: Layout
) -> Iterator[tuple[int, list[str]]]:
    """Rows of samples with the number of the line each ends in."""
    lines = (
        (number, line)
        for number, line in opened
        if number >= layout.first_line and not line.startswith(COMMENTS)
    )
    width = len(layout.names)
    for begin, number, row in text_layout.cut(path, lines, layout.separator):
        more = row[width + layout.has_remarks :] if len(row) > width else ["?"]
        if len(row) == width or not "".join(more).strip():
            yield number, row
        elif number > begin:
            raise InputError(f"{path}: line {begin}: {text_layout.UNCLOSED}")
        else:
            cells = f"{len(row)} cell{'s' if len(row) > 1 else ''}"
            raise InputError(
                f"{path}: line {number}: {cells}, the header has {width}; complete or remove the "
                "line"
            )


class _Missing(NamedTuple):
    """The first cell without a number."""

    number: int
    place: int
    cell: str


class _Parser:
    """Turns cells into numbers. The first decimal mark that is met is the file's.

    Thousands separators are read where they cannot be decimal marks (``1,234.5``, ``1.234.567``),
    and where such a cell was seen before. ``1,234`` is a decimal by the first rule; where another
    cell speaks against that, or the file has commas between its cells, it is refused.
    """

    def __init__(self, path: Path, layout: Layout) -> None:
        self._path = path
        self._layout = layout
        self._decimal = layout.decimal
        self._is_sure = bool(layout.decimal)
        """True once a cell was met whose mark cannot separate thousands."""
        self._thousands = ""
        """The mark that separates them, once a cell has shown it."""
        self._vague: dict[int, tuple[int, str]] = {}
        """Line and cell of the first in each column whose mark may be either."""
        self._whole: set[int] = set()
        """Columns with whole numbers that have no mark."""
        self._instants: set[int] = set()
        """Columns whose first cell is a date with its time."""
        self._missing: _Missing | None = None
        self._missing_rows, self._missing_line = 0, 0

    def __call__(self, number: int, place: int, cell: str) -> float:
        """Finite number in a cell, NaN for one that is missing; InputError for anything else."""
        if number == self._layout.first_line and is_instant(cell):
            self._instants.add(place)
        if place in self._instants:
            return self._read_instant(number, place, cell)
        if not self._is_sure:
            self._look(number, place, cell)
        value = self._read_number(cell)
        if math.isfinite(value) and "_" not in cell:
            return value
        if text_layout.is_missing(cell):
            return self._miss(number, place, cell)
        where, shown = self._where(number, place), cell.strip()
        if not shown.strip("-"):
            return self._miss(number, place, cell)
        if math.isinf(value) or "1.#INF" in shown.upper():
            raise InputError(f"{where}: {shown!r} is not finite; correct or remove the line")
        raise InputError(f"{where}: {shown[:SHOWN]!r} is not a number{self._advise(shown)}")

    def _read_number(self, cell: str) -> float:
        """The number in a cell, finite or not; NaN where it is none."""
        text = cell
        if self._decimal == ",":
            text = "?" if "." in cell else cell.replace(",", ".")
        try:
            return float(text)
        except ValueError:
            if _FORTRAN.fullmatch(text.strip()):
                return float(text.lower().replace("d", "e"))
            return self._read_grouped(cell)

    def _miss(self, number: int, place: int, cell: str) -> float:
        self._missing = self._missing or _Missing(number, place, cell.strip())
        self._missing_rows += number != self._missing_line
        self._missing_line = number
        return math.nan

    def _read_instant(self, number: int, place: int, cell: str) -> float:
        if text_layout.is_missing(cell):
            return self._miss(number, place, cell)
        try:
            return read_instant(cell) / seconds_in_name(self._layout.names[place])
        except (ValueError, OverflowError):
            raise InputError(
                f"{self._where(number, place)}: {cell.strip()[:SHOWN]!r} is no date with its time, "
                "as the first one is; correct or remove the line"
            ) from None

    def _where(self, number: int, place: int) -> str:
        return f"{self._path}: line {number}, column {self._layout.names[place]!r}"

    def _look(self, number: int, place: int, cell: str) -> None:
        """Learn from a cell which mark is the decimal one."""
        if "," not in cell and "." not in cell:
            if not text_layout.is_missing(cell):
                self._whole.add(place)
            return
        marks = [letter for letter in cell if letter in ",."]
        grouped = _GROUPED.fullmatch(cell.strip())
        separates = grouped is not None and grouped[1] in ",."
        if separates and len(marks) == 1 and not (self._is_cut_at_commas and marks == ["."]):
            self._vague.setdefault(place, (number, cell.strip()))
            self._decimal = self._decimal or marks[0]
            return
        separates = separates and len(marks) > 1
        decimal = {",": ".", ".": ","}[marks[0]] if separates else marks[-1]
        if self._decimal not in ("", decimal):
            shown = "thousands separators" if separates else repr(cell.strip()[:SHOWN])
            self._refuse_vague(min(self._vague), f"line {number} has {shown}")
        self._decimal, self._is_sure = decimal, True

    @property
    def _is_cut_at_commas(self) -> bool:
        return self._layout.separator == ","

    def _refuse_vague(self, place: int, why: str) -> None:
        number, cell = self._vague[place]
        one, other = re.sub("[.,]", ".", cell), re.sub("[.,]", "", cell)
        raise InputError(
            f"{self._where(number, place)}: {cell!r} may be {one} or {other}: {why}; write the "
            "numbers with decimal points and without marks between thousands"
        )

    def _read_grouped(self, cell: str) -> float:
        """A number with thousands separators that cannot be decimal marks, else not a number."""
        cell = cell.strip()
        found = _GROUPED.fullmatch(cell)
        if found is None:
            return math.nan
        separator, mark = found[1], found[2] or ""
        sure = bool(mark) or cell.count(separator) > 1 or separator in (*_BLANKS, self._thousands)
        if separator in (mark, self._decimal) or mark not in ("", self._decimal) or not sure:
            return math.nan
        if separator not in _BLANKS:
            self._thousands = separator
        return float(cell.replace(separator, "").replace(",", "."))

    def check(self, rows: int, allow_missing: bool) -> None:
        """Refuse what only all rows together show; raises InputError."""
        if self._vague and not self._is_sure:
            whole = self._vague.keys() & self._whole
            if whole:
                self._refuse_vague(min(whole), "whole numbers stand beside it")
            if self._is_cut_at_commas:
                self._refuse_vague(min(self._vague), "no number shows which mark is the decimal")
        if self._missing and not allow_missing:
            number, place, cell = self._missing
            what = f"{cell!r} is" if cell else "an empty cell is"
            raise InputError(
                f"{self._where(number, place)}: {what} no number "
                f"{describe_missing(self._missing_rows, rows)}"
            )

    def _advise(self, cell: str) -> str:
        """A hint where a date or the decimal mark may be what is wrong."""
        if is_date(cell):
            return "; write times in seconds, or with their date, as in 2026-01-31 12:00:00.5"
        if "," in cell and ("." in cell or cell.count(",") > 1):
            return "; write numbers without marks between thousands"
        if self._decimal == "," and "." in cell:
            return "; this file has decimal commas, so no points"
        if self._decimal == "." and "," in cell:
            return "; this file has decimal points, so no commas"
        return "; remove text and units from the columns that are read"
