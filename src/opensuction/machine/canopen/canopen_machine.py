"""The driver: a machine on a CANopen bus before the controller, as its device file describes it.

It produces SYNC: with each `write` set points go out and SYNC after them, and the nodes answer with
their readings, which the next `read` takes. Nothing here waits: nodes are set up between two reads
(`node_setup`), at the beginning and whenever one of them has started again. As long as a node is
not set up it is not put into operation, and no drive is: no set point is sent to it.

What speaks against a node is said once, in a line of the process's log, and its readings are
invalid as long as it does: the controller's alarms are of the readings.
"""

import math
from collections.abc import Sequence
from itertools import islice
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np

from opensuction import __version__
from opensuction.host.host import NS_PER_S, Host, Lock
from opensuction.kernel.codegen import plain_row
from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import DriveMessage
from opensuction.kernel.record import Array
from opensuction.machine.canopen import (
    device_file,
    node_setup,
    process_image,
    sensor_readings,
    set_point,
)
from opensuction.machine.canopen.device import Device, position_of
from opensuction.machine.canopen.frame_bus import CanFrame, FrameBus, open_bus
from opensuction.machine.canopen.node_setup import Setup
from opensuction.machine.canopen.objects import NmtCommand
from opensuction.machine.canopen.power_state import PowerState
from opensuction.machine.canopen.process_image import MODULE, NAMES, NEVER_S, STALE_S
from opensuction.machine.canopen.set_point import AT_START, SYNC, Axes
from opensuction.machine.port import NOTHING, Capabilities, MachineFacts, SimulatedHand, TruthPort

LOCK: Final = "canopen.lock"
"""File of a machine's folder that its controller holds: another one is refused."""
HOST_NAME: Final = "controller"
"""Of this participant on a bus of one computer."""
NODE_STARTS_S: Final = 10.0
"""[design] How long a node may take until it answers for the first time: it may have been switched
on together with this computer."""
REPEATS_S: Final = 0.25
"""How often a node that has not answered is asked again: all that is asked may be asked twice."""
SET_UP_S: Final = 20.0
"""[design] How long all of it may take."""
RESTARTED: Final = "has started again, and may have lost its position"
"""Objection to a drive, until a controller that starts anew asks both sensors of the head."""
MOST_FRAMES: Final = 2000
"""Frames that are taken in one reading: of a bus with more, what is taken is old."""


class Asking(NamedTuple):
    """Set-up of a node that is under way."""

    steps: Setup
    request: CanFrame
    repeat_s: float
    """When it is sent again."""
    ends_s: float
    """When it is given up."""
    has_answered: bool


