"""The patient's limits: every boundary, every persistence, and what a missing value does."""

import math
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel.interface import NO_MONITOR, Monitor
from opensuction.kernel.vocabulary import AgeGroup
from opensuction.safety import limits as safety_limits
from opensuction.safety.condition import Condition
from opensuction.safety.limits import AGE_LIMITS, COLLAPSING_CMH2O, AgeLimits
from opensuction.safety.watch import patient_watch
from opensuction.safety.watch.patient_watch import UNSEEN, PatientWatch
from tests.safety.watch.monitored import (
    ADULT,
    DT_S,
    PEEP,
    PERIOD_S,
    WELL,
    Report,
    at_pressure,
    breathing,
    first_s,
    on_time,
    seen,
    watched,
)
from tests.safety.watchdog import above, below

NAN = float("nan")


def test_a_patient_who_breathes_quietly_is_well() -> None:
    assert seen(watched(breathing, 60.0)) == set()
    assert seen(watched(breathing, 60.0, sucking=True)) == set()


@pytest.mark.requirement("OS-R38")
@pytest.mark.parametrize("age", AgeGroup)
def test_each_value_is_judged_at_its_limit_and_not_on_it(age: AgeGroup) -> None:
    limits = safety_limits.limits_of(age, PEEP, monitored=True)

    def found(change: Callable[[Monitor], Monitor]) -> set[Condition]:
        return seen(watched(lambda s: change(breathing(s)), 3.0, limits=limits))

    spo2, rate, most = limits.spo2_percent, limits.heart_rate_per_min, limits.airway_most_cmh2o
    well = breathing(0.0)._replace(heart_rate_per_min=rate)
    assert found(lambda m: m._replace(heart_rate_per_min=rate)) == set()
    slow = lambda m: m._replace(heart_rate_per_min=rate - 0.1)  # noqa: E731
    assert found(slow) == {Condition.HEART_RATE_LOW}
    fast = well._replace(spo2_percent=spo2)
    assert found(lambda m: fast._replace(airway_pressure_cmh2o=m.airway_pressure_cmh2o)) == set()
    low = fast._replace(spo2_percent=spo2 - 0.1)
    assert found(lambda m: low._replace(airway_pressure_cmh2o=m.airway_pressure_cmh2o)) == {
        Condition.SPO2_LOW
    }
    assert (
        seen(watched(lambda _: fast._replace(airway_pressure_cmh2o=most), 1.0, limits=limits))
        == set()
    )
    high = fast._replace(airway_pressure_cmh2o=most + 0.1)
    assert seen(watched(lambda _: high, 1.0, limits=limits)) == {Condition.AIRWAY_PRESSURE_UNSAFE}


@pytest.mark.parametrize(
    ("report", "code", "after_s"),
    [
        (lambda s: breathing(s)._replace(spo2_percent=79.9), Condition.SPO2_LOW, 2.0),
        (lambda s: breathing(s)._replace(heart_rate_per_min=49.9), Condition.HEART_RATE_LOW, 1.0),
        (lambda _: at_pressure(40.1), Condition.AIRWAY_PRESSURE_UNSAFE, 0.6),
        (lambda _: at_pressure(0.7), Condition.AIRWAY_PRESSURE_UNSAFE, 0.3),
        (lambda _: at_pressure(0.9), Condition.CIRCUIT_DISCONNECTED, 1.0),
        (lambda _: at_pressure(PEEP), Condition.AIRWAY_PRESSURE_UNSAFE, 10.0),
        (lambda _: at_pressure(PEEP + 12.0), Condition.AIRWAY_PRESSURE_UNSAFE, 10.01),
        (lambda _: NO_MONITOR, Condition.MONITOR_LINK_LOST, 2.0),
        (lambda s: breathing(s)._replace(connected=False), Condition.MONITOR_LINK_LOST, 2.0),
        (lambda s: breathing(s)._replace(spo2_valid=False), Condition.MONITOR_LINK_LOST, 12.0),
        (lambda s: breathing(s)._replace(heart_rate_valid=False), Condition.MONITOR_LINK_LOST, 2.0),
        (
            lambda s: breathing(s)._replace(airway_pressure_valid=False),
            Condition.MONITOR_LINK_LOST,
            2.0,
        ),
        (lambda s: breathing(s)._replace(spo2_percent=NAN), Condition.MONITOR_LINK_LOST, 12.0),
        (lambda s: breathing(s)._replace(heart_rate_per_min=NAN), Condition.MONITOR_LINK_LOST, 2.0),
        (lambda _: at_pressure(NAN), Condition.MONITOR_LINK_LOST, 2.0),
    ],
)
def test_a_condition_holds_after_its_time_and_is_the_only_one(
    report: Report, code: Condition, after_s: float
) -> None:
    states = watched(report, after_s + 0.1)
    assert seen(states) == {code}
    assert on_time(states, code, after_s)
    # It ends with its cause, a pressure that stood still with the next breath.
    assert watched(breathing, 2.0, watch=states[-1])[-1].conditions == 0


