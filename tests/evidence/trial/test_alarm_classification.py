"""Alarms in a sound cycle: true of the patient, or false."""

import numpy as np
import pytest

from opensuction.evidence.trial import judged_cycle
from opensuction.kernel.vocabulary import AgeGroup, Phase
from opensuction.safety import limits
from opensuction.safety.condition import Condition
from opensuction.simulation.trace import Columns

LIMITS = limits.limits_of(AgeGroup.ADULT, 8.0, monitored=True)
TICKS = 3000
SOUND = {
    "truth.spo2_percent": 97.0,
    "truth.heart_rate_per_min": 90.0,
    "truth.airway_pressure_cmh2o": 12.0,
}


def track(
    *said: Condition, trips: tuple[Condition, ...] = (), truth: dict[str, float] | None = None
) -> Columns:
    """A cycle in which conditions are shown, or trip, from its middle on."""
    columns: Columns = {name: np.zeros(TICKS) for name in judged_cycle.COLUMNS}
    columns["time_s"][:] = 0.001 * np.arange(TICKS)
    columns["phase"][:] = Phase.SUCTIONING
    for name, value in SOUND.items():
        columns[name][:] = value
    for name, value in (truth or {}).items():
        columns[f"truth.{name}"][1000:] = value
    columns["annunciator.said"][TICKS // 2 :] = sum(1 << one for one in said)
    columns["verdict.trips"][TICKS // 2 :] = sum(1 << one for one in trips)
    return columns


def test_nothing_said_is_nothing_false() -> None:
    assert judged_cycle.listen(track(), LIMITS) == ((), ())


@pytest.mark.parametrize(
    ("condition", "truth"),
    [
        (Condition.SPO2_LOW, {"spo2_percent": LIMITS.spo2_percent - 0.1}),
        (Condition.HEART_RATE_LOW, {"heart_rate_per_min": LIMITS.heart_rate_per_min - 1.0}),
        (
            Condition.AIRWAY_PRESSURE_UNSAFE,
            {"airway_pressure_cmh2o": LIMITS.airway_most_cmh2o + 20.0},
        ),
        (
            Condition.AIRWAY_PRESSURE_UNSAFE,
            {"airway_pressure_cmh2o": LIMITS.airway_least_cmh2o - 1.0},
        ),
        (Condition.LUNG_VOLUME_LOST, {"airway_pressure_cmh2o": LIMITS.airway_losing_cmh2o - 0.1}),
    ],
)
def test_what_the_patient_really_has_is_told_rightly(
    condition: Condition, truth: dict[str, float]
) -> None:
    assert judged_cycle.listen(track(condition, truth=truth), LIMITS) == (
        (),
        (condition.name,),
    )
    assert judged_cycle.listen(track(condition), LIMITS) == ((condition.name,), ())


def test_what_comes_to_pass_afterwards_was_false_when_it_was_said() -> None:
    columns = track(Condition.SPO2_LOW)
    columns["truth.spo2_percent"][TICKS // 2 + 1 :] = 60.0
    assert judged_cycle.listen(columns, LIMITS).false == ("SPO2_LOW",)


def test_a_machine_that_complains_without_a_fault_is_false() -> None:
    found = judged_cycle.listen(track(trips=(Condition.CATHETER_JAMMED,)), LIMITS)
    assert found == (("CATHETER_JAMMED",), ())


def test_that_automation_stopped_is_as_true_as_what_stopped_it() -> None:
    said = (Condition.SPO2_LOW, Condition.AUTOMATION_STOPPED)
    assert judged_cycle.listen(track(*said, truth={"spo2_percent": 60.0}), LIMITS).false == ()
    assert set(judged_cycle.listen(track(*said), LIMITS).false) == {one.name for one in said}


def test_a_cycle_that_is_broken_off_without_a_word_is_false() -> None:
    columns = track()
    columns["phase"][2000:] = Phase.ABORTING
    assert judged_cycle.listen(columns, LIMITS).false == (judged_cycle.BROKEN_OFF,)
