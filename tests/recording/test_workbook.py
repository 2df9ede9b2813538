"""Excel workbooks: sheets as people fill them, read like text, or refused in one line."""

import sys
import zipfile
from datetime import datetime, time, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import openpyxl
import pytest

import opensuction as osn
from opensuction.kernel.errors import InputError
from opensuction.recording import table, workbook
from tests.recording.test_table import EXPECTED, read, refusal

ROWS: list[list[Any]] = [["t_s", "head_mm"], [0, 1.5], [0.5, -2]]


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "recording.xlsx"


def write(file: Path, **sheets: list[list[Any]]) -> Path:
    book = openpyxl.Workbook()
    book.remove(book.active)
    for name, rows in sheets.items():
        sheet = book.create_sheet(name)
        for row in rows:
            sheet.append(row)
    book.save(file)
    return file


def test_a_sheet_is_read_like_text(file: Path) -> None:
    assert read(write(file, Data=ROWS)) == EXPECTED
    assert table.open_table(file).note == ""


def test_title_units_and_empty_rows_are_recognised(file: Path) -> None:
    write(file, Data=[["Bench 3"], [], ["t", "head"], ["s", "mm"], [0, 1.5], [], [0.5, -2]])
    opened = table.open_table(file)
    assert opened.names == ("t (s)", "head (mm)")
    assert opened.note == "the names of its columns are read from line 3, nothing from above it"
    assert table.find_name(opened, "head") == "head (mm)"
    assert [*read(file).values()] == [*EXPECTED.values()]


COVER: list[list[Any]] = [["Bench 3"], ["Operator", "Smith"], ["Rate", 100], ["ready", True]]
MORE: list[list[Any]] = [["a", "b"], [1, 2]]


def test_the_sheet_with_rows_of_numbers_is_read_and_told(file: Path) -> None:
    write(file, Cover=COVER, Data=ROWS)
    assert read(file) == EXPECTED
    note = "read from its sheet 'Data', nothing from 'Cover'"
    assert table.open_table(file).note == note


def test_of_several_sheets_one_is_named(file: Path) -> None:
    write(file, Cover=COVER, Data=ROWS, More=MORE)
    said = refusal(file)
    assert said == "2 of its sheets have rows of numbers; name one by --sheet: 'Data', 'More'"
    assert {name: row.tolist() for name, row in osn.read(file, sheet="Data").items()} == EXPECTED
    assert table.open_table(file, "More").names == ("a", "b")
    with pytest.raises(InputError, match=r"has no sheet 'data'; its sheets: 'Cover', 'Data'"):
        osn.read(file, sheet="data")
    with pytest.raises(InputError, match="name one by sheet: 'Data', 'More'"):
        osn.read(file)
    write(file, Cover=COVER, Notes=COVER)
    assert "none of its sheets has rows of numbers; name one" in refusal(file)


def test_what_is_no_workbook_has_no_sheets(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("a,b\n1,2\n")
    np.savez(tmp_path / "b.npz", a=np.arange(3.0))
    for name, words in (("a.csv", "is no Excel workbook"), ("b.npz", "is a NumPy archive")):
        with pytest.raises(InputError, match=f"{words}.*, so leave out --sheet"):
            table.open_table(tmp_path / name, "Data")


def test_numbers_keep_their_digits(file: Path) -> None:
    """A sheet's numbers have no marks of thousands: 1.234 beside 2 is no 1234."""
    write(file, Data=[["a", "b"], [1.234, 2**53 - 1], [2, 0.123456789012345]])
    assert read(file) == {"a": [1.234, 2.0], "b": [2.0**53 - 1, 0.123456789012345]}


def test_dates_and_times_are_seconds(file: Path) -> None:
    noon = datetime.fromisoformat("2026-01-31 12:00")
    rows: list[list[Any]] = [["date", "clock"], [noon, time(23, 59, 59, 500000)]]
    write(file, Data=[*rows, [noon + timedelta(milliseconds=250), timedelta(hours=24, seconds=1)]])
    found = read(file)
    assert found["date"][1] - found["date"][0] == pytest.approx(0.25, abs=1e-6)
    assert found["clock"] == [86399.5, 86401.0]


REFUSED: dict[str, tuple[list[list[Any]], str]] = {
    "text": ([*ROWS, [1, "up"]], "line 4, column 'head_mm': 'up' is not a number"),
    "comma": ([*ROWS, [1, "1,5"]], "'1,5' is not a number; this file has decimal points, so no"),
    "empty cell": ([*ROWS, [1, None]], "line 4, column 'head_mm': an empty cell is no number (in"),
    "error": ([*ROWS, [1, "#DIV/0!"]], "line 4, column 'head_mm': an empty cell is no number"),
    "true": ([*ROWS, [1, True]], "line 4, column 'head_mm': 'True' is not a number"),
    "two headers": ([["a", "b"], ["c d", "e"], [1, 2]], "lines 1 and 2 may both be the header"),
    "no numbers": ([["only", "text"]], "has a header and no samples below it"),
    "nothing": ([], "holds no line with values"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_bad_cells_are_refused_with_their_row(file: Path, case: str) -> None:
    rows, words = REFUSED[case]
    assert words in refusal(write(file, Data=rows))


def test_missing_numbers_leave_their_rows_out(file: Path) -> None:
    write(file, Data=[*ROWS, [1, None], [2, "#N/A"], [3, 4]])
    columns, left_out = table.read_columns(table.open_table(file), [*EXPECTED], True)
    assert (columns["head_mm"].tolist(), left_out) == ([1.5, -2.0, 4.0], 2)


@pytest.mark.parametrize("lacking", ["pandas", "openpyxl"])
def test_without_its_readers_one_line_says_what_to_install(
    file: Path, monkeypatch: pytest.MonkeyPatch, lacking: str
) -> None:
    write(file, Data=ROWS)
    monkeypatch.setitem(sys.modules, lacking, None)
    assert "which needs pandas and openpyxl: pip install 'opensuction[excel]'" in refusal(file)


@pytest.mark.parametrize("share", [0.3, 0.6, 0.9])
def test_a_cut_off_workbook_is_refused(file: Path, share: float) -> None:
    content = write(file, Data=ROWS).read_bytes()
    file.write_bytes(content[: int(share * len(content))])
    assert "damaged or incomplete" in refusal(file)


def test_a_workbook_with_damaged_sheets_is_refused(file: Path) -> None:
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("xl/workbook.xml", "<workbook/>")
    assert refusal(file) == "is a damaged or incomplete Excel workbook; save it again"


ARCHIVES = {
    "zip": ({"bench.csv": "a,b\n1,2\n"}, "is a zip archive; unpack it first"),
    "OpenDocument": (
        {"mimetype": "application/vnd.oasis.opendocument.spreadsheet"},
        "is a spreadsheet; save it as .xlsx, or export the sheet as CSV",
    ),
    "binary workbook": ({"xl/workbook.bin": ""}, "is a spreadsheet; save it as .xlsx"),
}


@pytest.mark.parametrize("case", ARCHIVES)
def test_other_archives_are_named(file: Path, case: str) -> None:
    members, words = ARCHIVES[case]
    with zipfile.ZipFile(file, "w") as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    assert words in refusal(file)


def test_a_workbook_that_unpacks_beyond_the_bound_is_refused(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(workbook, "LARGEST_TEXT_BYTES", 1000)
    assert "MB unpacked, above the limit of 1 MB; export" in refusal(write(file, Data=ROWS))
