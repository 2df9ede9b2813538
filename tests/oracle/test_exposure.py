"""Measures of the truth, on tracks drawn by hand: what a phase or a command says cannot matter."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel.record import Array
from opensuction.oracle import exposure
from opensuction.oracle.exposure import PatientExposure
from opensuction.simulation import rig as rigs

DT_S = 0.001
BENCH = rigs.rig("bench", 1).machine
PATIENT = rigs.rig("clinical", 1, patient="child-10kg").machine
UPPER_END_MM = -PATIENT.patient.tube_length_mm


def track(tip_mm: Array, **others: Array) -> dict[str, Array]:
    """Truth of a run with this tip; what is not named is 0 throughout."""
    named = {f"truth.{name}": values for name, values in {"tip_mm": tip_mm, **others}.items()}
    still = {name: np.zeros(tip_mm.size) for name in exposure.COLUMNS}
    return still | named | {"time_s": DT_S * np.arange(tip_mm.size)}


def measured(tip_mm: Array, **others: Array) -> PatientExposure:
    return exposure.measure(PATIENT, track(tip_mm, **others))


def test_a_catheter_that_stays_is_inside_at_the_end_for_as_long_as_it_was() -> None:
    """4 s outside, 6 s in; nobody drives it, and nobody need say so."""
    tip = np.concatenate((np.full(4000, UPPER_END_MM - 20.0), np.full(6000, 30.0)))
    found = measured(tip)
    assert found.inside_at_end
    assert found.end_mm == 30.0
    assert found.in_airway_s == pytest.approx(6.0, abs=1e-9)
    gone = measured(np.append(tip, UPPER_END_MM - 1.0))
    assert not gone.inside_at_end
    assert gone.in_airway_s == pytest.approx(6.0, abs=1e-9)


def test_the_airway_begins_at_the_upper_end_of_the_tube() -> None:
    assert not measured(np.full(10, UPPER_END_MM)).inside_at_end
    assert measured(np.full(10, math.nextafter(UPPER_END_MM, 0.0))).inside_at_end


def test_two_stretches_are_as_long_as_both() -> None:
    vacuum = np.tile(np.repeat([0.0, 60.0], 1000), 3)
    found = measured(np.full(vacuum.size, 10.0), tip_vacuum_mmhg=vacuum)
    assert found.suction_s == pytest.approx(3.0, abs=1e-9)
    assert found.vacuum_peak_mmhg == 60.0
    assert measured(np.full(6000, UPPER_END_MM), tip_vacuum_mmhg=vacuum).suction_s == 0.0


def test_advance_counts_under_vacuum_alone_and_from_the_least_depth() -> None:
    tip = np.concatenate((np.linspace(0.0, 50.0, 1000), np.linspace(50.0, 40.0, 1000)))
    tip = np.concatenate((tip, np.linspace(40.0, 40.4, 1000), np.linspace(40.4, 0.0, 1000)))
    vacuum = np.repeat([0.0, 80.0, 80.0, 80.0], 1000)
    assert measured(tip, tip_vacuum_mmhg=vacuum).advance_mm == pytest.approx(0.4, abs=1e-9)
    assert measured(tip, tip_vacuum_mmhg=80.0 - vacuum).advance_mm == pytest.approx(50.0)


def test_force_contact_and_what_lies_beyond_the_carina() -> None:
    carina = PATIENT.airway.carina_mm
    tip = np.full(2000, carina + 3.0)
    force = np.repeat([0.0, 0.2], 1000)
    found = measured(tip, contact_n=force)
    assert found.past_carina_mm == pytest.approx(3.0)
    assert found.force_peak_n == 0.2
    assert found.contact_s == pytest.approx(1.0, abs=1e-9)
    assert measured(np.full(10, carina - 1.0)).past_carina_mm == 0.0


def test_the_carina_is_where_it_was_at_that_instant() -> None:
    """A cough brings it to a tip that stays; a turned head takes it away from another."""
    carina = PATIENT.airway.carina_mm
    shift = np.array([0.0, 0.0, -4.0, 3.0])
    tip = np.array([carina - 2.0, carina - 1.0, carina - 2.5, carina + 3.0])
    # A tip answers a tick after the carina has moved.
    late, long = np.append(tip[0], np.repeat(tip, 10)[:-1]), np.repeat(shift, 10)
    assert measured(late, carina_shift_mm=long).past_carina_mm == pytest.approx(1.5)
    assert measured(tip).past_carina_mm == pytest.approx(3.0)


def test_a_tip_that_a_cough_pushes_back_and_lets_go_has_not_advanced() -> None:
    """But one that goes in under vacuum afterwards has, and so has one on a carina that rests."""
    tip = np.array([10.0, 10.0, 7.0, 6.0, 8.0, 10.0, 10.0])
    force = np.array([0.0, 0.0, 0.1, 0.1, 0.1, 0.0, 0.0])
    shift = np.array([0.0, 0.0, -4.0, -5.0, -3.0, 0.0, 0.0])
    vacuum = np.full(7, 80.0)
    coughed = {"contact_n": force, "tip_vacuum_mmhg": vacuum, "carina_shift_mm": shift}
    assert measured(tip, **coughed).advance_mm == 0.0
    assert measured(tip, **{**coughed, "carina_shift_mm": np.zeros(7)}).advance_mm == 4.0
    deeper = np.append(tip, 13.0)
    more = {name: np.append(values, values[-1]) for name, values in coughed.items()}
    assert measured(deeper, **more).advance_mm == 3.0


def test_pressure_and_volume_are_judged_without_what_the_muscles_do() -> None:
    """A cough of 90 cmH2O is not the machine's; suction that it hides is."""
    low, high = np.full(4000, -9.0), np.full(4000, 90.0)
    fine = np.full(4000, PATIENT.patient.ventilator.peep_cmh2o)
    still = np.zeros(4000)
    coughs = measured(still, airway_pressure_cmh2o=high, relaxed_pressure_cmh2o=fine)
    assert coughs.pressure_unsafe_s == 0.0
    hidden = measured(still, airway_pressure_cmh2o=fine, relaxed_pressure_cmh2o=low)
    assert hidden.pressure_unsafe_s == pytest.approx(4.0)
    assert hidden.airway_pressure_least_cmh2o == -9.0
    blown = measured(still, lung_volume_loss_ml=np.full(4000, 900.0))
    assert blown.lung_volume_loss_ml == 0.0


