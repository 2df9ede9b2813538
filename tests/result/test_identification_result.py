"""JSON objects of ``identify`` and ``compare``: keys, order and ``null`` as documented."""

import json
import re
from pathlib import Path

import pytest

from opensuction.result.identification_result import ComparisonResult, IdentificationResult
from opensuction.result.plain import Json, to_json
from tests.report import identification_example as example

RESULTS = Path(__file__).parents[2] / "docs" / "reference" / "results.md"

OF_A_MODEL = [
    "model",
    "model_words",
    "method",
    "method_words",
    "parameters",
    "rmse",
    "rmse_unit",
    "rmse_percent_of_range",
    "holdout_rmse_percent_of_range",
    "cross_validation_percent_of_range",
    "well_posed",
    "determined",
    "transfer_percent_of_range",
    "effective_parameters",
    "recommended",
    "reasons",
    "coupling_percent_of_range",
    "warnings",
    "at_bound",
    "samples",
    "fitted_samples",
    "fitted_range",
    "fit_seconds",
    "inverse",
    "compensator",
    "undriven",
    "parameter_file",
]
OF_THE_RUN = [
    "recording",
    "holdout_ratio",
    "line_rmse_percent_of_range",
    "version",
    "date_utc",
    "seconds",
]


def as_read(result: IdentificationResult | ComparisonResult) -> Json:
    """The object as a reader of the file has it; it is JSON without NaN."""
    read: Json = json.loads(json.dumps(to_json(result), allow_nan=False))
    return read


def test_identify_has_model_and_run_in_one_object() -> None:
    found = as_read(example.identified())
    assert list(found) == [*OF_A_MODEL, *OF_THE_RUN]
    assert found["parameters"]["slope"] == {"value": 0.95, "unit": "mm/mm", "ci95": [0.93, 0.99]}
    assert found["parameters"]["offset"] == {"value": -6.0, "unit": "mm", "ci95": None}
    assert found["fitted_range"] == {
        "lowest": 0.0,
        "highest": 100.0,
        "slowest": 9.0,
        "fastest": 11.0,
    }
    assert found["recording"]["output"] == {
        "column": "tip_mm",
        "unit": "mm",
        "negated": False,
        "lowest": -6.0,
        "highest": 90.0,
    }


def test_compare_has_the_run_once_beside_its_models() -> None:
    left_out = {"dahl": "tip_mm: turns back"}
    found = as_read(example.compared(left_out=left_out))
    assert list(found) == ["models", "left_out", *OF_THE_RUN]
    assert [list(model) for model in found["models"]] == 3 * [OF_A_MODEL]
    assert found["left_out"] == left_out


@pytest.mark.parametrize(
    "field", ["holdout_rmse_percent_of_range", "coupling_percent_of_range", "undriven"]
)
def test_what_is_not_there_stands_as_null(field: str) -> None:
    assert as_read(example.identified(**{field: None}))[field] is None


def test_every_key_is_documented() -> None:
    text = RESULTS.read_text(encoding="utf-8").split("## identify")[1].split("## compare")[0]
    documented = set(re.findall(r"\w+", " ".join(re.findall(r"`([^`]*)`", text))))
    found = as_read(example.identified())
    keys = {*found, *found["recording"], *found["fitted_range"], *found["parameters"]["slope"]}
    assert keys <= documented
