"""The closed loop with a fault in its sensors, drives or host, and people at its buttons.

The same two halves as `opensuction.simulation.closed_loop`, with a place in between where what is
read and what is driven can be falsified.
"""

from enum import IntEnum
from functools import cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from opensuction.control.compensation import CompensationKind
from opensuction.controller import controller
from opensuction.controller.record import Inputs
from opensuction.kernel.compiled import as_python, compiled
from opensuction.kernel.interface import NO_REQUESTS, Commands, Host, Readings, Requests
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.planning.protocol import PAPER
from opensuction.simulation import closed_loop, trace
from opensuction.simulation import rig as rigs
from opensuction.simulation.closed_loop import COLUMNS, DT_S, Loop, LoopState, record, write_row
from opensuction.simulation.rig import Identification, Rig
from opensuction.simulation.trace import Columns
from opensuction.simulation.wiring import wanted
from opensuction.twin import plant
from opensuction.twin.machine import fail_safe, machine
from opensuction.twin.machine.machine import MachineState
from tests.columns_of_rows import ColumnsOfRows

START, IDENTIFY, ABORT, RESET = 1, 2, 4, 8
TEACH, CONFIRM, HOME = 16, 32, 64
SERVICE, CHANGED, RETURN_TO_SERVICE, NOT_NEEDED = 128, 256, 512, 1024
ACKNOWLEDGE, AUDIO_PAUSE = 2048, 4096
ASSESSED, OXYGENATED, OXYGEN_SKIPPED = 8192, 16384, 32768
"""Buttons, as bits."""

NAN = float("nan")


class Fault(IntEnum):
    """What goes wrong."""

    NONE = 0
    HEAD_FLAGGED = 1
    """Marked invalid, and a number that looks like the park position."""
    HEAD_NAN = 2
    HEAD_FROZEN = 3
    CAM_FLAGGED = 4
    CAM_NAN = 5
    VACUUM_FLAGGED = 6
    VACUUM_HIGH = 7
    CONTACT_CLOSED = 8
    CONTACT_BOUNCING = 9
    """Closed two ticks in three."""
    CONTACT_FLAGGED = 10
    OVERRUN = 11
    HEAD_JAMMED = 12
    DRIVE_INWARDS = 13
    """The amplifier gives full voltage inwards whenever its torque is on."""
    VALVE_OPEN = 14
    """The valve's mechanism is stuck open."""
    CAM_FROZEN = 15
    PUMP_DEAD = 16
    HEAD_BLIND = 17
    """Both sensors of the head marked invalid."""


class When(NamedTuple):
    """Which fault, from which tick to before which."""

    fault: int
    start: int
    end: int


NEVER = When(fault=0, start=0, end=0)


@compiled
def _read(fault: int, tick: int, before: Readings, true: Readings) -> Readings:
    """What the sensors report under a fault; ``before`` is what they reported last."""
    head, cam = true.head_mm, true.cam_rad
    vacuum, contact = true.line_vacuum_mmhg, true.contact_closed
    if fault == Fault.HEAD_FLAGGED:
        head = 0.0
    if fault == Fault.HEAD_NAN:
        head = NAN
    if fault == Fault.HEAD_FROZEN:
        head = before.head_mm
    if fault == Fault.CAM_FLAGGED:
        cam = -1.0e3
    if fault == Fault.CAM_NAN:
        cam = NAN
    if fault == Fault.CAM_FROZEN:
        cam = before.cam_rad
    if fault == Fault.VACUUM_HIGH:
        vacuum = 400.0
    if fault == Fault.CONTACT_CLOSED:
        contact = True
    if fault == Fault.CONTACT_BOUNCING:
        contact = tick % 3 > 0
    return true._replace(
        head_mm=head,
        head_valid=fault not in (Fault.HEAD_FLAGGED, Fault.HEAD_BLIND),
        carriage_valid=fault != Fault.HEAD_BLIND,
        cam_rad=cam,
        cam_valid=fault != Fault.CAM_FLAGGED,
        line_vacuum_mmhg=vacuum,
        vacuum_valid=fault != Fault.VACUUM_FLAGGED,
        contact_closed=contact,
        contact_valid=fault != Fault.CONTACT_FLAGGED,
    )


@compiled
def _drive(fault: int, wanted: Commands) -> Commands:
    """What reaches the actuators under a fault."""
    volts = wanted.insertion_v
    if fault == Fault.DRIVE_INWARDS and wanted.insertion_on:
        volts = 24.0
    return wanted._replace(insertion_v=volts, pump_on=wanted.pump_on and fault != Fault.PUMP_DEAD)


@compiled
def _break(fault: int, before: MachineState, after: MachineState) -> MachineState:
    """Mechanics under a fault."""
    if fault == Fault.HEAD_JAMMED:
        return after._replace(
            insertion=before.insertion,
            head_mm=before.head_mm,
            transmission=before.transmission,
            airway=before.airway,
        )
    if fault == Fault.VALVE_OPEN:
        return after._replace(valve=before.valve)
    return after


