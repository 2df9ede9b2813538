"""The paper's bench behind emulated drives, and a bare master on their bus, tick by tick."""

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

import numpy as np
from canopen import RemoteNode

from opensuction.control.compensation import CompensationKind
from opensuction.machine.canopen import device_file, objects, power_state
from opensuction.machine.canopen.device import Device
from opensuction.machine.canopen.frame_bus import CanFrame
from opensuction.machine.canopen.objects import AXIS_TARGET, HEARTBEAT_ID, NMT_ID, SYNC_ID, Axis
from opensuction.machine.canopen.power_state import PowerState
from opensuction.machine.canopen.stepped_network import SteppedNetwork
from opensuction.machine.drives.emulated_machine import EmulatedMachine, Servos, without_patience
from opensuction.machine.twin import twin_machine
from opensuction.procedure.planning.protocol import PAPER
from opensuction.simulation import machine_side
from opensuction.simulation import rig as rigs
from opensuction.simulation.closed_loop import Loop, LoopState
from opensuction.simulation.machine_side import SHOWN_COLUMNS, MachineCall
from opensuction.twin.plant import PlantState
from tests.machine.canopen.stepped_bus import SteppedClock, Wire

TICK_NS = 1_000_000
CYCLE_TICKS = 4
DEVICE = device_file.load(device_file.EMULATED)
INSERTION, VALVE, MODULE = DEVICE.nodes


@cache
def loop() -> tuple[Loop, LoopState]:
    rig = rigs.rig("bench", 1)
    known = rigs.uncalibrated(rig.profile)
    return rigs.assemble(rig, PAPER, CompensationKind.NONE, known, 2)


class EmulatedBench:
    """Drives that are stepped, and whoever is the master."""

    def __init__(
        self, device: Device = DEVICE, played: tuple[Loop, LoopState] | None = None
    ) -> None:
        made, state = loop() if played is None else played
        side = without_patience(twin_machine.side_of(made, 1))
        self.call = MachineCall(machine_side.begin(side, PlantState(state.machine, state.bedside)))
        self.clock, self.wire, self.device = SteppedClock(), Wire(), device
        servos = Servos(made.controller.insertion_servo, made.controller.valve_servo)
        self.drives = EmulatedMachine(device, side.machine, servos, self.wire.join(), self.clock)
        self.bus = self.wire.join()
        self.network = SteppedNetwork(self.bus, self.clock, self.tick)
        self.measured: Callable[[], None] = lambda: None
        """Changes what the twin shows before the drives see it."""
        self.beats, self.words = True, {INSERTION: 0, VALVE: 0}
        self.targets = dict.fromkeys(self.words, 0)
        self.log: list[Mapping[str, float]] = []

    def tick(self) -> None:
        """A millisecond."""
        self.clock.now_ns += TICK_NS
        self.drives.exchange()
        self.drives.tick()
        self.call.step(self.drives.row, new=self.drives.has_news)
        self.measured()
        self.drives.measure(self.call.shown_row)

    def shown(self, name: str) -> float:
        """What the twin shows, by the name of its column."""
        return float(self.call.shown_row[SHOWN_COLUMNS.index(name)])

    def take(self, node: int, index: int, sub: int = 0) -> int:
        """An object as a node has it, whatever goes over the bus."""
        found = next(one for one in self.drives.nodes if one.number == node)
        found.refresh()
        return found.values[index, sub]

    def remote(self, node: int) -> RemoteNode:
        """A node by SDO."""
        return self.network.nodes.get(node) or self.network.add_remote(node)  # type: ignore[return-value]

    def write(self, node: int, index: int, value: int, length: int, sub: int = 0) -> None:
        """An object by SDO."""
        self.remote(node).sdo.download(
            index, sub, value.to_bytes(length, "little", signed=value < 0)
        )

    def command(self, command: int, node: int = 0) -> None:
        """An NMT command."""
        self.bus.send([CanFrame(NMT_ID, bytes([command, node]))])

    def operate(self, lost_host: Mapping[int, int] | None = None, host_ms: int = 20) -> None:
        """Set the nodes up as a driver does, and start process data."""
        for node in self.device.nodes:
            self.write(node, objects.Communication.HEARTBEAT_CONSUMER, 127 << 16 | host_ms, 4, 1)
        for node in self.words:
            self.write(node, objects.Axis.MODE, objects.Mode.CYCLIC_POSITION, 1)
            reaction = (lost_host or {}).get(node, -1 if node == INSERTION else 2)
            self.write(node, objects.Axis.ABORT_CONNECTION, reaction, 2)
        self.command(1)

    def cycle(self, sync: bool = True, ticks: int = CYCLE_TICKS) -> None:
        """Set points, SYNC, a heartbeat and the ticks until the next."""
        frames = [
            CanFrame(objects.rpdo_id(node, 1), AXIS_TARGET.pack(word, self.targets[node]))
            for node, word in self.words.items()
        ]
        if self.beats:
            frames.append(CanFrame(HEARTBEAT_ID + 127, b"\5"))
        self.bus.send([*frames, *([CanFrame(SYNC_ID, b"")] if sync else [])])
        for _ in range(ticks):
            self.tick()

    def enable(self, *nodes: int) -> None:
        """Lead drives into operation where they stand."""
        for word in (0x06, 0x07, 0x0F):
            for node in nodes:
                self.words[node] = word
                self.targets[node] = self.take(node, objects.Axis.POSITION)
            self.cycle()
        self.cycle()

    def came(self, can_id: int) -> list[bytes]:
        """Data of all frames with an identifier."""
        return [one.data for one in self.wire.sent if one.can_id == can_id]

    def row(self) -> np.ndarray[Any, Any]:
        """A copy of what the twin shows."""
        return self.call.shown_row.copy()


def state(bench: EmulatedBench, node: int = INSERTION) -> PowerState:
    return power_state.read_state(bench.take(node, Axis.STATUS_WORD))


def drive_in(bench: EmulatedBench, cycles: int, mm_per_s: float) -> None:
    """Targets of a steady motion."""
    counts = bench.device.insertion.counts_per_unit * mm_per_s * CYCLE_TICKS / 1000.0
    start = bench.targets[INSERTION]
    for number in range(cycles):
        bench.targets[INSERTION] = start + round(counts * (number + 1))
        bench.cycle()


def moving(bench: EmulatedBench, **kwargs: object) -> EmulatedBench:
    bench.operate(**kwargs)  # type: ignore[arg-type]
    bench.enable(INSERTION, VALVE)
    drive_in(bench, 100, 10.0)
    return bench


def withdraws(bench: EmulatedBench) -> bool:
    return bench.shown("alone") == 1.0 and state(bench) == PowerState.FAULT
