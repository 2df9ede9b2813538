"""No alarm and no broken bound is denied by a figure, a sentence or the first line."""

from typing import Any

import pytest

from opensuction.oracle import harm as oracle_harm
from opensuction.report import ending as report_harm
from opensuction.report import narrative
from opensuction.report.figure import WITNESSES
from opensuction.report.notice import CONSEQUENCES, PATIENT_FIRST, WORDS_INSIDE
from opensuction.result.cycle_result import CycleResult
from opensuction.safety.condition import Condition
from tests.report import example
from tests.report.contradiction import DENIED_BY_HARM, contradictions

RAISED = [condition for condition in Condition if condition.row.handling.priority]


def _name(condition: Condition) -> str:
    return condition.name.lower().replace("_", "-")


def _row(condition: Condition) -> dict[str, Any]:
    row = condition.row
    priority = row.handling.priority.name.lower()
    return {"priority": priority, "sentence": row.sentence, "remedy": row.remedy}


def _well(**changes: Any) -> CycleResult:
    """A patient's cycle in which every figure is green."""
    timing = example.GOOD["timing"] | {"in_airway_budget_s": 30.0}
    tip = example.ON_PATIENT["tip"] | {"deepest_mm": 90.7}
    well = {"vitals": example.VITALS, "timing": timing, "tip": tip, "carina_force_peak_n": 0.0}
    vacuum = {"setpoint_mmhg": 120.0, "peak_mmhg": 124.0, "tip_peak_mmhg": 119.0}
    well["vacuum"] = vacuum | {"guideline_mmhg": 150.0}
    return example.on_patient(approach="travel", **(well | changes))


@pytest.mark.parametrize("outcome", ["completed", "aborted"])
@pytest.mark.parametrize("condition", RAISED, ids=_name)
def test_no_alarm_of_the_controller_is_denied(condition: Condition, outcome: str) -> None:
    alarm = example.ALARM | _row(condition) | {"condition": _name(condition)}
    assert contradictions(_well(outcome=outcome, alarms=[alarm])) == []


@pytest.mark.parametrize("inside", [True, False])
@pytest.mark.parametrize("condition", RAISED, ids=_name)
def test_nothing_that_people_were_told_is_denied(condition: Condition, inside: bool) -> None:
    entry = {"what": _name(condition), "at_s": 13.3, "by": "drives"} | _row(condition)
    tip = example.ON_PATIENT["tip"] | {"inside_at_end": inside, "end_mm": 48.6}
    assert contradictions(_well(outcome="aborted", told=[entry], tip=tip)) == []


@pytest.mark.parametrize("name", oracle_harm.NAMES)
def test_no_broken_bound_is_denied(name: str) -> None:
    for outcome in ("completed", "aborted"):
        assert contradictions(_well(outcome=outcome, harm=[name])) == []


def test_a_cycle_that_went_well_contradicts_nothing_and_is_green() -> None:
    assert contradictions(_well()) == []


def test_a_report_that_denied_an_alarm_would_be_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    alarm = example.ALARM | _row(Condition.NEGATIVE_PRESSURE_TIME)
    data = _well(alarms=[alarm | {"condition": "negative-pressure-time"}])
    monkeypatch.setattr("opensuction.report.figure.WITNESSES", {})
    monkeypatch.setattr("opensuction.report.figure.speaking", lambda *_: [])
    monkeypatch.setattr(narrative, "speaking", lambda *_: [])
    monkeypatch.setattr(
        narrative, "PARTS", (*narrative.PARTS, lambda _: "No limit and no alarm was raised.")
    )
    assert contradictions(data) == [
        "['negative-pressure-time'], and a sentence knows of no alarm",
        "'Time under negative pressure' is green beside negative-pressure-time",
        "a sentence denies negative-pressure-time",
    ]


def test_every_bound_of_the_oracle_has_its_words_and_its_figure() -> None:
    assert set(report_harm.HARMS) == set(oracle_harm.NAMES) == set(DENIED_BY_HARM)
    measured = {name for witness in WITNESSES.values() for name in witness.harms}
    assert measured == set(oracle_harm.NAMES)


def test_tables_of_the_report_name_conditions_that_there_are() -> None:
    known = {_name(condition) for condition in Condition}
    named = {name for witness in WITNESSES.values() for name in witness.conditions}
    assert named | set(PATIENT_FIRST) | set(CONSEQUENCES) | set(WORDS_INSIDE) <= known
