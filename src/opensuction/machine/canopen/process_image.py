"""Process image: the newest that each node of a bus has said.

Frames and time in: no bus and no clock. What a node says counts while it is fresh, while the node
gives signs of life in NMT state operational, and while nothing speaks against it; else its
readings (`sensor_readings`) are invalid, and one line says why (`complaints`). A frame that is lost
or holds nonsense is as one that did not come: what was read before it stands until it is stale.
"""

import struct
from collections.abc import Sequence
from typing import Final, NamedTuple

from opensuction.machine.canopen import device as units
from opensuction.machine.canopen.device import Analogue, Device
from opensuction.machine.canopen.frame_bus import CanFrame
from opensuction.machine.canopen.objects import (
    AXIS_MOTION,
    AXIS_STATUS,
    EMERGENCY_ID,
    HEARTBEAT_ID,
    MODULE_ANALOGUE,
    MODULE_DIGITAL,
    Frame,
    NmtState,
    tpdo_id,
)
from opensuction.machine.canopen.power_state import PowerControl, PowerState, read_state

STALE_S: Final = 0.02
"""For so long a reading stands without a new frame: as long as the control loop takes readings that
do not change. Of frames of 4 ms five in a row are missing then."""
LOAD_FRAMES: Final = 200.0
"""Frames that a node may be ahead of `CYCLE_FRAMES` in each period before it counts as flooding."""
CYCLE_FRAMES: Final = 10.0
"""Frames of a node in a period: three of readings, a heartbeat, an emergency, an answer."""
CREDIT_S: Final = 1.0
"""What a node could have sent in this time may come at once: this computer may have stood still."""
FLOODED_S: Final = 1.0
"""For so long a node that has flooded the bus counts for nothing."""
RAILS: Final = (-0x8000, 0x7FFF)
"""Ends of an analogue channel: beyond its range, or a wire that is broken."""
TORQUE_S: Final = 0.012
"""Time over which a drive's torque is averaged. A servo goes by the steps of its encoder, and its
torque swings meanwhile by as much as the rated one: what is computed of single values is not what
the axis does. Measured, see docs/evidence/2026-11-29-drives-on-a-bus.md."""
RATE_S: Final = 0.02
"""[design] Time over which the change of an analogue input is averaged: a step of a tenth of a
millimetre of the head's second sensor is 5 mm/s then, and .02 mm in a period of 4 ms."""
COMMUNICATION_ERROR: Final = 0x81
"""High byte of an emergency's code: the node misses its host (CiA 301)."""
_ERROR_RESET: Final = 0xFF00
"""An emergency without any of these bits says that there is none any more (CiA 301)."""
NEVER_S: Final = -1e9
INSERTION, VALVE, MODULE = 0, 1, 2
"""Places of the nodes."""
NAMES: Final = ("insertion drive", "valve drive", "input module")


class NodeImage(NamedTuple):
    """Signs of life of a node, and of trouble."""

    nmt: int
    """As its newest heartbeat tells it."""
    beat_s: float
    """When that came."""
    boots: int
    """How often it has said that it starts: what was written into it is gone then."""
    emergency: int
    """Code of its newest emergency; 0: none, or over."""
    nonsense: str
    """Its newest frame that could not be read; "" for none."""
    load: float
    """Frames ahead of what a node sends."""
    load_s: float
    flooded_s: float
    """When it last was too far ahead."""


class AxisImage(NamedTuple):
    """Newest frames of a drive, with the times at which they came."""

    status: int
    counts: int
    torque: float
    """In thousandths of the rated one, averaged over `TORQUE_S`."""
    status_s: float
    velocity: int
    """Counts/s."""
    inputs: int
    motion_s: float


class ModuleImage(NamedTuple):
    """Newest frames of the module of inputs and outputs."""

    digital: int
    digital_s: float
    analogue: tuple[int, ...]
    """Channels 1 to 8."""
    analogue_s: tuple[float, float]
    """Of channels 1 to 4, and 5 to 8."""
    rates: tuple[float, ...]
    """Counts/s of each channel, averaged over `RATE_S`."""


class ProcessImage(NamedTuple):
    """The newest that the nodes have said."""

    nodes: tuple[NodeImage, NodeImage, NodeImage]
    axes: tuple[AxisImage, AxisImage]
    module: ModuleImage


