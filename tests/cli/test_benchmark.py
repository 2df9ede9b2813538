"""The ``benchmark`` command as its users meet it."""

import json
from pathlib import Path

import pytest

from opensuction.control.compensation import KIND_OF_NAME
from opensuction.evidence.benchmark.benchmark_plant import NAMES
from tests.cli.command import opensuction

KEYS = {
    "plant",
    "compensation",
    "seeds",
    "rmse_mm",
    "rmse_worst_mm",
    "peak_mm",
    "head_mm_per_s",
    "completed",
    "in_class",
    "floor_mm",
    "disturbances",
}


@pytest.mark.soak  # minutes: every plant, every compensator, every change
def test_one_seed_gives_json_and_a_page(tmp_path: Path) -> None:
    done = opensuction("benchmark", "--seeds", "1", "--json", "--out", "b", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    data = json.loads(done.stdout)
    assert len(data["results"]) == len(NAMES) * len(KIND_OF_NAME)
    assert all(entry.keys() >= KEYS for entry in data["results"])
    assert data["seeds"] == [101]
    assert json.loads((tmp_path / "b" / "benchmark.json").read_text()) == data
    html = (tmp_path / "b" / "report.html").read_text()
    for name in (*NAMES, *KIND_OF_NAME):
        assert name in html
        assert name in done.stderr or name in KIND_OF_NAME


@pytest.mark.parametrize("seeds", ["0", "1000", "many"])
def test_a_bad_number_of_seeds_is_one_line(seeds: str, tmp_path: Path) -> None:
    done = opensuction("benchmark", "--seeds", seeds, "--out", "b", cwd=tmp_path)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1
    assert "--seeds" in done.stderr
    assert list(tmp_path.iterdir()) == []
