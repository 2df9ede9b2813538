"""Recordings that are piped in: what a command makes of them, and what it refuses."""

import io
import json
import os
import sys
from pathlib import Path

import numpy as np
import pandas
import pytest

from opensuction.kernel.errors import InputError
from opensuction.recording import table
from tests.cli.command import opensuction
from tests.library.recordings import bench

COLUMNS = ("--input", "head_mm", "--output", "tip_mm")


def text(encoding: str = "utf-8") -> bytes:
    rows = [f"{x!r},{y!r},0" for x, y in np.column_stack(bench(200)).tolist()]
    return "\n".join(["head_mm,tip_mm,Größe", *rows, ""]).encode(encoding)


def test_a_table_is_identified_and_called_by_what_it_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    reader, writer = os.pipe()
    os.write(writer, text("cp1252"))  # a few kB: a pipe has room for them
    os.close(writer)
    with os.fdopen(reader) as stream:
        monkeypatch.setattr(sys, "stdin", stream)
        ran = opensuction("identify", "-", *COLUMNS, "--json", "--out", "found", cwd=tmp_path)
    assert ran.returncode == 0, ran.stderr
    data = json.loads(ran.stdout)
    assert data["recording"]["file"] == "standard input"
    assert data["recording"]["samples"] == 200
    assert "on standard input: head_mm to tip_mm" in ran.stderr
    assert "standard input: is not UTF-8; read as Windows-1252 (cp1252)" in ran.stderr
    assert "standard input" in (tmp_path / "found" / "identification.toml").read_text("utf-8")
    assert [one.name for one in tmp_path.iterdir()] == ["found"]


def workbook() -> bytes:
    content = io.BytesIO()
    names = ["head_mm", "tip_mm"]
    pandas.DataFrame(np.column_stack(bench(200)), columns=names).to_excel(content, index=False)
    return content.getvalue()


@pytest.mark.parametrize("kind", ["JSON", "Excel", "UTF-16"])
def test_other_formats_are_read_from_standard_input_too(
    kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    head, tip = (column.tolist() for column in bench(200))
    contents = {
        "JSON": json.dumps({"head_mm": head, "tip_mm": tip}).encode(),
        "Excel": workbook(),
        "UTF-16": text("utf-16"),
    }
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(contents[kind])))
    with table.spool() as file:
        columns, _ = table.read_columns(table.open_table(file), ["head_mm", "tip_mm"])
    assert columns["head_mm"] == pytest.approx(head, rel=1e-14)  # a workbook has 15 digits
    assert columns["tip_mm"] == pytest.approx(tip, rel=1e-14)


REFUSED = {
    "nothing": (b"", "standard input: is empty"),
    "cut off JSON": (b'[{"head_mm": 1,', "standard input: line 1: is damaged or incomplete JSON"),
    "gzip": (b"\x1f\x8b\x08", "standard input: is compressed (gzip); unpack it first, or pipe"),
    "binary": (b"MZ\0\0", "standard input: is a binary file"),
    "no such column": (b"head_mm,b\n1,2\n", "unknown column in standard input: 'tip_mm'"),
    "text in a cell": (b"head_mm,tip_mm\n1,2\n3,x\n", "standard input: line 3, column 'tip_mm'"),
    "too few": (b"head_mm,tip_mm\n1,2\n3,4\n", "standard input: 2 samples, at least 12"),
}


def test_what_is_no_recording_is_refused_by_its_name(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for content, words in REFUSED.values():
        stream = io.TextIOWrapper(io.BytesIO(content))
        monkeypatch.setattr(sys, "stdin", stream)
        ran = opensuction("compare", "-", *COLUMNS, cwd=tmp_path)
        assert (ran.returncode, ran.stdout) == (2, "")
        assert ran.stderr.splitlines()[-1].startswith(f"opensuction: {words}")
        assert list(tmp_path.iterdir()) == []


def test_what_never_ends_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(table, "LARGEST_TEXT_BYTES", 10_000_000)
    with Path("/dev/zero").open("rb") as endless:
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(endless))
        with (
            pytest.raises(InputError, match="more than 10 MB, above the limit"),
            table.spool(),
        ):
            pass


def test_a_terminal_is_no_recording(monkeypatch: pytest.MonkeyPatch) -> None:
    class Terminal(io.BytesIO):
        def isatty(self) -> bool:
            return True

    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(Terminal(b"a,b\n")))
    with (
        pytest.raises(InputError, match="standard input: nothing is piped in"),
        table.spool(),
    ):
        pass
    monkeypatch.setattr(sys, "stdin", None)
    with pytest.raises(InputError, match="nothing is piped in"), table.spool():
        pass
