"""Excel workbooks: a sheet as lines of text, so that it is read by the rules of text tables.

Read by pandas with openpyxl, which are an optional part: ``opensuction[excel]``.
"""

import csv
import io
import warnings
import zipfile
from collections.abc import Sequence
from datetime import date, timedelta
from pathlib import Path
from typing import Any, NamedTuple

from opensuction.kernel.errors import InputError
from opensuction.recording.array_column import LARGEST_TEXT_BYTES, megabytes


class Sheet(NamedTuple):
    """A sheet of a workbook as lines of text, cells apart by tabs."""

    lines: list[tuple[int, str]]
    """Of the rows that hold something, each with its number; the first states the separator."""
    note: str
    """What a person should know of which sheet it is."""


def read_sheet(path: Path, wanted: str | None = None) -> Sheet:
    """The sheet of an Excel workbook that is wanted; None: the one that has rows of numbers.

    Raises InputError for a sheet that it lacks, where none was named and not one alone has numbers,
    for a damaged file, and where pandas or openpyxl are not installed.
    """
    sheets = _read_sheets(path)
    name = _choose_sheet(path, sheets, wanted)
    note = ""
    if len(sheets) > 1:
        others = ", ".join(repr(other) for other in sheets if other != name)
        note = f"read from its sheet {name!r}, nothing from {others}"
    lines = [(0, "sep=\t")]
    for number, row in enumerate(sheets[name], start=1):
        cells = [_write_cell(cell) for cell in row]
        if any(cells):
            text = io.StringIO()
            csv.writer(text, delimiter="\t").writerow(cells)
            lines.append((number, text.getvalue()))
    return Sheet(lines, note)


def _choose_sheet(path: Path, sheets: dict[str, list[list[Any]]], wanted: str | None) -> str:
    """Name of the sheet to read; raises InputError with the names that there are."""
    if wanted is not None:
        if wanted not in sheets:
            listed = ", ".join(map(repr, sheets))
            raise InputError(f"{path}: has no sheet {wanted!r}; its sheets: {listed}")
        return wanted
    measured = [name for name, rows in sheets.items() if any(map(_has_numbers, rows))]
    if len(measured) == 1 or len(sheets) == 1:
        return [*measured, *sheets][0]
    held = "none of its sheets has rows of numbers"
    if measured:
        held = f"{len(measured)} of its sheets have rows of numbers"
    choices = ", ".join(map(repr, measured or sheets))
    raise InputError(f"{path}: {held}; name one by --sheet: {choices}")


def _read_sheets(path: Path) -> dict[str, list[list[Any]]]:
    """Rows of cells by the name of their sheet."""
    with zipfile.ZipFile(path) as archive:
        size_bytes = sum(one.file_size for one in archive.infolist())
    if size_bytes > LARGEST_TEXT_BYTES:
        raise InputError(
            f"{path}: is a workbook of {megabytes(size_bytes)} MB unpacked, above the limit of "
            f"{megabytes(LARGEST_TEXT_BYTES)} MB; export the sheet as CSV"
        )
    try:
        import pandas

        # openpyxl warns of drawings and rules that it leaves out.
        with (
            warnings.catch_warnings(action="ignore"),
            pandas.ExcelFile(path, engine="openpyxl") as book,
        ):
            # No filter: what counts as missing is decided as in text.
            return {
                sheet.title: book.parse(sheet.title, header=None, dtype=object, na_filter=False)
                .to_numpy()
                .tolist()
                for sheet in book.book.worksheets
            }
    except ImportError:
        raise InputError(
            f"{path}: is an Excel workbook, which needs pandas and openpyxl: pip install "
            "'opensuction[excel]', or export the sheet as CSV"
        ) from None
    except Exception:  # the reader raises almost anything for XML that is not what it seems
        raise InputError(
            f"{path}: is a damaged or incomplete Excel workbook; save it again"
        ) from None


def _has_numbers(row: Sequence[Any]) -> bool:
    """True for a row with two numbers or more, dates among them."""
    kinds = int | float | date | timedelta
    found = [cell for cell in row if isinstance(cell, kinds) and not isinstance(cell, bool)]
    return sum(cell == cell for cell in found) > 1


def _write_cell(cell: Any) -> str:
    """A cell as text has it; "" for an empty one, and for the mark of an error."""
    if cell is None or cell != cell:
        return ""
    if isinstance(cell, timedelta):  # a time of day beyond 24 hours
        minutes, seconds = divmod(cell.total_seconds(), 60.0)
        return f"{minutes // 60:.0f}:{minutes % 60:02.0f}:{seconds:09.6f}"
    if isinstance(cell, date):  # with its time, as Excel's always are
        return cell.isoformat().replace("T", " ")
    return " ".join(str(cell).split())