def test_pressure_below_peep_is_lost_volume_only_while_the_machine_sucks() -> None:
    for peep in (5.0, PEEP, 12.0):
        limits = safety_limits.limits_of(AgeGroup.ADULT, peep, monitored=True)
        for under, lost in ((3.69, False), (5.21, True), (30.0, True)):
            pressure = peep - under
            sample = at_pressure(pressure)
            states = watched(lambda _, it=sample: it, 0.5, sucking=True, limits=limits)  # type: ignore[misc]
            assert seen(states) == ({Condition.LUNG_VOLUME_LOST} if lost else set())
            assert not lost or on_time(states, Condition.LUNG_VOLUME_LOST, 0.3)
            # Once it is suction's doing it stays so while the valve closes.
            after = watched(lambda _, it=sample: it, 0.3, limits=limits, watch=states[-1])  # type: ignore[misc]
            assert seen(after) == seen(states)
            states = watched(lambda _, it=sample: it, 0.5, limits=limits)  # type: ignore[misc]
            assert seen(states) == ({Condition.AIRWAY_PRESSURE_UNSAFE} if lost else set())


def test_pressure_on_its_way_below_peep_is_lost_volume_a_little_later() -> None:
    """In a stiff lung the next breath loses as much again: 776 mL were lost before an alarm."""
    limits = safety_limits.limits_of(AgeGroup.ADULT, 12.0, monitored=True)
    falling = at_pressure(12.0 - 3.71)
    states = watched(lambda _: falling, 0.6, sucking=True, limits=limits)
    assert on_time(states, Condition.LUNG_VOLUME_LOST, 0.4)
    # With the valve closed it is the ventilator's affair.
    assert seen(watched(lambda _: falling, 0.6, limits=limits)) == set()


@pytest.mark.parametrize("peep", [3.0, 5.0, 6.0, 12.0])
@pytest.mark.parametrize("room", [-1.0, 0.0, 1.0])
def test_a_connector_at_the_rooms_pressure_is_open_whatever_the_peep(
    peep: float, room: float
) -> None:
    limits = safety_limits.limits_of(AgeGroup.ADULT, peep, monitored=True)
    states = watched(lambda _: at_pressure(room), 1.1, limits=limits)
    assert on_time(states, Condition.CIRCUIT_DISCONNECTED, 1.0)
    beyond = 1.01 if room > 0.0 else -1.01
    states = watched(lambda _: at_pressure(beyond), 1.1, limits=limits)
    assert Condition.CIRCUIT_DISCONNECTED not in seen(states)


def test_an_expiration_without_peep_is_no_disconnection() -> None:
    limits = safety_limits.limits_of(AgeGroup.ADULT, 0.0, monitored=True)
    quiet = lambda s: at_pressure(12.0 if s % 8.0 < 2.0 else 0.0)  # noqa: E731
    assert seen(watched(quiet, 30.0, limits=limits)) == set()
    off = watched(lambda _: at_pressure(0.0), 10.1, limits=limits)
    assert Condition.CIRCUIT_DISCONNECTED in seen(off)
    least = safety_limits.limits_of(AgeGroup.ADULT, 3.0, monitored=True)
    assert least.open_s == safety_limits.OPEN_S


def test_a_value_that_is_missing_now_and_then_hides_nothing() -> None:
    def every_other(time_s: float) -> Monitor:
        missing = round(time_s / DT_S) % 2 == 1
        low = at_pressure(0.0)._replace(spo2_percent=70.0, heart_rate_per_min=30.0)
        return NO_MONITOR if missing else low

    states = watched(every_other, 4.1)
    assert first_s(states, Condition.CIRCUIT_DISCONNECTED) == pytest.approx(2.0, abs=0.03)
    assert first_s(states, Condition.HEART_RATE_LOW) == pytest.approx(2.0, abs=0.03)
    assert first_s(states, Condition.SPO2_LOW) == pytest.approx(4.0, abs=0.05)
    assert Condition.MONITOR_LINK_LOST not in seen(states)


