"""Layout of a text table: its separator, its header, the units below it, and what precedes them.

The numbers show where the table begins: the first line whose cells all begin like numbers. The line
above has the names, or, where nothing but comments is above, the last comment, or else the columns
are called by their number. What may be meant in two ways is refused with both.
"""

import csv
import re
from collections.abc import Iterator, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import NamedTuple

from opensuction.kernel.errors import InputError
from opensuction.recording.column_unit import find_unit
from opensuction.recording.instant import is_date

SPACE = " "
"""Stands for any run of blanks."""
SEPARATORS = (";", "\t", ",", "|", SPACE)
"""Tried in this order: in text with decimal commas, commas would also cut."""
COMMENTS = ("#", "%")
MISSING = frozenset(("", "na", "n/a", "nan", "null", "none", "-nan", "+nan", "#n/a"))
"""How a missing number is written, in lower case."""
LONGEST_LINE = 1_000_000
"""Characters of a line, and of a cell; a longer one belongs to another kind of file."""
SAMPLED_LINES = 200
"""Lines by which a layout is found, comments not counted."""
REMARKS = ("comment", "comments", "remark", "remarks")
"""Last name of a header whose column most rows leave out, as LabVIEW writes it."""
SHOWN = 40
"""Characters of a cell that a message repeats."""
UNCLOSED = "a quote begins that is not closed; close or remove it"

_STATED = re.compile(r'"?sep=(.)"?\s*', re.IGNORECASE)
"""First line by which spreadsheets state the separator."""
_VALUE = re.compile(r"[+-]?[.,]?\d")
"""How a number begins, also one with a unit behind it, and a date."""
_BRACKETED = re.compile(r"[\[(].*[\])]")
_WINDOWS_NAN = re.compile(r"[+-]?1\.#(QNAN|SNAN|IND)\w*", re.IGNORECASE)
"""No number, as the libraries of Windows print it."""


class Layout(NamedTuple):
    """Layout of a text: separator of its cells, and names of its columns."""

    separator: str
    names: tuple[str, ...]
    short_names: tuple[str, ...]
    """Without the units of a row below the header."""
    first_line: int
    """Where the samples begin."""
    note: str = ""
    """What a person should know of how the header was found."""
    has_remarks: bool = False
    """Rows may have one more cell, for people alone."""
    decimal: str = ""
    """Mark of the decimals; "": to be seen by the numbers."""


class Record(NamedTuple):
    """The cells of one line, or of several that a quoted line break joins."""

    begin: int
    end: int
    """Numbers of its first and last line."""
    cells: list[str]


class _UnclearError(InputError):
    """Error of a separator that gives no table, although it cuts the numbers into cells."""


def is_comment(line: str) -> bool:
    """True for a line that is for people alone."""
    return line.startswith(COMMENTS)


def cut(
    path: Path, lines: Iterator[tuple[int, str]], separator: str
) -> Iterator[tuple[int, int, list[str]]]:
    """Cut numbered lines without comments into the parts of `Record`s, as fast as can be done.

    Raises InputError for what cannot be cut into cells.
    """
    begin = end = 0

    def feed() -> Iterator[str]:
        nonlocal begin, end
        for end, line in lines:
            begin = begin or end
            yield " ".join(line.split()) if separator == SPACE else line

    csv.field_size_limit(LONGEST_LINE)
    try:
        for cells in csv.reader(feed(), delimiter=separator, skipinitialspace=True):
            yield begin, end, cells
            begin = 0
    except csv.Error as error:
        raise InputError(f"{path}: line {begin}: cannot be cut into cells: {error}") from None


def find_layout(path: Path, lines: Iterator[tuple[int, str]]) -> Layout:
    """The layout of a text by its first lines, each with its number, comments among them.

    Raises InputError where they are no table, or may be one in two ways.
    """
    comments, plain = _sample(lines)
    separators: Sequence[str] = SEPARATORS
    if plain and (stated := _STATED.fullmatch(plain[0][1])):
        separators, plain = (stated[1],), plain[1:]
    if not plain:
        raise InputError(f"{path}: holds no line with values; give a table with a header line")
    unclear: _UnclearError | None = None
    for separator in separators:
        try:
            records = _records(path, plain, separator)
            bare = _drop_remarks(records)
            found = _find_by_numbers(path, bare, separator, comments)
        except _UnclearError as refused:
            unclear = unclear or refused
        else:
            if found is not None:
                return found._replace(has_remarks=bare is not records)
    if unclear is None or _is_one_column(plain):
        return _find_by_header(path, plain, separators, comments)
    raise unclear


def _sample(lines: Iterator[tuple[int, str]]) -> tuple[list[str], list[tuple[int, str]]]:
    """The last two comments above everything else, and the first lines that are no comments."""
    comments, plain = list[str](), []
    for number, line in lines:
        if not is_comment(line):
            plain.append((number, line))
        elif not plain:
            comments = [*comments[-1:], line.lstrip("".join(COMMENTS)).strip(" \r\n")]
        if len(plain) == SAMPLED_LINES:
            break
    return comments, plain


