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
    assert "no such file" in refusal(lambda: osn.read(tmp_path / "none.csv"))
