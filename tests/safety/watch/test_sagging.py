"""A lung that collapses below its PEEP: suction that lowers the pressure a little, for long."""

import math
from pathlib import Path

import pytest

from opensuction.kernel.interface import Monitor
from opensuction.kernel.vocabulary import AgeGroup
from opensuction.oracle import harm
from opensuction.safety import limits as safety_limits
from opensuction.safety.condition import Condition
from opensuction.safety.limits import (
    AGE_LIMITS,
    COLLAPSING_CMH2O,
    SAGGING_CMH2O,
    SAGGING_S,
)
from opensuction.safety.watch.patient_watch import DEEP_SAG_CMH2O, SAG_CMH2O
from opensuction.session.choice import CycleChoice, DayChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.session.day import day_run
from opensuction.twin.patient.patient_parameter import PATIENT_TABLES
from tests.safety.watch.monitored import DT_S, PERIOD_S, Report, at_pressure, first_s, watched

LOST = Condition.LUNG_VOLUME_LOST
ADULT = AgeGroup.ADULT
INSPIRED_S = 1.0
SAGS_S = PERIOD_S - INSPIRED_S
"""Of each breath."""
WORSE = {
    "resistance_cmh2o_s_per_l": -3.0,
    "weight_kg": -3.0,
    "carina_mm": 3.0,
    "compliance_ml_per_cmh2o_per_kg": -3.0,
    "droop_cmh2o_s_per_l": 3.0,
    "leak_ml_per_s_per_cmh2o": 3.0,
    "secretion_ml": 3.0,
    "viscosity_pa_s": 3.0,
    "secretion_resistance_ratio": 3.0,
    "closable_ml_per_kg": 3.0,
}
"""Values of a patient with ARDS by which suction takes more, in standard deviations; found by
moving one after the other."""


CLOSABLE = 20.8
"""Most that a patient file takes with the others as they are, mL/kg."""


def sagging(peep_cmh2o: float, by_cmh2o: float) -> Report:
    """Breaths whose expirations end so far below PEEP."""

    def report(time_s: float) -> Monitor:
        inspired = time_s % PERIOD_S < INSPIRED_S
        return at_pressure(peep_cmh2o + 12.0 if inspired else peep_cmh2o - by_cmh2o)

    return report


def told_s(peep_cmh2o: float, by_cmh2o: float, seconds: float = 20.0) -> float:
    limits = safety_limits.limits_of(ADULT, peep_cmh2o, monitored=True, breathes=True)
    report = sagging(peep_cmh2o, by_cmh2o)
    return first_s(watched(report, seconds, sucking=True, limits=limits), LOST)


def test_expirations_add_up_in_a_lung_that_collapses_below_its_peep() -> None:
    """In the second breath; of a fall that goes on it is not known before that it is suction's."""
    effort_s = AGE_LIMITS[ADULT].effort_s
    assert SAGS_S < SAGGING_S < SAGS_S + effort_s
    found_s = told_s(COLLAPSING_CMH2O, SAGGING_CMH2O + SAG_CMH2O + 0.05)
    assert found_s == pytest.approx(PERIOD_S + INSPIRED_S + effort_s, abs=2.0 * DT_S)


@pytest.mark.parametrize("below_cmh2o", [0.3, 0.6, 1.0])
def test_shallow_expirations_are_told_of_as_soon_as_they_are_deep_in_all(
    below_cmh2o: float,
) -> None:
    falls, left_s = divmod(SAG_CMH2O * SAGGING_S / below_cmh2o, SAGS_S)
    expected_s = falls * PERIOD_S + INSPIRED_S + max(left_s, AGE_LIMITS[ADULT].effort_s)
    found_s = told_s(COLLAPSING_CMH2O, SAGGING_CMH2O + below_cmh2o, 30.0)
    assert found_s == pytest.approx(expected_s, abs=5.0 * DT_S)


