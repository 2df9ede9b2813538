"""The ``reproduce`` command as its users meet it, and the claims that it makes."""

import html
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.cli.command import opensuction

pytestmark = pytest.mark.sweep

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


def test_every_claim_agrees_or_its_difference_is_explained(ran: Ran) -> None:
    for claim in ran.data["claims"]:
        near = abs(claim["measured"] - claim["paper"]) <= claim["tolerance"]
        assert claim["ok"] is near
        assert near or claim["explanation"], claim["name"]


def test_every_claim_says_where_its_number_is_from_and_what_agreement_is_worth(ran: Ran) -> None:
    claims = {claim["name"]: claim for claim in ran.data["claims"]}
    assert len(claims) == len(ran.data["claims"])
    assert {claim["source"] for claim in claims.values()} == {"printed", "computed"}
    assert {claim["kind"] for claim in claims.values()} == {
        "calibrated",
        "predicted",
        "arithmetic",
    }
    # The paper prints none of these six; they follow from its parameters.
    computed = {c["paper"] for c in claims.values() if c["kind"] == "arithmetic"}
    assert computed >= {-0.740, 2.47, 7.38, 16.48, 2.62, 11.09}
    assert all(c["source"] == "computed" for c in claims.values() if c["kind"] == "arithmetic")
    before = claims["standard deviation before compensation"]
    assert (before["kind"], before["evidence"]) == ("calibrated", False)
    assert claims["mean stop error at 65 mm"]["why_no_evidence"] == "0 would pass, too"
    for claim in claims.values():
        if claim["verdict"] == "agrees":
            assert claim["evidence"]
            assert claim["kind"] == "predicted"
            assert all(abs(null - claim["paper"]) > claim["tolerance"] for null in claim["nulls"])
        error = claim["standard_error"]
        assert error is None or error < claim["tolerance"]
    verdicts = [claim["verdict"] for claim in claims.values()]
    counted = {name: verdicts.count(name) for name in ("agrees", "no evidence", "differs")}
    assert counted == ran.data["verdicts"]
    words = f"{counted['agrees']} agree as evidence, {counted['no evidence']} agree but are no"
    assert words in (ran.folder / "report.html").read_text()


def test_what_was_predicted_agrees_and_what_the_twin_has_not_is_told(ran: Ran) -> None:
    claims = {claim["name"]: claim for claim in ran.data["claims"]}
    agreeing = {name for name, claim in claims.items() if claim["verdict"] == "agrees"}
    assert agreeing == {
        "mean stop error of 15 trials, ours less its seating",
        "suctions completed, of 15",
    }
    assert 2.6 < claims["RMSE under the paper's own parameters, mean of five"]["measured"] < 3.0
    assert claims["RMSE of Bouc-Wen over that of modified Dahl"]["measured"] < 0.15
    assert {name for name, claim in claims.items() if claim["verdict"] == "differs"} == {
        "beta",
        "RMSE of the Bouc-Wen model",
        "RMSE of Bouc-Wen over that of modified Dahl",
        "loop width of the printed Bouc-Wen numbers, against the other model",
        "RMSE under the paper's own parameters, mean of five",
    }


def test_15_trials_are_15_machines_with_a_seating_each(ran: Ran) -> None:
    rows = ran.data["table2"]
    assert [row["seed"] for row in rows] == list(range(1, 16))
    seatings = [row["seating_mm"] for row in rows]
    assert len(set(seatings)) == 15
    # The tip stops where the carina stands, and .36 mm beyond: one machine is like the other.
    pressed = [row["error_mm"] - row["seating_mm"] for row in rows]
    assert np.std(pressed) < 0.05
    assert 0.3 < np.std([row["error_mm"] for row in rows], ddof=1) < 0.7


def test_every_number_of_the_paper_is_listed_and_its_claim_is_there(ran: Ran) -> None:
    names = [claim["name"] for claim in ran.data["claims"]] + ["Table I, trial 1"]
    names += ["means and scatter", "stop errors"]  # rows of the two tables
    assert len(ran.data["numbers"]) > 40
    for number in ran.data["numbers"]:
        assert number["use"] in ("claim", "set", "not reproduced")
        assert number["why"]
        if number["use"] == "claim":
            assert any(number["why"] in name for name in names), number


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
    assert all(row["published_mm"] > 2.4 for row in first)
    # Ours beat the paper's on the same machines, every one of them.
    assert all(row["exact_inverse_mm"] < 0.5 * row["after_mm"] for row in first)
    # A tenth of the paper's error, the contract's figure, on every machine.
    assert all(row["preview_mm"] <= 0.24 for row in first)


def test_page_shows_every_figure_and_table(ran: Ran) -> None:
    page = html.unescape((ran.folder / "report.html").read_text())
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
        assert name in page, name
    for claim in ran.data["claims"]:
        assert claim["name"] in page


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
