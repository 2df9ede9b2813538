"""Layouts of text tables as people have them: read where they are clear, or refused with a remedy.

Each case is a kind of file that was once refused with a sentence that was false or did not help.
"""

from pathlib import Path

import pytest

from opensuction.kernel.errors import InputError
from opensuction.recording import table
from opensuction.recording.column_unit import seconds_of_column
from tests.recording.test_table import EXPECTED, LAYOUTS, read, refusal


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "recording.csv"


CLEAR = {
    "header behind #": "# t_s,head_mm\n0,1.5\n0.5,-2\n",
    "header behind #, below prose": "# bench 3, run 2\n#t_s,head_mm\n0,1.5\n0.5,-2\n",
    "header behind # with blanks, rows with commas": "# t_s head_mm\n0,1.5\n0.5,-2\n",
    "NumPy's savetxt": "# t_s head_mm\n0.0e+00 1.5e+00\n5.0e-01 -2.0e+00\n",
    "header behind %": "% Model: bench\n% t_s  head_mm\n0  1.5\n0.5  -2\n",
    "% comments above a header": "% bench 3\nt_s,head_mm\n0,1.5\n% turned\n0.5,-2\n",
    "quoted decimal commas": 't_s,head_mm\n"0","1,5"\n"0,5","-2"\n',
    "quoted decimal commas of three digits": 't_s,head_mm\n"0,000","1,500"\n"0,500","-2,000"\n',
    "a separator at the end of every line": "t_s,head_mm,\n0,1.5,\n0.5,-2,\n",
    "a separator at the end of the rows": "t_s;head_mm\n0;1,5;\n0,5;-2;\n",
    "a separator at the end of the header": "t_s\thead_mm\t\n0\t1.5\n0.5\t-2\n",
    "empty columns behind": "t_s,head_mm,,,\n0,1.5,,,\n0.5,-2,,,\n",
    "sep=;": "sep=;\nt_s;head_mm\n0;1,5\n0,5;-2\n",
    "sep=, in quotes": '"sep=,"\r\nt_s,head_mm\r\n0,1.5\r\n0.5,-2\r\n',
    "SEP=|": "SEP=|\nt_s|head_mm\n0|1.5\n0.5|-2\n",
    "preamble": "Bench 3\nDate: 2026-01-02\n\nt_s,head_mm\n0,1.5\n0.5,-2\n",
    "preamble of a spreadsheet": "Bench 3,\n,\nt_s,head_mm\n0,1.5\n0.5,-2\n",
    "preamble of names and values": "Operator;Smith\nRate;100\nt_s;head_mm\n0;1,5\n0,5;-2\n",
    "blanks": "t_s head_mm\n0 1.5\n0.5 -2\n",
    "blanks in columns": "   t_s   head_mm\n   0.0       1.5\n   0.5      -2.0\n",
    "blanks and decimal commas": "t_s head_mm\n0 1,5\n0,5 -2\n",
    "blanks and quotes": '"t_s" "head_mm"\n0 1.5\n0.5 -2\n',
    "strokes": "t_s|head_mm\n0|1.5\n0.5|-2\n",
    "exponents of Fortran": " t_s head_mm\n 0.0D+00 1.5D+00\n 5.0d-1 -0.2D1\n",
    "a minus as it is printed": "t_s;head_mm\n0;1,5\n0,5;\u22122\n",
    "header behind #, first name empty": "#,t_s,head_mm\n1,0,1.5\n2,0.5,-2\n",
    "header behind # with commas, rows with blanks": "# t_s, head_mm\n0.0 1.5\n0.5 -2\n",
    "a cell of 200 kB": f"t_s,note,head_mm\n0,{'a' * 200_000},1.5\n0.5,b,-2\n",
}


@pytest.mark.parametrize("case", CLEAR)
def test_clear_layouts_are_read_at_the_first_try(file: Path, case: str) -> None:
    file.write_text(CLEAR[case], newline="")
    assert read(file, *EXPECTED) == EXPECTED


