"""The twin as a process of its own plays it: a machine with its drives' watchdog and annunciator.

As in `closed_loop`, but the controller is somewhere else, and with it its clock: a message is new
where one has come since the last tick, and its number is the tick in which it came. What the
machine is set to and what it remembers are rows, so that nothing is compiled anew and a tick costs
Python two of them.
"""

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.kernel.codegen import plain_row, row
from opensuction.kernel.compiled import compiled
from opensuction.kernel.compiler.dispatcher import TypedCall
from opensuction.kernel.interface import MESSAGE_COLUMNS, Commands, DriveMessage, Readings
from opensuction.kernel.record import Array, make_zero
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.wiring import Wiring
from opensuction.twin import plant
from opensuction.twin.fault import link
from opensuction.twin.fault.link import SILENT, LinkState, Message, Ring
from opensuction.twin.machine import fail_safe, machine
from opensuction.twin.machine.dc_axis import HandState
from opensuction.twin.machine.fail_safe import Annunciator, Lines, WatchdogState
from opensuction.twin.machine.machine import Machine, Truth
from opensuction.twin.plant import PlantState


class MachineSide(NamedTuple):
    """Machine and wiring that are simulated."""

    machine: Machine
    wiring: Wiring


class MachineSideState(NamedTuple):
    """State of the machine's side."""

    tick: int
    plant: PlantState
    link: LinkState
    watchdog: WatchdogState
    annunciator: Annunciator


class Shown(NamedTuple):
    """Readings, commands and truth of the machine's side after a tick."""

    tick: int
    readings: Readings
    """As they leave for the controller."""
    commands: Commands
    """As the drives obeyed them."""
    alone: bool
    """The drives act on their own."""
    annunciator: Annunciator
    truth: Truth


SHOWN_COLUMNS = row.columns(Shown)
"""Columns of the row that it gives; of the one that it takes: `kernel.interface`."""

_HAND = [
    i
    for i, name in enumerate(row.columns(MachineSideState))
    if name.startswith("plant.machine.hand.")
]

_read_side = row.reader(MachineSide, checked=False)
_read_state = row.reader_with_arrays(MachineSideState)
_write_state = row.writer(MachineSideState, checked=False)
_read_sent = row.reader(DriveMessage, checked=False)
_write_shown = row.writer(Shown, checked=False)


class LinkMemory(NamedTuple):
    """Memory of the link, as tables that it writes: see `link.rings`."""

    got: Ring
    sent: Ring
    shown: Ring


@compiled
def _obey(
    side: MachineSide, state: MachineSideState, sent: DriveMessage, new: bool, past: LinkMemory
) -> tuple[MachineSideState, Commands, Message]:
    """State with the bedside display, commands that the drives obey, and the message that came."""
    wires, tick = side.wiring.link, state.tick
    came = Message(sent.commands, sent.wanted, tick if new else SILENT)
    recalled = link.recall(wires, past.got, past.sent, past.shown, tick)
    message, heard = link.receive_message(wires, state.link, came, recalled, tick)
    listening = fail_safe.LISTENING if new and sent.released else state.watchdog
    reported = machine.read(side.machine, state.plant.machine)
    alone = fail_safe.step(
        side.wiring.watchdog, listening, heard, wires.mains, reported.head_mm, DT_S
    )
    lines = Lines(
        heard=heard,
        wanted=message.wanted,
        reset=new and sent.reset,
        alone=alone.alone,
        mains=wires.mains,
        lag_s=(tick - message.number) * DT_S,
    )
    shown = fail_safe.step_annunciator(state.annunciator, lines, DT_S)
    commands: Commands = message.commands
    if alone.alone:
        powered = wires.mains or wires.reserve
        commands = fail_safe.commands(
            side.wiring.watchdog, alone, powered, reported.head_mm, reported.cam_rad
        )
    told = state.link._replace(message=message)
    return state._replace(link=told, watchdog=alone, annunciator=shown), commands, came


@compiled
def _report(
    side: MachineSide, state: MachineSideState, came: Message, past: LinkMemory
) -> tuple[MachineSideState, Readings]:
    """Readings that leave for the controller after the machine has moved."""
    wires, tick = side.wiring.link, state.tick
    reported = machine.read(side.machine, state.plant.machine)
    link.keep(reported, came, past.got, past.sent, past.shown, tick)
    sensed = link.sense(wires, reported, tick)
    recalled = link.recall(wires, past.got, past.sent, past.shown, tick)
    readings = link.receive_readings(wires, state.link, sensed, recalled, tick)
    monitor = link.receive_monitor(wires, state.link, sensed.monitor, recalled)
    readings = readings._replace(monitor=monitor)
    return state._replace(link=state.link._replace(readings=readings)), readings


class _Apart(NamedTuple):
    """Part of the state that no row holds, in the order of the records' fields."""

    saturations: Array
    """What the oximeter has averaged."""
    secretion_ml: Array
    produced_ml_per_s: Array


