"""JSON as programs and services write it: records, columns, rows and lines, or one line why not."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel.errors import InputError
from opensuction.recording import json_table, table
from tests.recording.test_table import EXPECTED, read, refusal

CELLS = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=3)
KEYS = st.sampled_from(["t", "x", "data", "columns", "1", ""])
FRAME = pandas.DataFrame(EXPECTED)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "recording.json"


READ = {
    "records": '[{"t_s": 0, "head_mm": 1.5},\n {"t_s": 0.5, "head_mm": -2}]',
    "lines": '{"t_s": 0, "head_mm": 1.5}\r\n\r\n{"t_s": 0.5, "head_mm": -2}\r\n',
    "columns": '{"t_s": [0, 0.5], "head_mm": [1.5, -2], "rate_hz": 2, "limits": [0, 1, 2]}',
    "columns in a list": '[{"t_s": [0, 0.5], "head_mm": [1.5, -2]}]',
    "rows with a header": '[["t_s", "head_mm"], [0, 1.5], [0.5, -2]]',
    "lines of rows": '["t_s", "head_mm"]\n[0, 1.5]\n[0.5, -2]\n',
    "text": '[{"t_s": "0", "head_mm": "1.5"}, {"t_s": " 0.5", "head_mm": "-2e0"}]',
    "byte order mark": '\ufeff{"t_s": [0, 0.5], "head_mm": [1.5, -2]}',
    "under a key": '{"bench": 3, "data": {"t_s": [0, 0.5], "head_mm": [1.5, -2]}}',
    "under a key, beside a list": '{"at": [1, 2], "data": [{"t_s": 0, "head_mm": 1.5}, '
    '{"t_s": 0.5, "head_mm": -2}]}',
    "pandas": FRAME.to_json(),
    "pandas, row by row": FRAME.to_json(orient="index"),
    "pandas, names apart": FRAME.to_json(orient="split"),
    "pandas, with a schema": FRAME.to_json(orient="table"),
}


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
@pytest.mark.parametrize("case", READ)
def test_usual_forms_are_read(file: Path, case: str, encoding: str) -> None:
    file.write_bytes(READ[case].encode(encoding))
    assert read(file, *EXPECTED) == EXPECTED


def test_rows_without_a_header_are_called_by_number(file: Path) -> None:
    file.write_text("[[0, 1.5], [0.5, -2]]")
    assert read(file) == {"1": [0.0, 0.5], "2": [1.5, -2.0]}


def test_a_record_in_a_record_gives_its_name_first(file: Path) -> None:
    file.write_text('[{"t": 0, "head": {"x": 1, "y": 2}}, {"t": 1, "head": {"x": 3, "y": 4}}]')
    assert read(file) == {"t": [0.0, 1.0], "head.x": [1.0, 3.0], "head.y": [2.0, 4.0]}


def test_the_key_of_a_table_is_told(file: Path) -> None:
    file.write_text(READ["under a key"])
    assert table.open_table(file).note == "its columns are read from 'data'"


def test_dates_are_seconds(file: Path) -> None:
    at = ["2026-01-31T12:00:00Z", "2026-01-31T12:00:00.25Z"]
    file.write_text(json.dumps({"at": at, "at_ms": at, "head": [1, 2]}))
    found = read(file)
    assert found["at"][1] - found["at"][0] == 0.25
    assert found["at_ms"][1] - found["at_ms"][0] == 250.0


REFUSED = {
    "one number": ("[3, 4]", "is JSON without a table of numbers; give records, as in [{"),
    "settings": ('{"rate": 100, "name": "bench"}', "is JSON without a table of numbers"),
    "nothing": ("[]", "is JSON without a table of numbers"),
    "rows of different lengths": ("[[0, 1], [1]]", "is JSON without a table of numbers"),
    "parts that are no columns": (
        '{"meta": {"rate": 100}, "more": {"deeper": {"t": [0, 1]}}}',
        "is JSON without a table of numbers",
    ),
    "two tables": (
        '{"a": {"t": [0, 1]}, "b": {"t": [0, 1]}}',
        "holds a table under each of 'a', 'b'; save one of them in a file of its own",
    ),
    "columns of different lengths": (
        '{"t": [0, 1, 2], "x": [1, 2]}',
        "'t' has 3 samples, 'x' 2; they should be as many",
    ),
    "text in numbers": (
        '[{"t": 0, "x": 1}, {"t": 1, "x": "up"}]',
        "row 2, column 'x': \"up\" is not a finite number",
    ),
    "decimal commas": ('{"t": [0], "x": ["1,5"]}', "row 1, column 'x': \"1,5\" is not a finite"),
    "digits apart": ('{"t": [0], "x": ["1_5"]}', "row 1, column 'x': \"1_5\" is not a finite"),
    "true": ('{"t": [0, 1], "x": [1, true]}', "row 2, column 'x': true is not a finite number"),
    "a list in a record": ('[{"t": 0, "x": [1]}, {"t": 1, "x": [2]}]', "column 'x': [1] is not a"),
    "null": (
        '[{"t": 0, "x": 1}, {"t": 1, "x": null}, {"t": 2}]',
        "row 2, column 'x': missing, should be a number (in 2 of 3 rows); fill it in, or leave",
    ),
    "NaN": ('{"t": [0, NaN], "x": [1, 2]}', "row 2, column 't': missing, should be a number"),
    "infinity": ('{"t": [0, Infinity], "x": [1, 2]}', "row 2, column 't': Infinity is not a fin"),
    "a number beyond all": (f'{{"t": [1{"0" * 400}, 2]}}', "is not a finite number"),
    "cut off": ('[{"t": 0, "x": 1},\n {"t": 1,', "line 2: is damaged or incomplete JSON (Exp"),
    "cut off lines": ('{"t": 0}\n{"t": 1}\n{"t"', "line 3: is damaged or incomplete JSON (Expect"),
    "too deep": ("[" * 100_000, "line 1: is damaged or incomplete JSON (nested too deep"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_anything_else_is_refused_in_one_line(file: Path, case: str) -> None:
    content, words = REFUSED[case]
    file.write_text(content)
    assert words in refusal(file)


def test_missing_numbers_leave_their_rows_out(file: Path) -> None:
    file.write_text('[{"t": 0, "x": 1}, {"t": 1, "x": null}, {"t": 2, "x": ""}, {"t": 3, "x": 4}]')
    columns, left_out = table.read_columns(table.open_table(file), ["t", "x"], True)
    assert (columns["t"].tolist(), columns["x"].tolist(), left_out) == ([0.0, 3.0], [1.0, 4.0], 2)


def test_other_encodings_and_too_large_files_are_refused(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file.write_bytes('{"µ": [0, 1]}'.encode("cp1252"))
    assert refusal(file) == "is JSON and not UTF-8; save it as UTF-8"
    monkeypatch.setattr(json_table, "LARGEST_BYTES", 10)
    assert "above the limit of 1 MB for JSON; save it as CSV or Parquet" in refusal(file)


@given(content=st.text('[]{}":,01.-entaulx \n', max_size=60))
def test_any_content_gives_numbers_or_one_line(
    tmp_path_factory: pytest.TempPathFactory, content: str
) -> None:
    file = tmp_path_factory.getbasetemp() / "any.json"
    file.write_text("[" + content)
    try:
        columns = read(file)
    except InputError as error:
        assert len(str(error).splitlines()) == 1
    else:
        assert all(np.isfinite(values).all() for values in columns.values())


@given(found=st.recursive(CELLS, lambda inner: st.lists(inner) | st.dictionaries(KEYS, inner)))
def test_any_json_gives_numbers_or_one_line(
    tmp_path_factory: pytest.TempPathFactory, found: Any
) -> None:
    file = tmp_path_factory.getbasetemp() / "some.json"
    file.write_text(json.dumps([found, found]))
    try:
        columns = read(file)
    except InputError as error:
        assert len(str(error).splitlines()) == 1
    else:
        assert all(np.isfinite(values).all() for values in columns.values())
