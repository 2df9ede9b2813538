"""A controller's message as frames to the nodes."""

import math
from itertools import pairwise
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel.interface import Commands, DriveMessage
from opensuction.kernel.record import make_zero
from opensuction.machine.canopen import device as units
from opensuction.machine.canopen import power_state, process_image, set_point
from opensuction.machine.canopen.device import AxisMode, AxisMotor
from opensuction.machine.canopen.frame_bus import CanFrame
from opensuction.machine.canopen.objects import (
    AXIS_FEEDFORWARD,
    AXIS_TARGET,
    AXIS_TORQUE,
    MODULE_ANNUNCIATOR,
    MODULE_OUTPUTS,
    rpdo_id,
)
from opensuction.machine.canopen.power_state import ENABLE_OPERATION, PowerState
from opensuction.machine.canopen.process_image import EMPTY, ProcessImage
from opensuction.machine.canopen.set_point import AT_START, Axes, AxisControl
from tests.machine.canopen.node_frames import DEVICE, axis_frames, beat, sound_cycle

ENABLED = PowerState.OPERATION_ENABLED
IN_OPERATION = power_state.PowerControl(ENABLE_OPERATION, 5, was_enabled=True, lost=False)
INSERTION = DEVICE.nodes[0]


def image_of(*frames: CanFrame) -> ProcessImage:
    image = EMPTY
    for frame in frames:
        image = process_image.take(DEVICE, image, frame, 0.0)
    return image


def message(released: bool = False, reset: bool = False, **commands: Any) -> DriveMessage:
    return make_zero(
        DriveMessage,
        commands=make_zero(Commands, insertion_on=True, valve_on=True)._replace(**commands),
        released=released,
        reset=reset,
        wanted=5,
    )


def send(image: ProcessImage, axes: Axes, sent: DriveMessage) -> tuple[dict[int, bytes], Axes]:
    frames, after = set_point.set_points(DEVICE, image, axes, sent, 0.0)
    assert len({one.can_id for one in frames}) == len(frames)
    return {one.can_id: one.data for one in frames}, after


def target(frames: dict[int, bytes]) -> tuple[int, float]:
    """Control word and position of the insertion drive."""
    word, counts = AXIS_TARGET.unpack(frames[rpdo_id(INSERTION, 1)])
    return word, units.position_of(DEVICE.insertion, counts)


def test_nothing_is_asked_of_a_node_before_it_is_operational() -> None:
    """Its control words would be ignored, and be thought to have been given."""
    axes: Axes = (AT_START, AT_START)
    for state in (b"\0", b"\x7f", b"\4"):
        image = image_of(*sound_cycle(state=PowerState.SWITCH_ON_DISABLED), beat(0, state))
        frames, axes = send(image, axes, message())
        assert rpdo_id(INSERTION, 1) not in frames
        assert axes[0] == AT_START
        assert len(frames) == 3
    assert not send(EMPTY, axes, message())[0]


def test_a_drive_out_of_operation_is_sent_where_it_stands() -> None:
    image = image_of(*sound_cycle(120.0, PowerState.SWITCHED_ON))
    word, head_mm = target(send(image, (AT_START, AT_START), message(head_mm=10.0))[0])
    assert (word, head_mm) == (0, 120.0)


def test_a_drive_that_comes_into_operation_moves_no_faster_than_its_limit() -> None:
    axes = (AxisControl(IN_OPERATION, 120.0), AT_START)
    step_mm = DEVICE.insertion.most_per_s * DEVICE.bus.period_s
    image = image_of(*sound_cycle(120.0, ENABLED))
    for cycle in range(1, 4):
        frames, axes = send(image, axes, message(head_mm=10.0))
        word, head_mm = target(frames)
        assert word == ENABLE_OPERATION
        assert abs(head_mm - (120.0 - cycle * step_mm)) < 0.01