class CanopenMachine:
    """A `port.Port` to the machine of a device file."""

    def __init__(self, device: Device, bus: FrameBus, host: Host, lock: Lock | None = None) -> None:
        """lock: let go of when the port is closed."""
        self.device, self._bus, self._host, self._lock = device, bus, host, lock
        self.image = process_image.EMPTY
        self._axes: Axes = (AT_START, AT_START)
        self._read = (math.nan, math.nan)
        self._asking: dict[int, Asking] = {}
        self._refused: dict[int, str] = {}
        self._boots = [0, 0, 0]
        self._restarted: set[int] = set()
        self.homing: set[int] = set()
        """Places of drives that are being homed."""
        self._beyond: set[int] = set()
        """Axes that are left without torque, as they stand beyond their range."""
        self._set_up_s = math.inf
        self._said: tuple[str, ...] = ("", "", "")
        self._number, self._newest_s = 0, NEVER_S
        self._sync_s = self._beat_s = self._written_s = self._behind_s = NEVER_S
        self.facts = _facts(device)
        for place in range(3):
            self._begin_set_up(place)

    @property
    def _is_set_up(self) -> bool:
        """True once all nodes have been as the device file says."""
        return self._set_up_s < math.inf

    def _now_s(self) -> float:
        return self._host.clock.monotonic_ns() / NS_PER_S

    def read(self, readings: Array) -> int:
        """The newest readings; see `port.Port.read`.

        Before the first ones the nodes are set up. Raises InputError where one of them is not as
        the device file says, or does not answer; nothing moves then.
        """
        now_s = self._now_s()
        self._drain(now_s)
        self._go_on_setting_up(now_s)
        if not self._is_set_up:
            self._conclude_first()
            return 0
        # Without a controller's commands, as before the first ones, it is asked for readings.
        if now_s - self._written_s > STALE_S and now_s - self._sync_s >= self.device.bus.period_s:
            self._send([], now_s)
        said = self._complaints(now_s)
        answers_s = max(STALE_S, self.device.heartbeats.lost_node_ms * 1e-3)
        newest_s = process_image.newest_s(self.image)
        if self._number == 0 and any(said) and now_s - self._set_up_s < answers_s:
            return 0  # the first answers are on their way
        if self._number == 0 or newest_s > self._newest_s:
            self._number, self._newest_s = self._number + 1, newest_s
        self._say(said)
        found = sensor_readings.readings(self.device, self.image, said, now_s)
        self._read = (found.head_mm, found.cam_rad)
        readings[:] = list(plain_row.numbers(found))
        return self._number

    def _complaints(self, now_s: float) -> list[str]:
        """Objections to each node's readings; "" where there are none."""
        if now_s - self._behind_s < process_image.FLOODED_S:
            return ["is behind: the bus carries more frames than are taken"] * 3
        power = (self._axes[0].power, self._axes[1].power)
        said = process_image.complaints(self.device, self.image, power, now_s)
        return [
            RESTARTED if place in self._restarted and not one else one
            for place, one in enumerate(said)
        ]

    def write(self, sent: Array) -> None:
        """New commands; see `port.Port.write`. One with what is no number in it is none."""
        now_s = self._now_s()
        if not self._is_set_up:
            return
        self._written_s = now_s
        if not np.isfinite(sent).all():
            self._send([], now_s)
            return
        message = plain_row.unpack(DriveMessage, sent)
        if message.released:
            self.image = process_image.forget_lost_host(self.image)
            self._restarted.clear()
        frames, self._axes = set_point.set_points(
            self.device,
            self.image,
            self._axes,
            message,
            now_s,
            self._restarted,
            self._read,
            self.homing,
        )
        self._say_beyond((message.commands.insertion_on, message.commands.valve_on))
        # Half a period forgives a time that is a number of periods.
        beat_s = self.device.heartbeats.host_ms * 1e-3 - 0.5 * self.device.bus.period_s
        if now_s - self._beat_s >= beat_s:
            frames.append(set_point.heartbeat(self.device))
            self._beat_s = now_s
        self._send(frames, now_s)

    def _say_beyond(self, wanted: tuple[bool, bool]) -> None:
        """Say of an axis that it gets no torque though the controller wants it, and why."""
        beyond = set()
        for place, axis in enumerate(self.device.axes):
            counts = self.image.axes[place].counts
            is_on = process_image.state_of(self.image, place) == PowerState.OPERATION_ENABLED
            may_be = place in self.homing or set_point.is_in_range(axis, counts)
            if not wanted[place] or is_on or may_be:
                continue
            beyond.add(place)
            if place not in self._beyond:
                self._host.say(
                    f"node {axis.node} ({NAMES[place]}) stands at {position_of(axis, counts):.2f}, "
                    f"beyond its range of {axis.lowest:g} to {axis.highest:g}: it gets no torque"
                )
        self._beyond = beyond

    def close(self) -> None:
        """No more commands: the drives' reaction to a lost host takes over."""
        self._bus.close()
        if self._lock is not None:
            self._lock.close()

    def _send(self, frames: list[CanFrame], now_s: float) -> None:
        """Send frames and SYNC."""
        self._bus.send([*frames, SYNC])
        self._sync_s = now_s

    def _drain(self, now_s: float) -> None:
        """Take what has come, and no more than `MOST_FRAMES` of it."""
        taken = 0
        for frame in islice(self._bus.receive(), MOST_FRAMES):
            taken += 1
            self.image = process_image.take(self.device, self.image, frame, now_s)
            for place, asking in list(self._asking.items()):
                if node_setup.is_answer(asking.request, frame):
                    self._answer(place, asking, frame.data, now_s)
        if taken == MOST_FRAMES:
            self._behind_s = now_s
        for place, node in enumerate(self.image.nodes):
            if node.boots > self._boots[place]:
                self._boots[place] = node.boots
                if self._is_set_up and place != MODULE:
                    self._restarted.add(place)
                self._begin_set_up(place)

    def _begin_set_up(self, place: int) -> None:
        """Set up a node from its beginning."""
        self._ask(place, node_setup.set_up(self.device, place), is_up=False)

    def is_asking(self, place: int) -> bool:
        """True while requests to a node are under way."""
        return place in self._asking

    def refusal(self, place: int) -> str:
        """Differences of a node that the last requests have found; "" for none."""
        return self._refused.get(place, "")

    def objection(self, place: int) -> str:
        """Objection to a node's readings, by the last look; "" for none."""
        return self._said[place]

    def ask(self, place: int, steps: Setup) -> None:
        """Begin with requests to a node that is set up, in place of those that are under way."""
        self._ask(place, steps, is_up=True)

    def _ask(self, place: int, steps: Setup, *, is_up: bool) -> None:
        """is_up: it has answered already, and stays operational."""
        now_s = self._now_s()
        self._refused.pop(place, None)
        self._asking[place] = Asking(
            steps,
            next(steps),
            repeat_s=now_s,
            ends_s=now_s + (node_setup.PATIENCE_S if is_up else NODE_STARTS_S),
            has_answered=is_up,
        )

    def _go_on_setting_up(self, now_s: float) -> None:
        """Ask again, or give up, where a node has not answered."""
        for place, asking in list(self._asking.items()):
            if now_s >= asking.ends_s:
                self._answer(place, asking, None, now_s)
            elif now_s >= asking.repeat_s:
                command = node_setup.nmt(NmtCommand.PREPARE, self.device.nodes[place])
                self._bus.send([*([] if asking.has_answered else [command]), asking.request])
                self._asking[place] = asking._replace(repeat_s=now_s + REPEATS_S)

    def _answer(self, place: int, asking: Asking, data: bytes | None, now_s: float) -> None:
        """Go on with a node's set-up. data: the answer; None where none came."""
        if data is None and not asking.has_answered:
            self._end_set_up(place, [f"it does not answer within {NODE_STARTS_S:g} s"])
            return
        try:
            request = asking.steps.send(data)
        except StopIteration as end:
            self._end_set_up(place, end.value)
            return
        self._asking[place] = asking._replace(
            request=request,
            repeat_s=now_s + REPEATS_S,
            ends_s=now_s + node_setup.PATIENCE_S,
            has_answered=True,
        )
        self._bus.send([request])

    def _end_set_up(self, place: int, wrong: list[str]) -> None:
        """A node is set up, or it is not as it should be."""
        del self._asking[place]
        if wrong:
            self._refused[place] = node_setup.describe(self.device, place, wrong)
            if self._is_set_up:
                self._host.say(f"{self._refused[place]}: it stays out of operation")
        elif self._is_set_up:
            self._start(place)

    def _start(self, place: int) -> None:
        """Put a node into operation."""
        self._bus.send([node_setup.nmt(NmtCommand.START, self.device.nodes[place])])

    def _conclude_first(self) -> None:
        """Put the nodes into operation, once all of them are set up."""
        if self._asking:
            return
        if self._refused:
            raise InputError(
                f"the machine '{self.device.name}' is not as its device file says, so nothing "
                "moves: " + " | ".join(self._refused[place] for place in sorted(self._refused))
            )
        self._set_up_s = self._now_s()
        for place in range(3):
            self._start(place)

    def _say(self, said: Sequence[str]) -> None:
        """Say what is new against a node, or that nothing is any more."""
        for place, (before, now) in enumerate(zip(self._said, said, strict=True)):
            if now.partition(";")[0] != before.partition(";")[0]:
                name = f"node {self.device.nodes[place]} ({NAMES[place]})"
                self._host.say(f"{name} {now}" if now else f"{name} is as it should be again")
        self._said = tuple(said)


