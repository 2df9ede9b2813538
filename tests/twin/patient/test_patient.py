import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.twin.patient import patient as patient_model
from opensuction.twin.patient import patient_preset
from opensuction.twin.patient.patient import Patient, PatientState
from opensuction.twin.patient.patient_parameter import PRESETS
from tests.settled import settled
from tests.twin.breathing import DT_S, ICU, PATIENTS, RESTING, START_S, closed_suction, record

ARDS = PATIENTS["adult-ards"]
step = settled(patient_model.step)


def at(time_s: float) -> int:
    return round(time_s / DT_S)


def quiet(patient: Patient, state: PatientState, seconds: float) -> PatientState:
    return patient_preset.breathe(patient, state, at(seconds), DT_S)


@pytest.mark.parametrize("name", PRESETS)
def test_no_gas_is_made_or_lost(name: str) -> None:
    """The lung holds what it held, plus what the tube brought, less what the catheter took."""
    patient, state = PATIENTS[name], RESTING[name]
    source = np.random.default_rng(1)
    volume = state.vitals.lung.volume_ml
    for _ in range(3000):
        suction = source.uniform(0.0, 400.0) if source.random() < 0.5 else 0.0
        state = step(patient, state, suction, source.uniform(0.0, 0.8), 0.0, DT_S)
        flow = state.vitals.airflow
        assert flow.suction_ml_per_s <= suction
        volume += (flow.tube_ml_per_s - flow.suction_ml_per_s) * DT_S
        assert state.vitals.lung.volume_ml == pytest.approx(volume, abs=1e-6)


@given(
    name=st.sampled_from(PRESETS),
    seed=st.integers(0, 2**32 - 1),
    suction=st.floats(0.0, 1000.0),
    ratio=st.floats(0.0, 1.0),
    compensation=st.floats(0.0, 1000.0),
    peep=st.floats(0.0, 25.0),
    dt_s=st.floats(0.002, 0.05),
)
def test_nothing_a_device_can_do_makes_nonsense(
    name: str,
    seed: int,
    suction: float,
    ratio: float,
    compensation: float,
    peep: float,
    dt_s: float,
) -> None:
    patient = patient_preset.patient(name, seed)
    ventilator = patient.ventilator._replace(compensation_ml_per_s=compensation, peep_cmh2o=peep)
    patient = patient._replace(ventilator=ventilator)
    state = RESTING[name]
    for _ in range(150):
        state = step(patient, state, suction, ratio, 0.0, dt_s)
    seen = patient_model.signs(patient, state)
    assert np.all(np.isfinite([*seen[:5], *seen.monitor]))
    assert state.vitals.lung.volume_ml > 0.0
    assert 0.0 <= state.vitals.gas.arterial_saturation <= 1.0
    assert 0.0 <= seen.spo2_percent <= 100.0
    assert 0.0 <= state.vitals.gas.alveolar_mmhg <= 713.0


@pytest.mark.parametrize("name", PRESETS)
def test_a_shorter_step_changes_little(name: str) -> None:
    """Ten times as many steps: tidal volume and pressure are those of the differential equation."""
    patient = PATIENTS[name]
    coarse = fine = RESTING[name]
    for _ in range(at(2.0 * patient.ventilator.period_s)):
        coarse = step(patient, coarse, 20.0, 0.4, 0.0, DT_S)
        for _ in range(10):
            fine = step(patient, fine, 20.0, 0.4, 0.0, 0.1 * DT_S)
    tidal_ml = coarse.vitals.breath.tidal_ml
    assert tidal_ml == pytest.approx(fine.vitals.breath.tidal_ml, rel=0.01)
    assert coarse.vitals.lung.volume_ml == pytest.approx(
        fine.vitals.lung.volume_ml, abs=0.02 * tidal_ml
    )
    assert coarse.vitals.gas.alveolar_mmhg == pytest.approx(
        fine.vitals.gas.alveolar_mmhg, rel=0.002
    )


@pytest.mark.parametrize(
    ("name", "l_per_min", "low_ml", "high_ml"),
    [
        ("adult-icu", 10.0, 100.0, 350.0),
        ("adult-icu", 15.0, 100.0, 350.0),
        ("adult-ards", 13.0, 303.0, 759.0),  # 531 +- 228 in closed suction, PMID 12615633
        ("adult-ards", 15.0, 425.0, 640.0),  # within a fifth where it was calibrated
    ],
)
def test_closed_suction_of_an_adult_loses_the_published_volume(
    name: str, l_per_min: float, low_ml: float, high_ml: float
) -> None:
    patient = PATIENTS[name]
    seen, after = closed_suction(patient, l_per_min, 15.0, 4.0, 600.0)
    loss = seen["lung_volume_loss_ml"]
    assert low_ml < loss.max() < high_ml
    during = seen["airway_pressure_cmh2o"][at(START_S) : at(START_S + 15.0)]
    fall = patient.ventilator.peep_cmh2o - during.min()
    assert 1.0 < fall < 5.0
    # Not yet back after a minute, back after ten.
    assert loss[at(START_S + 15.0 + 60.0)] > 0.2 * loss.max()
    assert loss[-1] < 0.05 * loss.max()
    assert after.vitals.lung.closed_ml < 0.05 * loss.max()


