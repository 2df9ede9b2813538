"""Nodes built on `durand`, a CANopen responder that nobody of this project wrote.

SDO server, NMT, SYNC, PDO and heartbeat are durand's; here are the objects that CiA 402-2 and
CiA 401 have for what a drive and a module do, and power states on top of them.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest
from durand import Array, DatatypeEnum, MinimalNode, Record, Variable
from durand.network import NetworkABC
from durand.scheduler import AbstractScheduler, VirtualScheduler, get_scheduler, set_scheduler
from durand.services.nmt import StateEnum

from opensuction.kernel.codegen import plain_row
from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import Commands, DriveMessage, Readings
from opensuction.kernel.record import make_zero
from opensuction.machine.canopen import device as units
from opensuction.machine.canopen import power_state
from opensuction.machine.canopen.canopen_machine import CanopenMachine
from opensuction.machine.canopen.device import Device, DriveAxis
from opensuction.machine.canopen.frame_bus import CanFrame
from opensuction.machine.canopen.objects import NMT_ID, NmtCommand, rpdo_id
from opensuction.machine.canopen.power_state import PowerState
from tests.machine.canopen.node_frames import DEVICE
from tests.machine.canopen.stepped_bus import MemoryBus, SteppedClock, Wire, stepped_host

U8, U16, U32 = DatatypeEnum.UNSIGNED8, DatatypeEnum.UNSIGNED16, DatatypeEnum.UNSIGNED32
I8, I16, I32 = DatatypeEnum.INTEGER8, DatatypeEnum.INTEGER16, DatatypeEnum.INTEGER32
U64 = DatatypeEnum.UNSIGNED64
CYCLIC_POSITION = 1 << 7
"""In the supported modes."""
Objects = dict[tuple[int, int], tuple[DatatypeEnum, str, int]]
"""Index and subindex: type, access by SDO, default."""


def writable(kinds: dict[tuple[int, int], DatatypeEnum]) -> Objects:
    """Objects that begin with 0."""
    return {key: (kind, "rw", 0) for key, kind in kinds.items()}


_DRIVE_KINDS = {
    (0x2300, 0): U32,
    (0x6007, 0): I16,
    (0x603F, 0): U16,
    (0x6040, 0): U16,
    (0x6041, 0): U16,
    (0x605A, 0): I16,
    (0x605E, 0): I16,
    (0x6060, 0): I8,
    (0x6061, 0): I8,
    (0x6064, 0): I32,
    (0x606C, 0): I32,
    (0x6071, 0): I16,
    (0x6072, 0): U16,
    (0x6077, 0): I16,
    (0x607A, 0): I32,
    (0x607D, 1): I32,
    (0x607D, 2): I32,
    (0x6080, 0): U32,
    (0x60C2, 1): U8,
    (0x60C2, 2): I8,
    (0x60FD, 0): U32,
}
DRIVE_OBJECTS: Objects = {**writable(_DRIVE_KINDS), (0x6502, 0): (U32, "ro", CYCLIC_POSITION)}
_MODULE_KINDS = {
    (0x2100, 1): U64,
    **{(0x6000, sub): U8 for sub in (1, 2)},
    **{(index, 1): U8 for index in (0x6200, 0x6206, 0x6207)},
    **{(0x6401, sub): I16 for sub in range(1, 9)},
    **{(0x6411, sub): I16 for sub in (1, 2)},
    **{(0x6443, sub): U8 for sub in (1, 2)},
    **{(0x6444, sub): I32 for sub in (1, 2)},
}


class WireNetwork(NetworkABC):  # type: ignore[misc]
    """A node's end of a wire in memory; durand calls it its network."""

    def __init__(self, bus: MemoryBus) -> None:
        self.bus = bus
        self._called: dict[int, Any] = {}

    def add_subscription(self, cob_id: int, callback: Any) -> None:
        self._called[cob_id] = callback

    def remove_subscription(self, cob_id: int, callback: Any = None) -> None:  # noqa: ARG002
        self._called.pop(cob_id, None)

    def send(self, cob_id: int, msg: bytes) -> None:
        self.bus.send([CanFrame(cob_id, bytes(msg))])

    def step(self) -> None:
        for can_id, data in list(self.bus.receive()):
            if can_id in self._called:
                self._called[can_id](can_id, data)


class DurandNode:
    """A node with some objects."""

    def __init__(self, wire: Wire, number: int, profile: int, objects: Objects) -> None:
        self.number, self.is_alive = number, True
        self.network = WireNetwork(wire.join())
        self.node = MinimalNode(self.network, number)
        self.objects = self.node.object_dictionary
        for (index, sub), (kind, access, value) in objects.items():
            variable = Variable(kind, access, value)
            if sub == 0:
                self.objects[index] = variable
            elif index in self.objects:
                self.objects[index][sub] = variable
            else:
                self.objects[index] = Record()
                self.objects[index][sub] = variable
        self.objects[0x1016] = Array(Variable(U32, "rw", 0), 1)
        self.objects[0x1029] = Array(Variable(U8, "rw", 0), 1)
        self.write(0x1000, 0, profile)

    def read(self, index: int, sub: int = 0) -> int:
        return int(self.objects.read(index, sub))

    def write(self, index: int, sub: int, value: int) -> None:
        self.objects.write(index, sub, value)

    def step(self) -> None:
        if self.is_alive:
            self.network.step()
            self.tick()

    def tick(self) -> None:
        """The node a millisecond on."""

    def reboot(self) -> None:
        """Its power goes and comes back: all that was written is gone."""
        self.objects._data.clear()
        self.node.nmt.reset()


