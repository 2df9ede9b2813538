"""Set-up of a node by SDO: is it the one that the device file means, and does it take its values.

Identity and profile are asked first; a node that is another one is not written to. Then its PDOs
are mapped, its heartbeats, limits and its reaction to a lost host written, and the insertion
drive's own stop at contact is armed. What was written is read again: each difference is told. Only
a node without a difference is put into operation.

A generator of requests, for the control loop waits for nobody: a node that starts again while the
loop runs is set up between two ticks. All objects fit into an expedited transfer (CiA 301).
"""

import struct
from collections.abc import Generator, Iterator
from typing import Final, NamedTuple

from opensuction.machine.canopen import device as units
from opensuction.machine.canopen.device import AxisMode, Device, DriveAxis, Identity
from opensuction.machine.canopen.frame_bus import CanFrame
from opensuction.machine.canopen.objects import (
    AXIS_FEEDFORWARD,
    AXIS_MOTION,
    AXIS_STATUS,
    AXIS_TARGET,
    AXIS_TORQUE,
    MODULE_ANALOGUE,
    MODULE_ANNUNCIATOR,
    MODULE_DIGITAL,
    MODULE_OUTPUTS,
    NMT_ID,
    AbortConnection,
    Axis,
    Communication,
    Frame,
    Mode,
    Module,
    NmtCommand,
    rpdo_id,
    tpdo_id,
)
from opensuction.machine.canopen.process_image import INSERTION, MODULE, NAMES

PATIENCE_S: Final = 1.0
"""[design] How long a node that works may take for an answer."""
REQUEST_ID: Final = 0x600
ANSWER_ID: Final = 0x580
DRIVE_PROFILE, MODULE_PROFILE = 402, 401
"""In the low half of the device type (0x1000)."""
_INVALID: Final = 1 << 31
"""In a PDO's identifier: it does not exist."""
_SYNCHRONOUS: Final = 1
"""Transmission type: with each SYNC."""
_STAYS_OPERATIONAL: Final = 1
"""Error behaviour (0x1029): a node whose host is lost goes on giving its readings."""
_SLOW_DOWN: Final = 2
"""Quick stop and reaction to a fault: brake, then take the torque off."""
_MS: Final = -3
"""Power of ten of a second that the interpolation period is in."""
_EXPEDITED: Final = {4: 0x23, 2: 0x2B, 1: 0x2F}
"""Command to write so many bytes."""
_WRITTEN, _READ_REQUEST, _ABORTED = 0x60, 0x40, 0x80
_LENGTHS: Final = {0x43: 4, 0x47: 3, 0x4B: 2, 0x4F: 1, 0x42: 4}
_HEAD: Final = struct.Struct("<BHB")
_NO_OBJECT: Final = 0x06020000
_REASONS: Final = {
    _NO_OBJECT: "does not exist",
    0x06090011: "has no such subindex",
    0x06010002: "is read-only",
    0x06040041: "cannot be mapped",
    0x06070010: "has another length",
    0x06090030: "does not take this value",
    0x08000022: "cannot be written in this state",
}


MODES: Final = {AxisMode.POSITION: Mode.CYCLIC_POSITION, AxisMode.TORQUE: Mode.CYCLIC_TORQUE}


class Entry(NamedTuple):
    """A value of the object dictionary."""

    object_index: int
    sub: int
    bits: int
    value: int
    is_read_again: bool = True
    """Steps on the way to a value, such as a PDO that is switched off, are not."""
    may_lack: bool = False
    """A node that does not have the object does by itself what is asked for."""


class Refusal(NamedTuple):
    """Answer to a request that is not carried out."""

    words: str
    is_lacking: bool = False
    """The node does not have the object."""


Answer = bytes | None
"""Data of a frame; None where none came in time."""
Setup = Generator[CanFrame, Answer, list[str]]
"""Yields what to send, is sent the answer, and returns what is not as it should be."""


