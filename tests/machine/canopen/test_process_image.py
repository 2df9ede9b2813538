"""Frames of nodes as readings, and what speaks against them."""

import math
from collections.abc import Iterable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel.codegen import plain_row
from opensuction.kernel.interface import Readings
from opensuction.machine.canopen import power_state, process_image, sensor_readings
from opensuction.machine.canopen.device import Device
from opensuction.machine.canopen.frame_bus import CanFrame
from opensuction.machine.canopen.objects import AXIS_MOTION, EMERGENCY_ID, SYNC_ID, tpdo_id
from opensuction.machine.canopen.power_state import PowerState
from opensuction.machine.canopen.process_image import EMPTY, STALE_S, ProcessImage
from tests.machine.canopen.node_frames import (
    DEVICE,
    axis_frames,
    beat,
    module_frames,
    sound_cycle,
)

PERIOD_S = DEVICE.bus.period_s
POWER = (power_state.AT_START, power_state.AT_START)
FIRST, VALVE, MODULE = DEVICE.nodes
ENABLED = PowerState.OPERATION_ENABLED


def take(
    frames: Iterable[CanFrame],
    image: ProcessImage = EMPTY,
    at_s: float = 0.0,
    device: Device = DEVICE,
) -> ProcessImage:
    for frame in frames:
        image = process_image.take(device, image, frame, at_s)
    return image


def judge(image: ProcessImage, at_s: float = 0.0) -> tuple[Readings, tuple[str, str, str]]:
    said = process_image.complaints(DEVICE, image, POWER, at_s)
    return sensor_readings.readings(DEVICE, image, said), said


def test_frames_of_sound_nodes_are_valid_readings() -> None:
    frames = [*axis_frames(0, 120.5, inputs=0b11 << 16, torque=250)]
    later_s = process_image.TORQUE_S
    image = take([*frames, *module_frames(vacuum_mmhg=80.0)], take(sound_cycle()), later_s)
    found, said = judge(image, later_s)
    assert said == ("", "", "")
    assert (found.head_mm, found.head_valid) == (120.5, True)
    assert (found.carriage_mm, found.carriage_valid) == (0.0, True)
    assert (found.cam_rad, found.cam_valid) == (0.0, True)
    assert (found.line_vacuum_mmhg, found.vacuum_valid) == (80.0, True)
    assert (found.contact_closed, found.contact_valid, found.mouth_clear) == (True, True, True)
    assert found.insertion_current_a == pytest.approx(0.25 * DEVICE.insertion.rated_current_a)
    assert found.monitor == (True, 97.0, True, 80.0, True, 5.0, True)


def test_nothing_is_valid_before_the_first_frames() -> None:
    found, said = judge(EMPTY)
    assert all(said)
    assert not any(flag for flag in found[1:] if isinstance(flag, bool))
    assert not found.monitor.connected


@given(st.lists(st.tuples(st.integers(0, 0x7FF), st.binary(max_size=8)), max_size=30))
def test_whatever_comes_the_readings_are_numbers(frames: list[tuple[int, bytes]]) -> None:
    image = take([*sound_cycle(), *(CanFrame(*one) for one in frames)])
    found, _ = judge(image)
    assert all(math.isfinite(value) for value in plain_row.numbers(found))


@pytest.mark.parametrize("place", range(3))
def test_a_frame_that_is_lost_makes_nothing_invalid(place: int) -> None:
    image = take(sound_cycle())
    for cycle in range(1, 20):
        lost = cycle % 3 == 0
        node = DEVICE.nodes[place]
        frames = [one for one in sound_cycle() if not (lost and one.can_id & 0x7F == node)]
        image = take(frames, image, cycle * PERIOD_S)
        assert judge(image, cycle * PERIOD_S)[1] == ("", "", "")


@pytest.mark.parametrize("place", range(3))
def test_readings_that_do_not_come_any_more_are_invalid_alone(place: int) -> None:
    image = take(sound_cycle())
    others = [one for one in sound_cycle() if one.can_id & 0x7F != DEVICE.nodes[place]]
    for at_s in (PERIOD_S, STALE_S + PERIOD_S):
        image = take([*others, beat(place)], image, at_s)
    found, said = judge(image, at_s)
    assert said[place] == "gives no readings"
    assert sum(map(bool, said)) == 1
    flags = (found.head_valid and found.contact_valid, found.cam_valid, found.vacuum_valid)
    assert [not flag for flag in flags] == [one == place for one in range(3)]
    if place == 2:
        assert not any((found.carriage_valid, found.mouth_clear, found.monitor.connected))