@compiled
def _requests(pressed: int) -> Requests:
    """What the buttons ask for."""
    return Requests(
        start=pressed & 1 != 0,
        identify=pressed & 2 != 0,
        abort=pressed & 4 != 0,
        reset=pressed & 8 != 0,
        teach=pressed & 16 != 0,
        confirm=pressed & 32 != 0,
        home=pressed & 64 != 0,
        service=pressed & 128 != 0,
        changed=pressed & 256 != 0,
        return_to_service=pressed & 512 != 0,
        not_needed=pressed & 1024 != 0,
        acknowledge=pressed & 2048 != 0,
        audio_pause=pressed & 4096 != 0,
        assessed=pressed & 8192 != 0,
        oxygenated=pressed & 16384 != 0,
        oxygen_skipped=pressed & 32768 != 0,
    )


@compiled
def _run(
    loop: Loop,
    state: LoopState,
    buttons: NDArray[np.int64],
    when: When,
    table: NDArray[np.float64],
) -> LoopState:
    """`run`, as machine code."""
    before = machine.read(loop.machine, state.machine)
    for i in range(buttons.size):
        fault = when.fault if when.start <= i < when.end else 0
        readings = _read(fault, i, before, machine.read(loop.machine, state.machine))
        before = readings
        requests = _requests(buttons[i])
        host = Host(overrun=fault == Fault.OVERRUN, conditions=0)
        truth = machine.truth(loop.machine, state.machine)
        inputs = Inputs(state.tick, DT_S, readings, requests, host)
        decided, outputs = controller.step(loop.controller, loop.heads_mm, state.controller, inputs)
        commands = _drive(fault, outputs.commands)
        moved = _break(
            fault, state.machine, machine.step(loop.machine, state.machine, commands, DT_S)
        )
        bedside = state.bedside
        if plant.is_due(moved):
            moved, bedside = plant.settle(loop.machine, moved, bedside, DT_S)
        shown = fail_safe.repeat(wanted(outputs))
        seen = record(i * DT_S, outputs.phase, readings, outputs, outputs.commands, truth, shown)
        write_row(table[i], seen)
        state = LoopState(state.tick + 1, decided, moved, bedside)
    return state


def _run_undisturbed(
    loop: Loop, state: LoopState, buttons: NDArray[np.int64], table: NDArray[np.float64]
) -> LoopState:
    """The same by the product's loop, in pieces that begin where something is pressed."""
    begins = [0, *(np.flatnonzero(buttons[1:]) + 1).tolist(), buttons.size]
    for done, end in pairwise(begins):
        requests, at = as_python(_requests)(int(buttons[done])), done
        while at < end:
            state, ran = closed_loop.run(loop, state, requests, table[at:end])
            requests, at = NO_REQUESTS, at + ran
    table[:, COLUMNS.index("time_s")] = np.arange(buttons.size) * DT_S
    return state


def run(
    loop: Loop,
    state: LoopState,
    buttons: NDArray[np.int64],
    when: When,
    table: NDArray[np.float64],
) -> LoopState:
    """As many ticks as ``buttons`` has entries; rows hold what was read, fault included.

    A compensation on curves is another kind in machine code, which takes half a minute: without a
    fault the product's loop plays it, whose kinds are there anyway.
    """
    if loop.heads_mm is not None and when == NEVER:
        return _run_undisturbed(loop, state, buttons, table)
    return _run(loop, state, buttons, when, table)


@cache
def rig() -> Rig:
    """The nominal bench."""
    return rigs.rig("bench", 1, nominal=True)


@cache
def identification() -> Identification:
    """The nominal bench, identified."""
    return rigs.identify(rig())


@cache
def at_rest(kind: CompensationKind) -> tuple[Loop, LoopState]:
    """The bench with a calibrated controller, parked."""
    return rigs.assemble(rig(), PAPER, kind, identification().calibration, run=2)


def simulate(
    kind: CompensationKind,
    seconds: float,
    pressed: dict[float, int],
    when: When = NEVER,
    start: LoopState | None = None,
    loop: Loop | None = None,
) -> tuple[LoopState, Columns]:
    """Run for a time with buttons pressed at some instants (s); returns state and trace."""
    nominal, parked = at_rest(kind)
    loop = nominal if loop is None else loop
    buttons = np.zeros(round(seconds / DT_S), dtype=np.int64)
    for time_s, bits in pressed.items():
        buttons[round(time_s / DT_S)] |= bits
    table = np.zeros((buttons.size, len(COLUMNS)))
    state = run(loop, parked if start is None else start, buttons, when, table)
    return state, ColumnsOfRows(table)


def during(fault: Fault, start_s: float, end_s: float = 1e6) -> When:
    """A fault from one instant to before another."""
    return When(int(fault), round(start_s / DT_S), round(end_s / DT_S))


def phases(columns: Columns) -> list[Phase]:
    """Phases of a run in order."""
    return [span.phase for span in trace.phase_spans(columns)]