def nmt(command: NmtCommand, node: int) -> CanFrame:
    """A command to a node's NMT state machine."""
    return CanFrame(NMT_ID, bytes((command, node)))


def set_up(device: Device, place: int) -> Setup:
    """Set up a node that is pre-operational."""
    node = device.nodes[place]
    wrong = yield from _check_identity(device, place)
    if wrong:
        return wrong
    return (yield from _write_all(node, list(entries(device, place))))


def start_homing(device: Device, place: int) -> Setup:
    """Set up a drive without torque for homing; it begins with a bit of its control word."""
    axis = device.axes[place]
    return (yield from _write_all(axis.node, list(_homing_entries(axis))))


def end_homing(device: Device, place: int) -> Setup:
    """Set up a drive without torque for set points again."""
    axis = device.axes[place]
    return (yield from _write_all(axis.node, [Entry(Axis.MODE, 0, 8, MODES[axis.mode])]))


def _write_all(node: int, written: list[Entry]) -> Setup:
    """Write values, then read them again; differences in words."""
    wrong, refusals = [], set()
    for one in written:
        refused = yield from _write(node, one)
        if refused is None:
            continue
        refusals.add(one)
        found, unread = yield from _read(node, one.object_index, one.sub)
        is_so_anyway = unread is None and _is_same(one, found)
        if not is_so_anyway and not (one.may_lack and refused.is_lacking):
            wrong.append(refused.words)
    for one in written:
        if one.is_read_again and one not in refusals:
            value, refused = yield from _read(node, one.object_index, one.sub)
            if refused is None and not _is_same(one, value):
                wanted = one.value % (1 << one.bits)
                wrong.append(f"{_name(one.object_index, one.sub)} is {value:#x}, not {wanted:#x}")
    return wrong


def _is_same(one: Entry, value: int) -> bool:
    return (value - one.value) % (1 << one.bits) == 0


def _check_identity(device: Device, place: int) -> Generator[CanFrame, Answer, list[str]]:
    """Differences between a node and the one that the device file means."""
    node, wrong = device.nodes[place], []
    one = device.module if place == MODULE else device.axes[place]
    profile = MODULE_PROFILE if place == MODULE else DRIVE_PROFILE
    kind, refused = yield from _read(node, Communication.DEVICE_TYPE, 0)
    if refused is not None:
        return [refused.words]
    if kind & 0xFFFF != profile:
        wrong.append(f"its profile is CiA {kind & 0xFFFF}, not CiA {profile}")
    for sub, name in enumerate(Identity._fields, 1):
        wanted = getattr(one.identity, name)
        if wanted:
            found, refused = yield from _read(node, Communication.IDENTITY, sub)
            if refused is not None:
                wrong.append(refused.words)
            elif found != wanted:
                wrong.append(f"its {name} is {found:#x}, not {wanted:#x}")
    if place != MODULE:
        modes, refused = yield from _read(node, Axis.SUPPORTED_MODES, 0)
        mode = device.axes[place].mode
        if refused is None and not modes >> (MODES[mode] - 1) & 1:
            wrong.append(f"it has no cyclic synchronous {mode} mode (0x6502)")
    return wrong


def read_identity(
    device: Device, place: int
) -> Generator[CanFrame, Answer, tuple[int, int, int] | None]:
    """Vendor, product and revision of a node; None of one that does not answer."""
    values = []
    for sub in range(1, len(Identity._fields) + 1):
        value, refused = yield from _read(device.nodes[place], Communication.IDENTITY, sub)
        if refused is not None:
            return None
        values.append(value)
    return values[0], values[1], values[2]