def _facts(device: Device) -> MachineFacts:
    """Self-description of a machine of a device file."""
    return MachineFacts(
        name=device.name,
        version=__version__,
        in_silico=device.in_silico,
        period_s=device.bus.period_s,
        watchdog_s=device.heartbeats.lost_host_ms * 1e-3,
        most={
            "commands.head_mm": max(abs(device.insertion.lowest), device.insertion.highest),
            "commands.cam_rad": max(abs(device.valve.lowest), device.valve.highest),
            "commands.vacuum_mmhg": device.module.most_vacuum_mmhg,
        },
        capabilities=_capabilities(device),
        answers_s=SET_UP_S,
    )


def _capabilities(device: Device) -> Capabilities:
    return NOTHING._replace(
        monitor=device.module.monitor_bit >= 0,
        mouth_barrier=device.module.mouth_bit >= 0,
        taught_by_hand=True,
    )


def hold(folder: Path, host: Host) -> Lock:
    """Hold a folder's machine against others. Raises InputError where another one does."""
    try:
        lock = host.locks.take_file(folder / LOCK)
    except OSError as error:
        raise InputError(f"{folder / LOCK} cannot be written: {error.strerror}") from None
    if lock is None:
        raise InputError(f"the machine of {folder} is being driven by another process")
    return lock


def attach(folder: Path, host: Host) -> CanopenMachine:
    """See `port.Backend.attach`: the machine of the folder's device file."""
    device, lock = device_file.find(folder), hold(folder, host)
    try:
        bus = open_bus(device.bus, host, HOST_NAME, folder)
    except InputError:
        lock.close()
        raise
    return CanopenMachine(device, bus, host, lock)


def capabilities_of(folder: Path) -> Capabilities:
    """See `port.Backend.capabilities_of`."""
    return _capabilities(device_file.find(folder))


def hand_of(folder: Path) -> SimulatedHand | None:  # noqa: ARG001
    """See `port.Backend.hand_of`: a person's own."""
    return None


def truth_of(folder: Path) -> TruthPort | None:  # noqa: ARG001
    """See `port.Backend.truth_of`: nobody knows it."""
    return None