def _is_one_column(lines: Sequence[tuple[int, str]]) -> bool:
    """True if a single name stands above single numbers; their commas are decimal then."""
    header, *rows = (line.strip() for _, line in lines)
    return not _is_value(header) and all(re.fullmatch(r"[+-]?\d*,?\d+", row) for row in rows)


def _records(path: Path, lines: Sequence[tuple[int, str]], separator: str) -> list[Record]:
    """Records of the first lines, as far as they can be cut."""
    found = []
    try:
        for record in cut(path, iter(lines), separator):
            found.append(Record(*record))
    except InputError:
        pass
    return found


def _drop_remarks(records: Sequence[Record]) -> Sequence[Record]:
    """The records without a last column of remarks where some rows leave it out."""
    for place, record in enumerate(records):
        width = len(record.cells) - 1
        if width > 1 and record.cells[-1].strip().lower() in REMARKS:
            below = records[place:]
            if any(len(one.cells) == width for one in below):
                bare = (one._replace(cells=one.cells[:width]) for one in below)
                return [*records[:place], *bare]
    return records


def _find_by_numbers(
    path: Path, records: Sequence[Record], separator: str, comments: Sequence[str]
) -> Layout | None:
    """The layout by the first row of two or more numbers, None where a separator leaves none.

    Raises _UnclearError where the lines above it are no header of it, or may be in two ways.
    """
    places = (
        place
        for place, record in enumerate(records)
        if len(record.cells) > 1 and _is_row(record.cells, strict=place == 0)
    )
    place = next(places, None)
    if place is None:
        return None
    rows = records[place:]
    if place == 0:
        return _name_without_header(rows, separator, comments)
    header, units = records[place - 1], list[str]()
    if not _is_header(header.cells, is_first=place == 1):
        return None
    width = _shared_width(header.cells, rows)
    if width is None:
        raise _UnclearError(f"{path}: {_describe_mismatch(header, rows[0], separator)}")
    if place > 1 and _is_second_header(
        records[place - 2].cells, header.cells, width, is_first=place == 2
    ):
        units, header = header.cells[:width], records[place - 2]
        if not all(map(_is_unit, units)):
            raise _UnclearError(
                f"{path}: lines {header.begin} and {records[place - 1].begin} may both be the "
                f"header of the numbers from line {rows[0].begin} on; remove one of them"
            )
    note = ""
    if header.begin > records[0].begin:
        note = f"the names of its columns are read from line {header.begin}, nothing from above it"
    names = name_columns(header.cells, width)
    return Layout(separator, _add_units(names, units), names, rows[0].begin, note)


def _find_by_header(
    path: Path, lines: Sequence[tuple[int, str]], separators: Sequence[str], comments: Sequence[str]
) -> Layout:
    """The layout of what begins with a header, by the line below it."""
    beginnings = {one: records[:2] for one in separators if (records := _records(path, lines, one))}
    if not beginnings:
        raise InputError(f"{path}: line {lines[0][0]}: {UNCLOSED}")
    fitting = [
        one
        for one, records in beginnings.items()
        if len(records[0].cells) > 1 and len({len(record.cells) for record in records}) == 1
    ]
    # Words of a single name are no columns.
    others = [one for one in beginnings if one != SPACE] or [*beginnings]
    most = max(others, key=lambda one: len(beginnings[one][0].cells))
    separator = fitting[0] if fitting else most
    header, *rows = beginnings[separator]
    if all(map(_is_number, filter(str.strip, header.cells))):
        return _name_without_header([header, *rows], separator, comments)
    if number := next(filter(_is_number, header.cells), ""):
        raise InputError(
            f"{path}: line {header.begin} has text and numbers side by side, such as "
            f"{number.strip()[:SHOWN]!r}, so it may be the header or the first samples; put a "
            "line with a name for each column above the samples, and nothing else"
        )
    if not rows:
        raise InputError(
            f"{path}: has a header and no samples below it"
            + (f"; line {header.begin}: {UNCLOSED}" if header.end > header.begin else "")
        )
    names = name_columns(header.cells, len(header.cells))
    return Layout(separator, names, names, rows[0].begin)


