"""An identification from names of columns to results, without a command line."""

from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from opensuction.kernel.errors import InputError
from opensuction.recording import text_table
from opensuction.recording.table import Columns
from opensuction.report.identification import identification_words as words
from opensuction.session.choice import RecordingChoice
from opensuction.session.identification import identification_run as run
from opensuction.session.identification.identification_summary import summarise_fit
from tests.recording.test_workbook import write as write_workbook

HEAD = 50.0 - 50.0 * np.cos(np.linspace(0.0, 20.0, 200))


def write(folder: Path, names: str, *columns: NDArray[Any]) -> Path:
    file = folder / "bench.csv"
    rows = (",".join(map(str, row)) for row in zip(*columns, strict=True))
    file.write_text("\n".join([names, *rows]) + "\n")
    return file


def choose(
    file: Path, input_: str = "head_mm", output: str = "tip_mm", **more: Any
) -> RecordingChoice:
    return RecordingChoice(file, (input_,), output)._replace(**more)


def test_columns_beside_are_read_together(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Twenty numbers in one pass; a text costs a few that end at its first cell."""
    count = 22
    others: list[NDArray[Any]] = [HEAD + place for place in range(count)]
    others[3] = np.full(HEAD.size, "left")
    names = ",".join(["head_mm", "tip_mm", *(f"c{place}" for place in range(count))])
    file = write(tmp_path, names, HEAD, 0.9 * HEAD, *others)
    asked: list[int] = []
    read = text_table.read_columns

    def count_reads(path: Path, wanted: Sequence[str], *more: Any, **named: Any) -> Columns:
        asked.append(len(wanted))
        return read(path, wanted, *more, **named)

    monkeypatch.setattr(text_table, "read_columns", count_reads)
    loaded = run.load(choose(file), "dahl", None)
    assert list(loaded.beside) == [f"c{place}" for place in range(21) if place != 3]
    assert loaded.beside["c20"] == pytest.approx(HEAD + 20)
    assert len(asked) <= 2 + 2 * 5 + 1


def test_a_column_beside_that_has_gaps_is_left_out_and_costs_no_others(tmp_path: Path) -> None:
    gaps = HEAD.copy()
    gaps[7] = np.nan
    file = write(tmp_path, "head_mm,tip_mm,c0,c1", HEAD, 0.9 * HEAD, gaps, HEAD + 1.0)
    assert list(run.load(choose(file), "dahl", None).beside) == ["c1"]
    file = write(tmp_path, "head_mm,tip_mm,c0,c1", HEAD, 0.9 * gaps, gaps, HEAD + 1.0)
    loaded = run.load(choose(file, skip_missing=True), "dahl", None)
    assert list(loaded.beside) == ["c0", "c1"]
    assert loaded.beside["c1"] == pytest.approx(np.delete(HEAD + 1.0, 7))


@pytest.mark.parametrize(
    ("name", "seconds"), [("t (msec)", 0.2), ("time_minutes", 12000.0), ("t", 200.0)]
)
def test_times_are_in_seconds_whatever_their_column_is_in(
    name: str, seconds: float, tmp_path: Path
) -> None:
    file = write(tmp_path, f"{name},head_mm,tip_mm", np.arange(1, 201), HEAD, 0.9 * HEAD)
    loaded = run.load(choose(file, time=name), "dahl", None)
    assert loaded.pair.time_s is not None
    assert loaded.pair.time_s[-1] == pytest.approx(seconds)
    given = run.load(choose(file, time=name, time_unit="us"), "dahl", None)
    assert given.pair.time_s is not None
    assert given.pair.time_s[-1] == pytest.approx(2e-4)


def test_a_unit_that_is_not_known_is_settled_by_the_option_named(tmp_path: Path) -> None:
    file = write(tmp_path, "Head (furlong),pos (5),motor_a", HEAD, 0.9 * HEAD, HEAD)
    choice = choose(file, "Head (furlong)", "pos (5)")
    with pytest.raises(InputError, match=r"'Head \(furlong\)': .* give --input-unit, '' for none"):
        run.load(choice, "dahl", None)
    labels = run.load(choice._replace(input_unit="Millimeter"), "dahl", None).labels
    assert (labels.input_unit, labels.output_unit) == ("mm", "output")
    labels = run.load(choose(file, "motor_a", "pos (5)"), "dahl", None).labels
    assert (labels.input_unit, labels.behind_input) == ("input", "")


def test_a_unit_of_time_without_a_time_is_refused(tmp_path: Path) -> None:
    file = write(tmp_path, "head_mm,tip_mm", HEAD, 0.9 * HEAD)
    for unit, time, said in (
        ("ms", None, "--time-unit needs the column of time"),
        ("mm", "t", "--time-unit 'mm': should be one of ns, us, ms, s, min, h, d"),
    ):
        with pytest.raises(InputError, match=said):
            run.load(choose(file, time=time, time_unit=unit), "dahl", None)


def test_an_epoch_that_is_not_cut_is_warned_of(tmp_path: Path) -> None:
    time_s = 1764000000 + np.arange(200)
    file = write(tmp_path, "t_s,head_mm,tip_mm", time_s, HEAD, 0.9 * HEAD)
    loaded = run.load(choose(file, time="t_s", from_s=5.0), "dahl", None)
    (found,) = run.fit(loaded)
    assert found.warnings[0] == "--from 5 cuts nothing: the recording begins at 1764000000 s."
    cut = run.load(choose(file, time="t_s", from_s=1764000005.0), "dahl", None)
    assert (cut.pair.driven.size, cut.notes) == (195, ())


@pytest.mark.parametrize(
    ("slope", "friction", "noise"),
    [(0.01, 0.0, 1.0), (0.9, 0.0, 0.0), (0.9, 0.0, 0.2), (0.9, 0.5, 3.0)],
    ids=["noise", "a line", "a noisy line", "a gap below the noise"],
)
def test_what_is_not_determined_gives_no_gap(
    slope: float, friction: float, noise: float, tmp_path: Path
) -> None:
    random = np.random.default_rng(5)
    tip = slope * HEAD + friction * np.sign(np.gradient(HEAD)) + noise * random.normal(size=200)
    file = write(tmp_path, "head_mm,tip_mm", HEAD, tip + 0.1 * noise * np.sign(HEAD - 50.0))
    loaded = run.load(choose(file), "modified-dahl", None)
    (found,) = run.fit(loaded)
    result = summarise_fit(loaded, found, datetime(2026, 1, 1, tzinfo=UTC), 0.0)
    said = " ".join(result.fit.warnings)
    assert result.fit.determined is ("Not determined" not in said and "mean nothing" not in said)
    assert result.fit.determined is False or "Uncertain" in said
    assert "apart" not in " ".join(words.sentences(result))


def test_the_sheet_of_a_workbook_is_the_one_that_was_named(tmp_path: Path) -> None:
    rows: list[list[Any]] = [["head_mm", "tip_mm"], *([at, 0.9 * at] for at in HEAD.tolist())]
    twice = [rows[0], *([at, 0.5 * at] for at in HEAD.tolist())]
    file = write_workbook(tmp_path / "bench.xlsx", Slow=rows, Fast=twice)
    loaded = run.load(choose(file, sheet="Fast"), "dahl", None)
    assert loaded.pair.answer == pytest.approx(0.5 * HEAD, rel=1e-12)
    with pytest.raises(InputError, match="name one by --sheet: 'Slow', 'Fast'"):
        run.load(choose(file), "dahl", None)
