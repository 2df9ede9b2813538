"""The ``leaderboard`` command as its users meet it."""

import json
from pathlib import Path

import pytest

from opensuction.evidence.leaderboard import data_set_table
from tests.cli.command import opensuction
from tests.cli.test_cycle import assert_refused
from tests.evidence.leaderboard.data_set_example import LINE, PERCENT


def test_a_table_in_json_and_markdown(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(data_set_table.DATA_SETS, "line", LINE)
    arguments = ("--data", ".", "--data-set", "line", "--data-set", "wall", "--out", "b")
    models = ("--model", "straight-line", "--model", "opensuction.evidence:nothing")
    ran = opensuction("leaderboard", *arguments, *models[:2], "--json", cwd=tmp_path)
    assert ran.returncode == 0, ran.stderr
    data = json.loads(ran.stdout)
    assert data == json.loads((tmp_path / "b" / "leaderboard.json").read_text())
    assert [(one["name"], one["state"]) for one in data["data_sets"]] == [
        ("line", "generated"),
        ("wall", "not there"),
    ]
    assert [one["model"] for one in data["entries"]] == ["straight-line"]
    page = (tmp_path / "b" / "leaderboard.md").read_text()
    assert f"| 1 | straight-line | 0.1 | {PERCENT} ({PERCENT} to {PERCENT})" in page
    read = opensuction("leaderboard", *arguments, *models[:2], "--force", cwd=tmp_path)
    words = " ".join(read.stdout.split())
    assert f"straight-line {PERCENT} ({PERCENT} to {PERCENT})" in words
    assert "wall: not there: no wall_ts1.csv in" in words
    refused = opensuction("leaderboard", *arguments, *models, "--force", cwd=tmp_path)
    assert_refused(refused, "opensuction.evidence has no nothing", tmp_path, left=1)


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (("--data-set", "wall"), "no folder of data was named"),
        (("--data", "none"), "--data none: no such folder"),
        (("--data", ".", "--model", "dah"), "unknown model 'dah'"),
        (("--data", ".", "--data-set", "wal"), "unknown data set 'wal'"),
        (("--data", ".", "--data-set", "wall"), "none of 1 data sets can be used, see --data"),
    ],
)
def test_bad_input_is_one_line(arguments: tuple[str, ...], expected: str, tmp_path: Path) -> None:
    assert_refused(opensuction("leaderboard", *arguments, cwd=tmp_path), expected, tmp_path)
