"""Data sets from files and equations: found, cut, or said to be missing."""

import hashlib
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from opensuction.evidence.leaderboard import data_set
from opensuction.evidence.leaderboard.data_set import DataSet, Split, halves
from opensuction.evidence.leaderboard.data_set_table import DATA_SETS
from opensuction.kernel.errors import InputError
from tests.evidence.leaderboard.data_set_example import LINE, SAMPLES

ROWS = 8


def of_file(file: Path, **changes: object) -> DataSet:
    """A data set that is in a file."""
    digest = hashlib.sha256(file.read_bytes()).hexdigest()
    described = LINE._replace(generate=None, file=file.name, sha256=digest, split=halves(0, ROWS))
    return described._replace(**changes)  # type: ignore[arg-type]


@pytest.fixture
def text(tmp_path: Path) -> Path:
    """A table in a folder of the folder."""
    file = tmp_path / "inner" / "line.csv"
    file.parent.mkdir()
    file.write_text("t,x,y\n" + "".join(f"{k},{k * k},{-k}\n" for k in range(ROWS)))
    return file


def test_a_file_is_found_below_the_folder_and_cut(text: Path, tmp_path: Path) -> None:
    split = Split(1, 4, 5, 7, "some")
    found = data_set.find(of_file(text, split=split, negate_output=True), tmp_path)
    assert (found.state, found.note) == (data_set.THERE, str(text))
    assert found.samples is not None
    assert found.samples.inputs.tolist() == [[1.0, 4.0, 9.0, 16.0, 25.0, 36.0]]
    assert found.samples.output.tolist() == [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    assert (found.samples.fitted, found.samples.held_out) == (3, 4)


def test_a_matlab_file(tmp_path: Path) -> None:
    file = tmp_path / "line.mat"
    savemat(file, {"x": np.arange(ROWS)[:, None] * 1.0, "y": np.ones((ROWS, 1))})
    found = data_set.find(of_file(file), tmp_path)
    assert found.samples is not None
    assert found.samples.inputs[0].tolist() == list(range(ROWS))


def test_rows_without_a_number_are_left_out_where_the_data_set_says_so(tmp_path: Path) -> None:
    file = tmp_path / "gaps.csv"
    file.write_text("x,y\n0,\n" + "".join(f"{k},{k}\n" for k in range(ROWS)))
    found = data_set.find(of_file(file, skip_missing=True), tmp_path)
    assert found.samples is not None
    assert found.samples.output.size == ROWS
    with pytest.raises(InputError, match="line 2"):
        data_set.find(of_file(file), tmp_path)


def test_another_version_of_the_file_is_named_in_one_line(text: Path, tmp_path: Path) -> None:
    known = of_file(text)
    text.write_text(text.read_text() + "9,9,9\n")
    found = data_set.find(known, tmp_path)
    assert (found.state, found.samples) == (data_set.OTHER_FILE, None)
    assert found.note.startswith(f"{text}: its sha256 begins with ")
    assert f"not {known.sha256[:12]}: another version of the file" in found.note
    assert "\n" not in found.note


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    found = data_set.find(DATA_SETS["column"], tmp_path)
    assert (found.state, found.samples) == (data_set.NOT_THERE, None)
    assert found.note == (
        f"no column_spc1.csv in {tmp_path}; it is published at github.com/cslotboom/hysteresis"
    )
    with pytest.raises(InputError, match="no such folder"):
        data_set.find(DATA_SETS["column"], tmp_path / "none")


def test_equations_need_no_folder() -> None:
    found = data_set.find(LINE, None)
    assert found.state == data_set.GENERATED
    assert found.samples is not None
    assert found.samples.output.size == SAMPLES
    with pytest.raises(InputError, match="400 samples, its split needs 401"):
        data_set.find(LINE._replace(split=halves(0, SAMPLES + 1)), None)


@pytest.mark.parametrize("known", DATA_SETS.values(), ids=lambda one: one.name)
def test_every_data_set_says_what_it_is(known: DataSet) -> None:
    assert known.generate is not None or (known.file and len(known.sha256) == 64)
    assert all((known.licence, known.source, known.sampling, known.split.words))
    first, fitted_end, held_out, end, _ = known.split
    assert 0 <= first < fitted_end <= held_out < end
    assert len(known.units) in (0, len(known.inputs) + 1)