def test_one_heartbeat_that_is_lost_loses_nobody_and_a_silent_node_is_told() -> None:
    every_s = DEVICE.heartbeats.node_ms * 1e-3
    image = take(sound_cycle())
    readings_only = [one for one in sound_cycle() if one.can_id < 0x700]
    image = take(readings_only, image, 2.0 * every_s)
    assert judge(image, 2.0 * every_s)[1] == ("", "", "")
    silent_s = (DEVICE.heartbeats.lost_node_ms + 1) * 1e-3
    image = take([*readings_only, beat(1), beat(2)], image, silent_s)
    found, said = judge(image, silent_s)
    assert said == ("is lost: no heartbeat", "", "")
    assert not found.head_valid
    assert found.cam_valid


@pytest.mark.parametrize(
    ("state", "words"), [(b"\0", "booting"), (b"\4", "stopped"), (b"\x7f", "pre-operational")]
)
def test_a_node_that_left_operation_on_the_bus_is_told(state: bytes, words: str) -> None:
    found, said = judge(take([*sound_cycle(), beat(0, state)]))
    assert said[0] == f"is not operational: {words}"
    assert not found.head_valid


def test_an_emergency_makes_readings_invalid_until_it_is_over() -> None:
    image = take([*sound_cycle(), CanFrame(EMERGENCY_ID + FIRST, b"\x05\x73\x21" + bytes(5))])
    found, said = judge(image)
    assert said[0] == "reports emergency 0x7305"
    assert not any((found.head_valid, found.contact_valid))
    assert process_image.forget_lost_host(image) == image
    image = take([CanFrame(EMERGENCY_ID + FIRST, bytes(8))], image)
    assert judge(image)[0].head_valid


def test_an_emergency_about_a_lost_host_is_over_with_the_next_host() -> None:
    image = take([*sound_cycle(), CanFrame(EMERGENCY_ID + VALVE, b"\x30\x81\x11" + bytes(5))])
    assert not judge(image)[0].cam_valid
    assert judge(process_image.forget_lost_host(image))[0].cam_valid
    # The node hears the host again, and says so: it is the same one, which did not start anew.
    image = take([CanFrame(EMERGENCY_ID + VALVE, bytes(8))], image)
    assert process_image.has_missed_host(image, process_image.VALVE)
    assert not judge(image)[0].cam_valid


@pytest.mark.parametrize(
    "frame",
    [
        CanFrame(tpdo_id(FIRST, 1), b"\x27"),
        CanFrame(tpdo_id(FIRST, 1), b""),
        CanFrame(tpdo_id(FIRST, 1), b"\x01\x00" + bytes(6)),  # a status word that is no state
        CanFrame(tpdo_id(FIRST, 2), bytes(3)),
        CanFrame(0x700 + FIRST, b"\x11"),
        CanFrame(EMERGENCY_ID + FIRST, b"\1"),
    ],
)
def test_nonsense_counts_for_nothing_and_is_told_where_nothing_else_comes(frame: CanFrame) -> None:
    image = take(sound_cycle())
    assert judge(take([frame], image))[0] == judge(image)[0]
    rest = [one for one in sound_cycle() if one.can_id & 0x7F != FIRST]
    at_s = STALE_S + PERIOD_S
    image = take([*rest, beat(0), frame], image, at_s)
    found, said = judge(image, at_s)
    assert not found.head_valid
    assert said[0].startswith("gives no readings; nonsense came: ")
    assert "\n" not in said[0]


def test_a_position_that_no_axis_can_have_is_invalid() -> None:
    found, _ = judge(take([*sound_cycle(), *axis_frames(0, 5_000.0)]))
    assert not found.head_valid
    found, _ = judge(take([*sound_cycle(), *axis_frames(0, DEVICE.insertion.highest + 5.0)]))
    assert found.head_valid  # it is not where it should be, and the controller has to know


def test_an_analogue_input_at_its_end_has_a_wire_that_is_broken() -> None:
    frames = module_frames(vacuum_mmhg=-0x8000 / DEVICE.module.vacuum.counts_per_unit)
    found, said = judge(take([*sound_cycle(), *frames]))
    assert not said[2]
    assert not found.vacuum_valid
    assert found.carriage_valid


def test_positions_go_on_across_the_wrap_at_32_bits() -> None:
    far = DEVICE._replace(insertion=DEVICE.insertion._replace(zero_counts=(1 << 31) - 1000))
    positions = []
    for head_mm in range(11):  # 200 counts for each: it wraps at 5 mm
        image = take([*sound_cycle(), *axis_frames(0, head_mm, device=far)], device=far)
        said = process_image.complaints(far, image, POWER, 0.0)
        found = sensor_readings.readings(far, image, said)
        assert found.head_valid
        positions.append(found.head_mm)
    assert positions == list(range(11))


def test_a_sync_that_comes_twice_changes_nothing() -> None:
    """Each node answers twice."""
    once = take(sound_cycle(30.0))
    twice = take([CanFrame(SYNC_ID, b""), *sound_cycle(30.0)], once)
    assert judge(twice) == judge(once)


