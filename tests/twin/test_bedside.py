import math

import pytest

from opensuction.kernel.interface import Commands
from opensuction.twin import coupling, parameter, preset
from opensuction.twin.coupling import PatientSigns
from opensuction.twin.machine import machine
from opensuction.twin.machine.machine import Machine, Truth
from opensuction.twin.patient import patient_preset
from opensuction.twin.patient.patient import PatientState
from opensuction.twin.plant import PlantState
from tests.twin.holding import DT_S, IDLE, hold

VALUES = parameter.nominal(parameter.CLINICAL)
ADULT = patient_preset.patient("adult-icu", 0, nominal=True)
TWIN = preset.machine(VALUES, ADULT)
STROKE_RAD = math.radians(30.0)
HOLDING_V = VALUES["spring_preload_v"] + VALUES["spring_v_per_rad"] * STROKE_RAD
SUCTION = IDLE._replace(pump_on=True, vacuum_mmhg=120.0, valve_v=HOLDING_V)


def turned(state: PlantState, cam_rad: float) -> PlantState:
    """The same with the valve's cam there."""
    body = state.machine
    return state._replace(machine=body._replace(valve=body.valve._replace(position=cam_rad)))


def open_at(head_mm: float, twin: Machine = TWIN) -> PlantState:
    """Parked with the head there and the valve wide open."""
    state = preset.park(twin, VALUES, head_mm, seed=1, run=0)
    return turned(state, STROKE_RAD)


def run(state: PlantState, commands: Commands, seconds: float) -> PlantState:
    return hold(TWIN, state, commands, round(seconds / DT_S))


def numbers(state: PatientState) -> list[float]:
    """Every number of a patient's state, so that two can be compared whole."""
    vitals, meter = state.vitals, state.oximeter
    records = (*(part for part in vitals if isinstance(part, tuple)), meter.sample)
    scalars = [float(value) for record in records for value in record]
    shown = [vitals.shown_per_min, float(meter.latest), meter.shown_percent]
    return [*scalars, *shown, *(float(value) for value in meter.history)]


def test_what_the_line_draws_inside_is_what_the_patient_loses() -> None:
    """Through the tube and on the way out of it, while the flow changes within every step."""
    state = open_at(-20.0)
    out = SUCTION._replace(insertion_v=-16.0)
    line_ml = patient_ml = outside_ml = 0.0
    for _ in range(5000):
        before = state
        state = hold(TWIN, state, out, 1)
        drawn = state.machine.line.gas_ml - before.machine.line.gas_ml
        if state.machine.airway.tip_mm > -ADULT.tube_length_mm:
            line_ml += drawn
        else:
            outside_ml += drawn
        if state.machine.coupling.ticks == 0:
            patient_ml += 0.01 * state.bedside.patient.vitals.airflow.suction_ml_per_s
    assert state.machine.coupling.gas_ml == 0.0
    assert line_ml > 100.0
    assert outside_ml > 100.0
    assert patient_ml == pytest.approx(line_ml, rel=1e-9)


def test_nothing_is_taken_outside() -> None:
    """Sucking air in the connector, the patient breathes as without a machine."""
    state = open_at(-130.0)
    assert state.machine.airway.tip_mm < -ADULT.tube_length_mm
    alone = patient_preset.breathe(ADULT, state.bedside.patient, 100, 0.01)
    sucked = run(state, SUCTION, 1.0)
    assert sucked.machine.line.gas_ml > 100.0
    assert numbers(sucked.bedside.patient) == numbers(alone)


def test_the_catheter_alone_narrows_the_tube() -> None:
    """Valve closed: the lung fills more slowly with the catheter in the tube than without."""
    inside = preset.park(TWIN, VALUES, -20.0, seed=1, run=0)
    outside = preset.park(TWIN, VALUES, -130.0, seed=1, run=0)
    narrowed, free = run(inside, IDLE, 0.5), run(outside, IDLE, 0.5)
    assert narrowed.machine.line.gas_ml == 0.0
    volumes = [one.bedside.patient.vitals.lung.volume_ml for one in (narrowed, free)]
    assert volumes[0] < volumes[1] - 0.5


def test_pressure_falls_under_suction_and_comes_back() -> None:
    state = open_at(20.0)
    breaths_s = 2.0 * ADULT.ventilator.period_s

    def lowest(commands: Commands) -> float:
        nonlocal state
        seen = math.inf
        for _ in range(round(breaths_s / (coupling.TICKS * DT_S))):
            state = hold(TWIN, state, commands, coupling.TICKS)
            seen = min(seen, machine.truth(TWIN, state.machine).airway_pressure_cmh2o)
        return seen

    peep = ADULT.ventilator.peep_cmh2o
    assert lowest(SUCTION) < peep - 2.0
    state = turned(state, 0.0)
    lowest(IDLE)  # the lung fills again
    # The catheter still lies in the tube: gas that flows past it costs a little.
    assert lowest(IDLE) == pytest.approx(peep, abs=0.3)
    truth = machine.truth(TWIN, state.machine)
    assert truth.lung_volume_loss_ml > 0.0  # what has closed takes minutes to open
    assert 90.0 < truth.spo2_percent < 100.0


def test_the_patient_steps_with_every_tenth_tick() -> None:
    state = preset.park(TWIN, VALUES, 0.0, seed=1, run=0)
    for tick in range(1, 101):
        before = state.bedside.patient.vitals
        state = hold(TWIN, state, IDLE, 1)
        assert state.machine.coupling.ticks == tick % coupling.TICKS
        stepped = state.bedside.patient.vitals.ventilator.breath_s != before.ventilator.breath_s
        assert stepped is (tick % coupling.TICKS == 0)
    assert state.bedside.patient.vitals.ventilator.breath_s == pytest.approx(0.1)


def test_without_a_patient_nobody_breathes() -> None:
    bench = preset.machine(VALUES)
    state = open_at(50.0, bench)
    start = state.bedside.patient
    state = hold(bench, state, SUCTION, 100)
    assert state.machine.line.gas_ml > 0.0
    assert numbers(state.bedside.patient) == numbers(start)
    assert machine.truth(bench, state.machine)[-4:] == (0.0, 0.0, 0.0, 0.0)


def test_a_patient_changes_nothing_of_machine_and_line() -> None:
    """But for the airway and what lies in it: the same commands move head, cam, gas alike."""
    bench = preset.machine(VALUES)
    alike = TWIN._replace(airway=bench.airway, bore=bench.bore, mouth_mm=bench.mouth_mm)
    one, other = open_at(-20.0, bench), open_at(-20.0)
    body = other.machine
    there = body.coupling._replace(reachable_ml=one.machine.coupling.reachable_ml)
    other = PlantState(
        machine=body._replace(airway=one.machine.airway, coupling=there),
        bedside=one.bedside._replace(patient=other.bedside.patient),
    )
    forth = SUCTION._replace(insertion_v=12.0)
    one, other = hold(bench, one, forth, 2000), hold(alike, other, forth, 2000)
    seen, also = machine.read(bench, one.machine), machine.read(alike, other.machine)
    assert seen == also._replace(monitor=seen.monitor)
    known, true = machine.truth(bench, one.machine), machine.truth(alike, other.machine)
    signs = {name: getattr(known, name) for name in PatientSigns._fields if name in Truth._fields}
    assert len(signs) == 8
    assert known == true._replace(**signs)
