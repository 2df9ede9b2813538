"""The patient as the suction device sees one: ventilator, tube, lung, oxygen, heart, monitor.

One pure step, a hundred times a second: the device says how much gas its catheter takes and how
much of the tube it fills and how it stimulates the airway, and learns what that does to pressure,
lung volume, saturation and heart rate.
"""

from typing import NamedTuple

from opensuction.kernel.arithmetic import drop_tiny
from opensuction.kernel.compiled import compiled
from opensuction.twin.airway import airway
from opensuction.twin.airway.airway import Tube
from opensuction.twin.behaviour.behaviour import Behaviour
from opensuction.twin.coupling import PatientSigns
from opensuction.twin.patient import gas_exchange, patient_monitor, ventilator
from opensuction.twin.patient.gas_exchange import GasExchange, GasState, Lung, LungState
from opensuction.twin.patient.patient_monitor import (
    Heart,
    HeartState,
    Oximeter,
    OximeterState,
    PatientMonitor,
)
from opensuction.twin.patient.ventilator import Airflow, Supply, Ventilator, VentilatorState

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
    """An `opensuction.kernel.vocabulary.AgeGroup`."""
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
    behaviour: Behaviour


class Strain(NamedTuple):
    """Strain that the patient puts on the lung during a step."""

    muscle_cmh2o: float
    """Pressure of the muscles on it."""
    resistance_ratio: float
    """Resistance of the airways over the stated one: secretions gather."""


AT_EASE = Strain(muscle_cmh2o=0.0, resistance_ratio=1.0)
"""A patient who does nothing."""


class BreathState(NamedTuple):
    """Breaths so far."""

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


class Relaxed(NamedTuple):
    """The lung of the same patient, had the muscles never moved.

    Ventilator, tube, suction, leak and faults are the same. What happens here is not the patient's
    own doing: the judge goes by it.
    """

    airflow: Airflow
    lung: LungState
    breath: BreathState


class PatientState(NamedTuple):
    """State of one patient; the oximeter's memory is apart, for it is an array."""

    vitals: Vitals
    oximeter: OximeterState
    relaxed: Relaxed
    """Stepped for a lively patient only; a quiet one is relaxed."""
    strain: Strain
    """Of the last step."""


@compiled
def is_inside(patient: Patient, tip_mm: float) -> bool:
    """True where the catheter's tip is past the tube's upper end."""
    return tip_mm > -patient.tube_length_mm


@compiled
def _step_breath(
    patient: Patient,
    breath: BreathState,
    lung_ml: float,
    inspired: bool,
    inspires: bool,
    dt_s: float,
) -> BreathState:
    """Volumes at the turns of the breath. lung_ml, inspired: before the step; inspires: after."""
    end_expiratory = breath.end_expiratory_ml
    tidal = breath.tidal_ml
    if inspires and not inspired:
        end_expiratory = lung_ml
    elif inspired and not inspires:
        tidal = lung_ml - end_expiratory
    share = dt_s / (LOSS_SMOOTHING * patient.ventilator.period_s + dt_s)
    loss = breath.reference_ml - end_expiratory
    return BreathState(
        reference_ml=breath.reference_ml,
        end_expiratory_ml=end_expiratory,
        loss_ml=drop_tiny(breath.loss_ml + share * (loss - breath.loss_ml)),
        tidal_ml=tidal,
    )


@compiled
def _pushed_cmh2o(patient: Patient, state: LungState, muscle_cmh2o: float) -> float:
    """Pressure that the muscles reach: they push ever less towards the residual volume."""
    if muscle_cmh2o <= 0.0:
        return muscle_cmh2o
    one = patient.lung
    share = (state.volume_ml - one.residual_ml) / (one.relaxed_ml - one.residual_ml)
    return muscle_cmh2o * min(max(share, 0.0), 1.0)


@compiled
def _ventilate(
    patient: Patient,
    state: LungState,
    supply: Supply,
    suction_ml_per_s: float,
    catheter_ratio: float,
    strain: Strain,
    dt_s: float,
) -> tuple[Airflow, LungState]:
    """Flows of a step, and the lung after it."""
    suction = gas_exchange.removable_ml_per_s(patient.lung, state, suction_ml_per_s, dt_s)
    elastic = gas_exchange.pressure_cmh2o(patient.lung, state)
    leak = 0.0
    if patient.behaviour.is_lively:
        # By the lung's own pressure: that of the trachea would be a loop within the step.
        leak = patient.behaviour.leak_ml_per_s_per_cmh2o * max(elastic, 0.0)
    flows = ventilator.solve(
        supply,
        airway.loss(patient.tube, catheter_ratio),
        elastic + _pushed_cmh2o(patient, state, strain.muscle_cmh2o),
        strain.resistance_ratio * patient.lung.resistance_cmh2o_s_per_ml
        + 0.5 * dt_s / patient.lung.compliance_ml_per_cmh2o,
        suction + leak,
    )
    filled = gas_exchange.step_lung(patient.lung, state, flows.lung_ml_per_s, dt_s)
    return flows._replace(suction_ml_per_s=suction), filled