def entries(device: Device, place: int) -> Iterator[Entry]:
    """All that is written into a node, in order."""
    node, beats = device.nodes[place], device.heartbeats
    watched = device.host_node << 16 | beats.lost_host_ms
    yield Entry(Communication.HEARTBEAT_PRODUCER_MS, 0, 16, beats.node_ms)
    yield Entry(Communication.HEARTBEAT_CONSUMER, 1, 32, watched)
    yield Entry(Communication.ERROR_BEHAVIOUR, 1, 8, _STAYS_OPERATIONAL)
    if place == MODULE:
        yield from _module_entries(device, node)
    else:
        axis = device.axes[place]
        yield from _axis_entries(device, axis)
    if place == INSERTION:
        for one in device.contact.stop:
            yield Entry(one.object_index, one.sub, one.bits, one.value)


def _axis_entries(device: Device, axis: DriveAxis) -> Iterator[Entry]:
    yield from _pdo(Communication.RPDO, 1, rpdo_id(axis.node, 1), AXIS_TARGET)
    yield from _pdo(Communication.TPDO, 1, tpdo_id(axis.node, 1), AXIS_STATUS)
    yield from _pdo(Communication.TPDO, 2, tpdo_id(axis.node, 2), AXIS_MOTION)
    yield Entry(Axis.ABORT_CONNECTION, 0, 16, AbortConnection(axis.lost_host))
    yield Entry(Axis.QUICK_STOP, 0, 16, _SLOW_DOWN)
    yield Entry(Axis.FAULT_REACTION, 0, 16, _SLOW_DOWN)
    if axis.mode == AxisMode.TORQUE:
        yield from _pdo(Communication.RPDO, 2, rpdo_id(axis.node, 2), AXIS_TORQUE)
    elif axis.velocity_offset:
        yield from _pdo(Communication.RPDO, 2, rpdo_id(axis.node, 2), AXIS_FEEDFORWARD)
    yield Entry(Axis.MODE, 0, 8, MODES[axis.mode])
    yield Entry(Axis.INTERPOLATION_PERIOD, 1, 8, round(device.bus.period_s * 1e3))
    yield Entry(Axis.INTERPOLATION_PERIOD, 2, 8, _MS)
    yield Entry(Axis.MAX_TORQUE, 0, 16, round(axis.most_torque * 1000))
    yield Entry(Axis.MAX_SPEED, 0, 32, axis.most_rpm)
    ends = sorted(units.counts_of(axis, end) for end in (axis.lowest, axis.highest))
    for sub, end in enumerate(ends, 1):
        yield Entry(Axis.POSITION_LIMIT, sub, 32, end)
    window, is_off = units.window_of(axis), axis.following_window == 0.0
    yield Entry(Axis.FOLLOWING_ERROR_WINDOW, 0, 32, window, may_lack=is_off)


def _homing_entries(axis: DriveAxis) -> Iterator[Entry]:
    homing, counts = axis.homing, abs(axis.counts_per_unit)
    here = units.wrap(axis.zero_counts + round(homing.at * axis.counts_per_unit))
    yield Entry(Axis.MODE, 0, 8, Mode.HOMING)
    yield Entry(Axis.HOMING_METHOD, 0, 8, homing.method)
    yield Entry(Axis.HOME_OFFSET, 0, 32, here)
    if homing.moves:
        yield Entry(Axis.HOMING_SPEEDS, 1, 32, round(homing.per_s * counts))
        yield Entry(Axis.HOMING_SPEEDS, 2, 32, round(homing.slow_per_s * counts))
        yield Entry(Axis.HOMING_ACCELERATION, 0, 32, round(homing.per_s2 * counts))


