"""Machines by name: parameters turned into the records that the twin steps."""

import math

import numpy as np
import numpy.typing as npt

from opensuction.hysteresis.play import PLAYS
from opensuction.kernel import random_stream
from opensuction.kernel.unit import ATMOSPHERE_MMHG, HOUR_S, ML_PER_S
from opensuction.twin import bedside, parameter
from opensuction.twin.airway.airway import BIN_MM, Airway, AirwayState, Bins, Tip
from opensuction.twin.bedside import BedsideState
from opensuction.twin.behaviour import behaviour
from opensuction.twin.conduit.play_line import SUM_OF_PLAYS as CLEARANCES
from opensuction.twin.conduit.play_line import TransmissionClass, TransmissionKind
from opensuction.twin.conduit.rate_friction import NO_FRICTION, NO_LAG, BoucWenLag, RateFriction
from opensuction.twin.machine import catheter as catheter_model
from opensuction.twin.machine import dc_axis, suction_line, tip_sensor, transmission
from opensuction.twin.machine import machine as machine_model
from opensuction.twin.machine.catheter import BORE_MMHG, LENGTH_M, STROKE_MM, Catheter, Conduit
from opensuction.twin.machine.dc_axis import AxisMotion, DcAxis, ValveMechanism
from opensuction.twin.machine.machine import Machine, MachineState
from opensuction.twin.machine.suction_line import Bore, SuctionLine, SuctionState
from opensuction.twin.machine.tip_sensor import ContactSwitch, Laser, LaserState
from opensuction.twin.machine.transmission import Creep, Transmission, bundle
from opensuction.twin.parameter import ParameterValues
from opensuction.twin.patient import patient_airway, patient_preset
from opensuction.twin.patient.patient import Patient
from opensuction.twin.plant import PlantState
from opensuction.twin.sensor import sensor

GIVEN_MASS_KG = parameter.BENCH["moving_mass_kg"].value
"""Moving mass for which an insertion axis's time constant is given."""
NOMINAL_WIDTH_MM = parameter.BENCH["bend_rad"].value * parameter.BENCH["clearance_mm"].value
"""Mean width of the paper's gap: lags of other classes are given for it."""
BINS = 12
"""Bins of secretions along the airway."""
NOISE_PURPOSE = 1000
"""Streams from here on are the measurement noise of run 0, 1, 2, ..."""
SWITCH_PURPOSE = 1_000_000
"""Streams from here on are the bouncing of the contact switch in run 0, 1, 2, ..."""
SENSOR_PURPOSE = 2_000_000
"""Streams from here on are the noise of the machine's own sensors in run 0, 1, 2, ..."""
ENDLESS_MM = 1.0e9
"""Ends of a rack that no run reaches; `limit_rack` sets real ones."""
BEHIND_PARK_MM = 10.0
"""[assumed] Rack behind the park position."""
MOUTH_MM = 10.0
"""[design] Light barrier in the connector, above the tube's upper end: half way to where the tip
parks."""
NO_PATIENT = patient_preset.patient("adult-icu", 0, nominal=True)
"""Fills the patient's place in a machine that has none; it is never stepped."""


def play_widths_mm(mean_mm: float, spread_mm: float, count: int) -> npt.NDArray[np.float64]:
    """Widths at equal quantiles of a normal distribution, with exactly its mean and deviation."""
    from scipy.special import ndtri

    quantiles = ndtri((np.arange(count) + 0.5) / count)
    return np.asarray(mean_mm + spread_mm * quantiles / np.std(quantiles), dtype=np.float64)


def insertion_axis(values: ParameterValues) -> DcAxis:
    """Insertion axis from its parameters."""
    supply = values["supply_v"]
    speed_per_v = values["no_load_mm_per_s"] / supply
    return DcAxis(
        speed_per_v=speed_per_v,
        time_constant_s=values["insertion_time_constant_s"] * inertia_ratio(values),
        voltage_limit_v=supply,
        friction_v=values["insertion_friction_v"],
        force_v=values["drive_force_n"] * load_v_per_n(values),
        encoder_step=values["head_encoder_mm"],
        brakes_when_off=True,
        polarity=1.0,
    )


def inertia_ratio(values: ParameterValues) -> float:
    """Moving mass over the one for which the axis's time constant is given."""
    return values["moving_mass_kg"] / GIVEN_MASS_KG