@given(
    values=st.tuples(st.floats(), st.floats(), st.floats()),
    flags=st.tuples(st.booleans(), st.booleans(), st.booleans(), st.booleans()),
    sucking=st.booleans(),
)
def test_without_a_monitor_nothing_is_judged(
    values: tuple[float, float, float], flags: tuple[bool, bool, bool, bool], sucking: bool
) -> None:
    odd = Monitor(flags[0], values[0], flags[1], values[1], flags[2], values[2], flags[3])
    none = safety_limits.limits_of(AgeGroup.ADULT, PEEP, monitored=False)
    assert watched(lambda _: odd, 0.1, sucking, none)[-1] == UNSEEN


@given(
    samples=st.lists(
        st.tuples(st.floats(), st.floats(), st.floats(), st.booleans(), st.booleans()), max_size=300
    )
)
def test_whatever_arrives_a_value_out_of_reach_is_never_taken_for_a_number(
    samples: list[tuple[float, float, float, bool, bool]],
) -> None:
    watch = UNSEEN
    for spo2, rate, pressure, connected, sucking in samples:
        monitor = Monitor(connected, spo2, True, rate, True, pressure, True)
        watch = patient_watch.step(ADULT, watch, monitor, sucking, DT_S)
        times = (watch.spo2_low_s, watch.heart_rate_low_s, watch.high_s, watch.low_s)
        assert all(0.0 <= time <= len(samples) * DT_S + 1e-9 for time in times)
        assert watch.conditions & ~ALL == 0


PATIENT = [c for c in Condition if Condition.SPO2_LOW <= c <= Condition.MONITOR_LINK_LOST]
ALL = sum(1 << code for code in PATIENT)
LINK = 1 << Condition.MONITOR_LINK_LOST


@given(chosen=st.sets(st.sampled_from(PATIENT)))
def test_conditions_end_a_cycle_only_where_there_is_something_to_withdraw(
    chosen: set[Condition],
) -> None:
    mask = sum(1 << code for code in chosen)
    assert patient_watch.select_trips(mask, False, False) == 0
    assert patient_watch.select_trips(mask, True, True) == mask
    assert patient_watch.select_trips(mask, True, False) == mask & ~LINK


def test_limits_follow_age_and_ventilator() -> None:
    assert set(AGE_LIMITS) == set(AgeGroup)
    assert set(safety_limits.SOURCES) == set(safety_limits.AgeLimits._fields)
    assert safety_limits.PatientLimits._fields[:6] == safety_limits.AgeLimits._fields
    small = AGE_LIMITS[AgeGroup.NEONATE], AGE_LIMITS[AgeGroup.CHILD], AGE_LIMITS[AgeGroup.ADULT]
    assert [limit.heart_rate_per_min for limit in small] == [100.0, 80.0, 50.0]
    assert ADULT.airway_least_cmh2o == pytest.approx(0.8)
    assert ADULT.breath_cmh2o == 8.0


def test_each_age_has_its_limits() -> None:
    # Saturation, heart rate, pressure, how long no breath may be seen, one of
    # their own may last, and coughs may push.
    assert {
        AgeGroup.NEONATE: AgeLimits(80.0, 100.0, 30.0, 4.0, 0.4, 0.3),
        AgeGroup.CHILD: AgeLimits(80.0, 80.0, 35.0, 6.0, 0.6, 0.35),
        AgeGroup.ADULT: AgeLimits(80.0, 50.0, 40.0, 10.0, 1.2, 0.6),
    } == AGE_LIMITS


# What is no fault: coughs, breaths of one's own, a hand that moves.


def leaping(to: float, from_s: float, to_s: float) -> Report:
    """A saturation that leaps there for a while."""
    return lambda s: breathing(s)._replace(spo2_percent=to if from_s <= s < to_s else 97.0)


@pytest.mark.requirement("OS-R38")
@pytest.mark.parametrize("to", [60.0, 75.0, 79.9])
@pytest.mark.parametrize("lasting_s", [0.5, 2.5, 11.9])
def test_a_saturation_that_leaps_down_and_back_is_a_hand_that_moved(
    to: float, lasting_s: float
) -> None:
    assert seen(watched(leaping(to, 1.0, 1.0 + lasting_s), 20.0)) == set()


def test_one_that_stays_down_is_believed_in_the_end() -> None:
    states = watched(leaping(70.0, 1.0, 99.0), 20.0)
    assert first_s(states, Condition.SPO2_LOW) == pytest.approx(1.0 + 12.0 + 2.0, abs=0.05)


