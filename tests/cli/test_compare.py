"""The ``compare`` command as its users meet it."""

import json
from pathlib import Path
from typing import Any

import pytest

from opensuction.identification import workbench
from tests.cli.command import opensuction
from tests.cli.test_cycle import assert_refused
from tests.cli.test_identify import COLUMNS, EXAMPLE, KEYS, recording


@pytest.fixture(scope="module")
def compared(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, Any], Path]:
    """The JSON of a comparison, and the folder in which it was asked for."""
    folder = tmp_path_factory.mktemp("compare")
    arguments = ("compare", str(EXAMPLE), *COLUMNS, "--time", "time_s")
    slow = {"play-readout", "residual-readout"}  # the library's tests compare all models
    some = {name: one for name, one in workbench.MODELS.items() if name not in slow}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(workbench, "MODELS", some)
        ran = opensuction(
            *(*arguments, "--purpose", "compensate", "--json", "--out", "found"), cwd=folder
        )
    assert len(some) == len(workbench.MODELS) - len(slow)
    assert ran.returncode == 0, ran.stderr
    return json.loads(ran.stdout), folder


def test_compare_ranks_models_and_recommends_one(compared: tuple[dict[str, Any], Path]) -> None:
    data, folder = compared
    assert sum(model["recommended"] for model in data["models"]) == 1
    for model in data["models"]:
        assert model.keys() >= KEYS
        assert (folder / model["parameter_file"]).is_file()
    assert json.loads((folder / "found" / "comparison.json").read_text()) == data
    assert (folder / "found" / "report.html").is_file()


def test_a_purpose_is_taken_and_its_reason_told(compared: tuple[dict[str, Any], Path]) -> None:
    best, *others = compared[0]["models"]
    assert (best["model"], best["compensator"]) == ("prandtl-ishlinskii", "model-preview")
    assert best["undriven"] is None
    for each in (best, *others):
        told = [warning for warning in each["warnings"] if warning.startswith("At its bound: ")]
        assert len(told) == len(each["at_bound"])
    assert best["reasons"]
    assert all(other["reasons"] == [] for other in others)
    undriven = {other["model"]: other["undriven"] for other in others if other["undriven"]}
    assert "turns at 2 places only" in undriven["preisach"]
    assert "a search whose steps no tick could bound" in undriven["bouc-wen"]


def test_models_are_compared_on_what_is_held_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    few = {name: workbench.MODELS[name] for name in ("modified-dahl", "dahl")}
    monkeypatch.setattr(workbench, "MODELS", few)
    recording(tmp_path)
    ran = opensuction(
        *("compare", "bench.csv", *COLUMNS, "--holdout", "0.5", "--json"), cwd=tmp_path
    )
    assert ran.returncode == 0, ran.stderr
    data = json.loads(ran.stdout)
    assert data["holdout_ratio"] == 0.5
    errors = {one["model"]: one["holdout_rmse_percent_of_range"] for one in data["models"]}
    assert errors.keys() == few.keys()
    assert errors["modified-dahl"] < 1e-3 < errors["dahl"]


def test_an_unknown_purpose_is_refused(tmp_path: Path) -> None:
    arguments = ("compare", str(EXAMPLE), *COLUMNS, "--json", "--purpose", "drive")
    ran = opensuction(*arguments, cwd=tmp_path)
    assert_refused(ran, "unknown purpose 'drive'", tmp_path)