@pytest.mark.parametrize("case", LAYOUTS)
def test_without_a_header_columns_are_called_by_number(file: Path, case: str) -> None:
    lines = LAYOUTS[case].replace("\r\n", "\n").replace("\r", "\n").splitlines()
    rows = [line for line in lines if line and not line.startswith("#")][1:]
    file.write_text("\n".join(rows))
    opened = table.open_table(file)
    assert opened.note == "no header, so its columns are called by their number, 1 to 2"
    assert read(file) == {"1": EXPECTED["t_s"], "2": EXPECTED["head_mm"]}


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (",head,tip\n0,1,2\n", {"1": [0.0], "head": [1.0], "tip": [2.0]}),
        ("head;;tip\n0,5;1;2\n", {"head": [0.5], "2": [1.0], "tip": [2.0]}),
        ("head,tip,\n1,2,3\n", {"head": [1.0], "tip": [2.0], "3": [3.0]}),
        ("1.5\n2.5\n", {"1": [1.5, 2.5]}),
    ],
)
def test_a_column_without_a_name_is_called_by_its_number(
    file: Path, content: str, expected: dict[str, list[float]]
) -> None:
    file.write_text(content)
    assert read(file) == expected


@pytest.mark.parametrize(
    "header",
    ['"Head\n(mm)","Tip\n(mm)"', '"Head\r\n(mm)","Tip (mm)"', "\"Head\n\n(mm)\",'Tip (mm)'"],
)
def test_a_line_break_in_a_quoted_name_is_a_blank(file: Path, header: str) -> None:
    file.write_text(f"{header}\n1,2\n3,4\n", newline="")
    names = table.open_table(file).names
    assert names[0] == "Head (mm)"
    assert names[1].strip("'") == "Tip (mm)"
    assert [*read(file).values()] == [[1.0, 3.0], [2.0, 4.0]]


UNITS = {
    "plain": ("Force ,Disp \nkN,mm\n", {"Force": "Force (kN)", "Disp": "Disp (mm)"}),
    "brackets": ("Force,Disp\n[N],(mm)\n", {"Force": "Force (N)", "Disp": "Disp (mm)"}),
    "some without": ("n,Disp\n-,mm\n", {"n": "n", "Disp": "Disp (mm)"}),
    "compound": ("v,a\nmm/s,m/s^2\n", {"v": "v (mm/s)", "a": "a (m/s^2)"}),
    "twice": ("Force (N),disp_mm\nN,mm\n", {"Force (N)": "Force (N)", "disp_mm": "disp_mm"}),
    "in comments": ("# t head\n# ms mm\n", {"t": "t (ms)", "head": "head (mm)"}),
    "below numbered channels": ("x,1\nsecond,Volt\n", {"x": "x (second)", "1": "1 (Volt)"}),
    "below a preamble": ("Bench\nt,Head\nms,mm\n", {"t": "t (ms)", "Head": "Head (mm)"}),
}


@pytest.mark.parametrize("case", UNITS)
def test_a_row_of_units_below_the_header_is_no_sample(file: Path, case: str) -> None:
    header, names = UNITS[case]
    file.write_text(f"{header}1,2\n3,4\n")
    opened = table.open_table(file)
    assert {name: table.find_name(opened, name) for name in names} == names
    assert read(file) == dict(zip(names.values(), ([1.0, 3.0], [2.0, 4.0]), strict=True))


