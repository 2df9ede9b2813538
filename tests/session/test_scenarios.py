"""Golden cycles: small files that say what to run and what must come of it.

A file's ``expect`` names keys of the ``cycle`` command's JSON by their path, each with a value
and a tolerance. The values were recorded; the tolerances are what may change with a processor's
arithmetic or a controller's detail without anyone noticing.
"""

import json
from pathlib import Path
from typing import Any

import pytest

from opensuction.result.plain import to_json
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, cycle_summary, resolution

FOLDER = Path(__file__).resolve().parents[1] / "scenarios"
FILES = sorted(FOLDER.glob("*.json"))


def at(data: Any, path: str) -> Any:
    """What lies at a dotted path."""
    for key in path.split("."):
        data = data[key]
    return data


def test_every_compensation_has_its_scenarios() -> None:
    assert len(FILES) >= 8


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_scenario_comes_out_as_recorded(file: Path) -> None:
    scenario = json.loads(file.read_text())
    assert scenario["name"] == file.stem
    keys = ("protocol", "approach", "compensation")
    rig = RigChoice(scenario["machine"], seed=scenario["seed"])
    choice = CycleChoice(rig, **{key: scenario[key] for key in keys})
    prepared = cycle_run.prepare(resolution.resolve(choice))
    columns = cycle_run.play(prepared)
    found = to_json(cycle_summary.summary(prepared, columns))
    assert found["outcome"] == "completed"
    assert found["trips"] == []
    assert found["alarms"] == []
    for path, (value, tolerance) in scenario["expect"].items():
        assert at(found, path) == pytest.approx(value, abs=tolerance), path