def load_v_per_n(values: ParameterValues) -> float:
    """Voltage that balances one newton at the head: F = m v / tau at the speed of one volt.

    It is the motor's, whatever mass is on the rack.
    """
    speed_m_per_s_per_v = values["no_load_mm_per_s"] / values["supply_v"] / 1000.0
    return values["insertion_time_constant_s"] / (GIVEN_MASS_KG * speed_m_per_s_per_v)


def transmission_of(
    values: ParameterValues, chosen: TransmissionClass = CLEARANCES
) -> Transmission:
    """Transmission from its parameters: mean width is bend angle times diametral clearance."""
    mean_width = values["bend_rad"] * values["clearance_mm"]
    widths = bundle(play_widths_mm(mean_width, values["width_spread_mm"], PLAYS))
    lag_ratio = mean_width / NOMINAL_WIDTH_MM
    if chosen.kind == TransmissionKind.RUBBING:  # as stretch: it goes with the bend
        lag_ratio = values["bend_rad"] / parameter.BENCH["bend_rad"].value
    elif chosen.kind == TransmissionKind.RECORDED:
        widths = bundle(lag_ratio * width for width in chosen.lines.widths_mm)
    return Transmission(
        kind=int(chosen.kind),
        widths_mm=widths,
        stretch_mm=values["stretch_mm"],
        gain=values["gain"],
        gain_per_mm=values["gain_per_100mm"] / 100.0,
        middle_mm=50.0,
        offset_mm=values["offset_mm"],
        creep=Creep(
            fast_mm=values["creep_fast_mm"],
            fast_per_s=1.0 / values["creep_fast_s"],
            slow_mm=values["creep_slow_mm"],
            slow_per_s=1.0 / values["creep_slow_s"],
        ),
        lag_ratio=lag_ratio,
        bouc_wen=_bouc_wen(values) if chosen.kind == TransmissionKind.BOUC_WEN else NO_LAG,
        friction=_friction(values) if chosen.kind == TransmissionKind.RUBBING else NO_FRICTION,
        lines=chosen.lines,
    )


def _bouc_wen(values: ParameterValues) -> BoucWenLag:
    dissipation, bend = values["bouc_wen_dissipation"], values["bouc_wen_bend"]
    return BoucWenLag(
        gain=values["bouc_wen_gain"],
        outward=bend + dissipation,
        homeward=bend - dissipation,
        exponent=values["bouc_wen_exponent"],
        share=values["bouc_wen_memory_gain"] / values["gain"],
    )


def _friction(values: ParameterValues) -> RateFriction:
    return RateFriction(
        static_mm=values["rub_static_mm"],
        kinetic_mm=values["rub_kinetic_mm"],
        stribeck_mm_per_s=values["rub_stribeck_mm_per_s"],
        film_s=values["rub_film_s"],
    )


def _valve_axis(values: ParameterValues) -> DcAxis:
    return DcAxis(
        speed_per_v=values["cam_no_load_rad_per_s"] / values["supply_v"],
        time_constant_s=values["valve_time_constant_s"],
        voltage_limit_v=values["supply_v"],
        friction_v=values["valve_friction_v"],
        force_v=values["valve_force_v"],
        encoder_step=values["cam_encoder_rad"],
        brakes_when_off=False,  # the spring must close the valve
        polarity=1.0,
    )


def _line(values: ParameterValues) -> SuctionLine:
    return SuctionLine(
        pump_free_ml_per_s=values["pump_free_l_per_min"] * ML_PER_S,
        pump_occluded_mmhg=values["pump_occluded_mmhg"],
        regulator_ml_per_s_per_mmhg=values["regulator_ml_per_s_per_mmhg"],
        relief_mmhg=values["relief_mmhg"],
        relief_ml_per_s_per_mmhg=values["relief_ml_per_s_per_mmhg"],
        mmhg_per_ml=ATMOSPHERE_MMHG / values["canister_ml"],
        bore_ml_per_s_per_root_mmhg=values["bore_l_per_min"] * ML_PER_S / math.sqrt(BORE_MMHG),
        leak_ml_per_s_per_mmhg=values["leak_ml_per_s_per_mmhg"],
        pump_runs_away=False,
    )


