"""Draw of a trial's cycle: it follows from the cycle's number alone."""

import numpy as np
import pytest

from opensuction.evidence.trial import draw
from opensuction.evidence.trial.draw import FAULTS
from opensuction.kernel.errors import InputError
from opensuction.result.trial_result import Trial
from opensuction.session.cycle.resolution import APPROACHES
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_table import ROWS
from opensuction.twin.patient.patient_parameter import PATIENT_TABLES

SINGLE, DOUBLE, NONE = Trial(faults="single"), Trial(faults="double"), Trial(faults="none")


def test_a_cohort_has_its_patients_by_every_approach() -> None:
    every = {(patient, approach) for patient in PATIENT_TABLES for approach in APPROACHES}
    assert set(draw.list_kinds("presets")) == every
    assert {kind.patient for kind in draw.list_kinds("neonate")} == {"neonate"}


def test_an_unknown_cohort_is_refused_with_those_that_are_known() -> None:
    with pytest.raises(InputError, match=r"--cohort 'adults'.*adult-icu.*presets") as refused:
        draw.list_kinds("adults")
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("trial", [SINGLE, NONE, Trial(cohort="neonate")])
@pytest.mark.parametrize("cycles", [1, 3, 8, 9, 100, 401, 1000])
def test_every_number_has_one_machine_whose_kind_is_its_own(trial: Trial, cycles: int) -> None:
    machines = draw.count_machines(trial, cycles)
    numbers = [draw.list_numbers(trial, machine, cycles) for machine in range(machines)]
    assert all(numbers)
    assert sorted(number for found in numbers for number in found) == [*range(1, cycles + 1)]
    for machine, found in enumerate(numbers):
        assert {draw.find_machine(trial, number) for number in found} == {machine}


def test_the_first_eight_cycles_are_of_every_kind() -> None:
    found = {draw.kind_of(SINGLE, draw.find_machine(SINGLE, number)) for number in range(1, 9)}
    assert found == set(draw.list_kinds("presets"))


def test_no_two_machines_share_a_seed_nor_do_trials() -> None:
    seeds = [
        draw.machine_seed(Trial(seed=seed), machine, 0)
        for seed in (1, 2, 3)
        for machine in range(2000)
    ]
    assert len({*seeds}) == len(seeds)
    assert draw.machine_seed(SINGLE, 5, 1) not in seeds


def test_faults_are_drawn_from_the_number_alone() -> None:
    drawn = [draw.draw_faults(DOUBLE, number) for number in range(1, 1001)]
    assert drawn[122] == draw.draw_faults(DOUBLE, 123)
    assert {len(one) for one in drawn} == {2}
    assert draw.draw_faults(NONE, 123) == ()
    assert draw.draw_faults(DOUBLE._replace(seed=2), 123) != drawn[122]
    faults = [fault for one in drawn for fault in one]
    assert {one.fault for one in faults} == set(FAULTS)
    for one in faults:
        ROWS[one.fault].check_strength(one.strength)
    parts = np.histogram([one.share for one in faults], bins=5, range=(0.0, 1.0))[0]
    assert parts.min() > 0.8 * parts.mean()
    assert not any(ROWS[fault].is_setup for fault in FAULTS)


def test_a_strength_of_a_wide_range_is_drawn_by_its_logarithm() -> None:
    strengths = [
        fault.strength
        for number in range(1, 20_001)
        for fault in draw.draw_faults(SINGLE, number)
        if fault.fault == Fault.CONTACT_INTERMITTENT
    ]
    known = ROWS[Fault.CONTACT_INTERMITTENT].strength
    assert known is not None
    middle = np.sqrt(known.least * known.most)
    # Of about 200 drawn, half within 3 standard deviations of 7.
    assert abs(np.mean(np.array(strengths) < middle) - 0.5) < 0.11