def _name_without_header(rows: Sequence[Record], separator: str, comments: Sequence[str]) -> Layout:
    """The layout of numbers above which there are comments alone."""
    width = _shared_width([""] * len(rows[0].cells), rows) or len(rows[0].cells)
    # Blanks last: they also stand beside commas.
    for one in sorted({separator, *SEPARATORS}, key=lambda one: (one == SPACE, one != separator)):
        cut_comments = (_records(Path(), [(1, comment)], one) for comment in comments)
        named = [[cell for record in found for cell in record.cells] for found in cut_comments]
        named = [cells for cells in named if _may_name(cells, width)]
        if named:
            has_units = len(named) == 2 and all(map(_is_unit, named[1]))
            short = name_columns(named[0 if has_units else -1], width)
            names = _add_units(short, named[1] if has_units else ())
            note = f"the names of its columns are read from a comment: {', '.join(names)}"
            return Layout(separator, names, short, rows[0].begin, note)
    names = name_columns([], width)
    note = f"no header, so its columns are called by their number, 1 to {width}"
    return Layout(separator, names, names, rows[0].begin, note)


def _may_name(cells: Sequence[str], width: int) -> bool:
    """True for the cells of a comment that has a name for each column."""
    # The first may be empty: a column called "#" begins like a comment.
    named = len(cells) == width and all(map(str.strip, cells[1:]))
    return named and _is_header(cells, is_first=False)


def name_columns(cells: Sequence[str], width: int) -> tuple[str, ...]:
    """Names on one line each; a column without one is called by its number."""
    names = [" ".join(cell.split()) for cell in cells[:width]] + [""] * (width - len(cells))
    return tuple(name or str(place) for place, name in enumerate(names, start=1))


def _add_units(names: Sequence[str], units: Sequence[str]) -> tuple[str, ...]:
    """Names with their units, as in ``Force (kN)``, where they do not carry them already."""
    full = []
    for name, cell in zip_longest(names, units, fillvalue=""):
        unit = cell.strip().strip("[]()-")
        has_unit = re.search(rf"[^a-z]{re.escape(unit)}\W*$", name, re.IGNORECASE)
        full.append(name if not unit or has_unit else f"{name} ({unit})")
    return tuple(full)


def _shared_width(header: Sequence[str], rows: Sequence[Record]) -> int | None:
    """Columns of a header and its rows without those at the end that are empty in all.

    None where there are not as many of both.
    """
    first = len(rows[0].cells)
    width = max(len(header), first)
    cells = [header, *(row.cells for row in rows)]
    while width and not any("".join(row[width - 1 : width]).strip() for row in cells):
        width -= 1
    return width if width <= min(len(header), first) else None


def is_missing(cell: str) -> bool:
    """True for a cell that says that there is no number."""
    text = cell.strip()
    return text.lower() in MISSING or bool(_WINDOWS_NAN.fullmatch(text))


def _is_value(cell: str) -> bool:
    text = cell.strip()
    return bool(_VALUE.match(text)) or text.lower().lstrip("+-") in ("inf", "infinity")


def _is_number(cell: str) -> bool:
    """True for a cell that is a number or a date and nothing else."""
    text = cell.strip()
    try:
        float(text.replace(",", "."))
    except ValueError:
        return is_date(text)
    return "_" not in text


def _is_row(cells: Sequence[str], strict: bool) -> bool:
    """True if all cells are values, and not all of them missing."""
    values = [cell for cell in cells if not is_missing(cell)]
    return bool(values) and all(_is_number(one) if strict else _is_value(one) for one in values)


def _is_header(cells: Sequence[str], is_first: bool) -> bool:
    """True if cells are names: none a value, or, in the first line of a text, not all."""
    names = [not (_is_value(cell) or is_missing(cell)) for cell in cells if cell.strip()]
    return any(names) and (is_first or all(names))


def _is_unit(cell: str) -> bool:
    """True for a cell that may be a unit below a name: a known one, any in brackets, or none."""
    text = cell.strip()
    return not text.strip("-") or bool(_BRACKETED.fullmatch(text)) or find_unit(text) is not None


def _is_second_header(
    above: Sequence[str], header: Sequence[str], width: int, is_first: bool
) -> bool:
    """True if the line above a header may be the header itself."""
    return (
        len(above) == len(header)
        and all(cell.strip() for cell in above[:width])
        and (_is_header(above, is_first=False) or (is_first and all(map(_is_unit, header))))
    )


def _describe_mismatch(header: Record, row: Record, separator: str) -> str:
    """Describe a header with another number of names than the row below has cells."""
    names, cells = len(header.cells), len(row.cells)
    if names == 1:
        return (
            f"line {row.begin} begins the numbers, {cells} in a row, and the line above, "
            f"{header.cells[0].strip()[:SHOWN]!r}, is no header of {cells} names; add one there, "
            "such as time_s,head_mm,tip_mm"
        )
    remedy = "give each column one name"
    if names > cells:
        remedy = "remove the names that have no column"
    if separator == "," and cells == 2 * names:
        remedy = "numbers with decimal commas need another separator, such as semicolons"
    if separator == SPACE:
        remedy = "give each column one name without blanks, or separate all by commas"
    return f"line {row.begin}: {cells} cells, the header has {names}; {remedy}"
