"""The JSON object of a calibration's result: the same keys whatever came of it."""

from opensuction.result.calibration_result import (
    CalibrationResult,
    CheckedBound,
    FeedforwardEstimate,
    IdentifiedModels,
    ModelChoice,
    NoModels,
    ValidationErrors,
)
from opensuction.result.identification_result import FittedParameter, PlaysModel
from opensuction.result.plain import to_json

REFUSED = CalibrationResult(
    accepted=False,
    reasons=("Stroke of the first run is 0 mm.",),
    machine="bench",
    patient=None,
    catheter_mm=4.0,
    conduit_bend_rad=1.5,
    seed=3,
    compensation="best",
    choice=None,
    in_silico=True,
    models=NoModels(),
    checks=(
        CheckedBound("stroke", float("nan"), 95.0, None, "mm", "free it", False, "at least 95 mm"),
    ),
    samples=0,
    recording_sha256="0" * 64,
    parameter_file=None,
    version="1",
    date_utc="2026-11-21T12:00:00+00:00",
    seconds=1.0,
)
MODELS = IdentifiedModels(
    model="modified-dahl",
    parameters={"slope": FittedParameter(0.97, "mm/mm", None)},
    plays=PlaysModel([1.0, 2.0], [0.1, 0.8], 0.05, -7.0, 1e-4, 3.4),
    servo=FeedforwardEstimate(0.5, 1.2, 0.01, 40_000),
    gap_mm=20.0,
    gap_ratio=0.9,
    rmse_mm=0.8,
    plays_rmse_mm=0.09,
    validation_rmse_mm=0.81,
    validation=ValidationErrors(0.81, 0.9, 0.09, 0.1, 0.11, 0.01, 90.0),
)


def test_models_stand_among_the_other_keys_or_are_null() -> None:
    accepted = to_json(REFUSED._replace(models=MODELS))
    refused = to_json(REFUSED)
    assert list(accepted) == list(refused)
    assert "models" not in refused
    assert {name: refused[name] for name in NoModels._fields} == dict.fromkeys(NoModels._fields)
    assert (accepted["model"], accepted["gap_ratio"]) == ("modified-dahl", 0.9)
    assert accepted["parameters"] == {"slope": {"value": 0.97, "unit": "mm/mm", "ci95": None}}
    assert accepted["plays"]["weights"] == [0.1, 0.8]
    assert "rmse_mm" not in accepted["plays"]
    assert accepted["servo"]["samples"] == 40_000
    assert accepted["validation"]["range_mm"] == 90.0


def test_without_models_the_same_keys_are_there_as_with_them() -> None:
    assert NoModels._fields == IdentifiedModels._fields
    assert REFUSED.identified is None
    assert REFUSED._replace(models=MODELS).identified is MODELS


def test_a_check_of_no_number_is_null_and_its_bound_is_kept() -> None:
    (check,) = to_json(REFUSED)["checks"]
    assert check == {
        "name": "stroke",
        "value": None,
        "least": 95.0,
        "most": None,
        "unit": "mm",
        "remedy": "free it",
        "ok": False,
        "bound": "at least 95 mm",
    }


def test_a_choice_says_what_each_model_left_and_why_one_drives_not() -> None:
    choice = ModelChoice("plays", "Best.", {"plays": 0.1}, {"duhem": "no inverse"}, None, None)
    data = to_json(REFUSED._replace(choice=choice))
    assert data["choice"] == {
        "model": "plays",
        "reason": "Best.",
        "errors_mm": {"plays": 0.1},
        "refused": {"duhem": "no inverse"},
        "driven_model": None,
        "driven_rmse_mm": None,
    }
    assert to_json(REFUSED)["choice"] is None