def _bore(values: ParameterValues, catheter: Catheter) -> Bore:
    diameter = catheter.bore_mm
    return Bore(
        volume_ml=0.25 * math.pi * diameter * diameter * LENGTH_M,
        diameter_mm=diameter,
        viscosity_pa_s=values["mucus_pa_s"],
        yield_pa=values["mucus_yield_pa"],
    )


def _valve(values: ParameterValues) -> ValveMechanism:
    return ValveMechanism(
        stroke_rad=values["cam_stroke_rad"],
        slide_mm=values["valve_slide_mm"],
        seal_mm=values["valve_seal_mm"],
        spring_preload_v=values["spring_preload_v"],
        spring_v_per_rad=values["spring_v_per_rad"],
        stop_rad=values["cam_stop_rad"],
        least_ratio=0.0,
        most_ratio=1.0,
    )


def _airway(values: ParameterValues) -> Airway:
    return Airway(
        carina_mm=values["carina_mm"],
        tip=Tip(
            carina_n_per_mm=values["carina_n_per_mm"],
            catheter_n_per_mm=values["catheter_n_per_mm"],
            buckling_n=values["buckling_n"],
            post_buckling_ratio=values["post_buckling_ratio"],
        ),
        uptake_ml_per_s_per_mmhg=values["uptake_ml_per_s_per_mmhg"],
        reach_mm=values["reach_mm"],
        mucus_share=values["mucus_share"],
    )


def _switch(values: ParameterValues) -> ContactSwitch:
    return ContactSwitch(
        close_n=values["switch_n"],
        open_n=values["switch_open_ratio"] * values["switch_n"],
        bounce_s=values["switch_bounce_s"],
        bounce_open_ratio=values["switch_bounce_open_ratio"],
        latency_s=values["switch_latency_s"],
        wired=True,
    )


def machine(
    values: ParameterValues,
    patient: Patient | None = None,
    catheter: Catheter | None = None,
    conduit: Conduit | None = None,
    transmission_class: TransmissionClass = CLEARANCES,
) -> Machine:
    """A machine with its airway from a full set of parameters.

    patient: whose airway it is; without one it is the bench's rubber trachea. catheter: the one for
    the patient's age where none is given, the paper's on the bench. conduit: the standard one for
    the catheter where none is given. transmission_class: values hold its parameters.
    """
    chosen = catheter if catheter is not None else catheter_model.for_patient(patient)
    laid = conduit if conduit is not None else catheter_model.lay("standard", chosen)
    fitted = catheter_model.adapt(values, chosen, laid)
    if patient is not None:
        fitted = patient_airway.adapt(fitted, patient)
    return Machine(
        insertion_axis=insertion_axis(fitted),
        rack_from_mm=-ENDLESS_MM,
        rack_to_mm=ENDLESS_MM,
        gear_backlash_mm=fitted["gear_backlash_mm"],
        sensors=sensor.sensors(fitted),
        amperes_per_v=fitted["drive_a_per_n"] / load_v_per_n(fitted),
        load_v_per_n=load_v_per_n(fitted),
        clamp_slip_ratio=0.0,
        mouth_mm=math.inf if patient is None else -(patient.tube_length_mm + MOUTH_MM),
        weak_tip_mm=0.0,
        transmission=transmission_of(fitted, transmission_class),
        valve_axis=_valve_axis(fitted),
        valve=_valve(fitted),
        line=_line(fitted),
        bore=_bore(fitted, chosen),
        airway=_airway(fitted),
        switch=_switch(fitted),
        laser=Laser(noise_mm=fitted["laser_noise_mm"]),
        patient=patient if patient is not None else NO_PATIENT,
        has_patient=patient is not None,
        catheter_mm=chosen.outer_mm,
        hand=dc_axis.NOBODY,
    )


def limit_rack(twin: Machine, park_head_mm: float) -> Machine:
    """The same machine with the ends of its rack, the head being parked at ``park_head_mm``."""
    return twin._replace(
        rack_from_mm=park_head_mm - BEHIND_PARK_MM, rack_to_mm=park_head_mm + STROKE_MM
    )


def ventilate(twin: Machine, oxygen_ratio: float) -> Machine:
    """The same machine, its patient breathing this share of oxygen."""
    ventilator = twin.patient.ventilator._replace(oxygen_ratio=oxygen_ratio)
    return twin._replace(patient=twin.patient._replace(ventilator=ventilator))