def test_a_steady_motion_is_led_by_a_period_and_no_jump_is_doubled() -> None:
    """A drive reaches a target a period after it was sent."""
    image = image_of(*sound_cycle(0.0, ENABLED))
    axes: Axes = (AxisControl(IN_OPERATION, 0.0), AT_START)
    led_mm = []
    for asked_mm in (0.0, 0.1, 0.2, 0.3, 0.3, 0.3, 0.2, 0.1, -0.3, -0.3):
        _, axes = send(image, axes, message(head_mm=asked_mm))
        led_mm.append(round(axes[0].target - asked_mm, 6))
    assert led_mm == [0.0, 0.0, 0.1, 0.1, 0.0, 0.0, 0.0, -0.1, -0.1, 0.0]


BY_TARGETS = DEVICE._replace(
    insertion=DEVICE.insertion._replace(velocity_offset=False, most_per_s=1000.0)
)


def _bound(
    ways_mm: list[float], planned_mm_per_s: float, moved_mm: float = -0.2
) -> tuple[list[float], list[float]]:
    """How far inwards of the head the target is, where commands are bound to it, and the ways.

    ways_mm: of the head, in each period. moved_mm: its way in the one before.
    """
    image, head_mm, behind_mm = image_of(*sound_cycle(0.0, ENABLED)), 0.0, []
    axes: Axes = (AxisControl(IN_OPERATION, 0.0, asked=0.0, moved=moved_mm), AT_START)
    for way_mm in ways_mm:
        head_mm += way_mm
        sent = message(head_mm=head_mm)._replace(head_mm_per_s=planned_mm_per_s)
        read = (head_mm, math.nan)
        _, axes = set_point.set_points(BY_TARGETS, image, axes, sent, 0.0, read=read)
        behind_mm.append(axes[0].target - head_mm)
    return behind_mm, [moved_mm, *ways_mm]


def test_a_head_that_leaves_faster_than_planned_is_braked_by_its_target() -> None:
    """Of a drive that makes its feedforward from its targets: they go on as planned."""
    period_s = DEVICE.bus.period_s
    behind_mm, _ = _bound([-0.3] * 3, -0.2 / period_s)
    assert behind_mm == pytest.approx([0.1, 0.2, 0.3])
    behind_mm, _ = _bound([-0.3] * 90, -0.2 / period_s)
    assert behind_mm[-1] == pytest.approx(0.3 / period_s * set_point.BRAKES_S)
    behind_mm, _ = _bound([-0.2] * 3, -0.3 / period_s)
    assert behind_mm == [0.0] * 3


@given(
    st.floats(-160.0, 160.0),
    st.floats(-0.5, 0.5),
    st.lists(st.floats(-0.6, 0.6), min_size=1, max_size=30),
)
def test_no_target_is_further_in_than_a_bound_head_that_stands_or_goes_in(
    planned_mm_per_s: float, moved_mm: float, ways_mm: list[float]
) -> None:
    found, ways_mm = _bound(ways_mm, planned_mm_per_s, moved_mm)
    share = set_point.BRAKES_S / DEVICE.bus.period_s
    for (before, way), behind in zip(pairwise(ways_mm), found, strict=True):
        assert behind <= max(-0.5 * (before + way), 0.0) * share + 1e-9


def _offsets(asked: list[tuple[float, float]], read_mm: float = math.nan) -> list[int]:
    """Velocity offsets of the insertion drive, counts/s. asked: positions with their speeds."""
    image, found = image_of(*sound_cycle(0.0, ENABLED)), list[int]()
    axes: Axes = (AxisControl(IN_OPERATION, 0.0), AT_START)
    for head_mm, mm_per_s in asked:
        sent = message(head_mm=head_mm)._replace(head_mm_per_s=mm_per_s)
        read = (read_mm, math.nan)
        frames, axes = set_point.set_points(DEVICE, image, axes, sent, 0.0, read=read)
        data = {one.can_id: one.data for one in frames}[rpdo_id(INSERTION, 2)]
        found += AXIS_FEEDFORWARD.unpack(data)
    return found


def test_a_drive_is_sent_the_speed_of_its_targets_as_its_feedforward() -> None:
    per_mm, period_s = DEVICE.insertion.counts_per_unit, DEVICE.bus.period_s
    found = _offsets([(0.1 * k, 0.1 / period_s) for k in range(8)])
    assert found[3:] == [round(0.1 / period_s * per_mm)] * 5
    assert _offsets([(0.0, 0.0)] * 3) == [0] * 3


