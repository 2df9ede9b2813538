"""The ``reproduce`` command as its users meet it, and the claims that it makes."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.cli.command import opensuction

CLAIM_KEYS = {"name", "paper", "measured", "tolerance", "ok"}
"""docs/reference/results.md."""


class Ran:
    """One run of the command for all tests of this file."""

    def __init__(self, folder: Path) -> None:
        done = opensuction("reproduce", "--json", "--out", "paper", cwd=folder)
        assert done.returncode == 0, done.stderr
        self.data: dict[str, Any] = json.loads(done.stdout)
        self.folder = folder / "paper"
        self.progress = done.stderr


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> Ran:
    return Ran(tmp_path_factory.mktemp("reproduce"))


def test_json_has_the_promised_keys(ran: Ran) -> None:
    assert {"claims", "table1", "table2"} <= ran.data.keys()
    assert all(claim.keys() >= CLAIM_KEYS for claim in ran.data["claims"])
    assert json.loads((ran.folder / "reproduce.json").read_text()) == ran.data


def test_every_claim_holds_or_is_explained(ran: Ran) -> None:
    for claim in ran.data["claims"]:
        near = abs(claim["measured"] - claim["paper"]) <= claim["tolerance"]
        assert claim["ok"] == near
        assert near or claim["explanation"], claim["name"]


def test_every_claim_says_whether_the_twin_was_calibrated_to_it(ran: Ran) -> None:
    origins = {claim["origin"] for claim in ran.data["claims"]}
    assert origins == {"calibrated", "predicted", "computed"}


def test_tables_hold_the_paper_s_trials_beside_ours(ran: Ran) -> None:
    first, second = ran.data["table1"], ran.data["table2"]
    assert [row["paper_before_mm"] for row in first] == [15.413, 15.552, 16.011, 14.998, 16.189]
    assert len(second) == 15
    means = [
        np.mean([row["paper_mm"] for row in second if row["distance_mm"] == d])
        for d in (65.0, 55.0, 45.0)
    ]
    assert means == pytest.approx([65.4076, 55.2626, 45.3862], abs=1e-4)
    for row in second:
        assert row["error_mm"] == pytest.approx(row["measured_mm"] - row["distance_mm"])
    # Ours beat the paper's on the same machines, every one of them.
    assert all(row["exact_inverse_mm"] < 0.5 * row["after_mm"] for row in first)
    # A tenth of the paper's error, the contract's figure, on every machine.
    assert all(row["preview_mm"] <= 0.24 for row in first)


def test_page_shows_every_figure_and_table(ran: Ran) -> None:
    html = (ran.folder / "report.html").read_text()
    for name in (
        "Fig. 5",
        "Fig. 6",
        "Fig. 7",
        "Fig. 8",
        "Fig. 9",
        "Fig. 10",
        "Fig. 11",
        "Table I:",
        "Table II:",
    ):
        assert name in html, name
    for claim in ran.data["claims"]:
        assert claim["name"] in html


def test_progress_goes_to_stderr(ran: Ran) -> None:
    assert "Table II" in ran.progress


def test_folder_that_is_not_empty_is_refused_at_once(tmp_path: Path) -> None:
    (tmp_path / "paper").mkdir()
    (tmp_path / "paper" / "kept.txt").write_text("mine")
    done = opensuction("reproduce", "--out", "paper", cwd=tmp_path)
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "--force" in done.stderr
    assert [file.name for file in (tmp_path / "paper").iterdir()] == ["kept.txt"]
