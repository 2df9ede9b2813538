"""The bedside at 100 Hz: the patient, and the secretions in the trachea.

It steps with every tenth tick of the machine, and only here: its arrays and its hundred numbers
stay out of the machine's tick (carried through each, they cost a quarter of it).
"""

from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.twin.airway import secretion
from opensuction.twin.airway.secretion import Bins
from opensuction.twin.coupling import NOBODY_SHOWN, TICKS, CouplingState, Shown
from opensuction.twin.machine.machine import Machine
from opensuction.twin.patient import heart
from opensuction.twin.patient import patient as patients
from opensuction.twin.patient.patient import Patient, PatientState


class BedsideState(NamedTuple):
    """State of the patient and of the trachea, the bench's too."""

    patient: PatientState
    """Never stepped where nobody is there."""
    secretion_ml: Bins
    """Secretions in each bin; never written, only replaced."""
    produced_ml_per_s: Bins
    """New secretions in each bin, none on the bench; never changes. It lies here because an array
    among the machine's parameters costs every tick 5 %."""


@compiled
def shown(machine: Machine, state: BedsideState) -> Shown:
    """What the patient shows."""
    if not machine.has_patient:
        return NOBODY_SHOWN
    seen = patients.observe(machine.patient, state.patient)
    return Shown(
        airway_pressure_cmh2o=seen.airway_pressure_cmh2o,
        lung_volume_ml=seen.lung_volume_ml,
        lung_volume_loss_ml=seen.lung_volume_loss_ml,
        spo2_percent=seen.spo2_percent,
        heart_rate_per_min=seen.heart_rate_per_min,
        monitor=patients.monitored(machine.patient, state.patient),
    )


@compiled
def met(machine: Machine, state: BedsideState, tip_mm: float) -> CouplingState:
    """The coupling right after a step of the bedside, the tip being where it is."""
    return CouplingState(
        ticks=0,
        gas_ml=0.0,
        mucus_ml=0.0,
        reachable_ml=secretion.within_reach_ml(state.secretion_ml, tip_mm, machine.airway.reach_mm),
        from_mm=tip_mm,
        shown=shown(machine, state),
    )


@compiled
def _breathing(
    machine: Machine, state: PatientState, gas_ml: float, tip_mm: float, span_s: float
) -> PatientState:
    """The patient after a step in which the catheter took gas and filled a part of the tube.

    Past the tube's lower end, at 0, it touches the trachea.
    """
    patient: Patient = machine.patient
    inside = patients.is_inside(patient, tip_mm)
    ratio = machine.catheter_mm / patient.tube_id_mm if inside else 0.0
    stimulus = heart.stimulus(tip_mm > 0.0, gas_ml > 0.0, tip_mm >= patient.carina_mm)
    return patients.step(patient, state, gas_ml / span_s, ratio, stimulus, span_s)


@compiled
def step(
    machine: Machine, state: BedsideState, coupling: CouplingState, tip_mm: float, dt_s: float
) -> BedsideState:
    """Advance by one step of the bedside, `TICKS` ticks of ``dt_s``.

    coupling: what has passed since the last. tip_mm: where the tip is now.
    """
    patient = state.patient
    if machine.has_patient:
        patient = _breathing(machine, patient, coupling.gas_ml, tip_mm, TICKS * dt_s)
    rest = secretion.step(
        state.secretion_ml,
        state.produced_ml_per_s,
        coupling.from_mm,
        machine.airway.reach_mm,
        coupling.mucus_ml,
        TICKS * dt_s,
    )
    return BedsideState(
        patient=patient, secretion_ml=rest, produced_ml_per_s=state.produced_ml_per_s
    )