def test_the_feedforward_of_a_command_that_is_bound_is_the_plans() -> None:
    """The head's own speed would brake nothing."""
    found = _offsets([(5.0, -20.0), (5.0, -10.0), (5.0, 0.0)], read_mm=5.0)
    assert found[1:] == [round(-10.0 * DEVICE.insertion.counts_per_unit), 0]


def test_a_drive_without_a_velocity_offset_is_sent_none() -> None:
    image = image_of(*sound_cycle(0.0, ENABLED))
    axes: Axes = (AxisControl(IN_OPERATION, 0.0), AT_START)
    frames, _ = set_point.set_points(BY_TARGETS, image, axes, message(), 0.0)
    assert rpdo_id(INSERTION, 2) not in {one.can_id for one in frames}


def test_a_drive_in_torque_mode_is_sent_the_torque_of_our_servos_volts() -> None:
    axis = DEVICE.insertion._replace(mode=AxisMode.TORQUE, motor=AxisMotor(20.0, 0.5, 0.0))
    device = DEVICE._replace(insertion=axis)
    image = image_of(*sound_cycle(10.0, ENABLED))
    axes: Axes = (AxisControl(IN_OPERATION, 10.0), AT_START)
    frames, _ = set_point.set_points(device, image, axes, message(insertion_v=10.0), 0.0)
    sent = {one.can_id: one.data for one in frames}
    assert AXIS_TORQUE.unpack(sent[rpdo_id(INSERTION, 2)]) == (500,)
    assert rpdo_id(DEVICE.nodes[1], 2) not in sent  # the valve's has its own servo


@given(st.floats(-100.0, 100.0), st.floats(-200.0, 200.0), st.floats(-170.0, 460.0), st.booleans())
def test_a_torque_is_within_its_limit_brakes_and_never_leads_out_of_the_range(
    volts: float, per_s: float, at_mm: float, is_reversed: bool
) -> None:
    encoder = DEVICE.insertion.encoder._replace(reversed=is_reversed)
    axis = DEVICE.insertion._replace(encoder=encoder, motor=AxisMotor(20.0, 0.5, 0.0))
    sign = -1.0 if is_reversed else 1.0
    share = sign * set_point.torque(axis, at_mm, per_s, volts) / 1000.0
    assert abs(share) <= axis.most_torque
    wanted = (volts - 0.5 * per_s) / 20.0
    if (at_mm >= axis.highest and wanted > 0.0) or (at_mm <= axis.lowest and wanted < 0.0):
        assert share == 0.0
    elif abs(wanted) < axis.most_torque:
        assert abs(share - wanted) <= 0.0006


def test_the_torque_goes_by_the_speed_of_now_not_by_the_late_one_that_was_read() -> None:
    motor = AxisMotor(20.0, 0.5, speed_lag_s=0.01)
    axis = DEVICE.insertion._replace(mode=AxisMode.TORQUE, motor=motor)
    device = DEVICE._replace(insertion=axis)
    axes: Axes = (AxisControl(IN_OPERATION, 10.0), AT_START)
    for step in range(40):  # 200 mm/s2
        per_s = 200.0 * (0.004 * step)
        image = image_of(*sound_cycle(10.0, ENABLED))
        insertion = image.axes[0]._replace(velocity=round(per_s * axis.counts_per_unit))
        image = image._replace(axes=(insertion, image.axes[1]))
        frames, axes = set_point.set_points(device, image, axes, message(insertion_v=10.0), 0.0)
    sent = {one.can_id: one.data for one in frames}
    (ratio,) = AXIS_TORQUE.unpack(sent[rpdo_id(INSERTION, 2)])
    now = per_s + 200.0 * (0.01 + set_point.LATE_PERIODS * DEVICE.bus.period_s)
    assert abs(ratio - 1000.0 * (10.0 - 0.5 * now) / 20.0) < 1.0


def test_an_axis_beyond_its_range_is_not_put_into_operation() -> None:
    """Its drive would bring it into the range by itself, and at once."""
    axes: Axes = (AT_START, AT_START)
    image = image_of(*sound_cycle(DEVICE.insertion.lowest - 20.0, PowerState.SWITCH_ON_DISABLED))
    for _ in range(50):
        frames, axes = send(image, axes, message())
        assert target(frames)[0] == power_state.DISABLE_VOLTAGE


