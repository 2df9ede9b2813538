"""The twin's process as a machine before the controller."""

import json
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np

from opensuction.host.host import Child, Host, Steps, after, finish
from opensuction.host.this_computer import THIS_COMPUTER
from opensuction.ipc.ring import FollowedRing, RingReader, RingWriter
from opensuction.kernel import private_file
from opensuction.kernel.codegen import plain_row
from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import MESSAGE_COLUMNS
from opensuction.kernel.record import Array
from opensuction.machine import port
from opensuction.machine.port import (
    EVERYTHING,
    Capabilities,
    HandTask,
    MachineFacts,
    TruthRead,
    read_capabilities,
)
from opensuction.machine.twin import twin_faults
from opensuction.machine.twin.twin_faults import CHANGE, PATIENCE_S
from opensuction.machine.twin.twin_process import BEGUN, CAPABILITIES, COMMANDS, SHOWN
from opensuction.simulation import machine_side
from opensuction.simulation.closed_loop import DT_S, Loop, LoopState
from opensuction.simulation.machine_side import SHOWN_COLUMNS, MachineSide
from opensuction.simulation.wiring import Wiring
from opensuction.twin import preset
from opensuction.twin.fault import link
from opensuction.twin.fault.bus import Bus
from opensuction.twin.machine import dc_axis, fail_safe
from opensuction.twin.machine.fail_safe import SILENCE_S
from opensuction.twin.machine.machine import Machine
from opensuction.twin.plant import PlantState

PROCESS = "opensuction.machine.twin.twin_process"
BEGINS_S, LOOKS_S = 120.0, 0.005
"""Longest time until the twin plays: it may have to be compiled first; how often it is looked."""
LOG = "twin_process.log"
"""What the process says."""
COMMAND_SLOTS = 64
LOOK_NS = 50_000_000
"""How often a machine that is silent is looked for anew: it may have been started again."""
FELT_N = dc_axis.HAND_PARAMETERS["felt_n"].value
_CONTACT = SHOWN_COLUMNS.index("truth.contact_n")
READINGS = [i for i, name in enumerate(SHOWN_COLUMNS) if name.startswith("readings.")]
SHOWN_READINGS = slice(READINGS[0], READINGS[-1] + 1)
"""One after the other, as any record's columns."""


def side_of(loop: Loop, seed: int) -> MachineSide:
    """The machine of a loop as a process plays it: its rack ends, its drives watch over messages.

    seed: chance of a link that loses messages.
    """
    home_mm = loop.controller.limits.park_head_mm
    machine = preset.limit_rack(loop.machine, home_mm)
    return MachineSide(machine, Wiring(link.healthy(seed), fail_safe.of(machine, home_mm)))


def start(
    folder: Path,
    loop: Loop,
    state: LoopState,
    seed: int,
    carrier: Bus | None = None,
    host: Host = THIS_COMPUTER,
) -> Child:
    """Start the twin of a loop in a folder, at rest; returns once it plays.

    carrier: as `launch` takes it. Raises InputError as `launch` does.
    """
    plant = PlantState(state.machine, state.bedside)
    return launch(folder, side_of(loop, seed), plant, carrier, host)


def prepare(folder: Path, side: MachineSide, plant: PlantState) -> None:
    """Write down in a folder what a twin shall play there, from its beginning."""
    begun: dict[str, Any] = {**machine_side.begin(side, plant)}
    with private_file.create(folder / BEGUN) as file:
        np.savez(file, **begun)
    (folder / SHOWN).unlink(missing_ok=True)
    port.name_backend(folder, port.TWIN)


def launch(
    folder: Path,
    side: MachineSide,
    plant: PlantState,
    carrier: Bus | None = None,
    host: Host = THIS_COMPUTER,
) -> Child:
    """Start the twin in a folder; returns once it plays.

    carrier: the bus between it and its controllers; None where messages are there at once. Raises
    InputError where it does not play, or for what no bus does.
    """
    if carrier is not None:
        wires = link.on_bus(side.wiring.link, carrier, DT_S)
        side = side._replace(wiring=side.wiring._replace(link=wires))
    prepare(folder, side, plant)
    # A process of its own, which outlives whoever started it.
    process = host.processes.spawn(PROCESS, (str(folder),), folder / LOG)
    if finish(_starting(folder, process, host), host.clock):
        return process
    process.kill()
    process.wait()
    said = (folder / LOG).read_text(encoding="utf-8", errors="replace").strip()
    raise InputError(f"the twin does not play in {folder}: {said or 'it took too long'}")


def _starting(folder: Path, process: Child, host: Host) -> Steps[bool]:
    """Steps until a twin plays; false where it does not."""
    ends_ns = after(host.clock, BEGINS_S)
    while host.clock.monotonic_ns() < ends_ns and process.poll() is None:
        if (folder / SHOWN).exists() and RingReader(folder / SHOWN).newest():
            return True
        yield after(host.clock, LOOKS_S)
    return False


def change(folder: Path, side: MachineSide, host: Host = THIS_COMPUTER) -> None:
    """Have the twin in a folder play another machine, to which its faults come from now on.

    For what no fault of the table does to it; see `twin_faults` for those.
    """
    with closing(host.datagrams.sender(PATIENCE_S)) as sender:
        sender.send(folder / CHANGE, plain_row.pack(MachineSide, side).tobytes())


