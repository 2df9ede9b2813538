"""Process image: the newest that each node of a bus has said, and the readings that it makes.

Frames and time in, readings out: no bus and no clock. What a node says counts while it is fresh,
while the node gives signs of life in NMT state operational, and while nothing speaks against it;
else its readings are invalid, and one line says why (`complaints`). A frame that is lost or holds
nonsense is as one that did not come: what was read before it stands until it is stale.
"""

import struct
from collections.abc import Sequence
from typing import Final, NamedTuple

from opensuction.kernel.interface import LARGEST, Monitor, Readings
from opensuction.machine.canopen import device as units
from opensuction.machine.canopen.device import Analogue, Device, DriveAxis
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
_RAILS: Final = (-0x8000, 0x7FFF)
"""Ends of an analogue channel: beyond its range, or a wire that is broken."""
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
    torque: int
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


class ProcessImage(NamedTuple):
    """The newest that the nodes have said."""

    nodes: tuple[NodeImage, NodeImage, NodeImage]
    axes: tuple[AxisImage, AxisImage]
    module: ModuleImage


_NODE: Final = NodeImage(NmtState.BOOTING, NEVER_S, 0, 0, "", 0.0, NEVER_S, NEVER_S)
_AXIS: Final = AxisImage(0, 0, 0, NEVER_S, 0, 0, NEVER_S)
EMPTY: Final = ProcessImage(
    (_NODE, _NODE, _NODE),
    (_AXIS, _AXIS),
    ModuleImage(0, NEVER_S, (0,) * 8, (NEVER_S, NEVER_S)),
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
        status, counts, torque = AXIS_STATUS.unpack(data)
        read_state(status)
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
    values[4 * k : 4 * k + 4] = layout.unpack(data)
    times[k] = now_s
    return module._replace(analogue=tuple(values), analogue_s=(times[0], times[1]))


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


def readings(
    device: Device, image: ProcessImage, said: Sequence[str], now_s: float = NEVER_S
) -> Readings:
    """Readings that the controller gets.

    said: `complaints`. now_s: time for which positions count; without it, as they came.
    """
    insertion, valve = image.axes
    head_mm, head_valid = _position(device, device.insertion, insertion, now_s)
    cam_rad, cam_valid = _position(device, device.valve, valve, now_s)
    inputs, wired = device.module, not said[MODULE]
    carriage_mm, carriage_valid = _value(inputs.carriage, image.module)
    vacuum_mmhg, vacuum_valid = _value(inputs.vacuum, image.module)
    sound = not said[INSERTION]
    amperes = insertion.torque * 1e-3 * device.insertion.rated_current_a
    return Readings(
        head_mm=head_mm,
        head_valid=head_valid and sound,
        carriage_mm=carriage_mm,
        carriage_valid=carriage_valid and wired,
        cam_rad=cam_rad,
        cam_valid=cam_valid and not said[VALVE],
        line_vacuum_mmhg=vacuum_mmhg,
        vacuum_valid=vacuum_valid and wired,
        contact_closed=_bit(insertion.inputs, device.contact.closed_bit),
        contact_valid=_bit(insertion.inputs, device.contact.wired_bit) and sound,
        mouth_clear=_bit(image.module.digital, inputs.mouth_bit) and wired,
        insertion_current_a=-amperes if device.insertion.encoder.reversed else amperes,
        monitor=_monitor(device, image.module, wired),
    )


def _position(
    device: Device, axis: DriveAxis, image: AxisImage, now_s: float
) -> tuple[float, bool]:
    """Position in mm or rad, and True where an axis can be there: within twice its range.

    A drive answers SYNC with where it is then, and that is read a period later: by its speed it
    has gone on meanwhile, and as far again while a frame is missing.
    """
    found = units.position_of(axis, image.counts)
    if now_s >= image.status_s > NEVER_S:
        period_s = device.bus.period_s
        age_s = period_s + min(now_s - image.status_s, period_s)
        speed = image.velocity / axis.counts_per_unit
        found += min(max(speed, -axis.most_per_s), axis.most_per_s) * age_s
    span = axis.highest - axis.lowest
    if not axis.lowest - span <= found <= axis.highest + span:
        return min(max(found, -LARGEST), LARGEST), False
    return found, True


def _value(channel: Analogue, module: ModuleImage) -> tuple[float, bool]:
    """Value of an analogue input, and True where it can be one; 0 where there is none."""
    if channel.channel == 0:
        return 0.0, False
    counts = module.analogue[channel.channel - 1]
    return units.value_of(channel, counts), counts not in _RAILS


def _bit(word: int, bit: int) -> bool:
    """A digital input; false where the machine does not have it."""
    return bit >= 0 and bool(word >> bit & 1)


def _monitor(device: Device, module: ModuleImage, wired: bool) -> Monitor:
    inputs = device.module
    connected = _bit(module.digital, inputs.monitor_bit) and wired
    channels = (inputs.spo2, inputs.heart_rate, inputs.airway_pressure)
    values = []
    for channel, bit in zip(channels, inputs.validity_bits, strict=True):
        value, valid = _value(channel, module)
        values.append((value, valid and connected and _bit(module.digital, bit)))
    (spo2, spo2_valid), (rate, rate_valid), (pressure, pressure_valid) = values
    return Monitor(
        connected=connected,
        spo2_percent=spo2,
        spo2_valid=spo2_valid,
        heart_rate_per_min=rate,
        heart_rate_valid=rate_valid,
        airway_pressure_cmh2o=pressure,
        airway_pressure_valid=pressure_valid,
    )