UNCLEAR = {
    "commas of thousands": (
        't_s,n\n"1,000","2,500"\n"2,000","3,500"\n',
        "'1,000' may be 1.000 or 1000",
    ),
    "commas of thousands, then points": (
        'a,b\n"1,000",2\n"1,500",0.5\n',
        "without marks between thousands",
    ),
    "two headers": ("Force,Disp\nload cell,laser\n1,2\n", "lines 1 and 2 may both be the header"),
    "title as wide as the table": (
        "Bench 3,run 2\nhead,tip\n1,2\n",
        "lines 1 and 2 may both be the header of the numbers from line 3 on; remove one",
    ),
    "words and values": (
        "Rate,100\nOperator,Smith\nhead,tip\n1,2\n",
        "lines 2 and 3 may both be the header of the numbers from line 4 on; remove one",
    ),
    "preamble without a header": (
        "Test 3\nOperator X\n0,1\n1,2\n",
        "line 3 begins the numbers, 2 in a row, and the line above, 'Operator X', is no header",
    ),
    "names with blanks between blanks": (
        "Head mm Tip mm\n0.0 1.0\n1.0 2.0\n",
        "line 2: 2 cells, the header has 4; give each column one name without blanks",
    ),
    "decimal commas between commas": (
        "a,b\n1,5,2,5\n3,5,4,5\n",
        "line 2: 4 cells, the header has 2; numbers with decimal commas need another separator",
    ),
    "names of rows": (
        'head,tip\n"1",0.1,0.2\n"2",0.1,0.2\n',
        "line 2: 3 cells, the header has 2; give each column one name",
    ),
    "names without columns": (
        "t\thead\tturns\n0\t1\n1\t2\n",
        "line 2: 2 cells, the header has 3; remove the names that have no column",
    ),
    "values beside the samples": (
        "Record Length,2.5e+03,,-0.02,0.1\nInterval,4e-06,,-0.01,0.2\nPoints,s,,0.0,0.3\n",
        "line 1 has text and numbers side by side, such as '2.5e+03', so it may be the header or",
    ),
    "open quote": ('a,b\n1,2\n"3,4\n5,6\n', "line 3: a quote begins that is not closed"),
    "open quote in the header": ('"a,b\n1,2\n3,4\n', "line 1: a quote begins that is not closed"),
    "a named cell of 200 kB": (f"a,b\n1,{'x' * 200_000}\n", "line 2, column 'b': 'xxxx"),
    "nothing measured at first": (
        "a,b\nNA,NA\n,\n1,2\n",
        "line 2, column 'a': 'NA' is no number (in 2 of 3 rows)",
    ),
    "text between rows": ("a,b\n1,2\nfoo,bar\n3,4\n", "line 3, column 'a': 'foo' is not a number"),
}


@pytest.mark.parametrize("case", UNCLEAR)
def test_unclear_layouts_are_refused_with_a_remedy(file: Path, case: str) -> None:
    content, words = UNCLEAR[case]
    file.write_text(content)
    message = refusal(file)
    assert words in message
    assert len(message) < 300


def test_a_cut_off_line_is_not_put_down_to_the_header(file: Path) -> None:
    for last in ("2,3", "2", "2,up,3,4"):
        file.write_text(f"t,note,h\n0,up,1\n1,down,2\n{last}\n")
        cells = f"{last.count(',') + 1} cell{'s' if ',' in last else ''}"
        expected = f"line 4: {cells}, the header has 3; complete or remove the line"
        assert refusal(file, "t", "h") == expected


FOREIGN = {
    "Git LFS": (
        "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n",
        "is a Git LFS pointer that stands for the file; get the file itself with 'git lfs pull'",
    ),
    "git-annex": ("/annex/objects/SHA256E-s9--4d7a.csv\n", "'git annex get'"),
    "web page": ("\n<!DOCTYPE html>\n<html><body>", "is a web page; download the file"),
    "XML": ('<?xml version="1.0"?>\n<data/>', "is XML; export the columns as CSV"),
    "PDF": ("%PDF-1.7\n1 0 obj\n", "is a PDF document"),
}


@pytest.mark.parametrize("case", FOREIGN)
def test_text_that_is_no_table_is_named(file: Path, case: str) -> None:
    content, words = FOREIGN[case]
    file.write_text(content)
    assert words in refusal(file)


MISSING = {
    "dashes": "t_s,head_mm\n0,\n0.25,--\n0.5,1\n0.75,2\n",
    "Windows": "t_s,head_mm\n0,\n0.25,-1.#IND\n0.5,1\n0.75,2\n",
    "text": "t_s,head_mm\n0,\n0.25,nan\n0.5,1\n0.75,2\n",
    "decimal commas": "t_s;head_mm\n0;\n0,25;NA\n0,5;1\n0,75;2,0\n",
    "blanks and quotes": 't_s head_mm\n0 ""\n0.25 null\n0.5 1\n0.75 2\n',
}


