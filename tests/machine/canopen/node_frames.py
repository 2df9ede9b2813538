"""Frames of sound nodes, for tests of whoever reads them."""

from opensuction.machine.canopen import device as units
from opensuction.machine.canopen import device_file, power_state
from opensuction.machine.canopen.device import Device
from opensuction.machine.canopen.frame_bus import CanFrame
from opensuction.machine.canopen.objects import (
    AXIS_MOTION,
    AXIS_STATUS,
    HEARTBEAT_ID,
    MODULE_ANALOGUE,
    MODULE_DIGITAL,
    tpdo_id,
)
from opensuction.machine.canopen.power_state import PowerState

DEVICE: Device = device_file.load(device_file.EMULATED)
OPERATIONAL = b"\5"


def beat(place: int, state: bytes = OPERATIONAL) -> CanFrame:
    return CanFrame(HEARTBEAT_ID + DEVICE.nodes[place], state)


def axis_frames(
    place: int,
    position: float = 0.0,
    state: PowerState = PowerState.SWITCH_ON_DISABLED,
    *,
    inputs: int = 0b10 << 16,
    torque: int = 0,
    device: Device = DEVICE,
) -> list[CanFrame]:
    """Readings of a drive; by its inputs the tip is on, and touches nothing."""
    axis, node = device.axes[place], device.nodes[place]
    counts = units.wrap(axis.zero_counts + round(position * axis.counts_per_unit))
    status = AXIS_STATUS.pack(power_state.write_status(state), counts, torque)
    return [
        CanFrame(tpdo_id(node, 1), status),
        CanFrame(tpdo_id(node, 2), AXIS_MOTION.pack(0, inputs)),
    ]


def module_frames(
    digital: int = 0b11111, vacuum_mmhg: float = 0.0, carriage: int = 0
) -> list[CanFrame]:
    """Readings of the module: 97 %, 80 1/min, 5 cmH2O. carriage: counts of the second sensor."""
    node = DEVICE.nodes[2]
    vacuum = round(vacuum_mmhg * DEVICE.module.vacuum.counts_per_unit)
    return [
        CanFrame(tpdo_id(node, 1), MODULE_DIGITAL.pack(digital & 0xFF, digital >> 8)),
        CanFrame(tpdo_id(node, 2), MODULE_ANALOGUE[0].pack(vacuum, carriage, 19_400, 8000)),
        CanFrame(tpdo_id(node, 3), MODULE_ANALOGUE[1].pack(1000, 0, 0, 0)),
    ]


def sound_cycle(
    head_mm: float = 0.0, state: PowerState = PowerState.OPERATION_ENABLED
) -> list[CanFrame]:
    """All frames of a cycle in which nothing is wrong."""
    beats = [beat(place) for place in range(3)]
    return [*beats, *axis_frames(0, head_mm, state), *axis_frames(1, 0.0, state), *module_frames()]
