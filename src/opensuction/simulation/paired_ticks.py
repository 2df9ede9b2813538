"""Ticks of a control loop and of the machine that it controls, each at its own instants.

What two processes do tick by tick, in one call: for a stretch of time in which nobody else does
anything, and only as far as neither has more to do than its tick. Both speak through their rings,
as on a computer.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.control.compensation import Branches
from opensuction.controller import loop_tick, real_time_call
from opensuction.controller.loop_tick import NUMBER, TICK, LoopMemory, LoopPace, TickTime
from opensuction.kernel import slot
from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import Array
from opensuction.kernel.slot import Words
from opensuction.simulation import machine_side
from opensuction.simulation.machine_side import MESSAGE, SILENT_TICKS, Heard, Memory

Whole = npt.NDArray[np.int64]

LOOP, MACHINE = 0, 1
"""Who does a tick."""
DEADLINE, SKIPPED, DUE, BUSY = range(4)
"""Places of a clock: deadline of the present tick, ns; ticks that were missed in all; when the next
step begins, ns; until when its process is busy, ns."""
CLOCK = 4
DRAWS = 2
"""Random numbers of a step: of its duration, and of the lateness of the next."""
NS_PER_S = 1e9


class RingEnds(NamedTuple):
    """Both ends of a ring, as each has it in its memory: its header and its slots."""

    header: Words
    """The writer's."""
    slots: Words
    read_header: Words
    read_slots: Words


class LoopSide(NamedTuple):
    """The control loop."""

    settings: Array
    heads_mm: Branches | None
    state: Array
    inputs: Array
    """Those of its memory, as a table of one row; likewise the outputs."""
    outputs: Array
    states: Array
    """A table without rows."""
    row: Array
    memory: LoopMemory
    pace: LoopPace
    readings: Array
    """Part of the inputs."""
    shown_readings: Whole
    """Columns of them in what the machine shows: the first, and the one after the last."""
    look_ticks: int
    """It has more to do in each tick of so many."""


class MachineRow(NamedTuple):
    """The machine."""

    side: Array
    memory: Memory
    shown: Array
    heard: Heard
    look_ticks: int
    """After so many ticks without a message it has more to do."""
    most_missed: int
    """So many ticks it makes up for at most."""


class Stretch(NamedTuple):
    """A stretch of time."""

    clocks: Whole
    """Written; shape (2, `CLOCK`): of the loop and of the machine."""
    periods_ns: Whole
    ends_ns: int
    """Before then only the two do anything."""
    phase_column: int
    """Of the loop's outputs: a stretch ends with the tick in which it changes."""
    looks_ns: int
    """From then on the loop looks for another machine where it finds the same readings again."""
    step_s: Array
    """Longest step, and longest lateness."""
    slow_until_ns: int
    slow: float
    """A step takes up to so many times as long until then."""
    draws: Array
    """Random numbers from 0 to 1, taken in their order."""
    at_ns: Whole
    """Written: when each step began."""
    who: npt.NDArray[np.uint8]
    """Written: `LOOP` or `MACHINE`."""


@compiled
def _begin(clock: Whole, period_ns: int, now_ns: int) -> int:
    """Begin a tick; how many were missed before it (`DeadlineScheduler.begin`)."""
    clock[DEADLINE] += period_ns
    missed: int = max(now_ns - clock[DEADLINE], 0) // period_ns
    clock[DEADLINE] += missed * period_ns
    clock[SKIPPED] += missed
    return missed


@compiled
def _newest(header: Words) -> int:
    newest: int = np.int64(header[slot.NEWEST])  # type: ignore[assignment]
    return newest


@compiled
def _publish(slots: Words, header: Words, row: Array) -> None:
    """Write the next row of a ring."""
    number = np.uint64(_newest(header) + 1)
    slot.write(slots, number, row.view(np.uint64))
    header[slot.NEWEST] = number


@compiled
def _tick_loop(
    loop: LoopSide, from_machine: RingEnds, shown: Words, clock: Whole, period_ns: int
) -> None:
    """A tick of the loop (`ControlLoop.step`). shown: room for a row that the machine shows."""
    now_ns = clock[DUE]
    skipped = _begin(clock, period_ns, now_ns)
    newest = _newest(from_machine.read_header)
    number = slot.read_newest(from_machine.read_slots, newest, 1, shown)
    first, end = loop.shown_readings[0], loop.shown_readings[1]
    loop.readings[:] = shown[first:end].view(np.float64)
    loop_tick.begin(loop.memory, loop.pace, TickTime(clock[DEADLINE], now_ns, skipped, 0.0), number)
    real_time_call.play(
        loop.settings, loop.heads_mm, loop.state, loop.inputs, loop.outputs, loop.states
    )
    loop_tick.conclude(loop.memory, loop.pace, loop.state, False)


