"""Three emulated nodes around a twin: what they measure is its readings, what they do its commands.

In each tick the nodes first take the frames that have come, a SYNC among them, and answer; then the
drives and the module give the twin its commands for the tick. Without a host the twin's own
watchdog draws the head home (`AbortConnection.WITHDRAW`): the nodes decide when it begins, so its
own patience is none (`without_patience`).
"""

from itertools import islice
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np

from opensuction.control.servo import Servo
from opensuction.host.host import Clock
from opensuction.kernel.codegen import plain_row
from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import MESSAGE_COLUMNS, Readings
from opensuction.kernel.record import Array
from opensuction.machine.canopen.device import Device
from opensuction.machine.canopen.frame_bus import CanFrame, FrameBus
from opensuction.machine.canopen.objects import Axis
from opensuction.machine.drives import node_fault
from opensuction.machine.drives.emulated_drive import EmulatedDrive, Motor, Order, Seen
from opensuction.machine.drives.emulated_module import ALONE, EmulatedModule, Outputs
from opensuction.machine.drives.emulated_node import INTERNAL, EmulatedNode
from opensuction.machine.drives.node_fault import ALL, NodeFault, Request
from opensuction.machine.twin.twin_machine import SHOWN_READINGS
from opensuction.simulation.machine_side import SHOWN_COLUMNS, MachineSide
from opensuction.twin.machine.machine import Machine

MOST_FRAMES: Final = 2000
"""Frames that are taken in a tick: a bus that is flooded keeps no node from its work."""
_ALONE: Final = SHOWN_COLUMNS.index("alone")
_NO_MAINS: Final = 0x3120
"""Error code of CiA 402: the supply's voltage is too low. The drives have reserve energy."""
_NO_TORQUE: Final = Order(0.0, 0.0, is_on=False)
_NO_OUTPUT: Final = Outputs(
    pump_on=False, vacuum_mmhg=0.0, wanted=ALONE, reset=False, released=False
)


class Servos(NamedTuple):
    """Servos in the drives."""

    insertion: Servo
    valve: Servo


def without_patience(side: MachineSide) -> MachineSide:
    """The machine side whose watchdog acts as soon as the nodes have it act."""
    watchdog = side.wiring.watchdog._replace(silence_s=0.0)
    return side._replace(wiring=side.wiring._replace(watchdog=watchdog))


def motors(machine: Machine, device: Device) -> tuple[Motor, Motor]:
    """Motors of insertion and valve, by the twin's parameters and the drives' rated currents.

    The twin measures no current of the valve's motor: rated is what its drive limits it to.
    """
    insertion, valve = machine.insertion_axis, machine.valve_axis
    rated_v = device.insertion.rated_current_a / machine.amperes_per_v
    return Motor(insertion.speed_per_v, rated_v), Motor(valve.speed_per_v, valve.force_v)


def stops_at_contact(device: Device) -> tuple[int, int]:
    """Inputs of the insertion drive that forbid motion towards higher and lower counts."""
    mask = 1 << device.contact.closed_bit
    return (mask, 0) if device.insertion.counts_per_unit > 0.0 else (0, mask)


def check_stop(device: Device, file: Path) -> None:
    """Raises InputError where a device file's stop at contact forbids the way out."""
    outwards = Axis.STOP_DOWN if device.insertion.counts_per_unit > 0.0 else Axis.STOP_UP
    for number, one in enumerate(device.contact.stop, 1):
        if one.object_index == outwards and one.value >> device.contact.closed_bit & 1:
            other = Axis.STOP_UP if outwards == Axis.STOP_DOWN else Axis.STOP_DOWN
            raise InputError(
                f"{file}: contact.stop[{number}] is object {outwards:#06x}, which at contact holds "
                f"the head back on its way out; give {other:#06x}, or check "
                "insertion.encoder.reversed"
            )


