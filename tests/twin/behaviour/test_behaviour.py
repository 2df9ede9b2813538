"""Behaviour of a patient as a whole: by seed and run, and none where the patient is quiet."""

import numpy as np
import pytest

from opensuction.kernel.record import Array
from opensuction.twin import parameter
from opensuction.twin.behaviour import behaviour_parameter
from opensuction.twin.patient import patient_preset
from opensuction.twin.patient.patient_parameter import PATIENT_TABLES, PRESETS
from tests.twin.behaviour import bed


def same(one: dict[str, Array], other: dict[str, Array]) -> bool:
    return all(np.array_equal(one[name], other[name]) for name in bed.COLUMNS)


def test_drawn_patients_are_lively_nominal_ones_quiet_and_the_switch_goes_both_ways() -> None:
    for name in PRESETS:
        assert not patient_preset.patient(name, 3, nominal=True).behaviour.is_lively
        person = patient_preset.patient(name, 3)
        assert person.behaviour.is_lively
        assert not patient_preset.quiet(person).behaviour.is_lively
        assert patient_preset.lively(patient_preset.quiet(person)) == person


def test_a_quiet_patient_does_nothing() -> None:
    person = patient_preset.quiet(patient_preset.patient("adult-icu", 3))
    after, seen = bed.watch(bed.bed(person), 60.0, tip_mm=30.0, l_per_min=10.0)
    for name in ("muscle_cmh2o", "carina_shift_mm"):
        assert set(seen[name]) == {0.0}
    assert set(seen["gap_ratio"]) == {1.0}
    assert np.array_equal(seen["airway_pressure_cmh2o"], seen["relaxed_pressure_cmh2o"])
    assert np.array_equal(seen["loss_ml"], seen["relaxed_loss_ml"])
    assert np.array_equal(seen["spo2_percent"], seen["shown_percent"])
    assert after.state.store.adherent_ml == after.state.store.deep_ml == 0.0


def test_the_same_seed_and_run_bring_the_same_and_others_others() -> None:
    person = bed.lively()
    _, one = bed.watch(bed.bed(person), 120.0, tip_mm=30.0)
    _, again = bed.watch(bed.bed(person), 120.0, tip_mm=30.0)
    _, run = bed.watch(bed.bed(person, run=1), 120.0, tip_mm=30.0)
    _, seed = bed.watch(bed.bed(person, seed=2), 120.0, tip_mm=30.0)
    assert same(one, again)
    assert not np.array_equal(one["muscle_cmh2o"], run["muscle_cmh2o"])
    assert not np.array_equal(one["muscle_cmh2o"], seed["muscle_cmh2o"])


def test_in_pieces_it_is_the_same() -> None:
    start = bed.bed(bed.lively())
    _, whole = bed.watch(start, 60.0, tip_mm=30.0)
    middle, first = bed.watch(start, 23.0, tip_mm=30.0)
    _, rest = bed.watch(middle, 37.0, tip_mm=30.0)
    for name in bed.COLUMNS:
        assert np.array_equal(whole[name], np.concatenate((first[name], rest[name]))), name


@pytest.mark.parametrize("name", PRESETS)
def test_deeper_sedation_makes_coughs_and_breaths_rarer_and_coughs_weaker(name: str) -> None:
    values = parameter.nominal(PATIENT_TABLES[name])
    awake, light, deep = (
        behaviour_parameter.assemble({**values, "sedation_ratio": ratio})
        for ratio in (0.0, 0.4, 1.0)
    )
    assert awake.cough.peak_cmh2o == values["cough_cmh2o"]
    assert light.cough.peak_cmh2o == pytest.approx(0.8 * values["cough_cmh2o"])
    for one, other in ((awake.cough, light.cough), (awake.effort, light.effort)):
        assert other[0] == pytest.approx(0.6 * one[0])
    assert light.cough.provoked_per_s == pytest.approx(0.6 * awake.cough.provoked_per_s)
    assert deep.cough.provoked_per_s == deep.cough.spontaneous_per_s == deep.effort.per_s == 0.0


def test_a_leak_is_the_ventilator_s_to_make_up_for() -> None:
    """Gas goes into the tube that does not come out of it: the leak's flow over a breath."""
    person = bed.lively()
    calm = person.behaviour.cough._replace(spontaneous_per_s=0.0)
    still = person.behaviour.effort._replace(per_s=0.0)
    habits = person.behaviour._replace(cough=calm, effort=still)
    tight = habits._replace(leak_ml_per_s_per_cmh2o=0.0)
    leaky = habits._replace(leak_ml_per_s_per_cmh2o=5.0)
    lost = []
    for one in (tight, leaky):
        _, seen = bed.watch(bed.bed(person._replace(behaviour=one)), 30.0)
        lost.append(seen["airway_pressure_cmh2o"].min())
    # Below PEEP by what the flow compensation lacks for 30 mL/s.
    assert 0.1 < lost[0] - lost[1] < 2.0


def test_coughs_and_moves_do_not_change_when_something_else_comes() -> None:
    """Each kind of event has random numbers of its own."""
    person = bed.lively()
    errs = person.behaviour.artefact._replace(per_s=0.5)
    other = person._replace(behaviour=person.behaviour._replace(artefact=errs))
    _, one = bed.watch(bed.bed(person), 120.0, tip_mm=30.0)
    _, two = bed.watch(bed.bed(other), 120.0, tip_mm=30.0)
    assert not np.array_equal(one["shown_percent"], two["shown_percent"])
    assert np.array_equal(one["muscle_cmh2o"], two["muscle_cmh2o"])
    assert np.array_equal(one["gap_ratio"], two["gap_ratio"])
