"""Faults of a patient: closed forms, and nothing else changes."""

import numpy as np
import pytest

from opensuction.kernel.interface import NO_MONITOR
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_row import PatientEffect
from opensuction.twin.fault.fault_table import ROWS
from opensuction.twin.patient import patient as patient_model
from opensuction.twin.patient import patient_preset, ventilator
from opensuction.twin.patient.patient import Patient
from opensuction.twin.patient.patient_parameter import PRESETS
from tests.twin.breathing import DT_S, ICU, PATIENTS, RESTING, record

EFFECTS = {
    fault: row.effect for fault, row in ROWS.items() if isinstance(row.effect, PatientEffect)
}


def broken(fault: Fault, strength: float = 0.0, patient: Patient = ICU) -> Patient:
    return EFFECTS[fault].change(patient, strength)


def steps(seconds: float) -> int:
    return round(seconds / DT_S)


@pytest.mark.parametrize("fault", EFFECTS, ids=lambda fault: fault.title)
def test_a_fault_changes_one_number_of_one_record(fault: Fault) -> None:
    changed = broken(fault, ROWS[fault].default_strength)
    differing = [
        (getattr(ICU, name), getattr(changed, name))
        for name in Patient._fields
        if getattr(ICU, name) != getattr(changed, name)
    ]
    assert len(differing) == 1
    before, after = differing[0]
    assert sum(a != b for a, b in zip(before, after, strict=True)) == 1


@pytest.mark.parametrize("name", PRESETS)
@pytest.mark.parametrize("l_per_min", [0.0, 15.0])
def test_disconnected_the_connector_is_at_the_rooms_pressure(name: str, l_per_min: float) -> None:
    """At once and whatever is sucked; gas is conserved, and no lung is emptied below the room's."""
    patient = broken(Fault.CIRCUIT_DISCONNECTED, patient=PATIENTS[name])
    state, suction = RESTING[name], l_per_min * 1000.0 / 60.0
    volume = state.vitals.lung.volume_ml
    for _ in range(steps(20.0)):
        state = patient_model.step(patient, state, suction, 0.4, 0.0, DT_S)
        flow = state.vitals.airflow
        assert flow.connector_cmh2o == pytest.approx(0.0, abs=1e-9)
        volume += (flow.tube_ml_per_s - flow.suction_ml_per_s) * DT_S
        assert state.vitals.lung.volume_ml == pytest.approx(volume, abs=1e-6)
    # Half a minute later the lung is in balance with the pressure in the trachea.
    held = state.vitals.lung.volume_ml - patient.lung.relaxed_ml + state.vitals.lung.closed_ml
    trachea = state.vitals.airflow.trachea_cmh2o
    assert held / patient.lung.compliance_ml_per_cmh2o == pytest.approx(trachea, abs=0.05)
    assert ventilator.inspired_ratio(patient.ventilator) == 0.21


def test_reconnected_the_lung_fills_again() -> None:
    empty = patient_preset.breathe(
        broken(Fault.CIRCUIT_DISCONNECTED), RESTING["adult-icu"], 2000, DT_S
    )
    lost = RESTING["adult-icu"].vitals.lung.volume_ml - empty.vitals.lung.volume_ml
    filled = patient_preset.breathe(ICU, empty, 2000, DT_S)
    assert lost > 250.0
    assert RESTING["adult-icu"].vitals.lung.volume_ml - filled.vitals.lung.volume_ml < 0.5 * lost


@pytest.mark.parametrize("ratio", [0.3, 0.7, 1.5, 3.0])
def test_pressures_out_of_range_are_multiples_of_those_set(ratio: float) -> None:
    """Without flow, at the end of each phase of the breath."""
    patient = broken(Fault.VENTILATOR_PRESSURE, ratio)
    none = np.zeros(steps(20.0))
    columns, _ = record(patient, RESTING["adult-icu"], none, none)
    settled = columns["ventilator_pressure_cmh2o"][steps(8.0) :]
    set_ = ICU.ventilator
    assert settled.max() == pytest.approx(
        ratio * (set_.peep_cmh2o + set_.driving_cmh2o), rel=0.03, abs=0.1
    )
    assert settled.min() == pytest.approx(ratio * set_.peep_cmh2o, rel=0.05, abs=0.3)


def test_without_compensation_suction_empties_an_adults_lung_at_its_own_flow() -> None:
    """In expiration, when nothing comes through the tube, the lung loses just what is sucked."""
    patient = broken(Fault.LUNG_VOLUME_LOST, 0.0)
    state, suction = RESTING["adult-icu"], 250.0
    still = 0
    for _ in range(steps(8.0)):
        before = state.vitals.lung.volume_ml
        state = patient_model.step(patient, state, suction, 0.4, 0.0, DT_S)
        inspired = ventilator.is_inspiring(patient.ventilator, state.vitals.ventilator)
        if not inspired and state.vitals.airflow.tube_ml_per_s == 0.0:
            still += 1
            assert before - state.vitals.lung.volume_ml == pytest.approx(
                state.vitals.airflow.suction_ml_per_s * DT_S, abs=1e-9
            )
    assert still > steps(1.0)
    healthy = patient_preset.at_rest(ICU)
    for _ in range(steps(8.0)):
        healthy = patient_model.step(ICU, healthy, suction, 0.4, 0.0, DT_S)
    assert state.vitals.breath.loss_ml > 1.5 * healthy.vitals.breath.loss_ml


def test_a_raised_shunt_lowers_the_shown_saturation_late() -> None:
    none = np.zeros(steps(90.0))
    columns, _ = record(broken(Fault.DESATURATION, 0.6), RESTING["adult-icu"], none, none)
    blood, shown = columns["sao2_percent"], columns["spo2_percent"]
    assert blood[-1] < 75.0
    late = (np.argmax(shown < 85.0) - np.argmax(blood < 85.0)) * DT_S
    assert 18.0 < late < 30.0  # 20 s to the finger and the mean of 8 s


def test_vagal_patients_lose_that_share_under_the_strongest_stimulus() -> None:
    state, patient = RESTING["adult-icu"], broken(Fault.BRADYCARDIA, 0.6)
    for _ in range(steps(30.0)):
        state = patient_model.step(patient, state, 0.0, 0.4, 1.0, DT_S)
    assert state.vitals.heart.rate_per_min == pytest.approx(0.4 * ICU.heart.rest_per_min, rel=1e-3)
    assert patient_model.signs(patient, state).monitor.heart_rate_per_min == pytest.approx(
        state.vitals.heart.rate_per_min, rel=1e-3
    )


def test_what_arrives_of_a_monitor_is_what_it_shows_or_nothing() -> None:
    state = RESTING["adult-icu"]
    healthy = patient_model.signs(ICU, state).monitor
    assert (healthy.spo2_valid, healthy.heart_rate_valid, healthy.airway_pressure_valid) == (
        True,
        True,
        True,
    )
    assert healthy.spo2_percent == state.oximeter.shown_percent
    assert healthy.airway_pressure_cmh2o == state.vitals.airflow.connector_cmh2o
    assert healthy.heart_rate_per_min == ICU.heart.rest_per_min
    off = ICU._replace(monitor=ICU.monitor._replace(probe_on=False))
    assert patient_model.signs(off, state).monitor == healthy._replace(
        spo2_percent=0.0, spo2_valid=False
    )
    assert patient_model.signs(broken(Fault.MONITOR_LOST), state).monitor == NO_MONITOR
    without = ICU._replace(monitor=ICU.monitor._replace(present=False))
    assert patient_model.signs(without, state).monitor == NO_MONITOR
