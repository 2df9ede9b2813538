"""Bounds that faults state for themselves: few, for that fault alone, and each with a reason."""

import math

import pytest

from opensuction.simulation.injection import fault_allowance
from opensuction.simulation.injection.fault_allowance import ALLOWANCES, PhysicalBound
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_table import ROWS


def test_only_the_fault_that_states_a_bound_has_it() -> None:
    common = 0.3
    assert fault_allowance.raise_limit(PhysicalBound.FORCE, common, ()) == common
    assert fault_allowance.raise_limit(PhysicalBound.FORCE, common, (Fault.PUMP_LOST,)) == common
    assert (
        fault_allowance.raise_limit(PhysicalBound.FORCE, common, (Fault.TUBE_DISPLACED,)) > common
    )
    assert (
        fault_allowance.raise_limit(PhysicalBound.SUCTION, common, (Fault.TUBE_DISPLACED,))
        == common
    )


def test_of_two_faults_the_one_that_adds_most_counts() -> None:
    both = (Fault.SWITCH_STIFF, Fault.TUBE_DISPLACED)
    alone = fault_allowance.raise_limit(PhysicalBound.FORCE, 0.3, both[1:])
    assert fault_allowance.raise_limit(PhysicalBound.FORCE, 0.3, both) == pytest.approx(alone)


def test_each_is_stated_once_and_is_a_number() -> None:
    assert len({(one.fault, one.bound) for one in ALLOWANCES}) == len(ALLOWANCES)
    for one in ALLOWANCES:
        assert math.isfinite(one.more)
        assert one.more > 0.0
        assert one.reason
        assert not ROWS[one.fault].is_setup


def test_time_in_the_patient_is_excused_by_no_fault() -> None:
    """Nor is the vacuum's height: for these there is always something left to do."""
    excused = {one.bound for one in ALLOWANCES}
    assert excused.isdisjoint({PhysicalBound.SUCTION, PhysicalBound.AIRWAY, PhysicalBound.VACUUM})
