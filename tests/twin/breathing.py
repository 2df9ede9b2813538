"""Patients breathe while something is sucked out: a row of observations for each step."""

import numpy as np
from numpy.typing import NDArray

from opensuction.kernel.compiled import compiled
from opensuction.twin.patient import patient as patient_model
from opensuction.twin.patient import patient_preset
from opensuction.twin.patient.patient import L_PER_MIN_PER_ML_PER_S, Patient, PatientState
from opensuction.twin.patient.patient_parameter import PRESETS

Array = NDArray[np.float64]
DT_S = patient_preset.DT_S
PATIENTS = {name: patient_preset.patient(name, 0, nominal=True) for name in PRESETS}
RESTING = {name: patient_preset.at_rest(one) for name, one in PATIENTS.items()}
ICU = PATIENTS["adult-icu"]
COLUMNS = (
    "airway_pressure_cmh2o",
    "ventilator_pressure_cmh2o",
    "lung_volume_ml",
    "lung_volume_loss_ml",
    "spo2_percent",
    "sao2_percent",
    "alveolar_o2_mmhg",
    "heart_rate_per_min",
    "ventilator_flow_l_per_min",
    "tidal_volume_ml",
)


@compiled
def _record(
    patient: Patient, state: PatientState, suction: Array, ratio: Array, rows: Array
) -> PatientState:
    for i in range(suction.size):
        state = patient_model.step(patient, state, suction[i], ratio[i], 0.0, DT_S)
        seen = patient_model.signs(patient, state)
        rows[i, 0] = seen.airway_pressure_cmh2o
        rows[i, 1] = state.vitals.airflow.connector_cmh2o
        rows[i, 2] = seen.lung_volume_ml
        rows[i, 3] = seen.lung_volume_loss_ml
        rows[i, 4] = seen.spo2_percent
        rows[i, 5] = 100.0 * state.vitals.gas.arterial_saturation
        rows[i, 6] = state.vitals.gas.alveolar_mmhg
        rows[i, 7] = seen.heart_rate_per_min
        rows[i, 8] = L_PER_MIN_PER_ML_PER_S * state.vitals.airflow.tube_ml_per_s
        rows[i, 9] = state.vitals.breath.tidal_ml
    return state


def record(
    patient: Patient, state: PatientState, suction_ml_per_s: Array, ratio: Array
) -> tuple[dict[str, Array], PatientState]:
    """Columns of a run by name, and the state after it. Arrays of shape (steps,)."""
    rows = np.empty((suction_ml_per_s.size, len(COLUMNS)))
    after = _record(patient, state, suction_ml_per_s, ratio, rows)
    return dict(zip(COLUMNS, rows.T, strict=True)), after


def closed_suction(
    patient: Patient, l_per_min: float, duration_s: float, catheter_mm: float, total_s: float
) -> tuple[dict[str, Array], PatientState]:
    """A patient at rest; from 10 s on the catheter lies in the tube and takes gas.

    It lies there for 3 s more than it sucks.
    """
    time_s = np.arange(round(total_s / DT_S)) * DT_S
    sucking = (time_s >= START_S) & (time_s < START_S + duration_s)
    inside = (time_s >= START_S) & (time_s < START_S + duration_s + 3.0)
    return record(
        patient,
        patient_preset.at_rest(patient),
        np.where(sucking, l_per_min * 1000.0 / 60.0, 0.0),
        np.where(inside, catheter_mm / patient.tube_id_mm, 0.0),
    )


START_S = 10.0
"""When `closed_suction` begins."""
