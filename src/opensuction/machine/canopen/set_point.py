"""Set points of a cycle: the frames that carry a controller's message to the nodes.

A drive that is not in operation, or not operational on the bus, is sent where it stands, so that it
does not jump when it comes into operation; one that is, is never sent further in a cycle than its
own limit of speed allows.
"""

import math
from collections.abc import Collection
from typing import Final, NamedTuple

from opensuction.kernel.interface import DriveMessage
from opensuction.machine.canopen import device as units
from opensuction.machine.canopen import power_state, process_image
from opensuction.machine.canopen.device import AxisMode, Device, DriveAxis
from opensuction.machine.canopen.frame_bus import CanFrame
from opensuction.machine.canopen.objects import (
    AXIS_FEEDFORWARD,
    AXIS_TARGET,
    AXIS_TORQUE,
    CONDITION_BITS,
    FLAG_SHIFT,
    HEARTBEAT_ID,
    MODULE_ANNUNCIATOR,
    MODULE_OUTPUTS,
    SYNC_ID,
    AnnunciatorFlag,
    NmtState,
    rpdo_id,
)
from opensuction.machine.canopen.power_state import (
    ENABLE_OPERATION,
    START_HOMING,
    PowerControl,
    PowerState,
)
from opensuction.machine.canopen.process_image import MODULE, ProcessImage

HOLD_S: Final = 0.012
"""[design] So long a control word stands: two within a millisecond are one for many drives."""
LATE_PERIODS: Final = 2.5
"""A speed is read a period after it was measured, and a torque acts from the next SYNC on for a
period. Measured: of 2, 2.5 and 3 the least tip error in nine of twelve cycles, see
docs/evidence/2026-11-29-drives-on-a-bus.md."""
AVERAGED_S: Final = 0.006
"""Time over which acceleration beyond what was asked for is averaged. With less the torque carries
more of the encoder's steps, with more the head follows less well. Measured: of 4, 6, 8 and 12 ms,
before the torque that is read was averaged, the least that had no sound machine broken off. See
docs/evidence/2026-11-29-drives-on-a-bus.md."""
BRAKES_S: Final = 0.01
"""[design] Where a command is bound to where the axis was read, the target stays behind an axis
that leaves by at most its way in this time: none for one that stands. Measured: of 5, 10, 20 and
40 ms all brake as well, see docs/evidence/2026-11-29-drives-on-a-bus.md."""
STRAY_SHARE: Final = 0.005
"""[design] Share of its range by which an axis may stand beyond it."""
SYNC: Final = CanFrame(SYNC_ID, b"")
HERE: Final = NmtState.OPERATIONAL.to_bytes(1, "little")
"""Heartbeat of the controller."""
_CONDITIONS: Final = (1 << CONDITION_BITS) - 1


class AxisControl(NamedTuple):
    """Memory of the controller's end of a drive."""

    power: PowerControl
    target: float
    """Position that was sent last, mm or rad; NaN: none."""
    asked: float = math.nan
    """Position that the controller asked for last."""
    moved: float = 0.0
    """Way from the one before to it."""
    speed: float = math.nan
    """Speed that was read last, mm/s or rad/s; NaN: none."""
    asked_per_s: tuple[float, ...] = ()
    """Speeds that were asked for, the newest first, as long as a speed is late."""
    beyond_per_s2: float = 0.0
    """Acceleration that was read beyond the one that was asked for, averaged."""
    way: float = 0.0
    """Way of the target in this period, as its velocity offset tells it."""


AT_START: Final = AxisControl(power_state.AT_START, math.nan)
Axes = tuple[AxisControl, AxisControl]


class Asked(NamedTuple):
    """Wishes of a controller for an axis."""

    wanted: bool
    """Torque on."""
    position: float
    read: float
    """Position that it had read then."""
    per_s: float
    """Speed that belongs to the position; NaN: as the positions have it."""
    is_homing: bool
    """Its position is not known yet."""


