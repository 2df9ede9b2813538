"""Controller and twin in a closed loop, a row of trace for each tick."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.controller import controller
from opensuction.controller.record import Inputs, Outputs, Settings, State
from opensuction.kernel import row
from opensuction.kernel.commands import Commands
from opensuction.kernel.compiled import compiled
from opensuction.kernel.phase import RESTING
from opensuction.kernel.readings import Readings
from opensuction.kernel.requests import NO_REQUESTS, Host, Requests
from opensuction.procedure.cycle.cycle import Demand
from opensuction.safety.alarm.alarm_state import Signals
from opensuction.safety.governor.governor import Verdict
from opensuction.twin import plant
from opensuction.twin.bedside import BedsideState
from opensuction.twin.machine import machine
from opensuction.twin.machine.machine import Machine, MachineState, Truth

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
    bedside: BedsideState


class TraceRow(NamedTuple):
    """What is recorded of a tick: read, wanted, let through, commanded, signalled; the truth."""

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
    signals: Signals
    truth: Truth


COLUMNS = row.columns(TraceRow)
"""Columns of the trace, in order."""
_write = row.writer(TraceRow)


@compiled
def _inputs(loop: Loop, tick: int, body: MachineState, requests: Requests) -> Inputs:
    return Inputs(
        tick=tick,
        dt_s=DT_S,
        readings=machine.read(loop.machine, body),
        requests=requests,
        host=Host(overrun=False, conditions=0),
    )


@compiled
def _record(
    loop: Loop, inputs: Inputs, body: MachineState, outputs: Outputs, signals: Signals
) -> TraceRow:
    """The row of a tick; ``body``: before the machine moved."""
    return TraceRow(
        time_s=inputs.tick * DT_S,
        phase=outputs.phase,
        cause=outputs.cause,
        check_item=outputs.check_item,
        check_failed=outputs.check_failed,
        readings=inputs.readings,
        demand=outputs.demand,
        verdict=outputs.verdict,
        commands=outputs.commands,
        signals=signals,
        truth=machine.truth(loop.machine, body),
    )


@compiled
def step(loop: Loop, state: LoopState, requests: Requests) -> tuple[LoopState, TraceRow]:
    """One tick: read, decide, act. The row holds what was read before the machine moved."""
    inputs = _inputs(loop, state.tick, state.machine, requests)
    decided, outputs = controller.step(loop.controller, state.controller, inputs)
    record = _record(loop, inputs, state.machine, outputs, outputs.signals)
    moved = machine.step(loop.machine, state.machine, outputs.commands, DT_S)
    bedside = state.bedside
    if plant.is_due(moved):
        moved, bedside = plant.settle(loop.machine, moved, bedside, DT_S)
    return LoopState(state.tick + 1, decided, moved, bedside), record


@compiled
def run(
    loop: Loop, state: LoopState, requests: Requests, trace: npt.NDArray[np.float64]
) -> tuple[LoopState, int]:
    """Run until the trace is full or the machine comes to rest.

    requests: pressed in the first tick only. trace: shape (ticks, columns), written row by row.
    Returns the state and how many rows were written; it stops early after the first tick at rest
    (parked or halted) that follows a tick of activity. Run in pieces it gives the same rows.
    """
    active = state.controller.procedure.phase not in RESTING
    tick, body, bedside = state.tick, state.machine, state.bedside
    # What moves and what is told are carried apart: alarms are touched only when there are some.
    memory, led = controller.memory(state.controller), state.controller.compensation
    alarms = state.controller.alarms
    done, at_rest = 0, False
    while done < trace.shape[0] and not at_rest:
        # Ticks up to the bedside's next step: an inner loop that does not carry its state.
        while done < trace.shape[0] and not at_rest and not plant.is_due(body):
            inputs = _inputs(loop, tick, body, requests)
            memory, led, outputs, wrong = controller.act(loop.controller, memory, led, inputs)
            alarms, signals = controller.announce(
                loop.controller, alarms, wrong, outputs.phase, requests, DT_S
            )
            record = _record(loop, inputs, body, outputs, signals)
            _write(trace[done], record)
            body = machine.step(loop.machine, body, outputs.commands, DT_S)
            requests = NO_REQUESTS
            tick += 1
            done += 1
            at_rest = active and record.phase in RESTING
            active = record.phase not in RESTING
        if plant.is_due(body):
            body, bedside = plant.settle(loop.machine, body, bedside, DT_S)
    return LoopState(tick, controller.joined(memory, led, alarms), body, bedside), done
