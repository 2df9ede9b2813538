"""Controller and twin in a closed loop, a row of trace for each tick."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.controller import controller
from opensuction.controller.controller import Inputs, Settings, State
from opensuction.kernel import row
from opensuction.kernel.commands import Commands
from opensuction.kernel.compiled import compiled
from opensuction.kernel.phase import Phase
from opensuction.kernel.readings import Readings
from opensuction.kernel.requests import NO_REQUESTS, Host, Requests
from opensuction.procedure.cycle import Demand
from opensuction.safety.governor import Verdict
from opensuction.twin import machine
from opensuction.twin.machine import Machine, MachineState, Observation

DT_S = 0.001
"""One tick: controller, axes, transmission, tip and line run at 1 kHz."""


class Loop(NamedTuple):
    """Both sides of the loop."""

    controller: Settings
    machine: Machine


class LoopState(NamedTuple):
    """Both sides' state and the number of ticks done."""

    tick: int
    controller: State
    machine: MachineState


class TraceRow(NamedTuple):
    """What is recorded of a tick: what was read, wanted, let through and commanded; the truth."""

    time_s: float
    phase: int
    cause: int
    """Event that led into the phase."""
    check_item: int
    """Item of the pre-use test that is being tested."""
    check_failed: int
    """Item of the last pre-use test that failed."""
    readings: Readings
    demand: Demand
    verdict: Verdict
    commands: Commands
    truth: Observation


COLUMNS = row.columns(TraceRow)
"""Columns of the trace, in order."""
_write = row.writer(TraceRow)


@compiled
def step(loop: Loop, state: LoopState, requests: Requests) -> tuple[LoopState, TraceRow]:
    """One tick: read, decide, act. The row holds what was read before the machine moved."""
    readings = machine.read(loop.machine, state.machine)
    inputs = Inputs(
        tick=state.tick,
        dt_s=DT_S,
        readings=readings,
        requests=requests,
        host=Host(overrun=False),
    )
    truth = machine.observe(loop.machine, state.machine)
    decided, outputs = controller.step(loop.controller, state.controller, inputs)
    moved = machine.step(loop.machine, state.machine, outputs.commands, DT_S)
    record = TraceRow(
        time_s=state.tick * DT_S,
        phase=outputs.phase,
        cause=outputs.cause,
        check_item=outputs.check_item,
        check_failed=outputs.check_failed,
        readings=readings,
        demand=outputs.demand,
        verdict=outputs.verdict,
        commands=outputs.commands,
        truth=truth,
    )
    return LoopState(tick=state.tick + 1, controller=decided, machine=moved), record


@compiled
def is_resting(phase: int) -> bool:
    """Whether a phase waits for a person."""
    return (
        phase == Phase.PARKED.value
        or phase == Phase.HALTED.value
        or phase == Phase.OUT_OF_SERVICE.value
    )


@compiled
def run(
    loop: Loop, state: LoopState, requests: Requests, trace: npt.NDArray[np.float64]
) -> tuple[LoopState, int]:
    """Run until the trace is full or the machine comes to rest.

    requests: pressed in the first tick only. trace: shape (ticks, columns), written row by row.
    Returns the state and how many rows were written; it stops early after the first tick at rest
    (parked or halted) that follows a tick of activity. Run in pieces it gives the same rows.
    """
    active = not is_resting(state.controller.procedure.phase)
    for i in range(trace.shape[0]):
        state, record = step(loop, state, requests)
        requests = NO_REQUESTS
        _write(trace[i], record)
        resting = is_resting(record.phase)
        if active and resting:
            return state, i + 1
        active = not resting
    return state, trace.shape[0]
