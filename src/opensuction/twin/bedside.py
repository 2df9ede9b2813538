"""The bedside at 100 Hz: the patient, and the secretions in the trachea.

It is stepped once every ten ticks of the machine: its arrays and its hundred numbers stay out of
the 1 kHz tick, where carrying them costs a quarter of the time.
"""

from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.twin.airway import airway
from opensuction.twin.airway.airway import Bins
from opensuction.twin.behaviour import behaviour
from opensuction.twin.behaviour.behaviour import Around, BehaviourState, Store
from opensuction.twin.coupling import NO_SIGNS, TICKS, CouplingState
from opensuction.twin.machine.machine import Machine
from opensuction.twin.patient import patient as patient_model
from opensuction.twin.patient import patient_monitor
from opensuction.twin.patient.patient import AT_EASE, PatientState, Strain


class BedsideState(NamedTuple):
    """State of the patient and of the trachea, the bench's too."""

    patient: PatientState
    """Not stepped on the bench, which has no patient."""
    behaviour: BehaviourState
    """Of a lively patient; not stepped otherwise."""
    secretion_ml: Bins
    """Secretions in each bin that suction can reach; never written, only replaced."""
    store: Store
    """Those that it cannot reach; empty but for a lively patient."""
    produced_ml_per_s: Bins
    """New secretions in each bin, none on the bench; never changes. It lies here because an array
    among the machine's parameters costs every tick 5 %."""


def sum_secretion_ml(state: BedsideState) -> float:
    """All secretions in the airway: loose, adherent and deep."""
    return float(state.secretion_ml.sum()) + (state.store.adherent_ml + state.store.deep_ml)


@compiled
def _is_lively(machine: Machine) -> bool:
    return machine.has_patient and machine.patient.behaviour.is_lively


@compiled
def couple(machine: Machine, state: BedsideState, tip_mm: float) -> CouplingState:
    """The coupling right after a step of the bedside. tip_mm: where the tip is now."""
    signs, shift_mm, gap_ratio = NO_SIGNS, 0.0, 1.0
    if machine.has_patient:
        signs = patient_model.signs(machine.patient, state.patient)
    if _is_lively(machine):
        shift_mm = behaviour.carina_shift_mm(machine.patient.behaviour, state.behaviour)
        gap_ratio = state.behaviour.posture.gap_ratio
        signs = signs._replace(monitor=behaviour.distort(state.behaviour.artefact, signs.monitor))
    return CouplingState(
        ticks=0,
        gas_ml=0.0,
        mucus_ml=0.0,
        reachable_ml=airway.within_reach_ml(state.secretion_ml, tip_mm, machine.airway.reach_mm),
        from_mm=tip_mm,
        carina_shift_mm=shift_mm,
        gap_ratio=gap_ratio,
        signs=signs,
    )


@compiled
def _stimulus(machine: Machine, coupling: CouplingState, tip_mm: float) -> float:
    """Stimulus of the airway by the catheter, 0 to 1.

    Past the tube's lower end, at 0, it touches the trachea.
    """
    carina_mm = machine.patient.carina_mm + coupling.carina_shift_mm
    return patient_monitor.stimulus(tip_mm > 0.0, coupling.gas_ml > 0.0, tip_mm >= carina_mm)


@compiled
def _act(
    machine: Machine, state: BedsideState, stimulus: float, tip_mm: float, span_s: float
) -> tuple[BehaviourState, Strain]:
    """Advance a lively patient's behaviour by a step, with the strain that it puts on the lung."""
    habits = machine.patient.behaviour
    around = Around(
        stimulus=stimulus,
        is_inside=patient_model.is_inside(machine.patient, tip_mm),
        spo2_percent=state.patient.oximeter.shown_percent,
    )
    acting = behaviour.step(habits, state.behaviour, around, span_s)
    strain = Strain(
        muscle_cmh2o=behaviour.muscle_cmh2o(habits, acting),
        resistance_ratio=behaviour.resistance_ratio(
            habits.clearance, state.secretion_ml, state.store
        ),
    )
    return acting, strain


@compiled
def _breathe(
    machine: Machine,
    state: BedsideState,
    coupling: CouplingState,
    tip_mm: float,
    span_s: float,
) -> tuple[PatientState, BehaviourState]:
    """The patient after a step in which the catheter took gas and filled a part of the tube."""
    inside = patient_model.is_inside(machine.patient, tip_mm)
    ratio = machine.catheter_mm / machine.patient.tube_id_mm if inside else 0.0
    stimulus = _stimulus(machine, coupling, tip_mm)
    acting, strain = state.behaviour, AT_EASE
    if _is_lively(machine):
        acting, strain = _act(machine, state, stimulus, tip_mm, span_s)
    patient = patient_model.step_under(
        machine.patient, state.patient, coupling.gas_ml / span_s, ratio, stimulus, strain, span_s
    )
    return patient, acting


@compiled
def step(
    machine: Machine, state: BedsideState, coupling: CouplingState, tip_mm: float, dt_s: float
) -> BedsideState:
    """Advance by one step of the bedside, `TICKS` ticks of ``dt_s``.

    coupling: what has passed since the last. tip_mm: where the tip is now.
    """
    patient, acting = state.patient, state.behaviour
    if machine.has_patient:
        patient, acting = _breathe(machine, state, coupling, tip_mm, TICKS * dt_s)
    rest = airway.step_secretion(
        state.secretion_ml,
        state.produced_ml_per_s,
        coupling.from_mm,
        machine.airway.reach_mm,
        coupling.mucus_ml,
        TICKS * dt_s,
    )
    store = state.store
    if _is_lively(machine):
        rest, store = behaviour.step_clearance(
            machine.patient.behaviour.clearance,
            rest,
            store,
            state.produced_ml_per_s,
            machine.patient.carina_mm,
            patient.strain.muscle_cmh2o,
            TICKS * dt_s,
        )
    return BedsideState(patient, acting, rest, store, state.produced_ml_per_s)
