"""Drives over the bus: power states, targets and stops."""

import itertools
import math

import pytest

from opensuction.kernel.codegen import plain_row
from opensuction.machine.canopen import node_setup, objects, power_state
from opensuction.machine.canopen.frame_bus import CanFrame
from opensuction.machine.canopen.objects import (
    AXIS_FEEDFORWARD,
    AXIS_MOTION,
    AXIS_STATUS,
    AXIS_TARGET,
    AXIS_TORQUE,
    AbortConnection,
    Axis,
    Mode,
)
from opensuction.machine.canopen.power_state import INTERNAL_LIMIT, PowerState
from opensuction.machine.drives import emulated_drive, emulated_node
from opensuction.machine.drives.emulated_drive import Seen
from opensuction.simulation.machine_side import SHOWN_COLUMNS, MachineSide
from opensuction.twin.machine.fail_safe import BRAKING_MM_PER_S2
from tests.controller.bedside import at_bed
from tests.machine.drives.emulated_bench import (
    CYCLE_TICKS,
    INSERTION,
    VALVE,
    EmulatedBench,
    drive_in,
    moving,
    state,
    withdraws,
)


@pytest.fixture
def bench() -> EmulatedBench:
    return EmulatedBench()


WAY_UP = [(0x06, PowerState.READY_TO_SWITCH_ON), (0x07, PowerState.SWITCHED_ON)]
OPERATION = [*WAY_UP, (0x0F, PowerState.OPERATION_ENABLED)]


@pytest.mark.parametrize(
    "ways",
    [
        [*WAY_UP, (0x06, PowerState.READY_TO_SWITCH_ON), (0x00, PowerState.SWITCH_ON_DISABLED)],
        [*WAY_UP, (0x00, PowerState.SWITCH_ON_DISABLED)],
        [*OPERATION, (0x07, PowerState.SWITCHED_ON), (0x0F, PowerState.OPERATION_ENABLED)],
        [*OPERATION, (0x06, PowerState.READY_TO_SWITCH_ON)],
        [*OPERATION, (0x00, PowerState.SWITCH_ON_DISABLED)],
        [*OPERATION[:1], (0x02, PowerState.SWITCH_ON_DISABLED)],
        [*OPERATION[:1], (0x0F, PowerState.OPERATION_ENABLED)],  # by way of switched on
        [(0x0F, PowerState.SWITCH_ON_DISABLED), (0x07, PowerState.SWITCH_ON_DISABLED)],
    ],
)
def test_each_way_through_the_power_states_over_the_bus(
    bench: EmulatedBench, ways: list[tuple[int, PowerState]]
) -> None:
    bench.operate()
    for word, after in ways:
        bench.words[VALVE] = word
        bench.cycle()
        bench.cycle()
        word_shown, _, _ = AXIS_STATUS.unpack(bench.came(objects.tpdo_id(VALVE, 1))[-1])
        assert power_state.read_state(word_shown) == after


def test_by_sdo_a_drive_obeys_before_process_data_flow(bench: EmulatedBench) -> None:
    for word, after in OPERATION:
        bench.write(VALVE, Axis.CONTROL_WORD, word, 2)
        bench.tick()
        assert state(bench, VALVE) == after


def test_answers_to_sync_are_the_twins_own_readings(bench: EmulatedBench) -> None:
    moving(bench)
    axis = bench.device.insertion
    before = bench.row()
    bench.cycle(ticks=1)
    _, position, torque = AXIS_STATUS.unpack(bench.came(objects.tpdo_id(INSERTION, 1))[-1])
    velocity, inputs = AXIS_MOTION.unpack(bench.came(objects.tpdo_id(INSERTION, 2))[-1])
    shown = dict(zip(SHOWN_COLUMNS, before, strict=True))
    assert position == round(shown["readings.head_mm"] * axis.counts_per_unit)
    assert torque == round(1000.0 * shown["readings.insertion_current_a"] / axis.rated_current_a)
    assert velocity == pytest.approx(10.0 * axis.counts_per_unit, rel=0.15)
    assert inputs == 1 << bench.device.contact.wired_bit