class TwinMachine:
    """A `ports.Port` to the twin that plays in a folder."""

    def __init__(self, folder: Path, host: Host = THIS_COMPUTER) -> None:
        """Raises InputError where no twin plays there, or another controller has it."""
        shown = _open_shown(folder)
        self._ring = FollowedRing(folder / SHOWN, lambda columns: columns == SHOWN_COLUMNS)
        self._ring.look()
        self._before, self.number = 0, 0
        self._clock = host.clock
        self._looked_ns = self._clock.monotonic_ns()
        self.commands = RingWriter(folder / COMMANDS, MESSAGE_COLUMNS, COMMAND_SLOTS, {}, host=host)
        self.facts = MachineFacts(
            name="twin",
            version=shown.facts.told["version"],
            in_silico=True,
            period_s=DT_S,
            watchdog_s=SILENCE_S,
            most=json.loads(shown.facts.told["most"]),
            capabilities=_capabilities(shown),
        )

    @property
    def shown(self) -> RingReader | None:
        """Ring of the twin that has played from the beginning; None where there was another."""
        return None if self._before else self._ring.reader

    @property
    def looks_ns(self) -> int:
        """From when on another twin is looked for where the readings stay the same."""
        return self._looked_ns + LOOK_NS

    def read(self, readings: Array) -> int:
        """The newest readings; see `ports.Port.read`.

        A twin that was started again is another machine, and its numbers go on from there.
        """
        number = self._take(readings)
        if number == self.number and self._look():
            self._before = number
            number = self._take(readings)
        self.number = number
        return number

    def _take(self, readings: Array) -> int:
        """Write what the ring shows now; its number among all that were."""
        newest = None if self._ring.reader is None else self._ring.reader.snapshot()
        if newest is None:
            return self.number
        readings[:] = newest[1][SHOWN_READINGS]
        return self._before + newest[0]

    def _look(self) -> bool:
        """Look for another twin, now and then; whether there is one."""
        now_ns = self._clock.monotonic_ns()
        if now_ns - self._looked_ns < LOOK_NS:
            return False
        self._looked_ns = now_ns
        return self._ring.look()

    def write(self, sent: Array) -> None:
        """New commands; see `ports.Port.write`."""
        self.commands.write(sent)

    def close(self) -> None:
        """No more commands: the drives' watchdog takes over."""
        self.commands.close()


class TwinHand:
    """The person at the catheter head of the twin that plays in a folder; a `SimulatedHand`."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def hold(self, task: HandTask, park_head_mm: float, quick_mm: float) -> None:
        """See `SimulatedHand.hold`."""
        twin_faults.hold(self._folder, task, park_head_mm, quick_mm)

    def feels_carina(self) -> bool | None:
        """See `SimulatedHand.feels_carina`: by the truth, which only the twin knows."""
        try:
            newest = TwinTruth(self._folder).newest()
        except InputError:
            return None
        return None if newest is None else bool(newest[_CONTACT] >= FELT_N)


class TwinTruth:
    """A `TruthPort` to the twin that plays in a folder, from its first tick that is still there."""

    columns, period_s = SHOWN_COLUMNS, DT_S

    def __init__(self, folder: Path) -> None:
        """Raises InputError where no twin plays there, or one of another version."""
        self._folder, self._ring = folder, _open_shown(folder)
        if self._ring.newest() >= self._ring.facts.slots // 2:
            self._ring.next = self._ring.newest()

    @property
    def built(self) -> Machine:
        """See `TruthPort.built`."""
        return read_side(self._folder).machine

    def read(self) -> TruthRead:
        """See `TruthPort.read`; the ring holds 20 s."""
        found = self._ring.read()
        return TruthRead(found.rows, found.missed)

    def newest(self) -> Array | None:
        """See `TruthPort.newest`."""
        newest = self._ring.snapshot()
        return None if newest is None else newest[1]


def read_side(folder: Path) -> MachineSide:
    """Machine side that the twin of a folder was begun with. Raises InputError for none."""
    try:
        with np.load(folder / BEGUN) as begun:
            return plain_row.unpack(MachineSide, begun["side"])
    except (OSError, EOFError, ValueError, KeyError) as error:
        raise InputError(f"no machine to judge in {folder / BEGUN}: {error}") from None


def capabilities_of(folder: Path) -> Capabilities:
    """See `backend.Backend.capabilities_of`."""
    return _capabilities(_open_shown(folder))


def _open_shown(folder: Path) -> RingReader:
    """The ring of the twin in a folder. Raises InputError for none, or for another version's."""
    shown = RingReader(folder / SHOWN)
    if shown.facts.columns != SHOWN_COLUMNS:
        raise InputError(f"{folder / SHOWN} is of another version of the twin")
    return shown


def _capabilities(shown: RingReader) -> Capabilities:
    """Capabilities that its twin names; one that an older version started names none, has all."""
    told = shown.facts.told.get(CAPABILITIES)
    return EVERYTHING if told is None else read_capabilities(json.loads(told))


attach, hand_of, truth_of = TwinMachine, TwinHand, TwinTruth
"""This module as a `backend.Backend`."""