_NODE: Final = NodeImage(NmtState.BOOTING, NEVER_S, 0, 0, "", 0.0, NEVER_S, NEVER_S)
_AXIS: Final = AxisImage(0, 0, 0.0, NEVER_S, 0, 0, NEVER_S)
EMPTY: Final = ProcessImage(
    (_NODE, _NODE, _NODE),
    (_AXIS, _AXIS),
    ModuleImage(0, NEVER_S, (0,) * 8, (NEVER_S, NEVER_S), (0.0,) * 8),
)
"""Nothing has come yet."""


def take(device: Device, image: ProcessImage, frame: CanFrame, now_s: float) -> ProcessImage:
    """The image after a frame; one of nobody's, or of another service, changes nothing."""
    node = frame.can_id & 0x7F
    if node not in device.nodes:
        return image
    place, service = device.nodes.index(node), frame.can_id & 0x780
    image = _set_node(image, place, _count(device, image.nodes[place], now_s))
    one = image.nodes[place]
    if service == HEARTBEAT_ID:
        return _set_node(image, place, _take_heartbeat(one, frame.data, now_s))
    if service == EMERGENCY_ID:
        return _set_node(image, place, _take_emergency(one, frame.data))
    try:
        return _take_readings(image, place, service, frame.data, now_s)
    except (struct.error, ValueError) as error:
        words = f"frame {frame.can_id:#05x} [{frame.data.hex(' ')}]: {error}"
        return _set_node(image, place, one._replace(nonsense=words))


def _set_node(image: ProcessImage, place: int, node: NodeImage) -> ProcessImage:
    nodes = list(image.nodes)
    nodes[place] = node
    return image._replace(nodes=(nodes[0], nodes[1], nodes[2]))


def _count(device: Device, node: NodeImage, now_s: float) -> NodeImage:
    """One frame more of a node."""
    due = (now_s - node.load_s) / device.bus.period_s * CYCLE_FRAMES
    spared = CREDIT_S / device.bus.period_s * CYCLE_FRAMES
    load = max(node.load - due, -spared) + 1.0
    flooded_s = now_s if load > LOAD_FRAMES else node.flooded_s
    return node._replace(load=min(load, LOAD_FRAMES + 1.0), load_s=now_s, flooded_s=flooded_s)


def _take_heartbeat(node: NodeImage, data: bytes, now_s: float) -> NodeImage:
    if len(data) != 1 or data[0] & 0x7F not in tuple(NmtState):
        return node._replace(nonsense=f"heartbeat [{data.hex(' ')}]")
    state = data[0] & 0x7F
    boots = node.boots + (state == NmtState.BOOTING)
    return node._replace(nmt=state, beat_s=now_s, boots=boots)


def _take_emergency(node: NodeImage, data: bytes) -> NodeImage:
    if len(data) != 8:
        return node._replace(nonsense=f"emergency [{data.hex(' ')}]")
    code = int.from_bytes(data[:2], "little")
    is_over = not code & _ERROR_RESET
    if is_over and _misses_host(node):
        return node  # it hears the host again, which has not started anew
    return node._replace(emergency=0 if is_over else code)


def _misses_host(node: NodeImage) -> bool:
    return node.emergency >> 8 == COMMUNICATION_ERROR


def _take_readings(
    image: ProcessImage, place: int, service: int, data: bytes, now_s: float
) -> ProcessImage:
    """A frame of readings. Raises struct.error or ValueError for nonsense."""
    if place == MODULE:
        return image._replace(module=_take_inputs(image.module, service, data, now_s))
    axis = image.axes[place]
    if service == tpdo_id(0, 1):
        status, counts, now = AXIS_STATUS.unpack(data)
        read_state(status)
        share = min((now_s - axis.status_s) / TORQUE_S, 1.0)
        torque = axis.torque + share * (now - axis.torque)
        axis = axis._replace(status=status, counts=counts, torque=torque, status_s=now_s)
    elif service == tpdo_id(0, 2):
        velocity, inputs = AXIS_MOTION.unpack(data)
        axis = axis._replace(velocity=velocity, inputs=inputs, motion_s=now_s)
    insertion, valve = image.axes
    return image._replace(axes=(axis, valve) if place == INSERTION else (insertion, axis))


def _take_inputs(module: ModuleImage, service: int, data: bytes, now_s: float) -> ModuleImage:
    if service == tpdo_id(0, 1):
        low, high = MODULE_DIGITAL.unpack(data)
        return module._replace(digital=low | high << 8, digital_s=now_s)
    for k, layout in enumerate(MODULE_ANALOGUE):
        if service == tpdo_id(0, 2 + k):
            return _take_channels(module, layout, k, data, now_s)
    return module


