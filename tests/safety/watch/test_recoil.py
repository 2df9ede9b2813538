"""A cough under suction empties the lung: the pressure that rises after it is no loss."""

import math

import pytest

from opensuction.kernel.interface import Monitor
from opensuction.kernel.vocabulary import AgeGroup
from opensuction.safety import limits as safety_limits
from opensuction.safety.condition import Condition
from opensuction.safety.watch.patient_watch import RISEN_CMH2O
from opensuction.session.choice import CycleChoice, DayChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.session.day import day_run
from opensuction.simulation.trace import Columns
from tests.safety.watch.monitored import (
    DT_S,
    PEEP,
    PERIOD_S,
    Report,
    at_pressure,
    breathing,
    first_s,
    seen,
    watched,
)

LOST = Condition.LUNG_VOLUME_LOST
COUGH_AT_S = 5.5
COUGHED_AT_S = COUGH_AT_S + 0.25
BY_AGE = {
    age: safety_limits.limits_of(age, PEEP, monitored=True, breathes=True) for age in AgeGroup
}
ADULT = BY_AGE[AgeGroup.ADULT]
LOWEST = PEEP - 4.8
"""As of the adults of seeds 209 and 9110, whose cycles were broken off."""


def coughing(after: Report, raised_s: float = 0.25) -> Report:
    """Quiet breaths, then something that raises the pressure for so long, and what comes after."""

    def report(time_s: float) -> Monitor:
        if time_s < COUGH_AT_S:
            return breathing(time_s)
        into_s = time_s - COUGH_AT_S
        return at_pressure(PEEP + 9.0) if into_s < raised_s else after(into_s - raised_s)

    return report


def rising(since_s: float) -> Monitor:
    """The lung fills again, slowly, for suction takes most of the flow."""
    return at_pressure(LOWEST + 1.0 - math.exp(-since_s / 0.5))


def recoil(since_s: float) -> Monitor:
    """The same, and a breath of the patient's own after a second."""
    pull = 1.2 * math.sin(math.pi * min(max(since_s - 1.0, 0.0) / 0.8, 1.0))
    return at_pressure(rising(since_s).airway_pressure_cmh2o - pull)


def staying(_: float) -> Monitor:
    return at_pressure(LOWEST)


def told_after_s(report: Report, from_s: float, seconds: float = 9.0) -> float:
    return first_s(watched(report, seconds, sucking=True, limits=ADULT), LOST) - from_s


def test_the_recoil_after_a_cough_is_no_lost_volume() -> None:
    report = coughing(recoil)
    assert seen(watched(report, COUGHED_AT_S + 1.8, sucking=True, limits=ADULT)) == set()
    # The same after an inspiration is: an expiration falls, and does not rise.
    inspired = coughing(recoil, raised_s=1.3)
    assert seen(watched(inspired, COUGH_AT_S + 3.1, sucking=True, limits=ADULT)) == {LOST}


def test_the_pull_of_a_breath_out_of_the_recoil_is_no_deep_one() -> None:
    """Seed 9106: a breath that begins low goes deeper than one from PEEP, and comes back."""

    def pulled(since_s: float) -> Monitor:
        return at_pressure(-5.1 + 4.0 * since_s * since_s + 3.0 * since_s)

    told_s = told_after_s(coughing(pulled), COUGHED_AT_S, COUGHED_AT_S + 1.2)
    assert told_s == math.inf


def test_a_pressure_that_stays_low_after_a_cough_is_told_as_soon_as_after_a_breath() -> None:
    told_s = told_after_s(coughing(staying), COUGHED_AT_S)
    assert told_s == pytest.approx(ADULT.low_s + 0.1, abs=3.0 * DT_S)
    breath_s = told_after_s(coughing(staying, raised_s=1.3), COUGH_AT_S + 1.3)
    assert told_s == pytest.approx(breath_s, abs=2.0 * DT_S)


def test_one_that_falls_again_counts_from_where_it_was_lowest() -> None:
    """It rose for a second and is lost then: told in its time from the fall on."""

    def falling(since_s: float) -> Monitor:
        return recoil(since_s) if since_s < 1.0 else staying(since_s)

    told_s = told_after_s(coughing(falling), COUGHED_AT_S + 1.0)
    assert told_s <= ADULT.low_s + 0.1 + 2.0 * DT_S


@pytest.mark.parametrize("risen", [0.0, RISEN_CMH2O - 0.1])
def test_a_rise_within_the_noise_is_none(risen: float) -> None:
    def noisy(since_s: float) -> Monitor:
        return at_pressure(LOWEST + (risen if round(since_s / DT_S) % 2 else 0.0))

    assert told_after_s(coughing(noisy), COUGHED_AT_S) < ADULT.low_s + 0.1 + 3.0 * DT_S


def test_noise_where_a_breath_ends_is_no_cough() -> None:
    """An inspiration, the line crossed back for a sample, and a loss that rises slowly."""

    def ended(since_s: float) -> Monitor:
        if 0.03 <= since_s < 0.05:
            return at_pressure(PEEP + 2.1)
        return recoil(max(since_s - 0.05, 0.0))

    states = watched(coughing(ended, 1.3), COUGH_AT_S + 3.2, sucking=True, limits=ADULT)
    assert seen(states) == {LOST}


@pytest.mark.parametrize("age", AgeGroup)
def test_a_lung_that_empties_breath_by_breath_is_told_whoever_coughed_before(
    age: AgeGroup,
) -> None:
    """The next inspiration ends what a cough excuses."""

    def emptying(since_s: float) -> Monitor:
        breath, into_s = divmod(since_s, PERIOD_S)
        if breath > 0.0 and into_s < 1.3:
            return at_pressure(PEEP + 9.0)._replace(heart_rate_per_min=150.0)
        low = rising(into_s if breath == 0.0 else into_s - 1.3)
        return low._replace(heart_rate_per_min=150.0)

    report, limits = coughing(emptying, 0.2), BY_AGE[age]
    states = watched(report, COUGHED_AT_S + 2.0 * PERIOD_S, sucking=True, limits=limits)
    assert COUGHED_AT_S + PERIOD_S < first_s(states, LOST) < COUGHED_AT_S + PERIOD_S + 3.0


@pytest.mark.parametrize("seed", [209, 9110])
def test_a_sound_adult_who_coughs_under_suction_is_sucked_to_the_end(seed: int) -> None:
    """Drawn adults by contact without a fault, broken off for volume that nobody had lost."""
    chosen = CycleChoice(RigChoice(patient="adult-icu", seed=seed), approach="contact")
    begun = cycle_run.prepare(resolution.resolve(chosen))
    coughs: list[float] = []

    def tell(_: object, __: object, columns: Columns) -> None:
        sucking = columns["truth.tip_vacuum_mmhg"] > 1.0
        coughs.append(float(columns["truth.muscle_cmh2o"][sucking].max()))

    found = day_run.play(begun, DayChoice(1, 30.0), tell)
    assert coughs[0] > 30.0
    assert found.cycles[0].outcome.completed
    assert found.cycles[0].outcome.trips == ()
