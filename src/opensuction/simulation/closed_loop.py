"""Controller and twin in a closed loop, a row of trace for each tick.

Between the two lies a link with drives that watch over it (`opensuction.twin.fault.link`,
`fail_safe`). It is played only where a fault of sensors, messages, power or controller is
injected; while no controller runs, the rows say that the machine has halted.

Time between cycles, the machine at rest: the patient breathes and secretions gather.

Nothing of the machine moves, so its thousand ticks a second need not be played: only the bedside
steps, at its own 100 Hz. The patient ends where the closed loop, parked for as long, would have
brought them. What of the machine settles by itself within seconds is not followed: the catheter
creeps by tenths of a millimetre more, and the tip stays where it is.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.control.compensation import Branches
from opensuction.controller import controller
from opensuction.controller.record import Inputs, Outputs, Settings, State
from opensuction.kernel.codegen import row
from opensuction.kernel.compiled import compiled
from opensuction.kernel.compiler.dispatcher import TypedCall
from opensuction.kernel.interface import NO_REQUESTS, Commands, Host, Readings, Requests
from opensuction.kernel.vocabulary import RESTING, Phase
from opensuction.procedure.cycle.demand import Demand
from opensuction.procedure.cycle.interlocks import Counters
from opensuction.safety.alarm.alarm_state import Signals
from opensuction.safety.governor.governor import Verdict
from opensuction.simulation.wiring import (
    HEALTHY,
    Between,
    Exchange,
    Messages,
    Passed,
    Wiring,
    command_drives,
    keep,
    recall,
    receive,
    wanted,
)
from opensuction.twin import bedside, plant
from opensuction.twin.bedside import BedsideState
from opensuction.twin.coupling import TICKS
from opensuction.twin.fault import link
from opensuction.twin.machine import fail_safe, machine, suction_line
from opensuction.twin.machine.fail_safe import Annunciator
from opensuction.twin.machine.machine import Machine, MachineState, Truth

DT_S = 0.001
"""One tick: controller, axes, transmission, tip and line run at 1 kHz."""


class Loop(NamedTuple):
    """Both sides of the loop."""

    controller: Settings
    heads_mm: Branches | None
    """Branches of the compensation's curves; they go with the controller's settings."""
    machine: Machine


class LoopState(NamedTuple):
    """Both sides' state and the number of ticks done."""

    tick: int
    controller: State
    machine: MachineState
    bedside: BedsideState


class TraceRow(NamedTuple):
    """Record of a tick: read, wanted, let through, commanded, signalled; the truth."""

    time_s: float
    phase: int
    cause: int
    """Event that led into the phase."""
    check_item: int
    """Item of the pre-use test that is being tested."""
    check_failed: int
    """Item of the last pre-use test that failed."""
    readings: Readings
    """As the controller gets them."""
    demand: Demand
    verdict: Verdict
    commands: Commands
    """As the drives obey them."""
    signals: Signals
    truth: Truth
    annunciator: Annunciator
    """What people are told at the bedside, with or without a controller."""
    counters: Counters
    """Of passes, rest and resets; see `interlocks`."""


COLUMNS = row.columns(TraceRow)
"""Columns of the trace, in order."""
write_row = row.writer(TraceRow)
_write_row_of = row.table_writer(TraceRow)


@compiled
def record(
    time_s: float,
    phase: int,
    readings: Readings,
    outputs: Outputs,
    commands: Commands,
    truth: Truth,
    shown: Annunciator,
) -> TraceRow:
    """The row of a tick. truth: before the machine moved."""
    return TraceRow(
        time_s=time_s,
        phase=phase,
        cause=outputs.cause,
        check_item=outputs.check_item,
        check_failed=outputs.check_failed,
        readings=readings,
        demand=outputs.demand,
        verdict=outputs.verdict,
        commands=commands,
        signals=outputs.signals,
        truth=truth,
        annunciator=shown,
        counters=outputs.counters,
    )


class _Sides(NamedTuple):
    """Settings of a tick, without an array: a reference to one is counted at every hand."""

    controller: Settings
    machine: Machine
    wiring: Wiring


class _SidesState(NamedTuple):
    """State that a tick changes; the bedside stands still."""

    tick: int
    controller: State
    machine: MachineState


@compiled
def _tick(
    sides: _Sides,
    heads_mm: Branches | None,
    state: _SidesState,
    requests: Requests,
    between: Between | None,
) -> tuple[_SidesState, int, TraceRow, Passed | None]:
    """One tick: read, decide, act. between: both sides, where the link is played.

    Returns the state after it, the controller's phase, what is recorded, with the truth before the
    machine moved, and what is left of the link where it is played.
    """
    tick, wires = state.tick, sides.wiring.link
    reported = machine.read(sides.machine, state.machine)
    truth = machine.truth(sides.machine, state.machine)
    readings, runs, late = reported, True, False
    if between is not None:
        reported = link.sense(wires, reported, tick)
        readings = receive(wires, between, reported, tick)
        runs, late = wires.controller_runs, tick < wires.late_until_tick
    decided = state.controller
    if between is not None and not runs:
        outputs = between.linked.outputs
    else:
        host = Host(overrun=late, conditions=0)
        inputs = Inputs(tick=tick, dt_s=DT_S, readings=readings, requests=requests, host=host)
        decided, outputs = controller.step(sides.controller, heads_mm, decided, inputs)
    commands, shown, passed = outputs.commands, fail_safe.repeat(wanted(outputs)), None
    if between is not None:
        now = Exchange(reported, readings, outputs, requests.reset, tick)
        commands, passed = command_drives(sides.wiring, between, now, DT_S)
        shown = passed.linked.annunciator
    moved = machine.step(sides.machine, state.machine, commands, DT_S)
    phase = outputs.phase if runs else Phase.HALTED
    seen = record(tick * DT_S, phase, readings, outputs, commands, truth, shown)
    return _SidesState(tick + 1, decided, moved), outputs.phase, seen, passed


