"""Something goes wrong with the patient during suction: what notices, and how soon it is over.

The machine of the twin is exchanged for one with the fault at an instant of a running cycle.
"""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from opensuction.kernel.interface import NO_REQUESTS, START, Requests
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle.lock_out import Refusal
from opensuction.safety.condition import Condition
from opensuction.safety.condition_mask import decode_trips
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation import closed_loop, trace
from opensuction.simulation.closed_loop import DT_S, Loop, LoopState
from opensuction.simulation.trace import Columns
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_row import PatientEffect
from opensuction.twin.fault.fault_table import ROWS
from opensuction.twin.patient import patient_monitor, patient_preset
from opensuction.twin.patient.patient import Patient
from tests.columns_of_rows import ColumnsOfRows
from tests.quiet_patient import quiet

PROTOCOLS = {"adult-icu": "adult", "child-10kg": "paediatric", "neonate": "paediatric"}
PROTOCOL = {**PROTOCOLS, "adult-ards": "adult"}
Change = Callable[[Patient], Patient]


@cache
def prepared(name: str, seed: int = 1) -> Prepared:
    rig = RigChoice(patient=quiet(name), seed=seed)
    choice = CycleChoice(rig, PROTOCOL[name], compensation="exact-inverse")
    return cycle_run.prepare(resolution.resolve(choice))


@cache
def begins_s(name: str, phase: Phase) -> float:
    """When a phase of the healthy cycle begins."""
    columns = cycle_run.play(prepared(name))
    return next(span.start_s for span in trace.phase_spans(columns) if span.phase == phase)


def ran(
    loop: Loop, state: LoopState, seconds: float, requests: Requests = NO_REQUESTS
) -> tuple[LoopState, Columns]:
    """So long, at rest or not."""
    table = trace.rows(seconds)
    done = 0
    while done < len(table):
        state, ticks = closed_loop.run(loop, state, requests, table[done:])
        requests = NO_REQUESTS
        done += ticks
    return state, ColumnsOfRows(table)


@cache
def begun(name: str, at_s: float) -> LoopState:
    """The healthy cycle at an instant."""
    ready = prepared(name)
    return ran(ready.loop, ready.start, at_s, START)[0]


def broken(
    name: str, change: Change, at_s: float, seconds: float = 25.0
) -> tuple[Loop, LoopState, Columns]:
    """A cycle in which the patient changes at an instant; the trace from there on."""
    ready = prepared(name)
    machine = ready.loop.machine
    loop = ready.loop._replace(machine=machine._replace(patient=change(machine.patient)))
    state, columns = ran(loop, begun(name, at_s), seconds)
    return loop, state, columns


def tripped(columns: Columns) -> set[Condition]:
    return set(decode_trips(int(columns["verdict.trips"][-1])))


def first_s(holds: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]) -> float:
    """Time from the fault to the first tick at which something holds; infinite for never."""
    return float(np.argmax(holds)) * DT_S if np.any(holds) else float("inf")


def out_s(name: str, columns: Columns) -> float:
    """Time from the fault until the tip is out of the tube for good."""
    inside = columns["truth.tip_mm"] > -prepared(name).rig.machine.patient.tube_length_mm
    return float(inside.size - np.argmax(inside[::-1])) * DT_S if np.any(inside) else 0.0


def fault(code: Fault, strength: float = 0.0) -> Change:
    """The patient with a fault."""
    effect = ROWS[code].effect
    assert isinstance(effect, PatientEffect)

    def change(patient: Patient) -> Patient:
        return effect.change(patient, strength)

    change.__name__ = f"{code.title}={strength:g}"
    return change


def probe_off(patient: Patient) -> Patient:
    """The oximeter's probe has come off."""
    return patient._replace(monitor=patient.monitor._replace(probe_on=False))


disconnected = fault(Fault.CIRCUIT_DISCONNECTED)
overpressure = fault(Fault.VENTILATOR_PRESSURE, 3.0)
no_ventilation = fault(Fault.VENTILATOR_PRESSURE, 0.0)
no_compensation = fault(Fault.LUNG_VOLUME_LOST, 0.0)
bradycardia = fault(Fault.BRADYCARDIA, 0.8)
desaturating = fault(Fault.DESATURATION, 0.7)
unlinked = fault(Fault.MONITOR_LOST)


WITHDRAWAL_S = {"adult-icu": 4.0, "child-10kg": 3.0, "neonate": 3.0}
"""From the trip until the tip is out: the gap and the way at the head's planned speed."""
WRONG: dict[Change, tuple[set[Condition], float]] = {
    # After 0.3 s the pressure is too low, after 1 s it is known why.
    disconnected: ({Condition.LUNG_VOLUME_LOST, Condition.CIRCUIT_DISCONNECTED}, 1.05),
    # With the valve closed the same pressure is the ventilation's failure.
    no_ventilation: (
        {
            Condition.LUNG_VOLUME_LOST,
            Condition.CIRCUIT_DISCONNECTED,
            Condition.AIRWAY_PRESSURE_UNSAFE,
        },
        3.2,
    ),
    # Too much shows in the next inspiration, of which a cough might be 0.6 s.
    overpressure: ({Condition.AIRWAY_PRESSURE_UNSAFE}, 3.7),
    # The tone rises, the average follows, the rate stays low for a second.
    bradycardia: ({Condition.HEART_RATE_LOW}, 5.0),
}
"""What each fault is taken for, and the longest time from the fault to the trip."""