class EmulatedMachine:
    """The nodes of a machine, a tick at a time."""

    def __init__(
        self, device: Device, machine: Machine, servos: Servos, bus: FrameBus, clock: Clock
    ) -> None:
        self.device, self._bus = device, bus
        self._amperes_per_v = machine.amperes_per_v
        insertion, valve = motors(machine, device)
        self.insertion = EmulatedDrive(device.insertion, servos.insertion, insertion, clock)
        self.insertion.stops = stops_at_contact(device)
        self.valve = EmulatedDrive(device.valve, servos.valve, valve, clock)
        self.module = EmulatedModule(device.module, clock)
        self.row: Array = np.zeros(len(MESSAGE_COLUMNS))
        """What the twin is commanded, by `MESSAGE_COLUMNS`."""
        self._lost: set[int] = set()
        """Nodes without power."""
        self._blind: set[int] = set()
        """Drives whose encoder tells nothing."""
        self.has_news = True
        """The twin's watchdog hears of somebody who looks after it."""
        for node in self.nodes:
            node.boot()

    @property
    def nodes(self) -> tuple[EmulatedNode, EmulatedNode, EmulatedNode]:
        """Insertion drive, valve drive and module."""
        return self.insertion, self.valve, self.module

    def exchange(self) -> None:
        """Take the frames that have come, and send what leaves."""
        came, leaving = list(islice(self._bus.receive(), MOST_FRAMES)), list[CanFrame]()
        for node in self.nodes:
            if node.number in self._lost:
                continue
            node.transceiver.bring(came)
            node.step()
            leaving += node.transceiver.take_leaving()
        if leaving:
            self._bus.send(leaving)

    def measure(self, shown: Array) -> None:
        """Take what the twin shows after a tick: a row by `SHOWN_COLUMNS`."""
        readings = plain_row.unpack(Readings, shown[SHOWN_READINGS])
        if shown[_ALONE] and not self.insertion.withdraws:
            self.insertion.withdraw(_NO_MAINS)
            self.insertion.emergency(_NO_MAINS)
        if self.insertion.number in self._blind:
            readings = readings._replace(head_valid=False)
        if self.valve.number in self._blind:
            readings = readings._replace(cam_valid=False)
        self.insertion.measure(self._seen(readings))
        self.valve.measure(Seen(readings.cam_rad, readings.cam_valid, None, 0))
        self.module.measure(readings)

    def tick(self) -> None:
        """The drives a tick on: what the twin is commanded in it is in `row`."""
        insertion, valve = (
            _NO_TORQUE if one.number in self._lost else one.tick()
            for one in (self.insertion, self.valve)
        )
        has_module = self.module.number not in self._lost
        outputs = self.module.outputs if has_module else _NO_OUTPUT
        self.row[:] = (
            insertion.position,
            insertion.volts,
            insertion.is_on,
            valve.position,
            valve.volts,
            valve.is_on,
            outputs.pump_on,
            outputs.vacuum_mmhg,
            outputs.wanted,
            outputs.reset,
            outputs.released or self.insertion.was_reset,
            0.0,  # the speed is for drives, not for what is behind them
        )
        # A drive without power has no program to run, either.
        self.has_news = not self.insertion.withdraws or self.insertion.number in self._lost

    def break_down(self, request: Request | None) -> None:
        """Give nodes a fault; None mends all of them. Raises InputError where there is no node."""
        if request is None:
            self._mend()
            return
        if request.node not in (ALL, *self.device.nodes):
            raise InputError(
                f"there is no node {request.node}; nodes: {', '.join(map(str, self.device.nodes))}"
            )
        for node in self.nodes:
            if request.node in (ALL, node.number):
                self._break(node, request)

    def _break(self, node: EmulatedNode, request: Request) -> None:
        wires = node.transceiver
        wires.faults = node_fault.wire_faults(wires.faults, request)
        if request.fault == NodeFault.NODE_LOST:
            self._lost.add(node.number)
        elif request.fault == NodeFault.ENCODER:
            self._blind.add(node.number)
        elif request.fault == NodeFault.EMERGENCY:
            node.fail(INTERNAL)

    def _mend(self) -> None:
        for node in self.nodes:
            node.transceiver.faults = node_fault.MENDED
            if node.number in self._lost:
                node.boot()
        self._lost.clear()
        self._blind.clear()

    def _seen(self, readings: Readings) -> Seen:
        contact = self.device.contact
        closed = readings.contact_closed << contact.closed_bit
        wired = readings.contact_valid << contact.wired_bit
        drive_v = readings.insertion_current_a / self._amperes_per_v
        return Seen(readings.head_mm, readings.head_valid, drive_v, closed | wired)