@compiled
def _run(
    loop: Loop,
    wiring: Wiring,
    state: LoopState,
    requests: Requests,
    trace: npt.NDArray[np.float64],
    messages: Messages | None,
) -> tuple[LoopState, int]:
    """`run`, as machine code."""
    sides, heads_mm = _Sides(loop.controller, loop.machine, wiring), loop.heads_mm
    now, bedside = _SidesState(state.tick, state.controller, state.machine), state.bedside
    active = state.controller.core.procedure.phase not in RESTING
    done, at_rest = 0, False
    between = None
    while done < trace.shape[0] and not at_rest:
        # Ticks up to the bedside's next step: an inner loop that does not carry its state.
        while done < trace.shape[0] and not at_rest and not plant.is_due(now.machine):
            if messages is not None:
                between = recall(wiring.link, messages, now.tick)
            now, phase, seen, passed = _tick(sides, heads_mm, now, requests, between)
            if messages is not None:
                keep(messages, passed, now.tick - 1)
            _write_row_of(trace, done, seen)
            requests = NO_REQUESTS
            done += 1
            at_rest = active and phase in RESTING
            active = phase not in RESTING
        if plant.is_due(now.machine):
            moved, bedside = plant.settle(loop.machine, now.machine, bedside, DT_S)
            now = now._replace(machine=moved)
    return LoopState(now.tick, now.controller, now.machine, bedside), done


def _kind(loop: Loop, *_: object) -> bool:
    return loop.heads_mm is None


_play = TypedCall(_run, _kind)


def run(
    loop: Loop,
    state: LoopState,
    requests: Requests,
    trace: npt.NDArray[np.float64],
    wiring: Wiring = HEALTHY,
    messages: Messages | None = None,
) -> tuple[LoopState, int]:
    """Run until the trace is full or the machine comes to rest.

    requests: pressed in the first tick only. trace: shape (ticks, columns), written row by row.
    wiring, messages: what lies between the two sides, and what it remembers; played where there
    are messages. Returns the state and how many rows were written; it stops early after the first
    tick at rest (parked or halted) that follows a tick of activity. Run in pieces it gives the
    same rows. Raises TypeError where the trace is not a table of doubles, row after row,
    with all columns.
    """
    if trace.dtype != np.float64 or not trace.flags.c_contiguous:
        raise TypeError(f"trace: {trace.dtype} {trace.strides}, should be rows of doubles")
    if trace.shape[1] != len(COLUMNS):
        raise TypeError(f"trace: {trace.shape[1]} columns, should be {len(COLUMNS)}")
    return _play(loop, wiring, state, requests, trace, messages)


STEP_S = TICKS * DT_S
"""Time passes in steps of the bedside."""


class Worst(NamedTuple):
    """Worst values of a patient's signs."""

    spo2_percent: float
    """Least saturation."""
    lung_volume_loss_ml: float
    """Most volume lost, less what the patient's own muscles take."""


@compiled
def _stand(
    twin: Machine, state: MachineState, around: BedsideState, steps: int
) -> tuple[MachineState, BedsideState, Worst]:
    """Steps of the bedside beside a machine that stands, and the worst signs before and in them."""
    tip_mm, coupling = state.airway.tip_mm, state.coupling
    least, most_ml = coupling.signs.spo2_percent, coupling.signs.relaxed_loss_ml
    for _ in range(steps):
        around = bedside.step(twin, around, coupling, tip_mm, DT_S)
        coupling = bedside.couple(twin, around, tip_mm)
        least = min(least, coupling.signs.spo2_percent)
        most_ml = max(most_ml, coupling.signs.relaxed_loss_ml)
    left = state._replace(
        # Pump off, valve closed, air let in: of the machine only the line changes.
        line=suction_line.step(twin.line, state.line, False, 0.0, 0.0, 0.0, steps * STEP_S),
        # As far between two steps of the bedside as before.
        coupling=coupling._replace(
            ticks=state.coupling.ticks, gas_ml=0.0, mucus_ml=0.0, from_mm=tip_mm
        ),
    )
    return left, around, Worst(least, most_ml)


_rest = TypedCall(_stand, lambda *_: 0)


def find_worst(loop: Loop, state: LoopState, duration_s: float) -> Worst:
    """Worst values of a patient's signs in a time at rest; arguments as of `pass_time`."""
    steps = round(duration_s / STEP_S)
    return _rest(loop.machine, state.machine, state.bedside, steps)[2]


def pass_time(loop: Loop, state: LoopState, duration_s: float) -> LoopState:
    """The closed loop after a time at rest; for a machine that is parked.

    duration_s: rounded to steps of the bedside (10 ms). Its tick goes on, so that time does; the
    controller's clocks are its caller's to move (`upkeep.pass_idle_time`). Mucus in
    the bore stays there.
    """
    steps = round(duration_s / STEP_S)
    if steps < 1:
        return state
    moved, around, _ = _rest(loop.machine, state.machine, state.bedside, steps)
    return state._replace(tick=state.tick + steps * TICKS, machine=moved, bedside=around)