def test_the_patient_is_measured_at_the_worst_instant_and_the_bench_has_none() -> None:
    pressure, loss, spo2 = np.full(10, 5.0), np.zeros(10), np.full(10, 97.0)
    pressure[3], loss[4], spo2[9] = -6.0, 80.0, 43.0
    columns = track(
        np.zeros(10), relaxed_pressure_cmh2o=pressure, relaxed_loss_ml=loss, spo2_percent=spo2
    )
    found = exposure.measure(PATIENT, columns)
    assert found[-3:] == (-6.0, 80.0, 43.0)
    assert all(math.isnan(value) for value in exposure.measure(BENCH, columns)[-3:])


def test_on_the_bench_outside_is_where_the_tip_lay_at_first() -> None:
    there_and_back = np.concatenate(([4.0], np.linspace(4.0, 90.0, 100), [5.0]))
    assert not exposure.measure(BENCH, track(there_and_back)).inside_at_end
    assert exposure.measure(BENCH, track(np.append(there_and_back, 5.1))).inside_at_end


def test_a_truth_that_is_no_number_is_refused() -> None:
    tip = np.zeros(10)
    tip[7] = np.nan
    with pytest.raises(ValueError, match=r"truth\.tip_mm is no number at tick 7"):
        measured(tip)


@given(
    st.lists(st.floats(-150.0, 120.0), min_size=2, max_size=40),
    st.lists(st.floats(0.0, 200.0), min_size=40, max_size=40),
    st.integers(1, 39),
)
def test_what_was_borne_never_becomes_less_by_watching_for_longer(
    tips: list[float], vacuums: list[float], cut: int
) -> None:
    tip, vacuum = np.array(tips), np.array(vacuums)[: len(tips)]
    whole = measured(tip, tip_vacuum_mmhg=vacuum)
    part = measured(tip[: max(cut % tip.size, 1)], tip_vacuum_mmhg=vacuum[: max(cut % tip.size, 1)])
    for name in ("in_airway_s", "suction_s", "vacuum_peak_mmhg", "advance_mm", "past_carina_mm"):
        assert getattr(whole, name) >= getattr(part, name) - 1e-9
    assert whole.suction_s <= whole.in_airway_s + 1e-9
    assert whole.in_airway_s <= tip.size * DT_S + 1e-9