def set_points(
    device: Device,
    image: ProcessImage,
    axes: Axes,
    message: DriveMessage,
    now_s: float,
    barred: Collection[int] = (),
    read: tuple[float, float] = (math.nan, math.nan),
    homing: Collection[int] = (),
) -> tuple[list[CanFrame], Axes]:
    """Frames of a cycle without heartbeat and SYNC, and what is remembered of both drives.

    A node that is not operational gets none: it would take none. A drive that has missed its host
    gets none either, until a controller has started anew. barred: places of further such drives.
    read: positions that the controller had for the message. homing: places of drives that are
    being homed: wherever they stand.
    """
    commands = message.commands
    wanted = (commands.insertion_on, commands.valve_on)
    positions = (commands.head_mm, commands.cam_rad)
    volts = (commands.insertion_v, commands.valve_v)
    speeds = (message.head_mm_per_s, math.nan)
    frames: list[CanFrame] = []
    after = list(axes)
    for place, axis in enumerate(device.axes):
        obeys = process_image.is_obeying(device, image, place, now_s)
        if place in barred or not obeys or process_image.has_missed_host(image, place):
            after[place] = AT_START
            continue
        control = _step_axis(
            device,
            axis,
            image,
            place,
            axes[place],
            Asked(wanted[place], positions[place], read[place], speeds[place], place in homing),
            message,
        )
        after[place] = control
        counts = units.counts_of(axis, control.target)
        starts = place in homing and control.power.word == ENABLE_OPERATION
        word = control.power.word | (START_HOMING if starts else 0)
        data = AXIS_TARGET.pack(word, counts)
        frames.append(CanFrame(rpdo_id(axis.node, 1), data))
        if axis.mode == AxisMode.TORQUE:
            speed = _speed_now(axis, control, device.bus.period_s)
            here = units.position_of(axis, image.axes[place].counts)
            ratio = torque(axis, here, speed, volts[place])
            frames.append(CanFrame(rpdo_id(axis.node, 2), AXIS_TORQUE.pack(ratio)))
        elif axis.velocity_offset:
            period_s = device.bus.period_s
            counts_per_s = round(control.way / period_s * axis.counts_per_unit)
            frames.append(CanFrame(rpdo_id(axis.node, 2), AXIS_FEEDFORWARD.pack(counts_per_s)))
    if process_image.is_obeying(device, image, MODULE, now_s):
        frames += _outputs(device, message)
    return frames, (after[0], after[1])


def _step_axis(
    device: Device,
    axis: DriveAxis,
    image: ProcessImage,
    place: int,
    control: AxisControl,
    asked: Asked,
    message: DriveMessage,
) -> AxisControl:
    """Control word and target of a drive in the next cycle."""
    wanted, position, read, per_s, is_homing = asked
    state = process_image.state_of(image, place)
    if state != PowerState.OPERATION_ENABLED and not is_homing:
        wanted = wanted and is_in_range(axis, image.axes[place].counts)
    power = control.power
    # A drive that this controller has in operation stays there: the head may be on its way, and
    # one without torque for so long counts as stalled.
    found = state == PowerState.OPERATION_ENABLED and power.word != ENABLE_OPERATION
    is_off = message.released and (state == PowerState.FAULT or power.lost or found)
    power = power_state.step_control(
        power,
        state,
        wanted=wanted and not is_off,
        reset=message.released,
        hold_cycles=math.ceil(HOLD_S / device.bus.period_s),
    )
    here = units.position_of(axis, image.axes[place].counts)
    period_s = device.bus.period_s
    speed = image.axes[place].velocity / axis.counts_per_unit
    # A command that is bound to where the axis was read asks for no speed of its own.
    is_bound = not wanted or position == read or math.isnan(control.asked)
    asked_per_s = speed if is_bound else (position - control.asked) / period_s
    control = _note_speeds(axis, control, speed, asked_per_s, period_s)
    follows = state == PowerState.OPERATION_ENABLED and power.word == ENABLE_OPERATION
    if is_homing or not follows or math.isnan(control.target):
        return control._replace(power=power, target=here, asked=here, moved=0.0, way=0.0)
    step = axis.most_per_s * period_s
    moved = 0.0 if math.isnan(control.asked) else position - control.asked
    # A command that is bound to where the axis was read has the speed of its encoder's steps.
    is_led, planned = position != read, 0.0 if math.isnan(per_s) else per_s * period_s
    lead = _lead(moved, control.moved) if is_led else 0.0
    if not (is_led or axis.velocity_offset):
        lead = _brake(control, position, planned, period_s)
    target = min(max(position + lead, control.target - step), control.target + step)
    target = min(max(target, axis.lowest), axis.highest)
    way = target - control.target if is_led else planned
    return control._replace(power=power, target=target, asked=position, moved=moved, way=way)


def _brake(control: AxisControl, position: float, planned: float, period_s: float) -> float:
    """Way by which the target stays behind an axis that leaves faster than planned.

    A drive without a velocity offset makes the feedforward of its servo from its targets: one that
    goes along with the axis brakes nothing. position: bound to where the axis was read. planned:
    way of a period.
    """
    way = 0.5 * (position - control.asked + control.moved)
    behind = control.target + min(planned, 0.0) - position
    return min(max(behind, 0.0), max(-way, 0.0) / period_s * BRAKES_S)