@pytest.mark.requirement("OS-R38")
@pytest.mark.parametrize("name", PROTOCOLS)
@pytest.mark.parametrize("change", WRONG)
def test_a_fault_of_the_patient_during_suction_ends_it(name: str, change: Change) -> None:
    """Or the cycle is over before: a child's suction lasts two seconds."""
    codes, within_s = WRONG[change]
    _, state, columns = broken(name, change, begins_s(name, Phase.SUCTIONING) + 0.2)
    conditions = columns["verdict.patient"].astype(np.int64)
    known_s = min(first_s(conditions >> int(code) & 1 == 1) for code in codes)
    assert known_s <= within_s
    assert out_s(name, columns) <= within_s + WITHDRAWAL_S[name]
    trips = tripped(columns)
    assert trips <= codes
    if name == "adult-icu":
        assert trips
    if trips:
        assert state.controller.core.procedure.phase == Phase.HALTED
        # Suction off in the tick of the trip, and the valve closes.
        after = columns["verdict.trips"] > 0.0
        assert first_s(after) == pytest.approx(known_s)
        assert not np.any(columns["commands.pump_on"][after])
        assert columns["truth.valve_open_ratio"][-1] == 0.0


def test_suction_that_takes_more_than_the_ventilator_gives_ends() -> None:
    """An adult's: what 6 Fr takes of a child is too little to empty its lung."""
    at_s = begins_s("adult-icu", Phase.SUCTIONING) + 0.2
    _, _, columns = broken("adult-icu", no_compensation, at_s)
    assert tripped(columns) == {Condition.LUNG_VOLUME_LOST}
    trip_s = first_s(columns["verdict.trips"] > 0.0)
    assert trip_s <= 4.1  # within the first breath
    assert out_s("adult-icu", columns) <= trip_s + WITHDRAWAL_S["adult-icu"]
    assert columns["truth.lung_volume_loss_ml"].max() < 600.0


@pytest.mark.parametrize("name", PROTOCOLS)
@pytest.mark.parametrize("change", [unlinked, probe_off])
def test_a_monitor_lost_during_suction_ends_no_cycle_but_refuses_the_next(
    name: str, change: Change
) -> None:
    loop, state, columns = broken(name, change, begins_s(name, Phase.SUCTIONING) + 0.2)
    assert tripped(columns) == set()
    assert state.controller.core.procedure.phase == Phase.PARKED
    assert decode_trips(int(columns["verdict.patient"][-1])) == [Condition.MONITOR_LINK_LOST]
    state, columns = ran(loop, state, 0.1, START)
    assert state.controller.core.upkeep.refusal == Refusal.MONITOR_LINK_LOST
    assert set(columns["phase"]) == {Phase.PARKED}


@pytest.mark.requirement("OS-R38")
def test_a_monitor_lost_before_the_catheter_is_in_keeps_it_out() -> None:
    _, state, columns = broken("child-10kg", unlinked, 0.1)
    first = columns["verdict.trips"][np.argmax(columns["verdict.trips"] > 0.0)]
    # Others may follow: a stop from 34 mm/s overshoots by more than what counts as a runaway.
    assert decode_trips(int(first)) == [Condition.MONITOR_LINK_LOST]
    assert out_s("child-10kg", columns) == 0.0
    assert state.controller.core.procedure.phase == Phase.HALTED


@pytest.mark.parametrize("name", PROTOCOLS)
def test_a_desaturation_is_seen_late_and_ends_the_cycle_it_falls_into(name: str) -> None:
    ready = prepared(name)
    machine = ready.loop.machine
    loop = ready.loop._replace(machine=machine._replace(patient=desaturating(machine.patient)))
    # At rest it is shown and refuses a start; it trips nothing.
    state, columns = ran(loop, ready.start, 60.0)
    low = columns["verdict.patient"] > 0.0
    late_s = first_s(low)
    assert late_s > machine.patient.oximeter.delay_samples * patient_monitor.SAMPLE_S
    assert tripped(columns) == set()
    state, columns = ran(loop, state, 0.1, START)
    assert state.controller.core.upkeep.refusal == Refusal.PATIENT_UNSAFE
    assert set(columns["phase"]) == {Phase.PARKED}
    # Begun before the cycle so that it shows during suction.
    state, _ = ran(loop, ready.start, late_s - begins_s(name, Phase.SUCTIONING) - 0.5)
    state, columns = ran(loop, state, 40.0, START)
    assert tripped(columns) == {Condition.SPO2_LOW}
    trip_s = first_s(columns["verdict.trips"] > 0.0)
    assert Phase.SUCTIONING in columns["phase"][: round(trip_s / DT_S)]
    assert out_s(name, columns) <= trip_s + WITHDRAWAL_S[name]
    assert state.controller.core.procedure.phase == Phase.HALTED


@pytest.mark.parametrize(
    "seeds",
    [range(100, 102), pytest.param(range(102, 120), marks=pytest.mark.soak)],
    ids=["two", "more"],
)
@pytest.mark.parametrize("name", [*PROTOCOLS, "adult-ards"])
def test_no_drawn_patient_is_taken_for_one_in_danger(name: str, seeds: range) -> None:
    """Drawn patients of each preset, in a cycle and for a minute and a half after it.

    On one machine and its plan: they differ in what the monitor shows, not in where the tip goes.
    """
    ready = prepared(name)
    for seed in seeds:
        person = patient_preset.quiet(patient_preset.patient(name, seed))
        own = ready.loop.machine.patient
        person = person._replace(carina_mm=own.carina_mm, secretion=own.secretion)
        machine = ready.loop.machine._replace(patient=person)
        breathing = patient_preset.at_rest(person)
        start = ready.start._replace(
            bedside=ready.start.bedside._replace(patient=breathing),
        )
        loop = ready.loop._replace(machine=machine)
        _, columns = ran(loop, start, 120.0, START)
        assert tripped(columns) == set(), seed
        assert not np.any(columns["verdict.patient"]), seed
        assert Phase.SUCTIONING in columns["phase"], seed