def test_targets_are_followed_as_by_a_servo_in_process(bench: EmulatedBench) -> None:
    """A proportional servo lags by what back-EMF and friction need; no more."""
    moving(bench)
    made = bench.drives.insertion
    volts = 10.0 / made._motor.speed_per_v + 1.5
    lag_mm = volts / made._servo.proportional_v
    target_mm = bench.targets[INSERTION] / bench.device.insertion.counts_per_unit
    assert target_mm - bench.shown("readings.head_mm") < lag_mm
    speeds = []
    for _ in range(25):
        before = bench.drives.insertion._set_point.position
        drive_in(bench, 1, 10.0)
        speeds.append(bench.drives.insertion._set_point.position - before)
    assert speeds == pytest.approx([0.04] * 25, abs=1e-9)


def _fed(bench: EmulatedBench, mm_per_s: float, cycles: int = 1) -> float:
    """Speed for the feedforward, mm/s, behind cycles with a velocity offset."""
    counts_per_s = round(mm_per_s * bench.device.insertion.counts_per_unit)
    for _ in range(cycles):
        frame = CanFrame(objects.rpdo_id(INSERTION, 2), AXIS_FEEDFORWARD.pack(counts_per_s))
        bench.bus.send([frame])
        bench.cycle()
    return bench.drives.insertion._fed_velocity()


