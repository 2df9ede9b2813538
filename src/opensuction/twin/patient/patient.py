"""The patient as the suction device sees one: ventilator, tube, lung, oxygen, heart, monitor.

One pure step, a hundred times a second: the device says how much gas its catheter takes and how
much of the tube it fills and how it stimulates the airway, and learns what that does to pressure,
lung volume, saturation and heart rate.
"""

from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.kernel.tiny import drop_tiny
from opensuction.twin.airway import tube
from opensuction.twin.airway.tube import Tube
from opensuction.twin.coupling import PatientSigns
from opensuction.twin.patient import (
    airflow,
    gas_exchange,
    heart,
    lung,
    oximeter,
    patient_monitor,
    ventilator,
)
from opensuction.twin.patient.airflow import Airflow
from opensuction.twin.patient.gas_exchange import GasExchange, GasState
from opensuction.twin.patient.heart import Heart, HeartState
from opensuction.twin.patient.lung import Lung, LungState
from opensuction.twin.patient.oximeter import Oximeter, OximeterState
from opensuction.twin.patient.patient_monitor import PatientMonitor
from opensuction.twin.patient.ventilator import Ventilator, VentilatorState

L_PER_MIN_PER_ML_PER_S = 0.06
LOSS_SMOOTHING = 0.25
"""Time constant of the shown loss of lung volume, in breaths."""


class Secretion(NamedTuple):
    """Secretions in the trachea, for the device's side of the twin."""

    volume_ml: float
    depth_mm: float
    """Depth below the tube around which they lie."""
    spread_mm: float
    """Half of the length over which they lie."""
    viscosity_pa_s: float
    yield_pa: float
    """Stress below which they do not flow."""
    production_ml_per_h: float


class Patient(NamedTuple):
    """One patient on one ventilator."""

    age_group: int
    """An `opensuction.kernel.age_group.AgeGroup`."""
    weight_kg: float
    tube_id_mm: float
    """Inner diameter of the tracheostomy tube."""
    tube_length_mm: float
    carina_mm: float
    """From the lower end of the tube to the carina."""
    carina_n_per_mm: float
    """Stiffness of what the tip presses on."""
    secretion: Secretion
    ventilator: Ventilator
    tube: Tube
    lung: Lung
    gas_exchange: GasExchange
    oximeter: Oximeter
    heart: Heart
    monitor: PatientMonitor


class BreathState(NamedTuple):
    """What is known of the breaths so far."""

    reference_ml: float
    """End-expiratory volume at the start."""
    end_expiratory_ml: float
    """End-expiratory volume of the last breath."""
    loss_ml: float
    """Loss against the start, smoothed."""
    tidal_ml: float
    """Volume by which the last inspiration filled the lung."""


class Vitals(NamedTuple):
    """State of a patient and of the ventilator, as it truly is."""

    ventilator: VentilatorState
    airflow: Airflow
    lung: LungState
    gas: GasState
    heart: HeartState
    shown_per_min: float
    """Heart rate that the monitor shows."""
    breath: BreathState


class PatientState(NamedTuple):
    """State of one patient; the oximeter's memory is apart, for it is an array."""

    vitals: Vitals
    oximeter: OximeterState


@compiled
def is_inside(patient: Patient, tip_mm: float) -> bool:
    """Whether the catheter's tip is past the tube's upper end."""
    return tip_mm > -patient.tube_length_mm


@compiled
def _step_breath(patient: Patient, state: Vitals, inspires: bool, dt_s: float) -> BreathState:
    """Volumes at the turns of the breath that the state before the step stood in."""
    breath = state.breath
    end_expiratory = breath.end_expiratory_ml
    tidal = breath.tidal_ml
    inspired = ventilator.is_inspiring(patient.ventilator, state.ventilator)
    if inspires and not inspired:
        end_expiratory = state.lung.volume_ml
    elif inspired and not inspires:
        tidal = state.lung.volume_ml - end_expiratory
    share = dt_s / (LOSS_SMOOTHING * patient.ventilator.period_s + dt_s)
    loss = breath.reference_ml - end_expiratory
    return BreathState(
        reference_ml=breath.reference_ml,
        end_expiratory_ml=end_expiratory,
        loss_ml=drop_tiny(breath.loss_ml + share * (loss - breath.loss_ml)),
        tidal_ml=tidal,
    )


@compiled
def step_vitals(
    patient: Patient,
    state: Vitals,
    suction_ml_per_s: float,
    catheter_ratio: float,
    stimulus: float,
    dt_s: float,
) -> Vitals:
    """`step` without the oximeter."""
    machine = ventilator.step(patient.ventilator, state.ventilator, dt_s)
    suction = lung.removable_ml_per_s(patient.lung, state.lung, suction_ml_per_s, dt_s)
    flows = airflow.solve(
        ventilator.supply(patient.ventilator, machine),
        tube.loss(patient.tube, catheter_ratio),
        lung.pressure_cmh2o(patient.lung, state.lung),
        patient.lung.resistance_cmh2o_s_per_ml + 0.5 * dt_s / patient.lung.compliance_ml_per_cmh2o,
        suction,
    )
    filled = lung.step(patient.lung, state.lung, flows.lung_ml_per_s, dt_s)
    gas = gas_exchange.step(
        patient.gas_exchange,
        state.gas,
        flows,
        ventilator.inspired_ratio(patient.ventilator),
        filled.volume_ml,
        filled.closed_ml,
        dt_s,
    )
    beating = heart.step(patient.heart, state.heart, stimulus, gas.arterial_saturation, dt_s)
    return Vitals(
        ventilator=machine,
        airflow=flows,
        lung=filled,
        gas=gas,
        heart=beating,
        shown_per_min=patient_monitor.average(
            patient.monitor, state.shown_per_min, beating.rate_per_min, dt_s
        ),
        breath=_step_breath(
            patient, state, ventilator.is_inspiring(patient.ventilator, machine), dt_s
        ),
    )


@compiled
def step(
    patient: Patient,
    state: PatientState,
    suction_ml_per_s: float,
    catheter_ratio: float,
    stimulus: float,
    dt_s: float,
) -> PatientState:
    """Advance by one step of a hundredth of a second or so.

    suction_ml_per_s: gas at atmospheric pressure that the catheter takes just below the tube.
    catheter_ratio: catheter over tube diameter while the catheter lies in the tube, else 0.
    stimulus: of the airway by the catheter, 0 to 1; see `opensuction.twin.patient.heart`.
    """
    vitals = step_vitals(patient, state.vitals, suction_ml_per_s, catheter_ratio, stimulus, dt_s)
    saturation = vitals.gas.arterial_saturation
    return PatientState(
        vitals=vitals, oximeter=oximeter.step(patient.oximeter, state.oximeter, saturation, dt_s)
    )


@compiled
def signs(patient: Patient, state: PatientState) -> PatientSigns:
    """What the machine and the trace learn of the patient."""
    vitals = state.vitals
    return PatientSigns(
        airway_pressure_cmh2o=vitals.airflow.trachea_cmh2o,
        lung_volume_ml=vitals.lung.volume_ml - patient.lung.residual_ml,
        lung_volume_loss_ml=vitals.breath.loss_ml,
        spo2_percent=state.oximeter.shown_percent,
        heart_rate_per_min=vitals.heart.rate_per_min,
        monitor=patient_monitor.read(
            patient.monitor,
            state.oximeter.shown_percent,
            vitals.shown_per_min,
            vitals.airflow.connector_cmh2o,
        ),
    )
