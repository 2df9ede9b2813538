"""Patients by name: parameters turned into the records that the twin steps, and their rest."""

import math
from functools import lru_cache

from opensuction.kernel.compiled import compiled
from opensuction.kernel.errors import InputError
from opensuction.kernel.unit import ML_PER_S
from opensuction.kernel.vocabulary import AgeGroup
from opensuction.twin import parameter
from opensuction.twin.airway import airway
from opensuction.twin.airway.airway import Tube
from opensuction.twin.behaviour import behaviour_parameter
from opensuction.twin.parameter import ParameterValues
from opensuction.twin.patient import gas_exchange, patient_monitor, ventilator
from opensuction.twin.patient import patient as patient_model
from opensuction.twin.patient.gas_exchange import DRY_MMHG, GasExchange, GasState, Lung, LungState
from opensuction.twin.patient.patient import (
    AT_EASE,
    BreathState,
    Patient,
    PatientState,
    Secretion,
    Vitals,
)
from opensuction.twin.patient.patient_monitor import Heart, PatientMonitor
from opensuction.twin.patient.patient_parameter import PATIENT_TABLES
from opensuction.twin.patient.ventilator import Ventilator

DT_S = 0.01
"""Step of the patient: also the resolution of the ventilator's clock."""
SETTLE_S = 600.0
"""Breathing before a patient counts as at rest: twelve times the slowest store of oxygen."""
LITRE_ML = 1000.0
OXYGEN_ML_PER_G = 1.34
"""Oxygen bound by a gram of haemoglobin."""
DL_ML = 100.0
OPENABLE = 0.95
"""Share of the gas between relaxed and residual volume that may be in units that close."""

AGE_GROUPS = {
    "adult-icu": AgeGroup.ADULT,
    "adult-ards": AgeGroup.ADULT,
    "child-10kg": AgeGroup.CHILD,
    "neonate": AgeGroup.NEONATE,
}


def _lung(values: ParameterValues) -> Lung:
    weight = values["weight_kg"]
    relaxed = values["relaxed_ml_per_kg"] * weight
    residual = values["residual_ml_per_kg"] * weight
    return Lung(
        compliance_ml_per_cmh2o=values["compliance_ml_per_cmh2o_per_kg"] * weight,
        resistance_cmh2o_s_per_ml=values["resistance_cmh2o_s_per_l"] / LITRE_ML,
        relaxed_ml=relaxed,
        residual_ml=residual,
        closing_cmh2o=values["peep_cmh2o"] - values["closing_margin_cmh2o"],
        # Even with everything closed, zero pressure leaves more than the residual volume.
        closable_ml=min(values["closable_ml_per_kg"] * weight, OPENABLE * (relaxed - residual)),
        half_closing_cmh2o=values["half_closing_cmh2o"],
        closing_s=values["closing_s"],
        opening_s=values["opening_s"],
    )


def _tube(values: ParameterValues) -> Tube:
    """Tube with its friction taken at the mean inspiratory flow."""
    tidal = values["tidal_ml_per_kg"] * values["weight_kg"]
    inspiration_s = 60.0 / values["rate_per_min"] * values["inspiration_ratio"]
    return airway.of_size(values["tube_id_mm"], values["tube_length_mm"], tidal / inspiration_s)


def driving_cmh2o(values: ParameterValues, inspiration_s: float) -> float:
    """Driving pressure that gives the wanted tidal volume, as the bedside would set it.

    The lung fills exponentially after the rise; resistance is taken at the mean flow.
    """
    tidal = values["tidal_ml_per_kg"] * values["weight_kg"]
    compliance = values["compliance_ml_per_cmh2o_per_kg"] * values["weight_kg"]
    resistance = (
        values["resistance_cmh2o_s_per_l"] + values["source_cmh2o_s_per_l"]
    ) / LITRE_ML + airway.loss(_tube(values), 0.0) * tidal / inspiration_s
    filling_s = inspiration_s - values["rise_s"]
    emptying_s = 60.0 / values["rate_per_min"] - inspiration_s - values["fall_s"]
    out = resistance + (values["valve_cmh2o_s_per_l"] - values["source_cmh2o_s_per_l"]) / LITRE_ML
    kept_full = math.exp(-filling_s / (resistance * compliance))
    kept_empty = math.exp(-emptying_s / (out * compliance))
    share = (1.0 - kept_full) * (1.0 - kept_empty) / (1.0 - kept_full * kept_empty)
    return tidal / compliance / share