@pytest.mark.parametrize("below_cmh2o", [1.4, 1.6, 2.6])
def test_a_fall_that_is_deep_is_told_of_before_the_next(below_cmh2o: float) -> None:
    """Short of where volume begins to be lost by its depth alone."""
    deep_s = DEEP_SAG_CMH2O * SAGGING_S / below_cmh2o
    expected_s = deep_s if deep_s < SAGS_S else PERIOD_S + AGE_LIMITS[ADULT].effort_s
    found_s = told_s(12.0, SAGGING_CMH2O + below_cmh2o)
    assert found_s == pytest.approx(INSPIRED_S + expected_s, abs=2.0 * DT_S)


def test_neither_less_than_that_nor_a_lung_that_holds_its_volume() -> None:
    assert told_s(COLLAPSING_CMH2O, SAGGING_CMH2O - 0.05) == float("inf")
    for below_cmh2o in (0.05, 2.6):
        assert told_s(COLLAPSING_CMH2O - 0.1, SAGGING_CMH2O + below_cmh2o) == float("inf")


@pytest.mark.parametrize("effort_s", [0.4, 0.8, 1.0])
@pytest.mark.parametrize("gap_s", [0.25, 0.6])
def test_breaths_of_the_patients_own_do_not_add_up(effort_s: float, gap_s: float) -> None:
    """As deep as they may be, between those of the ventilator and at any time but right before."""
    limits = safety_limits.limits_of(ADULT, 12.0, monitored=True, breathes=True)

    def report(time_s: float) -> Monitor:
        into_s = time_s % PERIOD_S
        left_s = PERIOD_S - into_s
        if into_s < INSPIRED_S:
            return at_pressure(24.0)
        pull = math.sin(math.pi * (left_s - gap_s) / effort_s)
        return at_pressure(12.0 - 3.0 * pull if gap_s < left_s < gap_s + effort_s else 12.0)

    states = watched(report, 60.0, sucking=True, limits=limits)
    assert first_s(states, LOST) == float("inf")


def test_each_suction_has_its_time() -> None:
    """What sags without suction is none of it, and the next one begins anew."""
    limits = safety_limits.limits_of(ADULT, 12.0, monitored=True, breathes=True)
    report = sagging(12.0, 2.0)
    seconds = PERIOD_S + INSPIRED_S
    first = watched(report, seconds, sucking=True, limits=limits)
    assert first[-1].sag.in_all_s == pytest.approx(SAGS_S, abs=2.0 * DT_S)
    closed = watched(report, PERIOD_S, sucking=False, limits=limits, watch=first[-1])
    again = watched(report, seconds, True, limits, closed[-1])
    assert all(first_s(states, LOST) == float("inf") for states in (first, closed, again))


@pytest.mark.parametrize(
    ("sd", "seed", "approach"),
    [
        (2.5, 1, "travel"),
        (3.0, 1, "travel"),
        pytest.param(3.0, 2, "travel", marks=pytest.mark.sweep),
        pytest.param(3.0, 1, "contact", marks=pytest.mark.sweep),
    ],
)
def test_a_patient_at_the_corner_of_the_spread_is_told_of(
    tmp_path: Path, sd: float, seed: int, approach: str
) -> None:
    """Up to 9 mL/kg, where it was told of none and up to 14 were lost."""
    table = PATIENT_TABLES["adult-ards"]
    lines = ['preset = "adult-ards"']
    for name, by in WORSE.items():
        row = table[name]
        value = row.value + row.spread * by * sd / 3.0
        high = CLOSABLE if name == "closable_ml_per_kg" else row.high
        lines.append(f"{name} = {min(max(value, row.low), high)}")
    file = tmp_path / "corner.toml"
    file.write_text("\n".join(lines))
    chosen = CycleChoice(RigChoice(patient=str(file), seed=seed), approach=approach)
    begun = cycle_run.prepare(resolution.resolve(chosen))
    outcome = day_run.play(begun, DayChoice(1, 30.0), lambda *_: None).cycles[0].outcome
    assert LOST in {one.trip for one in outcome.trips}
    assert harm.LUNG_VOLUME not in {one.name for one in outcome.harm}