class DurandDrive(DurandNode):
    """A drive that moves where it is told at 100 mm/s, or as many rad/s."""

    def __init__(self, wire: Wire, axis: DriveAxis, objects: Objects = DRIVE_OBJECTS) -> None:
        self.axis, self.power = axis, power_state.POWERED_UP
        self.position, self.inputs = 0.0, 1 << DEVICE.contact.wired_bit
        self.words: list[int] = []
        super().__init__(wire, axis.node, 402, objects)
        self.objects.download_callbacks[0x6040, 0].add(self._obey)

    def _obey(self, word: int) -> None:
        self.words.append(word)
        self.power = power_state.step_drive(self.power, word)

    @property
    def is_enabled(self) -> bool:
        return self.power.state == PowerState.OPERATION_ENABLED

    def leave(self, state: PowerState) -> None:
        """Go to another power state without being told."""
        self.power = self.power._replace(state=state)

    def tick(self) -> None:
        if self.is_enabled and self.node.nmt.state == StateEnum.OPERATIONAL:
            goal = units.position_of(self.axis, self.read(0x607A))
            self.position += min(max(goal - self.position, -0.1), 0.1)
        self.write(0x6041, 0, power_state.write_status(self.power.state, power_state.REMOTE))
        counts = self.axis.zero_counts + round(self.position * self.axis.counts_per_unit)
        self.write(0x6064, 0, counts)
        self.write(0x60FD, 0, self.inputs)


class DurandModule(DurandNode):
    """A module at whose inputs all is well."""

    def __init__(self, wire: Wire) -> None:
        super().__init__(wire, DEVICE.module.node, 401, writable(_MODULE_KINDS))
        self.write(0x6000, 1, 0b11111)


class Bench:
    """A controller's port before three such nodes; time passes by its steps alone."""

    def __init__(self, objects: Objects = DRIVE_OBJECTS) -> None:
        """objects: of the insertion drive."""
        self.clock, self.wire = SteppedClock(), Wire()
        self.said: list[str] = []
        self.insertion = DurandDrive(self.wire, DEVICE.insertion, objects)
        self.valve = DurandDrive(self.wire, DEVICE.valve)
        self.module = DurandModule(self.wire)
        self.nodes: list[DurandNode] = [self.insertion, self.valve, self.module]
        self.drive(DEVICE)
        self.row = np.zeros(len(list(plain_row.numbers(make_zero(Readings)))))
        self.number = 0

    def drive(self, device: Device) -> None:
        """Put a driver before them."""
        host = stepped_host(self.clock)._replace(say=self.said.append)
        self.port = CanopenMachine(device, self.wire.join(), host)

    def pass_ms(self, times: int = 1) -> None:
        for _ in range(times):
            self.clock.now_ns += 1_000_000
            scheduler = get_scheduler()
            assert isinstance(scheduler, VirtualScheduler)
            scheduler.run(0.001)
            for one in self.nodes:
                one.step()

    def start(self, patience_ms: int = 15_000) -> None:
        """Until there are readings. Raises InputError as the port does."""
        for _ in range(patience_ms):
            self.number = self.port.read(self.row)
            if self.number:
                return
            self.pass_ms()
        raise AssertionError("no readings")

    def refusal(self) -> str:
        """Words with which the machine is refused; none is put into operation, nor commanded."""
        with pytest.raises(InputError) as refused:
            self.start()
        message = str(refused.value)
        assert "\n" not in message
        assert "nothing moves" in message
        moving = {rpdo_id(node, 1) for node in DEVICE.nodes}
        assert not [one for one in self.wire.sent if one.can_id in moving]
        began = CanFrame(NMT_ID, bytes((NmtCommand.START, DEVICE.insertion.node)))
        assert began not in self.wire.sent
        return message

    def cycle(self, times: int = 1, released: bool = False, **commands: Any) -> Readings:
        """Some cycles of the control loop with the same command; the last readings."""
        given = make_zero(Commands)._replace(**commands)
        sent = make_zero(DriveMessage, commands=given, released=released)
        row = plain_row.pack(DriveMessage, sent)
        for _ in range(times):
            self.port.write(row)
            self.pass_ms(round(DEVICE.bus.period_s * 1e3))
            self.number = self.port.read(self.row)
        return self.readings

    def run_up(self) -> None:
        """Start, greet, and have both drives in operation."""
        self.start()
        self.cycle(10, released=True)
        self.cycle(20, insertion_on=True, valve_on=True)
        assert self.insertion.is_enabled
        assert self.valve.is_enabled

    @property
    def readings(self) -> Readings:
        return plain_row.unpack(Readings, self.row)


@contextmanager
def virtual_time() -> Iterator[None]:
    """durand's timers go by steps."""
    before: AbstractScheduler[Any] = get_scheduler()
    set_scheduler(VirtualScheduler())
    try:
        yield
    finally:
        set_scheduler(before)
