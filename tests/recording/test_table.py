"""Tables from disk: what is read, and how everything else is refused."""

import hashlib
import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel.errors import InputError
from opensuction.recording import array_column, table, text_table

MEASURED = Path(__file__).parents[2].parent / "shared" / "data" / "mrd"
"""Real recordings, beside the project where there are any."""


def read(path: Path, *names: str) -> dict[str, list[float]]:
    opened = table.open_table(path)
    columns, _ = table.read_columns(opened, names or opened.names)
    return {name: values.tolist() for name, values in columns.items()}


def refusal(path: Path, *names: str) -> str:
    with pytest.raises(InputError) as raised:
        read(path, *names)
    message = str(raised.value)
    assert len(message.splitlines()) == 1
    assert message.startswith(f"{path}: ")
    return message.removeprefix(f"{path}: ")


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "recording.csv"


EXPECTED = {"t_s": [0.0, 0.5], "head_mm": [1.5, -2.0]}

LAYOUTS = {
    "commas": "t_s,head_mm\n0,1.5\n0.5,-2\n",
    "semicolons and decimal commas": "t_s;head_mm\n0;1,5\n0,5;-2\n",
    "semicolons and points": "t_s;head_mm\n0;1.5\n0.5;-2\n",
    "tabs": "t_s\thead_mm\n0\t1.5\n0.5\t-2\n",
    "spaces": "t_s , head_mm\n 0 , 1.5 \n 0.5, -2\n",
    "byte order mark": "\ufefft_s,head_mm\n0,1.5\n0.5,-2\n",
    "Windows": "t_s,head_mm\r\n0,1.5\r\n0.5,-2\r\n",
    "old Macintosh": "t_s,head_mm\r0,1.5\r0.5,-2\r",
    "comments and empty lines": "# bench 3\n\nt_s,head_mm\n0,1.5\n# turned\n\n0.5,-2\n",
    "quotes": '"t_s","head_mm"\n"0","1.5"\n"0.5","-2"\n',
    "exponents": "t_s,head_mm\n0E0,15e-1\n5.0e-1,-2e+0\n",
    "no line end": "t_s,head_mm\n0,1.5\n0.5,-2",
}


@pytest.mark.parametrize("layout", LAYOUTS)
def test_usual_layouts_are_read(file: Path, layout: str) -> None:
    file.write_bytes(LAYOUTS[layout].encode())
    assert read(file) == EXPECTED


def test_text_in_other_columns_does_not_matter(file: Path) -> None:
    file.write_text('t_s,note,head_mm\n0,"up, then down",1.5\n0.5,,-2\n')
    assert read(file, "head_mm", "t_s") == EXPECTED


def test_header_with_commas_in_names_and_semicolons_between(file: Path) -> None:
    file.write_text("Kopf, mm;Spitze, mm\n1,5;2,5\n")
    assert read(file) == {"Kopf, mm": [1.5], "Spitze, mm": [2.5]}


def test_names_cannot_speak_to_the_terminal(file: Path) -> None:
    file.write_text("a\x1b[31m,b\nx,2\n")
    assert "\x1b" not in refusal(file)


def test_hash_is_of_the_whole_file(file: Path) -> None:
    file.write_text(LAYOUTS["commas"])
    assert table.open_table(file).sha256 == hashlib.sha256(file.read_bytes()).hexdigest()