class Memory(NamedTuple):
    """Memory that a tick changes: arrays all of it."""

    state: Array
    """A row by the columns of `MachineSideState`."""
    apart: _Apart
    past: LinkMemory


@compiled
def _keep(memory: Memory, state: MachineSideState) -> None:
    """Write a state down. memory: written."""
    _write_state(memory.state, state)
    bedside = state.plant.bedside
    memory.apart.saturations[:] = bedside.patient.oximeter.history
    memory.apart.secretion_ml[:] = bedside.secretion_ml
    memory.apart.produced_ml_per_s[:] = bedside.produced_ml_per_s


@compiled
def step(side: Array, memory: Memory, sent: Array, new: bool, shown: Array) -> None:
    """One tick. memory: written. shown: the row that it gives."""
    apart, past, played = memory.apart, memory.past, _read_side(side)
    before = _read_state(
        memory.state, apart.saturations, apart.secretion_ml, apart.produced_ml_per_s
    )
    obeying, commands, came = _obey(played, before, _read_sent(sent), new, past)
    moved = plant.step(played.machine, obeying.plant, commands, DT_S)
    after, readings = _report(played, obeying._replace(plant=moved), came, past)
    truth = machine.truth(played.machine, moved.machine)
    now = Shown(
        tick=before.tick,
        readings=readings,
        commands=commands,
        alone=after.watchdog.alone,
        annunciator=after.annunciator,
        truth=truth,
    )
    _write_shown(shown, now)
    _keep(memory, after._replace(tick=before.tick + 1))


class Heard(NamedTuple):
    """Memory of what a machine has heard of its controller."""

    row: Array
    """The last message that counts, by `MESSAGE_COLUMNS`."""
    counts: npt.NDArray[np.int64]


MESSAGE, SILENT_TICKS, GREETED = range(3)
"""Places of its counts: number of the last message that came; ticks since then; 1 once the
controller has said that it has started anew."""
HEARD_COUNTS = 3
_RELEASED = MESSAGE_COLUMNS.index("released")


@compiled
def hear(heard: Heard, number: int, message: Array) -> bool:
    """Take a message that has come; false where it does not count.

    One of a controller that has not said that it has started anew does not: it takes the machine
    for another one, or for where another one was. One with what is no number does not either.
    """
    counts = heard.counts
    counts[MESSAGE] = number
    counts[SILENT_TICKS] = 0
    for i in range(message.size):
        if not math.isfinite(message[i]):
            return False
    if message[_RELEASED] != 0.0:
        counts[GREETED] = 1
    if counts[GREETED] == 0:
        return False
    heard.row[:] = message
    return True


def begin(side: MachineSide, plant_state: PlantState) -> dict[str, Array]:
    """A machine at rest, before a controller has sent anything, as arrays by name.

    They are what `MachineCall` takes, in this process or another one.
    """
    reading = machine.read(side.machine, plant_state.machine)
    told = LinkState(reading, make_zero(Message)._replace(number=SILENT))
    state = MachineSideState(0, plant_state, told, fail_safe.LISTENING, fail_safe.DARK)
    apart = _Apart(*(one.copy() for one in plain_row.arrays(state)))
    return {
        "side": plain_row.pack(MachineSide, side),
        "state": plain_row.pack(MachineSideState, state),
        **apart._asdict(),
        **LinkMemory(*link.rings(told))._asdict(),
    }


class MachineCall:
    """A machine that Python steps, a tick at a time."""

    def __init__(self, begun: Mapping[str, Array]) -> None:
        """A machine as `begin` gives it. Compiles or loads what a tick needs."""
        self.side_row = begun["side"].copy()
        """What is played; to write into it breaks or mends the machine from the next tick on."""
        self.memory = _memory_of(begun)
        """What a tick changes."""
        self._step = TypedCall(step, lambda *_: 0)
        self.shown_row = np.zeros(len(SHOWN_COLUMNS))
        """What it gave in the last tick, by `SHOWN_COLUMNS`."""
        kept, self.memory = self.memory, _memory_of(begun)
        self.step(np.zeros(len(MESSAGE_COLUMNS)), new=False)
        self.memory = kept

    def step(self, sent: Array, *, new: bool) -> None:
        """One tick. sent: a row by `MESSAGE_COLUMNS`. new: it has come since the last tick."""
        self._step(self.side_row, self.memory, sent, new, self.shown_row)

    def put_hand(self, state: HandState) -> None:
        """Set the state of the hand at the catheter head from the next tick on."""
        self.memory.state[_HAND] = plain_row.pack(HandState, state)


def _memory_of(begun: Mapping[str, Array]) -> Memory:
    """Copies of what a tick changes."""
    copies = {name: value.copy() for name, value in begun.items()}
    return Memory(
        copies["state"],
        _Apart(*(copies[name] for name in _Apart._fields)),
        LinkMemory(*(copies[name] for name in LinkMemory._fields)),
    )