def _module_entries(device: Device, node: int) -> Iterator[Entry]:
    yield from _pdo(Communication.RPDO, 1, rpdo_id(node, 1), MODULE_OUTPUTS)
    yield from _pdo(Communication.RPDO, 2, rpdo_id(node, 2), MODULE_ANNUNCIATOR)
    yield from _pdo(Communication.TPDO, 1, tpdo_id(node, 1), MODULE_DIGITAL)
    for k, layout in enumerate(MODULE_ANALOGUE, 2):
        yield from _pdo(Communication.TPDO, k, tpdo_id(node, k), layout)
    regulator = device.module.regulator
    # Without a host the outputs go to these: the pump off, the line vented.
    yield Entry(Module.OUTPUT_ERROR_MODE, 1, 8, 0xFF)
    yield Entry(Module.OUTPUT_ERROR_VALUE, 1, 8, 0)
    yield Entry(Module.ANALOGUE_ERROR_MODE, regulator.channel, 8, 1)
    yield Entry(Module.ANALOGUE_ERROR_VALUE, regulator.channel, 32, regulator.zero_counts)


def _pdo(kind: Communication, number: int, can_id: int, layout: Frame) -> Iterator[Entry]:
    """Mapping of a PDO, which has to be switched off meanwhile (CiA 301)."""
    mapping = Communication.RPDO_MAP if kind == Communication.RPDO else Communication.TPDO_MAP
    index, mapped = kind + number - 1, mapping + number - 1
    yield Entry(index, 1, 32, can_id | _INVALID, is_read_again=False)
    yield Entry(mapped, 0, 8, 0, is_read_again=False)
    for sub, entry in enumerate(layout.entries, 1):
        yield Entry(mapped, sub, 32, entry)
    yield Entry(mapped, 0, 8, len(layout.entries))
    yield Entry(index, 2, 8, _SYNCHRONOUS)
    yield Entry(index, 1, 32, can_id, is_read_again=False)


def _write(node: int, one: Entry) -> Generator[CanFrame, Answer, Refusal | None]:
    """Write a value."""
    length = one.bits // 8
    value = (one.value % (1 << one.bits)).to_bytes(length, "little")
    head = _HEAD.pack(_EXPEDITED[length], one.object_index, one.sub)
    answer = yield CanFrame(REQUEST_ID + node, head + value.ljust(4, b"\0"))
    return _refusal(answer, one.object_index, one.sub, answer is not None and answer[0] == _WRITTEN)


def _read(
    node: int, index: int, sub: int
) -> Generator[CanFrame, Answer, tuple[int, Refusal | None]]:
    """A value, or its refusal."""
    request = _HEAD.pack(_READ_REQUEST, index, sub) + bytes(4)
    answer = yield CanFrame(REQUEST_ID + node, request)
    length = _LENGTHS.get(answer[0], 0) if answer else 0
    refused = _refusal(answer, index, sub, length > 0)
    return int.from_bytes((answer or b"")[4 : 4 + length], "little"), refused


def is_answer(request: CanFrame, frame: CanFrame) -> bool:
    """True where a frame answers a request: from the same node, of the same object.

    A request may be answered twice, where it was repeated: what answers to reading is no answer to
    writing.
    """
    if frame.can_id != request.can_id - REQUEST_ID + ANSWER_ID or len(frame.data) != 8:
        return False
    reads = request.data[0] == _READ_REQUEST
    others = frame.data[0] == _WRITTEN if reads else frame.data[0] in _LENGTHS
    return frame.data[1:4] == request.data[1:4] and not others


def _refusal(answer: Answer, index: int, sub: int, is_done: bool) -> Refusal | None:
    if is_done:
        return None
    name = _name(index, sub)
    if answer is None:
        return Refusal(f"it does not answer to {name}")
    if answer[0] == _ABORTED:
        code = int.from_bytes(answer[4:8], "little")
        reason = _REASONS.get(code, f"is refused with code {code:#010x}")
        return Refusal(f"{name} {reason}", is_lacking=code == _NO_OBJECT)
    return Refusal(f"it answers nonsense to {name}: {answer.hex(' ')}")


def _name(index: int, sub: int) -> str:
    return f"object {index:#06x}:{sub:02x}"


def describe(device: Device, place: int, wrong: list[str]) -> str:
    """Differences of a node in words."""
    return f"node {device.nodes[place]} ({NAMES[place]}): {'; '.join(wrong)}"