def _ventilator(values: ParameterValues) -> Ventilator:
    # A whole number of steps in a breath and in its inspiration, so that every breath is the same.
    period_s = round(60.0 / values["rate_per_min"] / DT_S) * DT_S
    inspiration_s = (round(period_s * values["inspiration_ratio"] / DT_S) - 0.5) * DT_S
    return Ventilator(
        peep_cmh2o=values["peep_cmh2o"],
        driving_cmh2o=driving_cmh2o(values, inspiration_s),
        period_s=period_s,
        inspiration_s=inspiration_s,
        rise_s=values["rise_s"],
        fall_s=values["fall_s"],
        source_cmh2o_s_per_ml=values["source_cmh2o_s_per_l"] / LITRE_ML,
        peak_ml_per_s=values["peak_l_per_min"] * ML_PER_S,
        droop_cmh2o_s_per_ml=values["droop_cmh2o_s_per_l"] / LITRE_ML,
        compensation_ml_per_s=values["compensation_l_per_min"] * ML_PER_S,
        valve_cmh2o_s_per_ml=values["valve_cmh2o_s_per_l"] / LITRE_ML,
        oxygen_ratio=values["oxygen_ratio"],
        pressure_ratio=1.0,
        connected=True,
    )


def _gas_exchange(values: ParameterValues) -> GasExchange:
    weight = values["weight_kg"]
    end_expiratory_ml = weight * (
        values["relaxed_ml_per_kg"]
        + values["compliance_ml_per_cmh2o_per_kg"] * values["peep_cmh2o"]
    )
    open_flow = 1.0 - values["shunt"]
    return GasExchange(
        dead_space_ml=values["dead_space_ml_per_kg"] * weight,
        consumption_ml_per_s=values["oxygen_ml_per_min_per_kg"] * weight / 60.0,
        output_ml_per_s=values["output_l_per_min_per_kg"] * weight * ML_PER_S,
        capacity=OXYGEN_ML_PER_G * values["haemoglobin_g_per_dl"] / DL_ML,
        p50_mmhg=values["p50_mmhg"],
        venous_ml=values["venous_ml_per_kg"] * weight,
        shunt=values["shunt"],
        # Blood flow is taken as even over the open lung's volume.
        shunt_per_ml=values["closed_perfusion"] * open_flow / end_expiratory_ml,
    )


def assemble(values: ParameterValues, age_group: AgeGroup) -> Patient:
    """A patient from a full set of parameters."""
    return Patient(
        age_group=int(age_group),
        weight_kg=values["weight_kg"],
        tube_id_mm=values["tube_id_mm"],
        tube_length_mm=values["tube_length_mm"],
        carina_mm=values["carina_mm"],
        carina_n_per_mm=values["carina_n_per_mm"],
        secretion=Secretion(
            volume_ml=values["secretion_ml"],
            depth_mm=values["secretion_depth_ratio"] * values["carina_mm"],
            spread_mm=values["secretion_spread_ratio"] * values["carina_mm"],
            viscosity_pa_s=values["viscosity_pa_s"],
            yield_pa=values["yield_pa"],
            production_ml_per_h=values["production_ml_per_h"],
        ),
        ventilator=_ventilator(values),
        tube=_tube(values),
        lung=_lung(values),
        gas_exchange=_gas_exchange(values),
        oximeter=patient_monitor.of_delay(values["delay_s"], values["average_s"]),
        heart=Heart(
            rest_per_min=values["heart_rate_per_min"],
            vagal_ratio=values["vagal_ratio"],
            vagal_s=values["vagal_s"],
            recovery_s=values["vagal_recovery_s"],
            hypoxic_ratio=values["hypoxic_ratio"],
        ),
        monitor=PatientMonitor(
            present=True, linked=True, probe_on=True, beat_average_s=values["beat_average_s"]
        ),
        behaviour=behaviour_parameter.assemble(values),
    )


def lively(one: Patient) -> Patient:
    """The same patient, who coughs, breathes, is moved, leaks; see `twin.behaviour`."""
    return one._replace(behaviour=one.behaviour._replace(is_lively=True))