def _take_channels(
    module: ModuleImage, layout: Frame, k: int, data: bytes, now_s: float
) -> ModuleImage:
    values, times = list(module.analogue), list(module.analogue_s)
    rates, since_s = list(module.rates), now_s - times[k]
    for channel, counts in enumerate(layout.unpack(data), 4 * k):
        if counts in RAILS or values[channel] in RAILS or times[k] == NEVER_S:
            rates[channel] = 0.0
        elif since_s > 0.0:
            gained = (counts - values[channel]) / since_s - rates[channel]
            rates[channel] += gained * min(since_s / RATE_S, 1.0)
        values[channel] = counts
    times[k] = now_s
    return module._replace(
        analogue=tuple(values), analogue_s=(times[0], times[1]), rates=tuple(rates)
    )


def forget_lost_host(image: ProcessImage) -> ProcessImage:
    """The image without emergencies about a host that was lost: one has started anew."""
    for place, node in enumerate(image.nodes):
        if _misses_host(node):
            image = _set_node(image, place, node._replace(emergency=0))
    return image


def has_missed_host(image: ProcessImage, place: int) -> bool:
    """True for a node that has missed its host, until `forget_lost_host`."""
    return _misses_host(image.nodes[place])


def newest_s(image: ProcessImage) -> float:
    """Time at which the newest frame of readings came."""
    axes = (time for one in image.axes for time in (one.status_s, one.motion_s))
    return max(*axes, image.module.digital_s, *image.module.analogue_s)


def state_of(image: ProcessImage, place: int) -> PowerState:
    """Power state that a drive's newest status word tells; not ready before the first."""
    axis = image.axes[place]
    if axis.status_s == NEVER_S:
        return PowerState.NOT_READY
    return read_state(axis.status)


def is_obeying(device: Device, image: ProcessImage, place: int, now_s: float) -> bool:
    """True while a node takes set points: it lives, and is operational."""
    node = image.nodes[place]
    return node.nmt == NmtState.OPERATIONAL and now_s - node.beat_s <= _lost_s(device)


def _lost_s(device: Device) -> float:
    return device.heartbeats.lost_node_ms * 1e-3


def complaints(
    device: Device, image: ProcessImage, power: Sequence[PowerControl], now_s: float
) -> tuple[str, str, str]:
    """Objections to each node's readings, in words; "" where there are none."""
    found = [_complaint(device, image.nodes[place], now_s) for place in range(3)]
    for place in (INSERTION, VALVE):
        found[place] = found[place] or _drive_complaint(image, place, power[place], now_s)
    fresh_s = min(image.module.digital_s, *_used_s(device, image.module))
    if now_s - fresh_s > STALE_S:
        found[MODULE] = found[MODULE] or _silent(image.nodes[MODULE])
    return found[0], found[1], found[2]


def _complaint(device: Device, node: NodeImage, now_s: float) -> str:
    """Objection to a node of any kind."""
    if now_s - node.flooded_s < FLOODED_S:
        return "floods the bus"
    if now_s - node.beat_s > _lost_s(device):
        return "is lost: no heartbeat" if node.beat_s > NEVER_S else "has given no heartbeat"
    if node.nmt != NmtState.OPERATIONAL:
        return f"is not operational: {NmtState(node.nmt).name.lower().replace('_', '-')}"
    return f"reports emergency {node.emergency:#06x}" if node.emergency else ""


def _drive_complaint(image: ProcessImage, place: int, power: PowerControl, now_s: float) -> str:
    """Objection to a drive, beyond `_complaint`."""
    axis = image.axes[place]
    if now_s - min(axis.status_s, axis.motion_s) > STALE_S:
        return _silent(image.nodes[place])
    if power.lost:
        state = read_state(axis.status).name.lower().replace("_", " ")
        return f"left operation without being told: {state}"
    return ""


def _silent(node: NodeImage) -> str:
    """Complaint about readings that do not come, with what came instead."""
    return "gives no readings" + (f"; nonsense came: {node.nonsense}" if node.nonsense else "")


def _used_s(device: Device, module: ModuleImage) -> tuple[float, ...]:
    """Times of the frames of analogue inputs that the machine has."""
    inputs = device.module
    channels = [one.channel for one in _inputs(inputs) if one.channel]
    return tuple(module.analogue_s[k] for k in {(channel - 1) // 4 for channel in channels})


def _inputs(module: units.InputModule) -> tuple[Analogue, ...]:
    return (
        module.vacuum,
        module.carriage,
        module.spo2,
        module.heart_rate,
        module.airway_pressure,
    )
