"""Allowances of faults on bounds: few, for that fault alone, and each with a reason."""

import math

import pytest

from opensuction.oracle import harm
from opensuction.oracle.harm import ADVANCE, FORCE, NAMES, SATURATION, TIP_PAST_CAP, Harm
from opensuction.simulation.injection import fault_allowance
from opensuction.simulation.injection.fault_allowance import ALLOWANCES, MOST_MM, OWN_HARM
from opensuction.simulation.injection.fault_instant import FaultInstant, Injection
from opensuction.twin.fault.fault import Fault, FaultSite
from opensuction.twin.fault.fault_table import ROWS

BOTH = (Fault.CONDUIT_REROUTED, Fault.TUBE_DISPLACED)


def pressed(newton: float) -> Harm:
    return Harm(FORCE, newton, 0.3, "N")


def came(*faults: Fault, strength: float = 1.0) -> list[Injection]:
    return [Injection(fault, FaultInstant(None, 0.0), strength) for fault in faults]


def is_breach(found: Harm, *faults: Fault) -> bool:
    return fault_allowance.find_breaches([found], came(*faults)) == (found,)


def test_only_the_fault_that_states_a_bound_has_it() -> None:
    assert is_breach(pressed(0.301))
    assert is_breach(pressed(0.301), Fault.PUMP_LOST)
    assert not is_breach(pressed(1.199), Fault.TUBE_DISPLACED)
    assert is_breach(pressed(1.201), Fault.TUBE_DISPLACED)
    assert is_breach(Harm(ADVANCE, 0.6, 0.5, "mm"), Fault.TUBE_DISPLACED)


def test_of_two_faults_the_one_that_adds_most_counts() -> None:
    for newton in (1.199, 1.201):
        assert is_breach(pressed(newton), *BOTH) == is_breach(pressed(newton), BOTH[1])


def test_what_must_hold_strictly_has_nothing_added() -> None:
    found = pressed(0.301), Harm(ADVANCE, 5.0, 0.5, "mm")
    faults = came(Fault.CONDUIT_REROUTED)
    assert fault_allowance.find_breaches(found, faults) == ()
    assert fault_allowance.find_breaches(found, faults, strictly=(FORCE,)) == found[:1]


def test_a_saturation_that_falls_by_itself_is_no_breach_and_pressure_then_is() -> None:
    low = Harm(SATURATION, 60.0, 83.0, "%")
    assert is_breach(low, Fault.PUMP_LOST)
    assert not is_breach(low, Fault.DESATURATION)
    assert is_breach(Harm(harm.AIRWAY_PRESSURE, 9.0, 5.0, "s"), Fault.DESATURATION)


@pytest.mark.parametrize(("name", "limit_s"), [(harm.CONTACT_TIME, 3.0), (harm.AIRWAY_TIME, 30.0)])
def test_a_motor_without_current_adds_that_time_and_no_other_fault_any(
    name: str, limit_s: float
) -> None:
    timed = [one.fault for one in ALLOWANCES if one.bound == name and one.for_strength]
    assert timed == [Fault.MOTOR_INTERMITTENT]
    found = Harm(name, limit_s + 2.05, limit_s, "s")
    for gone_s, breach in ((2.0, True), (2.1, False)):
        gone = came(Fault.MOTOR_INTERMITTENT, strength=gone_s)
        assert (fault_allowance.find_breaches([found], gone) == (found,)) == breach


def test_a_valve_adds_the_less_way_the_more_it_is_open_and_never_more_than_it_may() -> None:
    by_opening = [one.fault for one in ALLOWANCES if math.isfinite(one.over_strength)]
    assert by_opening == [Fault.VALVE_STUCK_OPEN]
    for opening, way_mm, breach in (
        (1.0, 13.9, False),
        (1.0, 14.1, True),
        (0.2, 43.9, False),
        (0.2, 44.1, True),
        (0.1, 60.4, False),
        (0.1, 60.6, True),
    ):
        open_by = came(Fault.VALVE_STUCK_OPEN, strength=opening)
        found = Harm(ADVANCE, way_mm, 0.5, "mm")
        assert (fault_allowance.find_breaches([found], open_by) == (found,)) == breach


def test_a_slit_of_a_valve_adds_a_small_patients_way_in_to_suction_and_a_wide_one_nothing() -> None:
    timed = [one.fault for one in ALLOWANCES if one.bound == harm.SUCTION_TIME]
    assert timed == [Fault.VALVE_STUCK_OPEN]
    for opening, lasted_s, breach in ((0.2, 10.2, False), (0.2, 10.4, True), (0.21, 6.1, True)):
        slit = came(Fault.VALVE_STUCK_OPEN, strength=opening)
        found = Harm(harm.SUCTION_TIME, lasted_s, 6.0, "s")
        assert (fault_allowance.find_breaches([found], slit) == (found,)) == breach


def test_each_is_stated_once_and_is_a_number_that_can_be_passed() -> None:
    assert len({(one.fault, one.bound) for one in ALLOWANCES}) == len(ALLOWANCES)
    for one in ALLOWANCES:
        assert math.isfinite(one.more)
        assert one.more > 0.0 or one.for_strength
        assert one.reason
        assert not ROWS[one.fault].is_setup
        if one.bound in (ADVANCE, TIP_PAST_CAP):
            assert one.more <= MOST_MM


def test_only_what_a_patient_or_a_ventilator_does_is_a_harm_of_its_own() -> None:
    for one in OWN_HARM:
        assert one.fault.site == FaultSite.PATIENT
        assert set(one.bounds) <= set(NAMES[-3:])
        assert one.reason


@pytest.mark.parametrize("name", [harm.LEFT_INSIDE, harm.VACUUM])
def test_time_in_the_patient_is_excused_by_no_fault(name: str) -> None:
    """Nor is the vacuum's height: for these there is always something left to do."""
    assert name not in {one.bound for one in ALLOWANCES}
    assert name not in {bound for one in OWN_HARM for bound in one.bounds}
