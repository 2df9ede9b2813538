"""The ``safety-case`` command as its users meet it."""

import json
from pathlib import Path
from typing import Any

import pytest

from opensuction.evidence import worker_pool
from tests.cli.command import opensuction, spread_here
from tests.evidence.safety_case.hazard_example import FAULT, ON_ONE, ROW

KEYS = {
    "id",
    "hazard",
    "fault",
    "alarm",
    "priority",
    "detected_ms",
    "safe_state",
    "safe_ms",
    "ok",
    "left_inside",
    "harm",
    "by",
    "searched",
}


def test_a_table_of_ones_own_gives_json_and_a_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(worker_pool, "spread", spread_here)
    (tmp_path / "mine.toml").write_text(ROW + FAULT + ON_ONE)
    arguments = ("safety-case", "--table", "mine.toml", "--json", "--out", "s", "--search", "40")
    done = opensuction(*arguments, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    data = json.loads(done.stdout)
    (entry,) = data["hazards"]
    assert entry.keys() >= KEYS
    assert entry["ok"] is True
    assert entry["priority"] == "high"
    assert 0.0 < entry["detected_ms"] < 2000.0
    assert entry["detected_ms"] < entry["safe_ms"] < 10000.0
    assert json.loads((tmp_path / "s" / "safety-case.json").read_text()) == data
    page = (tmp_path / "s" / "report.html").read_text()
    assert "1 of 1 hazards answered within their bounds" in page
    assert "pump-runaway@inserting" in page
    searched = entry["searched"]
    # No place is played twice, and this hazard has few.
    assert 30 < searched["runs"] <= 40
    assert searched["broken"] == 0
    assert 0.0 < searched["worst"]["share"] < 1.0
    assert f"Worst of {searched['runs']} searched runs: pump-runaway@" in page


def test_a_bound_that_is_broken_is_shown_and_exits_1(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(worker_pool, "spread", spread_here)
    text = ROW.replace("safe_ms = 10000", "safe_ms = 10")
    (tmp_path / "mine.toml").write_text(text + FAULT + ON_ONE)
    asked = ("safety-case", "--table", "mine.toml", "--out", "s", "--search", "0")
    done = opensuction(*asked, cwd=tmp_path)
    assert done.returncode == 1
    assert "0 of 1 hazards within their bounds" in done.stdout
    assert "bound 10" in done.stderr
    data = json.loads((tmp_path / "s" / "safety-case.json").read_text())
    assert "bound 10" in data["hazards"][0]["problems"][0]["problem"]


def test_processes_that_die_again_and_again_are_one_line_and_nothing_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def spread(*_: Any) -> None:
        raise worker_pool.WorkerLostError("3 processes died over the same task")

    monkeypatch.setattr(worker_pool, "spread", spread)
    (tmp_path / "mine.toml").write_text(ROW + FAULT + ON_ONE)
    (tmp_path / "s").mkdir()
    done = opensuction("safety-case", "--table", "mine.toml", "--json", "--out", "s", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (1, "")
    said = [line for line in done.stderr.splitlines() if line.startswith("opensuction: ")]
    assert said == ["opensuction: 3 processes died over the same task; nothing was written"]
    assert done.stderr.splitlines()[-1] == said[0]
    assert "Traceback" not in done.stderr
    assert list((tmp_path / "s").iterdir()) == []
    assert sorted(path.name for path in tmp_path.iterdir()) == ["mine.toml", "s"]


def test_a_hazard_that_does_not_exist_is_one_line(tmp_path: Path) -> None:
    done = opensuction("safety-case", "--hazard", "OS-H99", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.count("\n") == 1
    assert "--hazard 'OS-H99'" in done.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("text", "word"),
    [
        (ROW, "fault"),
        (ROW + FAULT.replace("pump-runaway", "pump"), "pump"),
        (ROW + FAULT + ROW + FAULT, "2 times"),
        ("nonsense", "TOML"),
    ],
)
def test_a_bad_table_is_one_line_and_nothing_is_written(
    text: str, word: str, tmp_path: Path
) -> None:
    (tmp_path / "mine.toml").write_text(text)
    done = opensuction("safety-case", "--table", "mine.toml", "--out", "s", cwd=tmp_path)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1
    assert "mine.toml" in done.stderr
    assert word in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["mine.toml"]