REFUSED = {
    "text in numbers": ("a,b\n1,2\n3,4mm\n", "line 3, column 'b': '4mm' is not a number"),
    "NaN": ("a,b\n1,2\nnan,4\n", "line 3, column 'a': 'nan' is no number"),
    "infinity": ("a,b\n1,2\n3,-inf\n", "line 3, column 'b': '-inf' is not finite"),
    "empty cell": ("a,b\n1,2\n3,\n", "line 3, column 'b': an empty cell is no number"),
    "cut off line": ("a,b,c\n1,2,3\n3,4\n", "line 3: 2 cells, the header has 3"),
    "surplus cell": ("a,b\n1,2\n3,4,5\n", "line 3: 3 cells, the header has 2"),
    "header only": ("a,b\n", "no samples below"),
    "only comments": ("# a\n\n", "no line with values"),
    "decimal commas between commas": ("a,b\n1,5,2,5\n", "4 cells, the header has 2"),
    "thousands beside whole numbers": (
        "a;b\n500;2\n1,234;4\n",
        "'1,234' may be 1.234 or 1234: whole",
    ),
    "thousands seen too late": ("a;b\n1.234;2\n2.345,5;4\n", "line 2, column 'a': '1.234' may be"),
    "a comma before points": ("a;b\n1,234;2\n12.5;4\n", "1234: line 3 has '12.5'"),
    "groups of two": ("a;b\n1,23,456.0;2\n3;4\n", "'1,23,456.0' is not a number"),
    "comma in a file with points": ("a;b\n1.5;2\n3,5;4\n", "decimal points, so no commas"),
    "point in a file with commas": ("a;b\n1,5;2\n3.5;4\n", "decimal commas, so no points"),
    "digits apart": ("a,b\n1,2\n3,4_0\n", "'4_0' is not a number"),
    "name given twice": ("a,a\n1,2\n", "2 columns are called 'a'"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_bad_text_is_refused_with_its_place(file: Path, case: str) -> None:
    content, words = REFUSED[case]
    file.write_text(content)
    assert words in refusal(file)


def test_line_numbers_count_comments_and_empty_lines(file: Path) -> None:
    file.write_text("# one\n\na,b\n1,2\n# five\n3,x\n")
    assert refusal(file).startswith("line 6, column 'b'")


FOREIGN = {
    "empty": (b"", "is empty"),
    "binary": (b"MZ\x90\0\3\0\0\0", "is a binary file"),
    "damaged spreadsheet": (b"PK\x03\x04rest", "a zip archive or a spreadsheet, damaged"),
    "gzip": (b"\x1f\x8b\x08rest", "unpack it first"),
    "damaged UTF-16": ("a,b\n1,2\n".encode("utf-16")[:-1], "damaged UTF-16 text; save it as"),
    "UTF-32": ("a,b\n1,2\n".encode("utf-32"), "save it as UTF-8"),
    "no text of the west": (b"a,b\n1,2\n\x81\x8d,3\n", "line 3: neither UTF-8 nor Windows-1252"),
    "NumPy array": (b"\x93NUMPY\x01\0v\0", "save named ones with numpy.savez"),
    "HDF5": (b"\x89HDF\r\n\x1a\n", "an HDF5 file that MATLAB did not write"),
    "unknown MATLAB": (b"MATLAB 9.9 MAT-file", "a MATLAB file of an unknown version"),
    "cut off MATLAB": (b"MATLAB 5.0 MAT-file", "damaged or incomplete MATLAB file"),
    "cut off MATLAB 7.3": (b"MATLAB 7.3 MAT-file", "damaged or incomplete MATLAB file"),
    "one endless line": (b"a," * 600_000, "more than 1000000 characters"),
    "cut off Parquet": (b"PAR1\x15\x04", "damaged or incomplete"),
}


@pytest.mark.parametrize("case", FOREIGN)
def test_other_kinds_of_files_are_refused(file: Path, case: str) -> None:
    content, words = FOREIGN[case]
    file.write_bytes(content)
    assert words in refusal(file)


def test_missing_file_folder_and_pipe(tmp_path: Path) -> None:
    assert "no such file" in refusal(tmp_path / "none.csv")
    assert "is a folder" in refusal(tmp_path)
    os.mkfifo(tmp_path / "pipe")
    assert "a device or a pipe" in refusal(tmp_path / "pipe")


def test_unreadable_file(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file.write_text(LAYOUTS["commas"])

    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "open", refuse)  # file modes do not stop root
    assert refusal(file) == "may not be read; change its permissions"


def test_gigabytes_are_refused_with_size_and_limit(file: Path) -> None:
    with file.open("wb") as sparse:
        sparse.write(b"a,b\n1,2\n")
        sparse.truncate(array_column.LARGEST_TEXT_BYTES + 1)
    # A sparse file: zeros follow, so that nothing but the size is refused before the bytes are.
    with file.open("r+b") as filled:
        filled.write(b"a,b\n" + b"1,2\n" * (table.LOOKED_AT_BYTES // 4))
    assert "is 1001 MB, above the limit of 1000 MB" in refusal(file)


def test_more_samples_than_the_bound_are_refused(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(text_table, "MOST_SAMPLES", 3)
    file.write_text("a,b\n" + "1,2\n" * 4)
    assert "above the limit" in refusal(file)
    file.write_text("a,b\n" + "1,2\n" * 3)
    assert read(file)["a"] == [1.0, 1.0, 1.0]


@given(
    content=st.binary(max_size=300) | st.text("ab1,;.\t\"'\n\r#% =s-", max_size=80).map(str.encode)
)
def test_any_content_gives_numbers_or_one_line(
    tmp_path_factory: pytest.TempPathFactory, content: bytes
) -> None:
    file = tmp_path_factory.getbasetemp() / "any.csv"
    file.write_bytes(content)
    try:
        columns = read(file)
    except InputError as error:
        assert len(str(error).splitlines()) == 1
    else:
        assert all(np.isfinite(values).all() for values in columns.values())


@given(
    values=st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=1, max_size=20),
    separator=st.sampled_from([",", ";", "\t"]),
    comma=st.booleans(),
)
def test_every_number_comes_back_as_it_was_written(
    tmp_path_factory: pytest.TempPathFactory, values: list[float], separator: str, comma: bool
) -> None:
    rows = [f"{i}{separator}{value!r}" for i, value in enumerate(values)]
    text = "\n".join([f"i{separator}x", *rows])
    if comma and separator != ",":
        text = text.replace(".", ",")
    file = tmp_path_factory.getbasetemp() / "written.csv"
    file.write_text(text)
    assert read(file)["x"] == values


@pytest.mark.skipif(not MEASURED.is_dir(), reason="no recordings beside the project")
def test_real_recordings_are_read_as_they_are() -> None:
    for path in sorted(MEASURED.glob("*.csv")):
        columns = read(path)
        assert list(columns) == ["t_s", "motor_deg", "spindle_deg", "jaw_deg", "jaw_torque_Nm"]
        assert len(columns["t_s"]) == len(path.read_text().splitlines()) - 1
        assert np.diff(columns["t_s"]).min() > 0.0


def test_text_of_windows_is_read_and_said_so(file: Path) -> None:
    file.write_bytes("Weg;Größe µm\n0,5;1\n1,5;2\n".encode("cp1252"))
    opened = table.open_table(file)
    assert opened.note == "is not UTF-8; read as Windows-1252 (cp1252)"
    assert read(file) == {"Weg": [0.5, 1.5], "Größe µm": [1.0, 2.0]}
    file.write_text("Weg;Größe µm\n0,5;1\n1,5;2\n", encoding="utf-8")
    assert table.open_table(file).note == ""


@pytest.mark.parametrize(
    ("text", "numbers"),
    [
        ("a;b\n900.5;1\n1,234.5;1\n2,000;1\n", [900.5, 1234.5, 2000.0]),
        ("a;b\n900,5;1\n-1.234,5;1\n", [900.5, -1234.5]),
        ("a\tb\n1.234.567\t1\n1.234\t1\n5,5\t1\n", [1234567.0, 1234.0, 5.5]),
        ('a,b\n"1,234.5",1\n"1,234",1\n', [1234.5, 1234.0]),
        ('b;a\n0.5;"1,250.5"\n', [1250.5]),
        ("a;b\n1 234,5;1\n12,5;1\n", [1234.5, 12.5]),
        ("a;b\n12,345;1\n9,871;1\n", [12.345, 9.871]),
    ],
)
def test_thousands_separators_are_read_where_they_are_sure(
    text: str, numbers: list[float], tmp_path: Path
) -> None:
    (tmp_path / "a.csv").write_text(text)
    assert read(tmp_path / "a.csv", "a")["a"] == numbers
