"""NumPy archives: named rows of numbers, and nothing that could run code."""

import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from opensuction.recording import binary_table, table
from tests.recording.test_table import read, refusal


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "recording.npz"


@pytest.mark.parametrize("write", [np.savez, np.savez_compressed])
def test_named_arrays_are_columns(file: Path, write: Any) -> None:
    write(
        file, t_s=np.array([0.0, 0.5]), head_mm=np.array([[1], [2]]), flag=np.array([True, False])
    )
    assert read(file) == {"t_s": [0.0, 0.5], "head_mm": [1.0, 2.0], "flag": [1.0, 0.0]}


def test_dates_become_seconds(file: Path) -> None:
    dates = np.array(["2026-01-01T00:00:00.000", "2026-01-01T00:00:00.250"], dtype="datetime64[ms]")
    np.savez(file, at=dates)
    assert read(file, "at") == {"at": [0.0, 0.25]}


@pytest.mark.parametrize("kind", ["datetime64[ms]", "timedelta64[us]"])
def test_a_date_that_is_missing_first_counts_itself_alone(file: Path, kind: str) -> None:
    at = np.array(["NaT", 1_000_000, 2_000_000], dtype=kind)
    np.savez(file, at=at, a=np.arange(3.0))
    assert "row 1, column 'at': missing, should be a number (in 1 of 3 rows)" in refusal(file, "at")
    columns, left_out = table.read_columns(table.open_table(file), ["at", "a"], skip_missing=True)
    second = 1000.0 if kind == "datetime64[ms]" else 1.0
    assert columns["at"].tolist() == [0.0, second]
    assert (columns["a"].tolist(), left_out) == ([1.0, 2.0], 1)


class Code:
    """Runs something where it is unpickled."""

    def __reduce__(self) -> Any:
        return (pytest.fail, ("a file ran code",))


BAD = {
    "objects": (np.array([Code(), 1], dtype=object), "holds Python objects"),
    "matrix": (np.zeros((3, 4)), "is 3 x 4, should be one row or column"),
    "text": (np.array(["a", "b"]), "holds <U1, should hold numbers"),
    "complex": (np.array([1j]), "holds complex128, should hold numbers"),
    "missing": (np.array([1.0, np.nan, np.nan]), "row 2, column 'a': missing"),
    "nothing": (np.array([]), "has no samples"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_is_no_row_of_numbers_is_refused(file: Path, case: str) -> None:
    values, words = BAD[case]
    np.savez(file, a=values)
    assert words in refusal(file, "a")


def test_columns_of_different_lengths_are_refused(file: Path) -> None:
    np.savez(file, a=np.zeros(3), b=np.zeros(4))
    assert refusal(file, "a", "b") == "'a' has 3 samples, 'b' 4; they should be as many"


def test_too_many_samples_are_refused_before_they_are_unpacked(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    np.savez_compressed(file, a=np.zeros(40_000))
    monkeypatch.setattr(binary_table, "MOST_SAMPLES", 1000)
    assert "rows or more, above the limit" in refusal(file, "a")


@pytest.mark.parametrize("share", [0.3, 0.6, 0.9])
def test_a_cut_off_archive_is_refused(file: Path, share: float) -> None:
    np.savez(file, a=np.arange(1000.0))
    content = file.read_bytes()
    file.write_bytes(content[: int(share * len(content))])
    # Without its list of members it is any zip archive.
    assert "zip archive or a spreadsheet" in refusal(file, "a")


def test_an_array_that_says_it_is_larger_than_the_memory_is_refused(file: Path) -> None:
    heading = io.BytesIO()
    shape = {"descr": "<f8", "fortran_order": False, "shape": (10**15,)}
    np.lib.format.write_array_header_1_0(heading, shape)
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("a.npy", heading.getvalue() + bytes(80))
    assert "damaged" in refusal(file, "a")


def test_altered_bytes_inside_are_refused(file: Path) -> None:
    np.savez_compressed(file, a=np.arange(1000.0))
    content = bytearray(file.read_bytes())
    content[60:90] = bytes(30)
    file.write_bytes(content)
    assert "damaged" in refusal(file, "a")
