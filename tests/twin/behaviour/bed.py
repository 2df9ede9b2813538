"""A lively patient at a machine whose tip is held somewhere: only the bedside steps."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import Array
from opensuction.twin import bedside, parameter, preset
from opensuction.twin.bedside import BedsideState
from opensuction.twin.coupling import TICKS, CouplingState
from opensuction.twin.machine.machine import Machine
from opensuction.twin.patient import patient_preset
from opensuction.twin.patient.patient import Patient

VALUES = parameter.nominal(parameter.CLINICAL)
DT_S = 0.001
STEP_S = TICKS * DT_S
PARKED_MM = -120.0
COLUMNS = (
    "muscle_cmh2o",
    "airway_pressure_cmh2o",
    "relaxed_pressure_cmh2o",
    "loss_ml",
    "relaxed_loss_ml",
    "spo2_percent",
    "shown_percent",
    "shown",
    "carina_shift_mm",
    "gap_ratio",
    "connector_cmh2o",
    "lung_volume_ml",
)


class Bed(NamedTuple):
    """A machine at a patient, and how both are."""

    machine: Machine
    state: BedsideState
    coupling: CouplingState


def lively(name: str = "adult-icu", seed: int = 0) -> Patient:
    """A patient exactly nominal for seed 0, drawn otherwise."""
    return patient_preset.lively(patient_preset.patient(name, seed, nominal=seed == 0))


def bed(patient: Patient, seed: int = 1, run: int = 0) -> Bed:
    machine = preset.machine(VALUES, patient)
    start = preset.park(machine, VALUES, PARKED_MM, seed, run)
    return Bed(machine, start.bedside, start.machine.coupling)


@compiled
def _watch(
    machine: Machine,
    state: BedsideState,
    coupling: CouplingState,
    tip_mm: float,
    gas_ml: float,
    rows: Array,
) -> tuple[BedsideState, CouplingState]:
    for i in range(rows.shape[0]):
        state = bedside.step(machine, state, coupling._replace(gas_ml=gas_ml), tip_mm, DT_S)
        coupling = bedside.couple(machine, state, tip_mm)
        signs = coupling.signs
        rows[i, 0] = signs.muscle_cmh2o
        rows[i, 1] = signs.airway_pressure_cmh2o
        rows[i, 2] = signs.relaxed_pressure_cmh2o
        rows[i, 3] = signs.lung_volume_loss_ml
        rows[i, 4] = signs.relaxed_loss_ml
        rows[i, 5] = signs.spo2_percent
        rows[i, 6] = signs.monitor.spo2_percent
        rows[i, 7] = 1.0 if signs.monitor.spo2_valid else 0.0
        rows[i, 8] = coupling.carina_shift_mm
        rows[i, 9] = coupling.gap_ratio
        rows[i, 10] = signs.monitor.airway_pressure_cmh2o
        rows[i, 11] = signs.lung_volume_ml
    return state, coupling


def watch(
    start: Bed, seconds: float, tip_mm: float = PARKED_MM, l_per_min: float = 0.0
) -> tuple[Bed, dict[str, Array]]:
    """The bed later, and columns of what was seen. l_per_min: what the tip takes."""
    rows = np.empty((round(seconds / STEP_S), len(COLUMNS)))
    gas_ml = l_per_min * 1000.0 / 60.0 * STEP_S
    state, coupling = _watch(start.machine, start.state, start.coupling, tip_mm, gas_ml, rows)
    return start._replace(state=state, coupling=coupling), dict(zip(COLUMNS, rows.T, strict=True))


def count_starts(holds: npt.NDArray[np.bool_]) -> int:
    """How often something began to hold."""
    flags = np.concatenate(([0], holds.astype(np.int8)))
    return int(np.count_nonzero(np.diff(flags) == 1))