@compiled
def _perfused(patient: Patient) -> GasExchange:
    """Oxygen transport, with the blood flow that closed lung keeps in a lively patient."""
    gas = patient.gas_exchange
    if not patient.behaviour.is_lively:
        return gas
    return gas._replace(shunt_per_ml=patient.behaviour.perfusion_ratio * gas.shunt_per_ml)


@compiled
def step_vitals(
    patient: Patient,
    state: Vitals,
    suction_ml_per_s: float,
    catheter_ratio: float,
    stimulus: float,
    strain: Strain,
    dt_s: float,
) -> Vitals:
    """`step_under` without the oximeter and the relaxed lung."""
    inspired = ventilator.is_inspiring(patient.ventilator, state.ventilator)
    machine = ventilator.step(patient.ventilator, state.ventilator, dt_s)
    supply = ventilator.supply(patient.ventilator, machine)
    flows, filled = _ventilate(
        patient, state.lung, supply, suction_ml_per_s, catheter_ratio, strain, dt_s
    )
    gas = gas_exchange.step(
        _perfused(patient),
        state.gas,
        flows,
        ventilator.inspired_ratio(patient.ventilator),
        filled.volume_ml,
        filled.closed_ml,
        dt_s,
    )
    beating = patient_monitor.step_heart(
        patient.heart, state.heart, stimulus, gas.arterial_saturation, dt_s
    )
    inspires = ventilator.is_inspiring(patient.ventilator, machine)
    return Vitals(
        ventilator=machine,
        airflow=flows,
        lung=filled,
        gas=gas,
        heart=beating,
        shown_per_min=patient_monitor.average(
            patient.monitor, state.shown_per_min, beating.rate_per_min, dt_s
        ),
        breath=_step_breath(patient, state.breath, state.lung.volume_ml, inspired, inspires, dt_s),
    )


@compiled
def _step_relaxed(
    patient: Patient,
    state: PatientState,
    machine: VentilatorState,
    suction_ml_per_s: float,
    catheter_ratio: float,
    strain: Strain,
    dt_s: float,
) -> Relaxed:
    """The lung had the muscles never moved. machine: the ventilator after the step."""
    before = state.relaxed
    flows, filled = _ventilate(
        patient,
        before.lung,
        ventilator.supply(patient.ventilator, machine),
        suction_ml_per_s,
        catheter_ratio,
        strain._replace(muscle_cmh2o=0.0),
        dt_s,
    )
    inspired = ventilator.is_inspiring(patient.ventilator, state.vitals.ventilator)
    inspires = ventilator.is_inspiring(patient.ventilator, machine)
    breath = _step_breath(patient, before.breath, before.lung.volume_ml, inspired, inspires, dt_s)
    return Relaxed(airflow=flows, lung=filled, breath=breath)


@compiled
def relax(vitals: Vitals) -> Relaxed:
    """The lung of a patient whose muscles have not moved."""
    return Relaxed(airflow=vitals.airflow, lung=vitals.lung, breath=vitals.breath)


@compiled
def step_under(
    patient: Patient,
    state: PatientState,
    suction_ml_per_s: float,
    catheter_ratio: float,
    stimulus: float,
    strain: Strain,
    dt_s: float,
) -> PatientState:
    """`step` of a patient who does something. strain: what, during the step."""
    vitals = step_vitals(
        patient, state.vitals, suction_ml_per_s, catheter_ratio, stimulus, strain, dt_s
    )
    if patient.behaviour.is_lively:
        relaxed = _step_relaxed(
            patient, state, vitals.ventilator, suction_ml_per_s, catheter_ratio, strain, dt_s
        )
    else:
        relaxed = relax(vitals)
    saturation = vitals.gas.arterial_saturation
    return PatientState(
        vitals=vitals,
        oximeter=patient_monitor.step(patient.oximeter, state.oximeter, saturation, dt_s),
        relaxed=relaxed,
        strain=strain,
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
    """Advance by one step of a hundredth of a second or so, in which the patient does nothing.

    suction_ml_per_s: gas at atmospheric pressure that the catheter takes just below the tube.
    catheter_ratio: catheter over tube diameter while the catheter lies in the tube, else 0.
    stimulus: of the airway by the catheter, 0 to 1; see `opensuction.twin.patient.patient_monitor`.
    """
    return step_under(patient, state, suction_ml_per_s, catheter_ratio, stimulus, AT_EASE, dt_s)


@compiled
def signs(patient: Patient, state: PatientState) -> PatientSigns:
    """Signs of the patient, for the machine and the trace."""
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
        muscle_cmh2o=state.strain.muscle_cmh2o,
        relaxed_pressure_cmh2o=state.relaxed.airflow.trachea_cmh2o,
        relaxed_loss_ml=state.relaxed.breath.loss_ml,
    )
