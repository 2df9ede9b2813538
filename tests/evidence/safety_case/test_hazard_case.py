"""Single rows of the table that once broke a bound."""

import pytest

from opensuction.evidence.safety_case import hazard, hazard_case


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


def test_a_dead_current_sensor_breaks_no_bound() -> None:
    (row,) = (one for one in hazard.load() if one.row.id == "OS-H40")
    runs = [hazard_case.run(case) for case in hazard_case.cases(row, (1,))]
    assert len(runs) == 8
    assert [result.problem for result in runs] == [""] * 8