@pytest.mark.parametrize("place", range(3))
def test_a_node_that_floods_counts_for_nothing_and_is_told_alone(place: int) -> None:
    image, at_s = take(sound_cycle()), 0.0
    node = DEVICE.nodes[place]
    mine = [one for one in sound_cycle() if one.can_id & 0x7F == node]
    for _ in range(10):
        at_s += PERIOD_S
        image = take([*sound_cycle(), *200 * mine], image, at_s)
    found, said = judge(image, at_s)
    assert said[place] == "floods the bus"
    assert sum(map(bool, said)) == 1
    assert (found.head_valid, found.cam_valid, found.vacuum_valid)[place] is False
    # A computer that stood still for a second finds as many frames, and nobody has flooded.
    image = take(250 * sound_cycle(), take(sound_cycle()), 1.0)
    assert judge(image, 1.0)[1] == ("", "", "")


def test_a_drive_that_left_operation_without_a_word_is_told() -> None:
    image = take(sound_cycle(state=PowerState.SWITCHED_ON))
    lost = power_state.AT_START._replace(lost=True)
    said = process_image.complaints(DEVICE, image, (lost, power_state.AT_START), 0.0)
    assert said == ("left operation without being told: switched on", "", "")
    assert not sensor_readings.readings(DEVICE, image, said).head_valid


@given(st.floats(-62.0, 62.0), st.sampled_from([0.002, 0.004]), st.sets(st.integers(12, 39)))
def test_both_sensors_of_a_head_that_moves_have_it_at_the_same_place(
    per_s: float, period_s: float, lost: set[int]
) -> None:
    """Whichever frames of the second sensor are lost; it was a period behind, .25 mm."""
    device = DEVICE._replace(bus=DEVICE.bus._replace(period_s=period_s))
    carriage, counts_per_mm = device.module.carriage, device.insertion.counts_per_unit
    moving = CanFrame(tpdo_id(FIRST, 2), AXIS_MOTION.pack(round(per_s * counts_per_mm), 2 << 16))
    image, step_mm = EMPTY, 0.1
    rounded_mm = step_mm * (0.5 + 2.0 * period_s / process_image.RATE_S)
    for cycle in range(40):
        at_s = cycle * period_s
        here_mm = per_s * at_s  # at the SYNC before
        stepped_mm = step_mm * round(here_mm / step_mm)
        module = module_frames(carriage=round(stepped_mm * carriage.counts_per_unit))
        frames = [*axis_frames(0, here_mm, ENABLED), moving]
        image = take([*frames, *(module if cycle not in lost else ())], image, at_s, device)
        is_missing = cycle in lost and cycle - 1 in lost
        if cycle > 20 and not is_missing:  # it is for one frame that a reading is carried on
            found = sensor_readings.readings(device, image, ("", "", ""), at_s)
            assert found.carriage_mm == pytest.approx(found.head_mm, abs=rounded_mm)


@pytest.mark.parametrize("period_s", [0.002, 0.004])
def test_a_torque_is_what_the_drive_gives_over_some_periods(period_s: float) -> None:
    """A servo goes by the steps of its encoder: its torque swings, and its mean is what counts."""
    image, swing, mean = EMPTY, 900, 300
    for cycle in range(40):
        torque = mean + (swing if cycle % 2 else -swing)
        image = take(axis_frames(0, torque=torque), image, cycle * period_s)
    found = sensor_readings.readings(DEVICE, image, ("", "", ""))
    share = 0.5 * period_s / process_image.TORQUE_S
    off_a = 1.5 * share * 1e-3 * swing * DEVICE.insertion.rated_current_a
    wanted_a = 1e-3 * mean * DEVICE.insertion.rated_current_a
    assert found.insertion_current_a == pytest.approx(wanted_a, abs=off_a)


def test_a_second_sensor_that_comes_back_from_a_broken_line_is_where_it_is() -> None:
    image = EMPTY
    for cycle, counts in enumerate([100, 100, -0x8000, -0x8000, 5000]):
        image = take(module_frames(carriage=counts), image, cycle * PERIOD_S)
    found = sensor_readings.readings(DEVICE, image, ("", "", ""), 4 * PERIOD_S)
    assert found.carriage_mm == 5000 / DEVICE.module.carriage.counts_per_unit


def test_a_position_is_that_of_the_time_at_which_it_is_read() -> None:
    """A drive answers SYNC, and its answer is read a period later; one that is lost, two later."""
    speed_mm_per_s = 30.0
    counts_per_s = round(speed_mm_per_s * DEVICE.insertion.counts_per_unit)
    moving = CanFrame(tpdo_id(FIRST, 2), AXIS_MOTION.pack(counts_per_s, 0b10 << 16))
    image = take([*sound_cycle(50.0), moving], at_s=1.0)
    said = ("", "", "")
    for late, periods in ((0, 1), (1, 2), (4, 2)):
        found = sensor_readings.readings(DEVICE, image, said, 1.0 + late * PERIOD_S)
        assert found.head_mm == pytest.approx(50.0 + periods * speed_mm_per_s * PERIOD_S)