@compiled
def _tick_machine(
    machine: MachineRow,
    to_machine: RingEnds,
    from_machine: RingEnds,
    message: Words,
    clock: Whole,
    period_ns: int,
) -> None:
    """A tick of the machine (`twin_process.steps`). message: room for a row of the commands."""
    missed = min(_begin(clock, period_ns, clock[DUE]), machine.most_missed)
    counts = machine.heard.counts
    # One call, for those missed too: each call is the whole twin once more in machine code.
    for left in range(missed, -1, -1):
        new = False
        if left == 0:
            counts[SILENT_TICKS] += 1
            newest = _newest(to_machine.read_header)
            if newest != counts[MESSAGE]:
                slot.read_newest(to_machine.read_slots, newest, 1, message)
                new = machine_side.hear(machine.heard, newest, message.view(np.float64))
        machine_side.step(machine.side, machine.memory, machine.heard.row, new, machine.shown)
        _publish(from_machine.slots, from_machine.header, machine.shown)


@compiled
def _looks(machine: MachineRow) -> bool:
    """True where the machine's next step looks for another controller."""
    return bool((machine.heard.counts[SILENT_TICKS] + 1) % machine.look_ticks == 0)


@compiled
def _has_more_to_do(
    loop: LoopSide, machine: MachineRow, from_machine: RingEnds, stretch: Stretch, who: int
) -> bool:
    """True where a step is more than its tick."""
    if who == MACHINE:
        return _looks(machine)
    counts = loop.memory.counts
    same = _newest(from_machine.read_header) == counts[NUMBER]
    if same and stretch.clocks[LOOP, DUE] >= stretch.looks_ns:
        return True
    return bool(counts[TICK] % loop.look_ticks == 0)


@compiled
def _schedule(stretch: Stretch, who: int, due_ns: int, draw: int) -> None:
    """Set the instant of the next step of somebody who does one now."""
    clock, step_s = stretch.clocks[who], stretch.step_s
    now_ns = clock[DUE]
    most_s = step_s[0] * (stretch.slow if now_ns < stretch.slow_until_ns else 1.0)
    clock[BUSY] = now_ns + np.int64(np.rint(stretch.draws[draw] * most_s * NS_PER_S))
    late_ns = np.int64(np.rint(stretch.draws[draw + 1] * step_s[1] * NS_PER_S))
    clock[DUE] = max(max(due_ns, now_ns) + late_ns, clock[BUSY])


@compiled
def play(
    loop: LoopSide,
    machine: MachineRow,
    to_machine: RingEnds,
    from_machine: RingEnds,
    loop_ring: RingEnds,
    stretch: Stretch,
) -> int:
    """Play ticks as they come, as long as there is nothing but ticks; how many there were.

    It ends where both are due at the same instant: whose turn it is, others decide.

    to_machine: commands, written by the loop and read by the machine. from_machine: what the
    machine shows, likewise. loop_ring: what the loop shows.
    """
    shown = np.empty(from_machine.slots.shape[1] - slot.AROUND, np.uint64)
    message = np.empty(to_machine.slots.shape[1] - slot.AROUND, np.uint64)
    clocks, phase = stretch.clocks, stretch.phase_column
    for count in range(min(stretch.at_ns.size, stretch.draws.size // DRAWS)):
        who = LOOP if clocks[LOOP, DUE] < clocks[MACHINE, DUE] else MACHINE
        now_ns = clocks[who, DUE]
        if now_ns >= stretch.ends_ns or clocks[LOOP, DUE] == clocks[MACHINE, DUE]:
            return count
        if _has_more_to_do(loop, machine, from_machine, stretch, who):
            return count
        stretch.at_ns[count], stretch.who[count] = now_ns, who
        before, period_ns = loop.memory.outputs[phase], stretch.periods_ns[who]
        if who == LOOP:
            _tick_loop(loop, from_machine, shown, clocks[LOOP], period_ns)
            _publish(to_machine.slots, to_machine.header, loop.memory.sent)
            _publish(loop_ring.slots, loop_ring.header, loop.row)
        else:
            clock = clocks[MACHINE]
            _tick_machine(machine, to_machine, from_machine, message, clock, period_ns)
        _schedule(stretch, who, clocks[who, DEADLINE] + period_ns, DRAWS * count)
        if loop.memory.outputs[phase] != before:
            return count + 1
    return min(stretch.at_ns.size, stretch.draws.size // DRAWS)


@compiled
def play_machine(
    machine: MachineRow, to_machine: RingEnds, from_machine: RingEnds, stretch: Stretch
) -> int:
    """Play ticks of a machine that nobody controls; see `play`."""
    message = np.empty(to_machine.slots.shape[1] - slot.AROUND, np.uint64)
    clock, period_ns = stretch.clocks[MACHINE], stretch.periods_ns[MACHINE]
    most = min(stretch.at_ns.size, stretch.draws.size // DRAWS)
    for count in range(most):
        if clock[DUE] >= stretch.ends_ns or _looks(machine):
            return count
        stretch.at_ns[count], stretch.who[count] = clock[DUE], MACHINE
        _tick_machine(machine, to_machine, from_machine, message, clock, period_ns)
        _schedule(stretch, MACHINE, clock[DEADLINE] + period_ns, DRAWS * count)
    return most