@pytest.mark.parametrize("case", MISSING)
def test_rows_without_a_number_are_counted_and_left_out_if_asked(file: Path, case: str) -> None:
    file.write_text(MISSING[case])
    assert refusal(file) == (
        "line 2, column 'head_mm': an empty cell is no number (in 2 of 4 rows); fill it in, or "
        "leave such rows out with --skip-missing"
    )
    opened = table.open_table(file)
    columns, left_out = table.read_columns(opened, opened.names, skip_missing=True)
    assert left_out == 2
    assert {name: values.tolist() for name, values in columns.items()} == {
        "t_s": [0.5, 0.75],
        "head_mm": [1.0, 2.0],
    }


def test_devices_that_take_turns_share_no_row(file: Path) -> None:
    file.write_text("t_s,a,b\n0,1,\n1,,2\n2,3,\n3,,4\n")
    opened = table.open_table(file)
    with pytest.raises(InputError, match="none of its 4 rows has a number in each of 'a', 'b'"):
        table.read_columns(opened, ["a", "b"], skip_missing=True)
    columns, left_out = table.read_columns(opened, ["t_s", "b"], skip_missing=True)
    assert (columns["t_s"].tolist(), columns["b"].tolist(), left_out) == ([1.0, 3.0], [2.0, 4.0], 2)


def test_what_is_not_finite_or_no_number_is_never_left_out(file: Path) -> None:
    for cell, words in (("inf", "not finite"), ("3mm", "not a number"), ("1_0", "not a number")):
        file.write_text(f"a,b\n1,2\n3,{cell}\n")
        opened = table.open_table(file)
        with pytest.raises(InputError, match=words):
            table.read_columns(opened, opened.names, skip_missing=True)


HASHED = {
    "names in a comment": "# t_s, head_mm\n0, 1.5  # begun\n0.5, -2 # slipped, twice\n",
    "blanks": "# t_s head_mm\n0 1.5\n0.5 -2 # slipped, twice\n",
    "a cell of its own": "t_s;head_mm\n0;1,5;# begun\n0,5;-2\n",
    "far down": "t_s,head_mm\n0,1.5\n" + "0.5,-2\n" * 250 + "0.5,-2  #late\n",
}


@pytest.mark.parametrize("case", HASHED)
def test_remarks_behind_a_row_are_left_out(file: Path, case: str) -> None:
    file.write_text(HASHED[case])
    found = read(file)
    assert {name: values[:2] for name, values in found.items()} == EXPECTED
    assert found["head_mm"][-1] == -2.0


def test_a_cell_with_a_hash_is_no_remark(file: Path) -> None:
    file.write_text("t_s,try,head_mm\n0,#5,1.5\n0.5,Run 2 #6,-2\n")
    assert read(file, "t_s", "head_mm") == EXPECTED
    file.write_text("t_s,head_mm\n0,1.5\n0.5, #N/A\n")
    assert "'#N/A' is no number (in 1 of 2 rows)" in refusal(file)


LABVIEW = (
    "LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\t\n\t\nChannels\t1\t\t\n"
    "Delta_X\t0.5\t\t\n***End_of_Header***\t\t\nt_s\thead_mm\tComment\n"
)
REMARKED = {
    "no remark": LABVIEW + "0\t1.5\n0.5\t-2\n",
    "one in the first row": LABVIEW + "0\t1.5\tbegun\n0.5\t-2\n",
    "one in the last row": LABVIEW + "0\t1.5\n0.5\t-2\tended\n",
    "some with numbers": LABVIEW + "0\t1.5\t1\n0.5\t-2\n",
    "quoted, between commas": 't_s,head_mm,Remarks\n0,1.5\n0.5,-2,"turned, by hand"\n',
}