@pytest.mark.parametrize("fall_percent_per_s", [0.5, 2.0, 7.0])
def test_one_that_falls_is_believed_at_once(fall_percent_per_s: float) -> None:
    """The display gives a value each half a second."""

    def falling(time_s: float) -> Monitor:
        shown_s = 0.5 * (time_s // 0.5)
        return breathing(time_s)._replace(spo2_percent=97.0 - fall_percent_per_s * shown_s)

    below_s = 0.5 * ((97.0 - ADULT.spo2_percent) // (0.5 * fall_percent_per_s)) + 0.5
    told_s = first_s(watched(falling, below_s + 4.0), Condition.SPO2_LOW)
    assert told_s == pytest.approx(below_s + 2.0, abs=0.55)


def test_a_low_saturation_that_is_there_from_the_start_is_believed() -> None:
    states = watched(leaping(70.0, 0.0, 99.0), 4.0)
    assert first_s(states, Condition.SPO2_LOW) == pytest.approx(2.0, abs=0.03)


@pytest.mark.parametrize("cmh2o", [60.0, 120.0])
def test_a_cough_is_no_blocked_expiration(cmh2o: float) -> None:
    """Three of them in a row, 0.25 s each, and again after half a minute."""

    def coughing(time_s: float) -> Monitor:
        at_s = time_s % 30.0
        pushed = any(start_s <= at_s < start_s + 0.25 for start_s in (5.0, 6.0, 7.2))
        return at_pressure(cmh2o) if pushed else breathing(time_s)

    assert seen(watched(coughing, 60.0)) == set()


@pytest.mark.parametrize(("age", "rate_per_min"), [(AgeGroup.NEONATE, 40), (AgeGroup.ADULT, 15)])
def test_inspirations_that_are_too_high_add_up(age: AgeGroup, rate_per_min: int) -> None:
    limits = safety_limits.limits_of(age, PEEP, monitored=True)
    period_s, high = 60.0 / rate_per_min, limits.airway_most_cmh2o + 1.0

    def forced(time_s: float) -> Monitor:
        return at_pressure(high if time_s % period_s < period_s / 3.0 else PEEP)

    states = watched(forced, 10.0, limits=limits)
    assert first_s(states, Condition.AIRWAY_PRESSURE_UNSAFE) < 2.1 * period_s


def test_a_pull_deeper_than_any_breath_is_told_as_soon_as_of_one_who_does_not_breathe() -> None:
    alone = safety_limits.limits_of(AgeGroup.ADULT, 12.0, monitored=True, breathes=True)
    for under, after_s in ((9.1, 1.2), (9.3, 0.3), (17.7, 0.3)):
        deep = at_pressure(12.0 - under)
        states = watched(lambda _, it=deep: it, 2.0, sucking=True, limits=alone)  # type: ignore[misc]
        told_s = first_s(states, Condition.LUNG_VOLUME_LOST)
        assert told_s == pytest.approx(after_s, abs=0.03)


@pytest.mark.parametrize("age", AgeGroup)
@pytest.mark.parametrize(
    ("sucking", "peep_cmh2o", "seconds"),
    [
        (False, 12.0, 20.0),
        (True, COLLAPSING_CMH2O - 0.1, 20.0),
        # Each ends in the ventilator's inspiration, as what suction takes does: they add up.
        (True, 12.0, 10.0),
    ],
)
def test_a_breath_of_ones_own_is_no_lost_volume(
    age: AgeGroup, sucking: bool, peep_cmh2o: float, seconds: float
) -> None:
    alone, sedated = (
        safety_limits.limits_of(age, peep_cmh2o, monitored=True, breathes=breathes)
        for breathes in (True, False)
    )
    effort_s = AGE_LIMITS[age].effort_s
    pulled = at_pressure(peep_cmh2o - 6.0)._replace(heart_rate_per_min=150.0)

    def pulling(time_s: float) -> Monitor:
        pulls = time_s % PERIOD_S > PERIOD_S - 0.95 * effort_s
        quiet = peep_cmh2o + (12.0 if time_s % PERIOD_S < 1.3 else 0.0)
        return pulled if pulls else pulled._replace(airway_pressure_cmh2o=quiet)

    assert seen(watched(pulling, seconds, sucking, alone)) == set()
    lost = Condition.LUNG_VOLUME_LOST if sucking else Condition.AIRWAY_PRESSURE_UNSAFE
    assert seen(watched(pulling, 20.0, sucking, sedated)) == {lost}
    # What lasts for longer is told of those who breathe, too.
    states = watched(lambda _: pulled, 2.0, sucking, alone)
    assert on_time(states, lost, effort_s)


EXACT_S = 0.125
"""A sample interval that sums exactly."""


@pytest.mark.parametrize(
    ("name", "sample", "allowed_s", "code"),
    [
        ("spo2_low_s", WELL._replace(spo2_percent=70.0), 2.0, Condition.SPO2_LOW),
        ("heart_rate_low_s", WELL._replace(heart_rate_per_min=40.0), 1.0, Condition.HEART_RATE_LOW),
        ("high_s", at_pressure(60.0), 0.6, Condition.AIRWAY_PRESSURE_UNSAFE),
        ("low_s", at_pressure(-9.0), 0.3, Condition.AIRWAY_PRESSURE_UNSAFE),
        ("open_s", at_pressure(1.0), 1.0, Condition.CIRCUIT_DISCONNECTED),
        ("breath_s", WELL, 10.0, Condition.AIRWAY_PRESSURE_UNSAFE),
        ("missing_s", WELL._replace(heart_rate_valid=False), 2.0, Condition.MONITOR_LINK_LOST),
        ("unsaturated_s", WELL._replace(spo2_valid=False), 12.0, Condition.MONITOR_LINK_LOST),
    ],
)
def test_each_may_last_its_time_and_no_longer(
    name: str, sample: Monitor, allowed_s: float, code: Condition
) -> None:
    raised = sample.airway_pressure_cmh2o > ADULT.breath_cmh2o
    # This sample brings it to its time exactly; the next, just beyond.
    before = UNSEEN._replace(breath=UNSEEN.breath._replace(raised=raised))
    on_it = patient_watch.step(ADULT, before, sample, False, allowed_s)
    assert getattr(on_it, name) == allowed_s
    assert on_it.conditions >> code & 1 == 0
    beyond = patient_watch.step(ADULT, on_it, sample, False, above(allowed_s) - allowed_s)
    assert getattr(beyond, name) == above(allowed_s)
    assert beyond.conditions >> code & 1 == 1


def test_a_pressure_on_its_limit_is_allowed() -> None:
    least, line = ADULT.airway_least_cmh2o, ADULT.breath_cmh2o

    def after(pressure: float) -> PatientWatch:
        return patient_watch.step(ADULT, UNSEEN, at_pressure(pressure), False, EXACT_S)

    assert after(least).low_s == 0.0
    assert after(below(least)).low_s == EXACT_S
    assert not after(line).breath.raised
    assert after(above(line)).breath.raised
    # A breath has crossed the line: it begins anew.
    assert after(line).breath_s == EXACT_S
    assert after(above(line)).breath_s == 0.0


def sinking(per_s: float) -> Report:
    """Suction takes more than the ventilator gives: each expiration falls further than the last."""

    def pressure(time_s: float) -> Monitor:
        breath, into_s = divmod(time_s, 3.0)
        fallen = per_s * (into_s - 1.3) + 0.5 * breath
        return at_pressure(27.0 if into_s < 1.3 else 12.0 - 3.2 - fallen)

    return pressure


def test_a_lung_that_empties_is_told_before_it_is_as_low_as_it_must_not_be() -> None:
    """An adult who breathes: 1.2 s must be waited for, for a breath falls and comes back."""
    alone = safety_limits.limits_of(AgeGroup.ADULT, 12.0, monitored=True, breathes=True)
    states = watched(sinking(1.2), 12.0, sucking=True, limits=alone)
    told_s = first_s(states, Condition.LUNG_VOLUME_LOST)
    low = [one.low_s for one in states[: round(told_s / DT_S)]]
    assert told_s == pytest.approx(1.3 + 1.5, abs=0.3)
    assert max(low) < alone.low_s / 3.0
    assert seen(watched(sinking(1.2), 12.0, sucking=False, limits=alone)) <= {
        Condition.AIRWAY_PRESSURE_UNSAFE
    }


@pytest.mark.parametrize("age", AgeGroup)
@pytest.mark.parametrize("deepest_cmh2o", [4.0, 6.0, 8.9])
def test_a_half_sine_of_a_breath_is_not_a_lung_that_empties(
    age: AgeGroup, deepest_cmh2o: float
) -> None:
    alone = safety_limits.limits_of(age, 12.0, monitored=True, breathes=True)
    lasts_s = AGE_LIMITS[age].effort_s / 1.2

    def pulling(time_s: float) -> Monitor:
        into_s = time_s % PERIOD_S
        if into_s < 1.3:
            return at_pressure(24.0)._replace(heart_rate_per_min=150.0)
        phase = min(max((into_s - 2.0) / lasts_s, 0.0), 1.0)
        pull = deepest_cmh2o * math.sin(math.pi * phase)
        return at_pressure(12.0 - pull)._replace(heart_rate_per_min=150.0)

    assert seen(watched(pulling, 30.0, True, alone)) == set()
