"""The control loop before the emulated drives, on a bus in memory, without a wall clock.

The loop, the driver, the nodes and the twin are the real ones. The drives' process and the loop
each do what is due at an instant; frames that leave come to the others later, as the wire has it.
"""

import heapq
import os
import pickle
import random
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple, TypeVar

import numpy as np

from opensuction.kernel.record import Array
from opensuction.machine.canopen import device_file
from opensuction.machine.canopen.canopen_machine import CanopenMachine
from opensuction.machine.canopen.device import AxisMode, Device
from opensuction.machine.canopen.frame_bus import CanFrame
from opensuction.machine.drives import drives_process
from opensuction.machine.drives.emulated_machine import EmulatedMachine, Servos, without_patience
from opensuction.machine.twin import twin_machine
from opensuction.simulation import machine_side
from opensuction.simulation.closed_loop import DT_S, Loop, LoopState
from opensuction.simulation.machine_side import MachineCall
from opensuction.twin.plant import PlantState
from tests.machine.canopen.stepped_bus import MemoryBus, SteppedClock, Wire, stepped_host
from tests.runtime.stepped_room import TICK_NS, LoopRoom

EMULATED = device_file.load(device_file.EMULATED)
SETS_UP_MS = 2000
Result = TypeVar("Result")


def branch(play: Callable[[], Result]) -> Result:
    """Play on in a copy of this process; where it comes to, while nothing has happened here."""
    reads, writes = os.pipe()
    pid = os.fork()
    if pid == 0:
        try:
            with os.fdopen(writes, "wb") as pipe:
                pickle.dump(play(), pipe)
        finally:
            os._exit(0)
    os.close(writes)
    with os.fdopen(reads, "rb") as pipe:
        data = pipe.read()
    os.waitpid(pid, 0)
    assert data, "the copy has failed"
    found: Result = pickle.loads(data)
    return found


class Noise(NamedTuple):
    """Shares of the frames that go astray."""

    lost: float = 0.0
    twice: float = 0.0
    late: float = 0.0
    """Of what a participant sends at once: it waits for the bus, and what it sends next as well."""
    late_ticks: int = 0
    """It comes up to so many ticks later."""


class DelayedWire(Wire):
    """A wire on which frames come a while after they were sent, or not, or twice; in order."""

    def __init__(self, clock: SteppedClock, seed: int) -> None:
        super().__init__()
        self.noise = Noise()
        self._clock, self._chance = clock, random.Random(seed)
        self._waiting: list[tuple[int, int, MemoryBus, CanFrame]] = []
        self._number = 0
        self._busy_ns: dict[int, int] = {}
        """Until when what a participant has sent waits."""

    def carry(self, sender: MemoryBus, frames: Sequence[CanFrame]) -> None:
        """See `Wire.carry`."""
        due_ns = max(self._clock.now_ns, self._busy_ns.get(id(sender), 0))
        if self._is_drawn(self.noise.late):
            late_ns = self._chance.randint(1, self.noise.late_ticks) * TICK_NS
            due_ns = max(due_ns, self._clock.now_ns + late_ns)
        self._busy_ns[id(sender)] = due_ns
        for one in self.participants:
            if one is not sender:
                for frame in frames:
                    self._send(one, frame, due_ns)

    def _is_drawn(self, share: float) -> bool:
        return share > 0.0 and self._chance.random() < share

    def _send(self, to: MemoryBus, frame: CanFrame, due_ns: int) -> None:
        if self._is_drawn(self.noise.lost):
            return
        for _ in range(2 if self._is_drawn(self.noise.twice) else 1):
            self._number += 1
            heapq.heappush(self._waiting, (due_ns, self._number, to, frame))

    def deliver(self) -> None:
        """Bring what is due by now."""
        while self._waiting and self._waiting[0][0] <= self._clock.now_ns:
            _, _, to, frame = heapq.heappop(self._waiting)
            to.waiting.append(frame)


class BusMachine:
    """A `ports.Port` to emulated drives on a bus, which move when they are told to."""

    def __init__(self, loop: Loop, state: LoopState, device: Device, seed: int = 1) -> None:
        self.device, self.clock, self.said = device, SteppedClock(), list[str]()
        self.host = stepped_host(self.clock)._replace(say=self.said.append)
        self.wire = DelayedWire(self.clock, seed)
        side = without_patience(twin_machine.side_of(loop, seed))
        plant = PlantState(state.machine, state.bedside)
        self.call = MachineCall(machine_side.begin(side, plant))
        servos = Servos(loop.controller.insertion_servo, loop.controller.valve_servo)
        bus = self.wire.join()
        self.drives = EmulatedMachine(device, side.machine, servos, bus, self.clock)
        self.shown: list[Array] = []
        """What the twin gave in each tick, by `SHOWN_COLUMNS`."""
        self.port = CanopenMachine(device, self.wire.join(), self.host)
        self.facts = self.port.facts
        self._set_up()

    def _set_up(self) -> None:
        """Until there are readings."""
        row: Array = np.zeros(len(twin_machine.READINGS))
        for _ in range(SETS_UP_MS):
            if self.read(row):
                return
            self.move(1)
        raise AssertionError(f"no readings within {SETS_UP_MS} ms")

    def move(self, ticks: int) -> None:
        """So many ticks of 1 ms."""
        for _ in range(ticks):
            self.clock.now_ns += TICK_NS
            self.wire.deliver()
            self.drives.exchange()
            self.drives.tick()
            self.call.step(self.drives.row, new=self.drives.has_news)
            self.drives.measure(self.call.shown_row)
            self.shown.append(self.call.shown_row.copy())

    def read(self, readings: Array) -> int:
        """See `ports.Port.read`."""
        self.wire.deliver()
        return self.port.read(readings)

    def write(self, sent: Array) -> None:
        """See `ports.Port.write`."""
        self.port.write(sent)

    def close(self) -> None:
        """See `ports.Port.close`."""
        self.port.close()


def by_torque(loop: Loop) -> Device:
    """The emulated drives' device file, the insertion drive's torque set by our own servo."""
    motor, _ = drives_process.motors_of(loop)
    return EMULATED._replace(
        insertion=EMULATED.insertion._replace(mode=AxisMode.TORQUE, motor=motor)
    )


def by_targets() -> Device:
    """Their device file with an insertion drive that takes no velocity offset."""
    return EMULATED._replace(insertion=EMULATED.insertion._replace(velocity_offset=False))


class BusRoom(LoopRoom[BusMachine]):
    """The loop before emulated drives."""

    def __init__(
        self,
        folder: Path,
        loop: Loop,
        state: LoopState,
        period: int,
        seed: int = 1,
        device: Device = EMULATED,
    ) -> None:
        """period: of SYNC and of the loop, in ms. seed: chance of the bus."""
        device = device._replace(bus=device.bus._replace(period_s=period * DT_S))
        machine = BusMachine(loop, state, device, seed)
        super().__init__(folder, machine, loop, state, period, machine.host)
        self.first_tick = len(machine.shown) - 1
        """Of the twin, as the loop begins."""