def quiet(one: Patient) -> Patient:
    """The same patient, who does nothing of it."""
    return one._replace(behaviour=one.behaviour._replace(is_lively=False))


def patient(name: str, seed: int, nominal: bool = False) -> Patient:
    """A patient by preset name, drawn by the seed, or exactly nominal and quiet.

    A drawn one is lively as the parameter `lively` says; `lively` and `quiet` make them so.
    Raises InputError for an unknown name.
    """
    if name not in PATIENT_TABLES:
        raise InputError(f"patient '{name}' is not known: one of {', '.join(PATIENT_TABLES)}")
    table = PATIENT_TABLES[name]
    values = parameter.nominal(table) if nominal else parameter.draw(table, seed)
    found = assemble(values, AGE_GROUPS[name])
    return quiet(found) if nominal else found


@compiled
def breathe(patient: Patient, state: PatientState, steps: int, dt_s: float) -> PatientState:
    """State after a number of steps without suction and catheter."""
    vitals, meter, done = state.vitals, state.oximeter, 0
    while done < steps:
        sample, due = meter.sample, False
        # Up to the oximeter's next sample without its memory: a reference to an array is counted
        # at every hand, which takes as long as the breathing.
        while done < steps and not due:
            vitals = patient_model.step_vitals(patient, vitals, 0.0, 0.0, 0.0, AT_EASE, dt_s)
            sample = patient_monitor.integrate(sample, vitals.gas.arterial_saturation, dt_s)
            due = patient_monitor.is_due(sample, dt_s)
            done += 1
        if due:
            meter = patient_monitor.show(patient.oximeter, meter, sample)
        else:
            meter = meter._replace(sample=sample)
    return PatientState(vitals, meter, patient_model.relax(vitals), AT_EASE)


def near_rest(patient: Patient) -> PatientState:
    """Near rest: end of expiration, ventilation and circulation roughly in balance."""
    gas = patient.gas_exchange
    peep = patient.ventilator.peep_cmh2o
    volume = patient.lung.relaxed_ml + patient.lung.compliance_ml_per_cmh2o * peep
    alveolar_mmhg = max(DRY_MMHG * patient.ventilator.oxygen_ratio - 40.0, 60.0)
    arterial = gas_exchange.content(gas, 80.0)
    vitals = Vitals(
        ventilator=ventilator.at_rest(patient.ventilator),
        airflow=ventilator.still(peep),
        lung=LungState(volume_ml=volume, closed_ml=0.0),
        gas=GasState(
            dead_space_ratio=alveolar_mmhg / DRY_MMHG,
            alveolar_o2_ml=alveolar_mmhg / DRY_MMHG * volume,
            alveolar_mmhg=alveolar_mmhg,
            venous_content=arterial - gas.consumption_ml_per_s / gas.output_ml_per_s,
            arterial_mmhg=80.0,
            arterial_saturation=gas_exchange.saturation(gas, 80.0),
        ),
        heart=patient_monitor.at_rest_heart(patient.heart),
        shown_per_min=patient.heart.rest_per_min,
        breath=BreathState(
            reference_ml=volume, end_expiratory_ml=volume, loss_ml=0.0, tidal_ml=0.0
        ),
    )
    shown = patient_monitor.at_rest(gas_exchange.saturation(gas, 80.0))
    return PatientState(vitals, shown, patient_model.relax(vitals), AT_EASE)


@lru_cache(maxsize=1)
def at_rest(patient: Patient) -> PatientState:
    """State in the middle of quiet ventilation, at the start of a breath; nothing drifts any more.

    The end-expiratory volume reached is the reference of the loss of lung volume. The last answer
    is kept: teaching and cycles of one machine begin with the same patient.
    """
    breath_steps = round(patient.ventilator.period_s / DT_S)
    breaths = round(SETTLE_S / patient.ventilator.period_s)
    state = breathe(patient, near_rest(patient), breaths * breath_steps, DT_S)
    breath = state.vitals.breath
    begun = breath._replace(reference_ml=breath.end_expiratory_ml, loss_ml=0.0)
    vitals = state.vitals._replace(breath=begun)
    return state._replace(vitals=vitals, relaxed=patient_model.relax(vitals))