@pytest.fixture
def fed(bench: EmulatedBench) -> EmulatedBench:
    """A drive whose feedforward comes with its targets."""
    bench.operate()
    for one in node_setup.entries(bench.device, 0):
        bench.write(INSERTION, one.object_index, one.value, one.bits // 8, one.sub)
    bench.command(1)
    bench.enable(INSERTION)
    return bench


def test_the_feedforward_is_the_hosts_velocity_offset(fed: EmulatedBench) -> None:
    """It goes over from one to the next within a period, and is none where targets are silent."""
    assert _fed(fed, 20.0) == pytest.approx(20.0, abs=0.01)
    between = []
    fed.measured = lambda: between.append(fed.drives.insertion._fed_velocity())
    assert _fed(fed, 40.0) == pytest.approx(40.0, abs=0.01)
    assert between == pytest.approx([25.0, 30.0, 35.0, 40.0], abs=0.01)
    for _ in range(2 * CYCLE_TICKS):
        fed.tick()
    assert fed.drives.insertion._fed_velocity() == 0.0


def test_a_velocity_offset_is_bounded_and_leads_into_no_stop(fed: EmulatedBench) -> None:
    drive = fed.drives.insertion
    assert _fed(fed, 1000.0, 2) == pytest.approx(fed.device.insertion.most_per_s, rel=0.001)
    seen = drive._seen
    drive.measure(seen._replace(inputs=1 << fed.device.contact.closed_bit))
    assert drive._fed_velocity() == 0.0
    drive.measure(seen)
    assert _fed(fed, -30.0, 2) == pytest.approx(-30.0, abs=0.01)
    drive.measure(seen._replace(inputs=1 << fed.device.contact.closed_bit))
    assert drive._fed_velocity() == pytest.approx(-30.0, abs=0.01)  # out is let through


def test_a_drive_that_is_sent_no_velocity_offset_feeds_what_its_targets_show(
    bench: EmulatedBench,
) -> None:
    moving(bench)
    assert bench.drives.insertion._fed_velocity() == pytest.approx(10.0, abs=0.01)


def test_two_control_words_within_a_tick_are_one(bench: EmulatedBench) -> None:
    moving(bench)
    bench.drives.insertion.fail(emulated_node.INTERNAL)
    for _ in range(3):
        bench.cycle()
    assert state(bench) == PowerState.FAULT
    words = [
        CanFrame(objects.rpdo_id(INSERTION, 1), AXIS_TARGET.pack(word, 0)) for word in (0x80, 0x00)
    ]
    bench.bus.send([words[0], CanFrame(objects.SYNC_ID, b""), words[1]])
    bench.bus.send([CanFrame(objects.SYNC_ID, b"")])
    bench.tick()
    assert state(bench) == PowerState.FAULT  # the first was never seen
    bench.words[INSERTION] = 0x80
    bench.cycle()
    assert state(bench) == PowerState.SWITCH_ON_DISABLED
    assert bench.came(objects.EMERGENCY_ID + INSERTION)[-1] == bytes(8)


def test_a_quick_stop_may_be_over_before_anybody_looks(bench: EmulatedBench) -> None:
    moving(bench)
    bench.words[INSERTION] = power_state.QUICK_STOP
    bench.cycle()
    bench.cycle()
    told = [
        power_state.read_state(AXIS_STATUS.unpack(one)[0])
        for one in bench.came(objects.tpdo_id(INSERTION, 1))
    ]
    assert PowerState.QUICK_STOP_ACTIVE not in told
    assert told[-1] == PowerState.SWITCH_ON_DISABLED


def test_a_quick_stop_brakes_and_stays_where_it_is_told_to(bench: EmulatedBench) -> None:
    moving(bench)
    bench.write(INSERTION, Axis.QUICK_STOP, 6, 2)
    bench.write(INSERTION, Axis.QUICK_STOP_DECELERATION, 40_000, 4)  # 200 mm/s2
    bench.words[INSERTION] = power_state.QUICK_STOP
    before = bench.shown("readings.head_mm")
    for _ in range(100):
        bench.cycle()
    assert state(bench) == PowerState.QUICK_STOP_ACTIVE
    assert before <= bench.shown("readings.head_mm") < before + 1.5
    bench.words[INSERTION] = power_state.ENABLE_OPERATION
    for _ in range(3):
        bench.cycle()
    assert state(bench) == PowerState.QUICK_STOP_ACTIVE  # there is no transition 16


def test_an_encoder_that_tells_nothing_takes_the_torque_off(bench: EmulatedBench) -> None:
    moving(bench)
    lost = SHOWN_COLUMNS.index("readings.head_valid")
    bench.measured = lambda: bench.call.shown_row.__setitem__(lost, 0.0)
    bench.cycle()
    assert state(bench) == PowerState.FAULT
    assert bench.drives.row[1:3].tolist() == [0.0, 0.0]
    assert bench.came(objects.EMERGENCY_ID + INSERTION)[-1][:2] == b"\x05\x73"


def test_a_target_far_away_is_a_following_error(bench: EmulatedBench) -> None:
    bench.operate()
    bench.write(INSERTION, Axis.FOLLOWING_ERROR_WINDOW, 400, 4)  # 2 mm
    bench.enable(INSERTION)
    bench.targets[INSERTION] += 4000
    for _ in range(10):
        bench.cycle()
    assert state(bench) == PowerState.FAULT
    assert bench.take(INSERTION, Axis.ERROR_CODE) == emulated_drive.FOLLOWING
    assert bench.shown("readings.head_mm") < 1.0


def test_speed_and_range_of_the_drive_limit_its_set_point(bench: EmulatedBench) -> None:
    bench.operate()
    counts = bench.device.insertion.counts_per_unit
    bench.write(INSERTION, Axis.POSITION_LIMIT, round(2.0 * counts), 4, 2)
    bench.write(INSERTION, Axis.MAX_SPEED, round(5.0 * 60 * 3.0 / 30.72), 4)
    bench.enable(INSERTION)
    bench.targets[INSERTION] += 100_000
    places = []
    for _ in range(200):
        bench.cycle()
        places.append(bench.drives.insertion._set_point.position)
    assert places[-1] == pytest.approx(2.0)
    assert max(b - a for a, b in itertools.pairwise(places)) <= 5.1 * 0.004


def test_a_target_may_come_by_sdo(bench: EmulatedBench) -> None:
    bench.operate()
    bench.enable(INSERTION)
    bench.write(INSERTION, Axis.TARGET_POSITION, 400, 4)
    for _ in range(400):
        bench.bus.send([CanFrame(objects.HEARTBEAT_ID + 127, b"\5"), CanFrame(0x80, b"")])
        bench.tick()
    assert bench.shown("readings.head_mm") == pytest.approx(2.0, abs=0.3)


def test_without_the_mains_the_head_comes_home_on_reserve(bench: EmulatedBench) -> None:
    moving(bench)

    def power(mains: bool) -> None:
        side = plain_row.unpack(MachineSide, bench.call.side_row)
        link = side.wiring.link._replace(mains=mains)
        side = side._replace(wiring=side.wiring._replace(link=link))
        bench.call.side_row[:] = plain_row.pack(MachineSide, side)

    power(mains=False)
    bench.cycle()
    bench.cycle()
    assert withdraws(bench)
    assert bench.came(objects.EMERGENCY_ID + INSERTION)[-1][:2] == b"\x20\x31"
    power(mains=True)
    bench.cycle()
    assert withdraws(bench)  # until somebody resets it
    bench.words[INSERTION] = 0x80
    bench.cycle()
    bench.enable(INSERTION)
    assert bench.shown("alone") == 0.0
    assert state(bench) == PowerState.OPERATION_ENABLED


def test_torque_is_a_mode_of_its_own(bench: EmulatedBench) -> None:
    bench.operate()
    bench.write(INSERTION, Axis.MODE, Mode.CYCLIC_TORQUE, 1)
    bench.enable(INSERTION)
    before = bench.shown("readings.head_mm")

    def push(thousandths: int, cycles: int) -> float:
        for _ in range(cycles):
            frame = AXIS_TORQUE.pack(thousandths)
            bench.bus.send([CanFrame(objects.rpdo_id(INSERTION, 2), frame)])
            bench.cycle()
        return bench.shown("readings.head_mm")

    assert push(0, 50) == pytest.approx(before, abs=0.01)
    inside = push(150, 100)
    assert inside > before + 0.5
    assert push(-150, 150) < inside


def test_homing_where_it_stands(bench: EmulatedBench) -> None:
    moving(bench)
    bench.write(INSERTION, Axis.MODE, Mode.HOMING, 1)
    bench.write(INSERTION, Axis.HOME_OFFSET, 700, 4)
    bench.words[INSERTION] = 0x1F
    for _ in range(3):
        bench.cycle()
    assert bench.take(INSERTION, Axis.STATUS_WORD) & 0x3400 == 0x1400
    assert bench.take(INSERTION, Axis.POSITION) == pytest.approx(700, abs=40)  # it coasts on


def test_an_encoder_that_gives_no_number_leaves_its_count_and_is_a_fault(
    bench: EmulatedBench,
) -> None:
    moving(bench)
    drive, before = bench.drives.insertion, bench.take(INSERTION, Axis.POSITION)
    drive.measure(Seen(math.nan, is_valid=False, drive_v=math.nan, inputs=0))
    drive.tick()
    drive.refresh()
    assert drive.values[Axis.POSITION, 0] == pytest.approx(before, abs=400)
    assert drive.values[Axis.ERROR_CODE, 0] == emulated_drive.ENCODER_LOST


def test_contact_stops_the_motor_though_the_host_has_gone() -> None:
    """In a neonate: the carina is there, and the last target is beyond it."""
    bench = EmulatedBench(played=at_bed("neonate"))
    bench.operate()
    bench.enable(INSERTION)
    bench.targets[INSERTION] = 90_000
    # Without heartbeats and without SYNC, and no reaction to it: only the input is left.
    bench.write(INSERTION, Axis.MAX_SPEED, round(30.0 * 60 * 3.0 / 30.72), 4)
    bench.write(INSERTION, Axis.ABORT_CONNECTION, AbortConnection.NOTHING, 2)
    bench.write(INSERTION, objects.Communication.ERROR_BEHAVIOUR, 1, 1, 1)
    bench.cycle()
    ticks = 0
    while not bench.shown("readings.contact_closed"):
        bench.tick()
        ticks += 1
        assert ticks < 10_000
    closed_mm = furthest_mm = bench.shown("readings.head_mm")
    most_n = 0.0
    for _ in range(300):
        bench.tick()
        furthest_mm = max(furthest_mm, bench.shown("readings.head_mm"))
        most_n = max(most_n, bench.shown("truth.contact_n"))
    assert furthest_mm - closed_mm < 30.0**2 / (2.0 * BRAKING_MM_PER_S2)
    assert most_n < 0.3
    assert bench.take(INSERTION, Axis.STATUS_WORD) & INTERNAL_LIMIT
    # Outward is let through, and with the host's own heartbeats again.
    bench.command(1)
    bench.beats = True
    for _ in range(300):
        bench.targets[INSERTION] = round((closed_mm - 20.0) * 200.0)
        bench.cycle()
    assert bench.shown("readings.head_mm") < closed_mm - 15.0
    assert not bench.take(INSERTION, Axis.STATUS_WORD) & INTERNAL_LIMIT