def secretions_ml(values: ParameterValues) -> Bins:
    """Secretions in each bin: a cosine bump around their depth, cut off at the carina."""
    middles = (np.arange(BINS) + 0.5) * BIN_MM
    centre = values["carina_mm"] - values["secretion_above_carina_mm"]
    from_centre = (middles - centre) / values["secretion_spread_mm"]
    shape = np.where(np.abs(from_centre) < 1.0, 1.0 + np.cos(np.pi * from_centre), 0.0)
    shape[middles > values["carina_mm"]] = 0.0
    total = float(np.sum(shape))
    if total == 0.0:  # no bin's middle among them
        # A child's may lie in a single bin; a trachea taken off holds none.
        shape[np.floor(middles / BIN_MM) == np.floor(centre / BIN_MM)] = 1.0
        total = max(float(np.sum(shape)), 1.0)
    return np.asarray(shape * values["secretion_ml"] / total, dtype=np.float64)


def _settle_bedside(twin: Machine, values: ParameterValues, seed: int, run: int) -> BedsideState:
    """The bedside before use: the patient breathes quietly, all secretions lie there.

    New secretions come where the others lie; on the bench, where nobody waits, none do.
    seed, run: what a lively patient does.
    """
    person = twin.patient
    fitted, hourly_ml, breathing = values, 0.0, patient_preset.near_rest(person)
    if twin.has_patient:
        fitted = patient_airway.adapt(values, person)
        hourly_ml = person.secretion.production_ml_per_h
        breathing = patient_preset.at_rest(person)
    loose_ml = secretions_ml(fitted)
    store = behaviour.EMPTY
    if twin.has_patient and person.behaviour.is_lively:
        loose_ml, store = behaviour.part(person.behaviour.clearance, loose_ml)
    return BedsideState(
        patient=breathing,
        behaviour=behaviour.begin(person.behaviour, seed, run),
        secretion_ml=loose_ml,
        store=store,
        produced_ml_per_s=secretions_ml({**fitted, "secretion_ml": hourly_ml / HOUR_S}),
    )


def park(twin: Machine, values: ParameterValues, head_mm: float, seed: int, run: int) -> PlantState:
    """State at rest after a retract that ended with the encoder at ``head_mm``; pump off.

    values: those that the machine was made from. The patient breathes quietly.
    seed, run: the measurement noise and what a lively patient does; the same machine gives other
    noise for another run.
    """
    behind_gear = head_mm + 0.5 * twin.gear_backlash_mm
    moved = transmission.after_retract(twin.transmission, behind_gear)
    around = _settle_bedside(twin, values, seed, run)
    at_rest = AxisMotion(position=head_mm, velocity=0.0, drive_v=0.0)
    measured = machine_model.measure(twin, at_rest, behind_gear, 0.0, 0.0)
    machine = MachineState(
        insertion=at_rest,
        head_mm=behind_gear,
        slipped_mm=0.0,
        piece_mm=0.0,
        transmission=moved,
        valve=AxisMotion(position=0.0, velocity=0.0, drive_v=0.0),
        line=SuctionState(vacuum_mmhg=0.0, gas_ml_per_s=0.0, gas_ml=0.0),
        bore=suction_line.EMPTY,
        airway=AirwayState(
            taken_ml=0.0,
            removed_ml=0.0,
            tip_mm=moved.tip_mm,
            contact_n=0.0,
            free_share=1.0,
        ),
        switch=tip_sensor.released(random_stream.stream(seed, SWITCH_PURPOSE + run)),
        laser=LaserState(
            reading_mm=moved.tip_mm,
            spare=0.0,
            has_spare=False,
            stream=random_stream.stream(seed, NOISE_PURPOSE + run),
        ),
        sensed=sensor.begin(
            twin.sensors, measured, random_stream.stream(seed, SENSOR_PURPOSE + run)
        ),
        coupling=bedside.couple(twin, around, moved.tip_mm),
        hand=dc_axis.AWAY,
    )
    return PlantState(machine=machine, bedside=around)


MACHINE_TABLES = {"bench": parameter.BENCH, "clinical": parameter.CLINICAL}
"""Machine presets by name."""
