"""Something goes wrong with the patient during suction: what notices, and how soon it is over.

The machine of the twin is exchanged for one with the fault at an instant of a running cycle.
"""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from opensuction.evidence import cycle_run
from opensuction.evidence.cycle_choice import Choice
from opensuction.evidence.cycle_run import Prepared
from opensuction.kernel.phase import Phase
from opensuction.kernel.requests import NO_REQUESTS, START, Requests
from opensuction.safety.trip import Trip, names
from opensuction.simulation import closed_loop, trace
from opensuction.simulation.closed_loop import DT_S, Loop, LoopState
from opensuction.simulation.trace import Columns
from opensuction.twin import patient_fault
from opensuction.twin.patient import Patient

PROTOCOLS = {"adult-icu": "adult", "child-10kg": "paediatric", "neonate": "paediatric"}
Change = Callable[[Patient], Patient]


@cache
def prepared(name: str, seed: int = 1) -> Prepared:
    return cycle_run.prepare(
        Choice(None, PROTOCOLS[name], "travel", "exact-inverse", seed, patient=name)
    )


@cache
def begins_s(name: str, phase: Phase) -> float:
    """When a phase of the healthy cycle begins."""
    columns = cycle_run.play(prepared(name), lambda _: None)
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
    return state, trace.by_name(table)


def broken(
    name: str, change: Change, at_s: float, seconds: float = 25.0
) -> tuple[Loop, LoopState, Columns]:
    """A cycle in which the patient changes at an instant; the trace from there on."""
    ready = prepared(name)
    state, _ = ran(ready.loop, ready.start, at_s, START)
    machine = ready.loop.machine
    loop = ready.loop._replace(machine=machine._replace(patient=change(machine.patient)))
    state, columns = ran(loop, state, seconds)
    return loop, state, columns


def tripped(columns: Columns) -> set[Trip]:
    return set(names(int(columns["verdict.trips"][-1])))


def first_s(holds: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]) -> float:
    """Time from the fault to the first tick at which something holds; infinite for never."""
    return float(np.argmax(holds)) * DT_S if np.any(holds) else float("inf")


def out_s(name: str, columns: Columns) -> float:
    """Time from the fault until the tip is out of the tube for good."""
    inside = columns["truth.tip_mm"] > -prepared(name).rig.machine.patient.tube_length_mm
    return float(inside.size - np.argmax(inside[::-1])) * DT_S if np.any(inside) else 0.0


def disconnected(patient: Patient) -> Patient:
    return patient_fault.disconnected(patient)


def overpressure(patient: Patient) -> Patient:
    return patient_fault.mispressured(patient, 3.0)


def underpressure(patient: Patient) -> Patient:
    return patient_fault.mispressured(patient, 0.0)


def no_compensation(patient: Patient) -> Patient:
    return patient_fault.flow_limited(patient, 0.0)


def bradycardia(patient: Patient) -> Patient:
    return patient_fault.vagal(patient, 0.8)


WITHDRAWAL_S = {"adult-icu": 4.0, "child-10kg": 3.0, "neonate": 3.0}
"""From the trip until the tip is out: the way at the head's planned speed, with the gap."""


@pytest.mark.parametrize("name", PROTOCOLS)
@pytest.mark.parametrize(
    ("change", "code", "within_s"),
    [
        (disconnected, Trip.CIRCUIT_DISCONNECTED, 1.05),
        # Too much shows in the next inspiration.
        (overpressure, Trip.AIRWAY_PRESSURE_UNSAFE, 3.2),
        (bradycardia, Trip.HEART_RATE_LOW, 6.0),
    ],
)
def test_a_fault_of_the_patient_during_suction_ends_it(
    name: str, change: Change, code: Trip, within_s: float
) -> None:
    _, state, columns = broken(name, change, begins_s(name, Phase.SUCTIONING) + 0.2)
    assert tripped(columns) == {code}
    trip_s = first_s(columns["verdict.trips"] > 0.0)
    assert trip_s <= within_s
    assert out_s(name, columns) <= trip_s + WITHDRAWAL_S[name]
    # No vacuum is asked for any more, and the valve closes.
    assert not np.any(columns["commands.pump_on"][round(trip_s / DT_S) + 1 :])
    assert columns["truth.valve_open_ratio"][-1] == 0.0
    assert state.controller.procedure.phase == Phase.HALTED