def _late_s(axis: DriveAxis, period_s: float) -> float:
    """From the time of a speed that is read to that at which the torque by it acts."""
    return axis.motor.speed_lag_s + LATE_PERIODS * period_s


def _note_speeds(
    axis: DriveAxis, control: AxisControl, speed: float, asked_per_s: float, period_s: float
) -> AxisControl:
    """The memory with the speeds that were read, and asked for, now."""
    kept = math.ceil(_late_s(axis, period_s) / period_s) + 1
    asked = (asked_per_s, *control.asked_per_s)[:kept]
    read_at = round(axis.motor.speed_lag_s / period_s) + 1
    gained = 0.0 if math.isnan(control.speed) else speed - control.speed
    if read_at + 1 < len(asked):
        gained -= asked[read_at] - asked[read_at + 1]
    beyond = gained / period_s - control.beyond_per_s2
    return control._replace(
        speed=speed,
        asked_per_s=asked,
        beyond_per_s2=control.beyond_per_s2 + beyond * min(period_s / AVERAGED_S, 1.0),
    )


def _speed_now(axis: DriveAxis, control: AxisControl, period_s: float) -> float:
    """Speed at which a torque that is sent now finds the axis.

    Since its speed was read it has gained what was asked for since, and what it gained beyond that
    it goes on gaining.
    """
    late_s, asked = _late_s(axis, period_s), control.asked_per_s
    place, share = divmod(late_s / period_s, 1.0)
    then, before = (asked[min(int(place) + k, len(asked) - 1)] for k in (0, 1))
    gained = asked[0] - (then + share * (before - then))
    return control.speed + gained + late_s * control.beyond_per_s2


def torque(axis: DriveAxis, here: float, speed: float, volts: float) -> int:
    """Target torque (0x6071) for the volts of our servo, in thousandths of the rated one.

    here, speed: position and speed of the axis now. A motor at a voltage is braked by its own
    back-EMF, one at a torque by nothing: what the speed would take of the volts is taken off.
    Beyond the axis' range there is torque back alone.
    """
    share = (volts - axis.motor.back_emf_v_s * speed) / axis.motor.rated_v
    share = min(max(share, -axis.most_torque), axis.most_torque)
    if (here >= axis.highest and share > 0.0) or (here <= axis.lowest and share < 0.0):
        share = 0.0
    return round(-1000.0 * share if axis.encoder.reversed else 1000.0 * share)


def is_in_range(axis: DriveAxis, counts: int) -> bool:
    """True where an axis stands within its range, or hardly beyond.

    A drive would bring one that does not there by itself as soon as it is put into operation.
    """
    most = STRAY_SHARE * (axis.highest - axis.lowest)
    here = units.position_of(axis, counts)
    return axis.lowest - most <= here <= axis.highest + most


def _lead(moved: float, before: float) -> float:
    """Way to go on beyond a position by the time at which the drive has reached it.

    A drive reaches a target a period after it was sent, and the controller has its position where
    it is to be now. Only what two periods in a row have gone goes on: no jump is doubled, and a
    motion that turns is not led.
    """
    if moved * before <= 0.0:
        return 0.0
    return moved if abs(moved) < abs(before) else before


def _outputs(device: Device, message: DriveMessage) -> list[CanFrame]:
    """Frames of the module: valves, pump, and what people are told."""
    module, commands = device.module, message.commands
    vacuum_mmhg = min(max(commands.vacuum_mmhg, 0.0), module.most_vacuum_mmhg)
    analogue = [0, 0]
    analogue[module.regulator.channel - 1] = units.output_of(module.regulator, vacuum_mmhg)
    pump = int(bool(commands.pump_on)) << module.pump_bit
    flags = (AnnunciatorFlag.RESET if message.reset else 0) | (
        AnnunciatorFlag.RELEASED if message.released else 0
    )
    told = (message.wanted & _CONDITIONS) | flags << FLAG_SHIFT
    return [
        CanFrame(rpdo_id(module.node, 1), MODULE_OUTPUTS.pack(pump, *analogue)),
        CanFrame(rpdo_id(module.node, 2), MODULE_ANNUNCIATOR.pack(told)),
    ]


def heartbeat(device: Device) -> CanFrame:
    """The controller's own sign of life."""
    return CanFrame(HEARTBEAT_ID + device.host_node, HERE)
