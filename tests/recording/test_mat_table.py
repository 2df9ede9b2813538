"""MATLAB files, as SciPy and h5py write them: numbers, also in structures, the rest refused."""

import re
import sys
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from scipy.io import savemat

from opensuction.kernel.errors import InputError
from opensuction.recording import table
from tests.recording.test_table import read, refusal


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "recording.mat"


def put_73(out: Any, name: str, kind: str, values: Any) -> None:
    """A variable as MATLAB writes it: axes in reverse, a structure as a group of its fields.

    values: of a structure its fields, of an array of structures a list of such.
    """
    if kind != "struct":
        if kind == "cell":
            values = np.array([[out.require_group("#refs#").ref]], dtype=h5py.ref_dtype)
        out[name] = values
        out[name].attrs["MATLAB_class"] = kind.encode()
        return
    group = out.create_group(name)
    group.attrs["MATLAB_class"] = b"struct"
    if not isinstance(values, list):
        for field, inner in (values or {}).items():
            put_73(group, field, *inner)
        return
    for field in values[0]:
        refs = []
        for place, element in enumerate(values):
            held = f"{name}-{field}-{place}"
            put_73(out.file.require_group("#refs#"), held, *element[field])
            refs.append([out.file["#refs#"][held].ref])
        group[field] = np.array(refs, dtype=h5py.ref_dtype)


def written_73(path: Path, **variables: Any) -> Path:
    """A file as MATLAB writes it with '-v7.3': its own heading before HDF5."""
    with h5py.File(path, "w", userblock_size=512) as out:
        for name, (kind, values) in variables.items():
            put_73(out, name, kind, values)
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


def test_cells_and_structures_without_numbers_are_refused_with_what_would_do(file: Path) -> None:
    savemat(file, {"data": {"who": "Smith"}, "c": np.array([[1, "a"]], dtype=object)})
    said = refusal(file)
    assert "holds data.who (1 char), c (1 x 2 cell), no row or column of numbers" in said
    assert "x = data.x; save('recording.mat', 'x', 'y')" in said


def row_73(*values: float) -> tuple[str, Any]:
    return "double", np.array(values)[:, None]


T, X = [0.0, 0.5, 1.0], [1.5, -2.0, 3.0]
RUN: dict[str, Any] = {"t": T, "bench": {"x": X, "who": "Smith"}, "m": np.column_stack([T, X])}
RUN_73: dict[str, Any] = {
    "t": row_73(*T),
    "bench": ("struct", {"x": row_73(*X), "who": ("char", np.array([[83], [109]], np.uint16))}),
    "m": ("double", np.array([T, X])),
}


def structures(held: list[dict[str, Any]]) -> Any:
    """An array of structures, as SciPy writes it."""
    kinds = [(name, object) for name in held[0]]
    return np.array([tuple(one.values()) for one in held], dtype=kinds)


POINTS = [{"t": at, "x": value} for at, value in zip(T, X, strict=True)]


@pytest.mark.parametrize("version", ["5", "7.3"])
def test_fields_of_a_structure_are_columns(file: Path, version: str) -> None:
    if version == "5":
        savemat(file, {"run": RUN})
    else:
        written_73(file, run=("struct", RUN_73))
    names = ("run.t", "run.bench.x", "run.m(:,1)", "run.m(:,2)")
    opened = table.open_table(file)
    assert {*opened.names} == {*names, "run.bench.who"}
    assert read(file, *names) == dict(zip(names, [T, X, T, X], strict=True))
    assert [table.find_name(opened, name) for name in ("x", "bench.x", "m(:,2)", "run.t")] == [
        "run.bench.x",
        "run.bench.x",
        "run.m(:,2)",
        "run.t",
    ]
    assert "'run.bench.who' is a char of" in refusal(file, "run.bench.who")


@pytest.mark.parametrize("version", ["5", "7.3"])
def test_a_structure_for_each_sample_gives_columns(file: Path, version: str) -> None:
    if version == "5":
        savemat(file, {"run": structures(POINTS)})
    else:
        held = [{name: row_73(value) for name, value in one.items()} for one in POINTS]
        written_73(file, run=("struct", held))
    assert read(file) == {"run.t": T, "run.x": X}


@pytest.mark.parametrize("version", ["5", "7.3"])
def test_what_several_structures_have_is_refused_with_the_choices(file: Path, version: str) -> None:
    if version == "5":
        savemat(file, {"run": structures([{"x": T}, {"x": X}]), "old": {"x": T}})
    else:
        held = [{"x": row_73(*T)}, {"x": row_73(*X)}]
        written_73(file, run=("struct", held), old=("struct", {"x": row_73(*T)}))
    assert read(file) == {"run(1).x": T, "run(2).x": X, "old.x": T}
    opened = table.open_table(file)
    for name, choices in (("run.x", "run(1).x, run(2).x"), ("x", "x, old.x")):
        with pytest.raises(InputError, match=re.escape("may be")) as raised:
            table.find_name(opened, name)
        said = str(raised.value)
        assert said.startswith(f"{file}: column '{name}' may be ")
        assert all(choice in said for choice in choices.split(", ")), said


def test_a_structure_that_holds_itself_is_refused(file: Path) -> None:
    written_73(file, run=("struct", {"x": row_73(*X)}))
    with h5py.File(file, "r+") as out:
        out["run/again"] = out["run"]
    assert "damaged" in refusal(file)


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


def test_cells_of_version_7_3_are_refused_likewise(file: Path) -> None:
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
