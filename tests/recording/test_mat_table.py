"""MATLAB files, as SciPy and h5py write them: rows and columns of numbers, and the rest refused."""

import sys
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from scipy.io import savemat

from opensuction.recording import table
from tests.recording.test_table import read, refusal


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "recording.mat"


def written_73(path: Path, **variables: Any) -> Path:
    """A file as MATLAB writes it with '-v7.3': its own heading before HDF5, axes in reverse."""
    with h5py.File(path, "w", userblock_size=512) as out:
        for name, (kind, values) in variables.items():
            if kind == "struct":
                out.create_group(name).attrs["MATLAB_class"] = b"struct"
                continue
            if kind == "cell":
                out.create_group("#refs#")
                out[name] = np.array([[out["#refs#"].ref]], dtype=h5py.ref_dtype)
            else:
                out[name] = values
            out[name].attrs["MATLAB_class"] = kind.encode()
    with path.open("r+b") as out:
        out.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")
    return path


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("axis", ["row", "column"])
def test_rows_and_columns_are_read(file: Path, axis: Any, packed: bool) -> None:
    variables = {"t_s": [0.0, 0.5], "head_mm": np.array([1, -2], dtype=np.int16)}
    savemat(file, variables, oned_as=axis, do_compression=packed)
    assert read(file) == {"t_s": [0.0, 0.5], "head_mm": [1.0, -2.0]}


def test_version_7_3_is_read(file: Path) -> None:
    written_73(
        file,
        t_s=("double", np.array([[0.0, 0.5]])),
        head_mm=("single", np.array([[1.5], [2.5]], dtype=np.float32)),
    )
    assert read(file) == {"t_s": [0.0, 0.5], "head_mm": [1.5, 2.5]}


def test_a_structure_is_refused_with_what_there_is_and_what_would_do(file: Path) -> None:
    savemat(file, {"data": {"x": [1.0, 2.0]}, "c": np.array([[1, "a"]], dtype=object)})
    said = refusal(file)
    assert "holds data (1 x 1 struct), c (1 x 2 cell), no row or column of numbers" in said
    assert "x = data.x; save('recording.mat', 'x', 'y')" in said


def test_a_structure_beside_numbers_is_refused_when_it_is_asked_for(file: Path) -> None:
    savemat(file, {"data": {"x": [1.0, 2.0]}, "t": [0.0, 1.0], "s": "text"})
    assert read(file, "t") == {"t": [0.0, 1.0]}
    assert "'data' is a struct of 1 x 1, should be a row or column of numbers" in refusal(
        file, "data"
    )
    assert "'s' is a char" in refusal(file, "s")


MATRIX = np.array([[0.0, 1.5], [0.5, -2.0], [1.0, 3.0]])


def test_a_matrix_gives_its_columns_or_its_rows_where_these_are_longer(file: Path) -> None:
    savemat(file, {"m": MATRIX, "n": MATRIX.T})
    columns, rows = ("m(:,1)", "m(:,2)"), ("n(1,:)", "n(2,:)")
    assert table.open_table(file).names == columns + rows
    assert read(file) == dict(zip(columns + rows, [*MATRIX.T.tolist()] * 2, strict=True))
    written_73(file, m=("double", MATRIX.T))
    assert read(file) == dict(zip(columns, MATRIX.T.tolist(), strict=True))


def test_a_square_and_a_picture_have_no_signals(file: Path) -> None:
    savemat(file, {"t": [0.0, 1.0], "s": np.eye(3), "p": np.zeros((300, 200))})
    assert table.open_table(file).names == ("t", "s", "p")
    assert "'s' is 3 x 3, should be one row or column" in refusal(file, "s")
    assert "'p' is 300 x 200, should be one row or column" in refusal(file, "p")


def test_structures_of_version_7_3_are_refused_likewise(file: Path) -> None:
    written_73(file, data=("struct", None), c=("cell", None))
    said = refusal(file)
    assert "holds c (1 x 1 cell), data (1 x 1 struct), no row or column of numbers" in said


def test_without_h5py_one_line_says_what_to_install(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    written_73(file, a=("double", np.array([[1.0, 2.0]])))
    monkeypatch.setitem(sys.modules, "h5py", None)
    assert "pip install 'opensuction[matlab]'" in refusal(file)


def test_missing_numbers_are_refused_with_their_row(file: Path) -> None:
    savemat(file, {"a": [1.0, np.nan]})
    assert "row 2, column 'a': missing" in refusal(file, "a")


@pytest.mark.parametrize("version", ["5", "7.3"])
@pytest.mark.parametrize("share", [0.3, 0.6, 0.9])
def test_a_cut_off_file_is_refused(file: Path, version: str, share: float) -> None:
    if version == "5":
        savemat(file, {"a": np.arange(1000.0)})
    else:
        written_73(file, a=("double", np.arange(1000.0)[None]))
    content = file.read_bytes()
    file.write_bytes(content[: int(share * len(content))])
    assert "damaged or incomplete MATLAB file" in refusal(file, "a")


def test_a_variable_that_lies_in_another_file_is_none(file: Path, tmp_path: Path) -> None:
    written_73(tmp_path / "other.mat", b=("double", np.array([[7.0, 8.0]])))
    written_73(file, a=("double", np.array([[1.0, 2.0]])))
    with h5py.File(file, "r+") as out:
        out["b"] = h5py.ExternalLink(str(tmp_path / "other.mat"), "/b")
    assert read(file) == {"a": [1.0, 2.0]}
