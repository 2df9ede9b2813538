"""``cycle --trace``: the time series as a file, refused before anything is played."""

import json
import sys
from pathlib import Path

import pytest

import opensuction as osn
from opensuction.kernel.errors import InputError
from opensuction.session.cycle import trace_file
from tests.cli.command import Ran, largest_file, opensuction

CYCLE = ("cycle", "--machine", "bench", "--compensation", "none", "--no-recording", "--json")


def one_line(ran: Ran, status: int) -> str:
    assert (ran.returncode, ran.stdout) == (status, "")
    return ran.stderr.splitlines()[-1]


BAD = {
    "ending": ("ticks.xlsx", "--trace ticks.xlsx: should end in .csv or .parquet"),
    "no ending": ("ticks", "--trace ticks: should end in .csv or .parquet"),
    "there already": ("old.csv", "--trace old.csv: is there already; name another one or add"),
    "a folder": ("folder.csv", "--trace folder.csv: this is a folder; name a file"),
    "no folder": ("none/ticks.csv", "--trace none/ticks.csv: there is no folder none; make it"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_cannot_be_meant_is_refused_before_anything_is_played(
    tmp_path: Path, case: str
) -> None:
    (tmp_path / "old.csv").write_text("old")
    (tmp_path / "folder.csv").mkdir()
    file, words = BAD[case]
    line = one_line(opensuction(*CYCLE, "--trace", file, "--out", "run", cwd=tmp_path), 2)
    assert line.startswith(f"opensuction: {words}")
    assert sorted(one.name for one in tmp_path.iterdir()) == ["folder.csv", "old.csv"]


def test_without_pyarrow_parquet_is_refused_with_the_remedy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    line = one_line(opensuction(*CYCLE, "--trace", "ticks.parquet", cwd=tmp_path), 2)
    assert "pip install 'opensuction[parquet]', or take --trace ticks.csv" in line


def test_with_force_a_file_is_replaced_and_named(tmp_path: Path) -> None:
    (tmp_path / "ticks.parquet").write_text("old")
    arguments = ("--trace", "ticks.parquet", "--out", "run", "--force")
    ran = opensuction(*CYCLE, *arguments, cwd=tmp_path)
    assert json.loads(ran.stdout)["trace"] == "ticks.parquet"
    assert osn.read(tmp_path / "ticks.parquet", "time_s")["time_s"].size > 20_000
    assert sorted(one.name for one in tmp_path.iterdir()) == ["run", "ticks.parquet"]


@pytest.mark.skipif(sys.platform == "win32", reason="no limit of a file's size")
def test_a_full_disk_leaves_nothing_half_written(tmp_path: Path) -> None:
    (tmp_path / "ticks.csv").write_text("old")
    arguments = ("--trace", "ticks.csv", "--force", "--out", "run")
    with largest_file(2_000_000):
        ran = opensuction(*CYCLE, *arguments, cwd=tmp_path)
    line = one_line(ran, 74)
    assert line == "opensuction: ticks.csv: file too large; nothing was written"
    assert [one.name for one in tmp_path.iterdir()] == ["ticks.csv"]
    assert (tmp_path / "ticks.csv").read_text() == "old"


def test_a_file_is_taken_as_soon_as_it_is_named(tmp_path: Path) -> None:
    file = tmp_path / "ticks.csv"
    with (
        trace_file.reserve(file, force=False),
        pytest.raises(InputError, match="is there already; name another one or add --force"),
        trace_file.reserve(file, force=False),
    ):
        pytest.fail("two have it")
    with pytest.raises(InputError, match="is there already"):
        trace_file.check(file, force=False)


@pytest.mark.parametrize(
    ("before", "written", "after"),
    [(None, None, None), (None, "new", "new"), ("old", None, "old"), ("", None, "")],
)
def test_a_cycle_that_fails_leaves_no_empty_trace(
    before: str | None, written: str | None, after: str | None, tmp_path: Path
) -> None:
    file = tmp_path / "ticks.csv"
    if before is not None:
        file.write_text(before)
    with pytest.raises(KeyboardInterrupt), trace_file.reserve(file, force=True):  # noqa: PT012
        if written is not None:
            with trace_file.place(file) as aside:
                aside.write_text(written)
        raise KeyboardInterrupt
    assert (file.read_text() if file.exists() else None) == after
