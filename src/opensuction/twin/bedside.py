"""The bedside at 100 Hz: the patient, and the secretions in the trachea.

It is stepped once every ten ticks of the machine: its arrays and its hundred numbers stay out of
the 1 kHz tick, where carrying them costs a quarter of the time.
"""

from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.twin.airway import secretion
from opensuction.twin.airway.secretion import Bins
from opensuction.twin.coupling import NO_SIGNS, TICKS, CouplingState
from opensuction.twin.machine.machine import Machine
from opensuction.twin.patient import heart
from opensuction.twin.patient import patient as patient_model
from opensuction.twin.patient.patient import Patient, PatientState


class BedsideState(NamedTuple):
    """State of the patient and of the trachea, the bench's too."""

    patient: PatientState
    """Not stepped on the bench, which has no patient."""
    secretion_ml: Bins
    """Secretions in each bin; never written, only replaced."""
    produced_ml_per_s: Bins
    """New secretions in each bin, none on the bench; never changes. It lies here because an array
    among the machine's parameters costs every tick 5 %."""


@compiled
def couple(machine: Machine, state: BedsideState, tip_mm: float) -> CouplingState:
    """The coupling right after a step of the bedside. tip_mm: where the tip is now."""
    signs = NO_SIGNS
    if machine.has_patient:
        signs = patient_model.signs(machine.patient, state.patient)
    return CouplingState(
        ticks=0,
        gas_ml=0.0,
        mucus_ml=0.0,
        reachable_ml=secretion.within_reach_ml(state.secretion_ml, tip_mm, machine.airway.reach_mm),
        from_mm=tip_mm,
        signs=signs,
    )


@compiled
def _breathe(
    machine: Machine, state: PatientState, gas_ml: float, tip_mm: float, span_s: float
) -> PatientState:
    """The patient after a step in which the catheter took gas and filled a part of the tube.

    Past the tube's lower end, at 0, it touches the trachea.
    """
    patient: Patient = machine.patient
    inside = patient_model.is_inside(patient, tip_mm)
    ratio = machine.catheter_mm / patient.tube_id_mm if inside else 0.0
    stimulus = heart.stimulus(tip_mm > 0.0, gas_ml > 0.0, tip_mm >= patient.carina_mm)
    return patient_model.step(patient, state, gas_ml / span_s, ratio, stimulus, span_s)


@compiled
def step(
    machine: Machine, state: BedsideState, coupling: CouplingState, tip_mm: float, dt_s: float
) -> BedsideState:
    """Advance by one step of the bedside, `TICKS` ticks of ``dt_s``.

    coupling: what has passed since the last. tip_mm: where the tip is now.
    """
    patient = state.patient
    if machine.has_patient:
        patient = _breathe(machine, patient, coupling.gas_ml, tip_mm, TICKS * dt_s)
    rest = secretion.step(
        state.secretion_ml,
        state.produced_ml_per_s,
        coupling.from_mm,
        machine.airway.reach_mm,
        coupling.mucus_ml,
        TICKS * dt_s,
    )
    return state._replace(patient=patient, secretion_ml=rest)