@given(st.floats(-1e6, 1e6), st.floats(-160.0, 450.0))
def test_no_target_is_beyond_the_axis_range_or_its_speed(wanted_mm: float, at_mm: float) -> None:
    image = image_of(*sound_cycle(at_mm, ENABLED))
    frames, after = send(
        image, (AxisControl(IN_OPERATION, at_mm), AT_START), message(head_mm=wanted_mm)
    )
    axis, head_mm = DEVICE.insertion, target(frames)[1]
    assert axis.lowest <= head_mm <= axis.highest
    step_mm = axis.most_per_s * DEVICE.bus.period_s
    assert abs(after[0].target - at_mm) <= step_mm + 1e-9
    assert abs(head_mm - after[0].target) <= 0.51 / axis.counts_per_unit


def test_torque_off_goes_out_with_the_next_frame() -> None:
    image = image_of(*sound_cycle(state=ENABLED))
    axes = (AxisControl(IN_OPERATION, 0.0), AxisControl(IN_OPERATION, 0.0))
    frames, _ = send(image, axes, message(insertion_on=False, valve_on=False))
    assert target(frames)[0] == power_state.DISABLE_VOLTAGE


def test_a_quick_stop_that_passes_between_two_frames_is_noticed_by_what_is_left() -> None:
    """Operation, then switch-on disabled: the state between was in no frame."""
    axes: Axes = (AxisControl(IN_OPERATION, 0.0), AxisControl(IN_OPERATION, 0.0))
    after = image_of(*sound_cycle(state=ENABLED), *axis_frames(0))
    frames, axes = send(after, axes, message())
    assert axes[0].power.lost
    assert target(frames)[0] == power_state.DISABLE_VOLTAGE
    for _ in range(50):  # it does not come back by itself
        frames, axes = send(after, axes, message())
        assert target(frames)[0] == power_state.DISABLE_VOLTAGE


def test_a_fault_is_reset_by_an_edge_and_by_a_controller_that_starts_alone() -> None:
    image = image_of(*sound_cycle(state=PowerState.FAULT))
    axes: Axes = (AT_START, AT_START)
    for _ in range(20):
        frames, axes = send(image, axes, message(reset=True))  # a person's button
        assert not target(frames)[0] & power_state.FAULT_RESET
    words = []
    for _ in range(40):
        frames, axes = send(image, axes, message(released=True))
        words.append(target(frames)[0])
    high = [bool(word & power_state.FAULT_RESET) for word in words]
    assert sum(b and not a for a, b in pairwise(high)) >= 3
    runs = "".join("01"[one] for one in high).strip("01"[high[-1]])
    held = math.ceil(set_point.HOLD_S / DEVICE.bus.period_s)
    assert all(len(run) >= held for run in runs.split("0") if run)


def test_a_controller_that_has_just_started_moves_nothing() -> None:
    image = image_of(*sound_cycle(30.0, ENABLED))
    axes: Axes = (AT_START, AT_START)
    for _ in range(10):
        frames, axes = send(image, axes, message(released=True, head_mm=99.0))
        assert target(frames) == (power_state.DISABLE_VOLTAGE, 30.0)


def test_outputs_are_within_what_the_device_file_allows() -> None:
    image, node = image_of(*sound_cycle()), DEVICE.nodes[2]
    for asked, given_mmhg in ((120.0, 120.0), (1e9, 150.0), (-5.0, 0.0)):
        frames, _ = send(image, (AT_START, AT_START), message(vacuum_mmhg=asked, pump_on=True))
        pump, vacuum, other = MODULE_OUTPUTS.unpack(frames[rpdo_id(node, 1)])
        assert (pump, other) == (1 << DEVICE.module.pump_bit, 0)
        assert vacuum == given_mmhg * DEVICE.module.regulator.counts_per_unit


def test_people_are_told_by_the_module() -> None:
    frames, _ = send(image_of(*sound_cycle()), (AT_START, AT_START), message(True, True))
    (told,) = MODULE_ANNUNCIATOR.unpack(frames[rpdo_id(DEVICE.nodes[2], 2)])
    assert told == 5 | 3 << 56
