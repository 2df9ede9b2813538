"""Reports of real runs in which something goes wrong: none denies what its JSON holds."""

from functools import cache

import pytest

from opensuction.report import headline
from opensuction.report.cycle import page
from opensuction.result.cycle_result import CycleResult
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, cycle_summary, fault_run, resolution
from tests.report.contradiction import contradictions

ADULT, ARDS, CHILD, NEONATE = "adult-icu", "adult-ards", "child-10kg", "neonate"

RUNS = (
    (ADULT, "travel", ""),
    (ADULT, "contact", ""),
    (ARDS, "travel", ""),
    (CHILD, "travel", ""),
    (NEONATE, "contact", ""),
    (ADULT, "travel", "power-lost-without-reserve@suctioning"),
    (ADULT, "travel", "power-lost@suctioning"),
    (CHILD, "contact", "power-lost@withdrawing"),
    (ADULT, "travel", "catheter-jammed@withdrawing+1"),
    (ADULT, "travel", "catheter-kinked@inserting+2"),
    (ARDS, "travel", "desaturation@inserting"),
    (NEONATE, "travel", "desaturation@inserting"),
    (NEONATE, "travel", "line-clogged@preloading=1"),
    (NEONATE, "travel", "valve-stuck-closed@checking=0"),
    (ADULT, "travel", "circuit-disconnected@suctioning"),
    (CHILD, "travel", "circuit-disconnected@inserting+2"),
    (NEONATE, "travel", "pump-runaway@suctioning"),
    (ADULT, "travel", "pump-lost@opening"),
    (ADULT, "travel", "valve-jammed@suctioning+2"),
    (ADULT, "travel", "valve-stuck-open@suctioning"),
    (ADULT, "travel", "line-leak@suctioning"),
    (ADULT, "travel", "canister-full@suctioning"),
    (ADULT, "contact", "carina-missed"),
    (CHILD, "contact", "switch-stuck-open"),
    (ADULT, "travel", "tube-displaced"),
    (ADULT, "travel", "motor-lost@suctioning"),
    (ADULT, "travel", "gear-lost@withdrawing+1"),
    (ADULT, "travel", "encoder-jumping@suctioning"),
    (CHILD, "travel", "encoder-slipping@inserting"),
    (ADULT, "travel", "ventilator-pressure@suctioning"),
    (ADULT, "contact", "tip-detached@suctioning"),
    (ADULT, "travel", "vacuum-sensor-offset"),
    (ADULT, "travel", "message-lost@suctioning"),
    (ADULT, "travel", "controller-stopped@suctioning=1"),
    (ADULT, "travel", "tick-late@suctioning=60"),
)


@cache
def _result(patient: str, approach: str, fault: str) -> CycleResult:
    """A cycle with a fault, as the command plays it."""
    faults = (fault,) if fault else ()
    choice = CycleChoice(RigChoice(patient=patient), approach=approach, faults=faults)
    prepared = cycle_run.prepare(resolution.resolve(choice))
    found = fault_run.play(prepared, lambda _: None)
    return cycle_summary.summary(prepared, found.columns, fault_run.on_record(found))


@pytest.mark.parametrize(
    ("patient", "approach", "fault"),
    [pytest.param(*one, marks=pytest.mark.soak if i % 4 else ()) for i, one in enumerate(RUNS)],
)
def test_no_report_denies_what_happened(patient: str, approach: str, fault: str) -> None:
    assert contradictions(_result(patient, approach, fault)) == []


def test_a_loss_of_all_power_inside_is_told_as_what_it_is() -> None:
    result = _result(ADULT, "travel", "power-lost-without-reserve@suctioning")
    assert result.is_inside
    assert "left-inside" in result.harms
    assert {"power"} <= {entry.by for entry in result.told or ()}
    first = headline.headline(result)
    assert first.text.startswith("CATHETER IS STILL IN THE AIRWAY, 48.6 mm below the tube's end")
    assert "mains power is gone" in first.lead
    html = page.render(result, {})
    assert "No safety limit tripped and no alarm was raised" not in html
    assert "Nothing noticed it" not in html


def test_a_catheter_that_jams_is_in_the_airway_for_as_long_as_it_is_there() -> None:
    result = _result(ADULT, "travel", "catheter-jammed@withdrawing+1")
    assert result.is_inside
    assert (result.timing.in_airway_s or 0.0) > 90.0


def test_a_clog_that_nobody_is_told_of_is_not_a_cycle_that_went_well() -> None:
    result = _result(NEONATE, "travel", "line-clogged@preloading=1")
    assert (result.secretion.removed_percent or 0.0) < 5.0
    assert headline.headline(result).verdict.value != "good"


def test_healthy_cycles_of_adults_and_neonates_are_green() -> None:
    for patient in (ADULT, NEONATE):
        assert headline.headline(_result(patient, "travel", "")).verdict.value == "good"
