"""Single rows of the table that once broke a bound."""

import pytest

from opensuction.evidence.campaign import sound_machine
from opensuction.evidence.campaign.sound_machine import Kind
from opensuction.evidence.safety_case import hazard, hazard_case
from opensuction.evidence.safety_case.hazard_case import COMPENSATION
from opensuction.evidence.safety_case.hazard_claim import Response
from opensuction.kernel.vocabulary import Phase
from opensuction.simulation.injection import injection, run_judgement
from opensuction.simulation.injection.fault_instant import FaultInstant, Injection
from opensuction.twin.fault.fault import Fault


@pytest.mark.parametrize("patient", ["adult-icu", "neonate"])
def test_a_tip_that_was_pushed_deep_by_a_stiff_switch_does_not_press_during_suction(
    patient: str,
) -> None:
    """It closed at .25 N, 9 mm of catheter after the touch; 10 mm back the tip pressed for 10 s."""
    (row,) = (one for one in hazard.load() if one.row.id == "OS-H08")
    runs = [
        hazard_case.run(case)
        for case in hazard_case.cases(row, (2,))
        if case.claim.name == "switch-stiff" and case.strength == 0.25 and case.patient == patient
    ]
    assert runs
    for result in runs:
        assert result.problem == ""
        assert result.exposure is not None
        assert result.exposure.contact_s < 2.5


@pytest.mark.sweep
def test_a_dead_current_sensor_breaks_no_bound() -> None:
    (row,) = (one for one in hazard.load() if one.row.id == "OS-H40")
    runs = [hazard_case.run(case) for case in hazard_case.cases(row, (1,))]
    assert len(runs) == 8
    assert [result.problem for result in runs] == [""] * 8


@pytest.mark.parametrize("patient", ["adult-icu", "neonate"])
def test_a_tip_that_a_wider_gap_holds_back_leaves_the_carina_before_suction(patient: str) -> None:
    """The switch opens where the back-off was to end: it goes on until the tip is off."""
    ready = sound_machine.prepare(Kind(patient, "contact"), 1, COMPENSATION)
    wider = Injection(Fault.CONDUIT_REROUTED, FaultInstant(Phase.INSERTING, 0.1), 1.6)
    ran = injection.run(ready.loop, ready.start, (wider,), seed=1)
    cap_mm = ready.loop.controller.limits.cap_mm
    found = run_judgement.judge(ready.rig.machine, cap_mm, ran.columns, ran.faults)
    assert found.breaches == ()
    assert found.told == ()
    assert found.borne.contact_s < 2.0
    touching = ran.columns["truth.contact_n"] > 0.01
    assert not (touching & (ran.columns["phase"] == Phase.SUCTIONING)).any()


def test_a_plan_that_is_refused_answers_only_where_the_row_takes_a_refusal() -> None:
    (row,) = (one for one in hazard.load() if one.row.id == "OS-H11")
    deep = next(
        case
        for case in hazard_case.cases(row, (1,))
        if case.claim.name == "taught-too-deep" and case.strength == 60.0
    )
    result = hazard_case.run(deep)
    assert (result.refused, result.problem) == (True, "")
    owed = deep._replace(claim=deep.claim._replace(response=Response.ALARM_OR_LIMITS))
    result = hazard_case.run(owed)
    assert not result.refused
    assert "cannot be planned" in result.problem


def test_what_was_taught_a_little_too_deep_is_run() -> None:
    (row,) = (one for one in hazard.load() if one.row.id == "OS-H11")
    adults = [
        case
        for case in hazard_case.cases(row, (1,))
        if case.claim.name == "taught-too-deep"
        and case.patient == "adult-icu"
        and case.strength <= 13.0
    ]
    runs = [hazard_case.run(case) for case in adults]
    assert [result.problem for result in runs] == [""] * 3
    assert not any(result.refused for result in runs)
