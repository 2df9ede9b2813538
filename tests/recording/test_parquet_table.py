"""Parquet tables: numbers of every kind, times, what is missing, what is damaged."""

import builtins
from datetime import UTC, datetime, timedelta
from decimal import Decimal
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from opensuction.kernel.errors import InputError
from opensuction.recording import binary_table, table


def written(path: Path, **columns: Any) -> Path:
    pq.write_table(pa.table(columns), path)
    return path


def read(path: Path, *names: str) -> dict[str, list[float]]:
    columns, _ = table.read_columns(table.open_table(path), names)
    return {name: values.tolist() for name, values in columns.items()}


def refusal(path: Path, *names: str) -> str:
    with pytest.raises(InputError) as raised:
        read(path, *names)
    assert len(str(raised.value).splitlines()) == 1
    return str(raised.value)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "recording.parquet"


def test_numbers_of_every_kind_become_doubles(file: Path) -> None:
    written(
        file,
        single=pa.array([0.5, 1.5], pa.float32()),
        counts=pa.array([1, 2], pa.int16()),
        exact=pa.array([Decimal("0.25"), Decimal("-1.75")]),
        note=["up", "down"],
    )
    assert read(file, "single", "counts", "exact") == {
        "single": [0.5, 1.5],
        "counts": [1.0, 2.0],
        "exact": [0.25, -1.75],
    }


def test_dates_and_durations_become_seconds(file: Path) -> None:
    start = datetime(2026, 1, 2, 3, 4, 5, tzinfo=UTC)
    written(
        file,
        at=[start, start + timedelta(milliseconds=10)],
        since=pa.array([5_000, 5_250], pa.duration("ms")),
    )
    assert read(file, "at", "since") == {"at": [0.0, 0.01], "since": [0.0, 0.25]}


def test_a_name_does_not_matter_the_content_does(tmp_path: Path) -> None:
    path = written(tmp_path / "recording.csv", head_mm=[1.0, 2.0])
    assert read(path, "head_mm") == {"head_mm": [1.0, 2.0]}


def test_missing_values_are_refused_with_their_row(file: Path) -> None:
    written(file, a=[1.0, None, 3.0], b=[1.0, 2.0, float("inf")])
    assert "row 2, column 'a': missing" in refusal(file, "a")
    assert "row 3, column 'b': inf" in refusal(file, "b")


@pytest.mark.parametrize("missing", [[0], [0, 1], [0, 3], [2]])
def test_a_time_that_is_missing_first_counts_itself_alone(file: Path, missing: list[int]) -> None:
    start = datetime(2026, 1, 2, tzinfo=UTC)
    at = [None if i in missing else start + timedelta(seconds=i) for i in range(4)]
    since = pa.array([None if i in missing else 1000 * i for i in range(4)], pa.duration("ms"))
    written(file, at=at, since=since, a=[0.0, 1.0, 2.0, 3.0])
    for name in ("at", "since"):
        words = f"row {missing[0] + 1}, column {name!r}: missing, should be a number "
        assert f"{words}(in {len(missing)} of 4 rows)" in refusal(file, name)
    columns, left_out = table.read_columns(table.open_table(file), ["at", "a"], skip_missing=True)
    kept = [float(i) for i in range(4) if i not in missing]
    assert columns["a"].tolist() == kept
    assert (columns["at"] - columns["at"][0]).tolist() == [i - kept[0] for i in kept]
    assert left_out == len(missing)


def test_a_time_that_is_missing_everywhere_is_refused(file: Path) -> None:
    written(file, at=pa.array([None, None], pa.timestamp("ms")))
    assert "(in 2 of 2 rows)" in refusal(file, "at")


def test_text_is_refused(file: Path) -> None:
    written(file, a=["1.0", "2.0"])
    assert "column 'a' holds string, should hold numbers" in refusal(file, "a")


def test_no_rows_are_refused(file: Path) -> None:
    written(file, a=pa.array([], pa.float64()))
    assert "no samples" in refusal(file, "a")


def test_more_rows_than_the_bound_are_refused_before_they_are_read(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(binary_table, "MOST_SAMPLES", 3)
    written(file, a=[1.0, 2.0, 3.0, 4.0])
    assert "above the limit" in refusal(file, "a")


def test_damage_inside_is_refused(file: Path) -> None:
    written(file, a=[float(i) for i in range(2000)])
    content = bytearray(file.read_bytes())
    content[4:1000] = bytes(996)
    file.write_bytes(content)
    assert "damaged or incomplete" in refusal(file, "a")


def test_without_pyarrow_the_remedy_is_named(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written(file, a=[1.0, 2.0])
    real = builtins.__import__

    def without(name: str, *rest: Any) -> Any:
        if name.startswith("pyarrow"):
            raise ImportError(name)
        return real(name, *rest)

    monkeypatch.setattr(builtins, "__import__", without)
    assert "pip install 'opensuction[parquet]'" in refusal(file, "a")
