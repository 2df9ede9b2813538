"""Columns of a file for scripts."""

from pathlib import Path

import numpy as np

import opensuction as osn
from tests.library.test_fit import refusal


def test_columns_are_read_by_name(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", t_s=np.arange(3.0), head_mm=np.ones(3))
    assert list(osn.read(tmp_path / "a.npz")) == ["t_s", "head_mm"]
    one = osn.read(str(tmp_path / "a.npz"), "head_mm")
    assert one["head_mm"].tolist() == [1.0, 1.0, 1.0]
    assert repr(one) == "Table(3 samples of head_mm)"
    assert "did you mean 'head_mm'?" in refusal(lambda: osn.read(tmp_path / "a.npz", "hed_mm"))
    np.savez(tmp_path / "b.npz", t_s=[0.0, 1.0, 2.0], head_mm=[1.0, np.nan, 3.0])
    assert "leave such rows out with skip_missing" in refusal(lambda: osn.read(tmp_path / "b.npz"))
    whole = osn.read(tmp_path / "b.npz", skip_missing=True)
    assert (whole["t_s"].tolist(), whole["head_mm"].tolist()) == ([0.0, 2.0], [1.0, 3.0])
    assert "no such file" in refusal(lambda: osn.read(tmp_path / "none.csv"))


def test_a_name_is_taken_with_or_without_its_unit(tmp_path: Path) -> None:
    file = tmp_path / "a.csv"
    file.write_text("Force ,Tip\nkN,mm\n1,2\n3,4\n")
    assert list(osn.read(file)) == ["Force (kN)", "Tip (mm)"]
    for name in ("Force", "Force (kN)", "Force "):
        assert osn.read(file, name)[name].tolist() == [1.0, 3.0]