@pytest.mark.parametrize(
    ("name", "l_per_min", "duration_s", "catheter_mm"),
    [
        ("adult-icu", 15.0, 15.0, 4.0),
        ("adult-ards", 15.0, 15.0, 4.0),
        ("child-10kg", 4.0, 5.0, 2.0),
        ("neonate", 4.0, 5.0, 2.0),
    ],
)
def test_the_oximeter_shows_the_lowest_saturation_only_after_suction(
    name: str, l_per_min: float, duration_s: float, catheter_mm: float
) -> None:
    """So an abort rule must not rely on it."""
    seen, _ = closed_suction(PATIENTS[name], l_per_min, duration_s, catheter_mm, 300.0)
    shown = seen["spo2_percent"]
    fall = shown[: at(START_S)].mean() - shown.min()
    assert 0.0 < fall < 5.0
    assert float(np.argmin(shown)) * DT_S > START_S + duration_s + 5.0
    blood = seen["sao2_percent"]
    assert np.argmin(blood) < np.argmin(shown)


@pytest.mark.parametrize("name", ["child-10kg", "neonate"])
def test_small_patients_lose_in_proportion(name: str) -> None:
    """5 s at 2.5 L/min with a 6 Fr catheter: like adults, 4 to 15 % of end-expiratory volume."""
    patient = PATIENTS[name]
    seen, _ = closed_suction(patient, 2.5, 5.0, 2.0, 60.0)
    held = RESTING[name].vitals.breath.end_expiratory_ml
    assert 0.04 < seen["lung_volume_loss_ml"].max() / held < 0.15
    assert seen["airway_pressure_cmh2o"].min() > -10.0


def test_disconnection_loses_what_was_measured_in_lung_injury() -> None:
    """1466 +- 586 mL, not recovered after a minute: PMID 12615633."""
    start = RESTING["adult-ards"]
    off = ARDS.ventilator._replace(peep_cmh2o=0.0, driving_cmh2o=0.0, droop_cmh2o_s_per_ml=0.0)
    end = quiet(ARDS._replace(ventilator=off), start, 15.0)
    lost = start.vitals.breath.end_expiratory_ml - end.vitals.lung.volume_ml
    assert lost == pytest.approx(1466.0, abs=586.0)
    later = patient_model.signs(ARDS, quiet(ARDS, end, 60.0))
    assert later.lung_volume_loss_ml > 0.3 * lost


def test_more_gas_than_the_ventilator_gives_pulls_the_airway_below_the_atmosphere() -> None:
    weak = ICU._replace(ventilator=ICU.ventilator._replace(compensation_ml_per_s=100.0))
    seen, state = closed_suction(weak, 18.0, 15.0, 4.0, 20.0)
    assert seen["airway_pressure_cmh2o"].min() < -1.0
    assert seen["lung_volume_ml"].min() > -weak.lung.residual_ml
    assert np.all(np.isfinite(state.vitals.airflow))


def test_a_catheter_in_the_tube_takes_tidal_volume_even_without_suction() -> None:
    steps = at(20.0)
    none, inside = np.zeros(steps), np.full(steps, 0.8)
    seen, _ = record(ICU, RESTING["adult-icu"], none, inside)
    tidal = seen["tidal_volume_ml"]
    assert tidal[-1] < 0.95 * tidal[0]
    assert seen["ventilator_pressure_cmh2o"].max() > seen["airway_pressure_cmh2o"].max()


def test_without_fresh_gas_the_patient_desaturates() -> None:
    still = ICU.ventilator._replace(driving_cmh2o=0.0)
    end = quiet(ICU._replace(ventilator=still), RESTING["adult-icu"], 180.0)
    assert end.vitals.gas.arterial_saturation < 0.85
    assert end.oximeter.shown_percent > 100.0 * end.vitals.gas.arterial_saturation


def test_pre_oxygenation_fills_the_store() -> None:
    rich = ICU._replace(ventilator=ICU.ventilator._replace(oxygen_ratio=1.0))
    end = quiet(rich, RESTING["adult-icu"], 60.0)
    assert end.vitals.gas.alveolar_mmhg > 550.0
    assert end.vitals.gas.arterial_saturation > 0.99