@pytest.mark.parametrize("case", REMARKED)
def test_remarks_behind_the_numbers_are_left_alone(file: Path, case: str) -> None:
    file.write_text(REMARKED[case])
    assert read(file, *EXPECTED) == EXPECTED


def test_a_second_cell_too_many_is_no_remark(file: Path) -> None:
    file.write_text("t_s,head_mm,Comment\n0,1.5\n0.5,-2,3,4\n")
    assert refusal(file).endswith("line 3: 4 cells, the header has 2; complete or remove the line")


INSTANTS = {
    "2026-01-31T12:00:00,2026-01-31T12:00:00.25": 0.25,
    "2026-01-31 12:00:00Z,2026-01-31 13:00:00.5+01:00": 0.5,
    "2026/01/31 23:59:59.999,2026/02/01 00:00:00.001": 0.002,
    "2026-01-31T12:00,2026-01-31T12:01": 60.0,
    "31.01.2026 23:59:59.999,1.2.2026 0:00:00.001": 0.002,
    "31.01.2026 12:00,31.01.2026 12:01": 60.0,
    "12:00:59.75,12:01:00": 0.25,
    "9:59:59,10:00:00.5": 1.5,
    "99:59:59,100:00:00": 1.0,
}


@pytest.mark.parametrize("case", INSTANTS)
def test_dates_with_their_time_are_seconds(file: Path, case: str) -> None:
    first, second = case.split(",")
    file.write_text(f"stamp;head_mm\n{first};1,5\n{second};-2\n")
    found = read(file)
    assert found["head_mm"] == EXPECTED["head_mm"]
    began, ended = found["stamp"]
    assert ended - began == pytest.approx(INSTANTS[case], abs=1e-6)


def test_a_date_with_its_time_is_utc_where_it_names_no_zone(file: Path) -> None:
    file.write_text("stamp,head_mm\n1970-01-02 00:00:01.5,1\n1970-01-02 01:00:00+01:00,2\n")
    assert read(file)["stamp"] == [86401.5, 86400.0]


@pytest.mark.parametrize(
    ("cells", "said"),
    [
        (["31/01/2026 12:00:00"], "write times in seconds, or with their date, as in 2026-01-31"),
        (["12:00"], "write times in seconds, or with their date, as in 2026-01-31"),
        (["2026-01-31"], "write times in seconds, or with their date, as in 2026-01-31"),
        (["2026-01-31 12:00", "5"], "'5' is no date with its time, as the first one is"),
        (["2026-01-31 12:00", "2026-02-30 12:00"], "'2026-02-30 12:00' is no date with its time"),
        (["12:00:00.5", "12:61:00"], "'12:61:00' is no date with its time, as the first one is"),
        (["5", "2026-01-31 12:00"], "'2026-01-31 12:00' is not a number; write times in seconds"),
    ],
)
def test_other_times_are_refused_with_what_would_do(
    file: Path, cells: list[str], said: str
) -> None:
    file.write_text("stamp;head_mm\n" + "".join(f"{cell};1\n" for cell in cells))
    assert said in refusal(file)


@pytest.mark.parametrize(
    ("name", "unit_s"), [("stamp", 1.0), ("stamp_ms", 1e-3), ("stamp (hh:mm:ss)", 1.0)]
)
def test_dates_are_in_the_unit_that_their_name_says(file: Path, name: str, unit_s: float) -> None:
    file.write_text(f"{name},head\n2026-01-31 12:00:00,1\n2026-01-31 12:00:30,2\n")
    began, ended = read(file)[name]
    assert (ended - began) * seconds_of_column(name, None) == 30.0
    assert seconds_of_column(name, None) == unit_s


def test_a_missing_date_leaves_its_row_out(file: Path) -> None:
    file.write_text("stamp,head_mm\n2026-01-31 12:00,1\n,2\n2026-01-31 12:01,3\n")
    assert "an empty cell is no number (in 1 of 3 rows)" in refusal(file)
    columns, skipped = table.read_columns(table.open_table(file), ["head_mm", "stamp"], True)
    assert (columns["head_mm"].tolist(), skipped) == ([1.0, 3.0], 1)
