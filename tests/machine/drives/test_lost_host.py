"""Drives whose host is lost: each reaction, in time; and the way back into operation."""

from collections.abc import Callable

import pytest

from opensuction.machine.canopen import objects
from opensuction.machine.canopen.frame_bus import CanFrame
from opensuction.machine.canopen.objects import AbortConnection
from opensuction.machine.canopen.power_state import PowerState
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

LOST_HOST_MS = 20


@pytest.fixture
def bench() -> EmulatedBench:
    return EmulatedBench()


def has_fault(bench: EmulatedBench) -> bool:
    return state(bench) in (PowerState.FAULT, PowerState.FAULT_REACTION_ACTIVE)


def is_off(bench: EmulatedBench) -> bool:
    return state(bench) == PowerState.SWITCH_ON_DISABLED and bench.drives.row[2] == 0.0


def stands(bench: EmulatedBench) -> bool:
    return state(bench) in (PowerState.QUICK_STOP_ACTIVE, PowerState.SWITCH_ON_DISABLED)


@pytest.mark.parametrize(
    ("reaction", "is_safe", "instants"),
    [
        (AbortConnection.WITHDRAW, withdraws, range(50)),
        (AbortConnection.FAULT, has_fault, range(0, 50, 7)),
        (AbortConnection.DISABLE_VOLTAGE, is_off, range(0, 50, 7)),
        (AbortConnection.QUICK_STOP, stands, range(0, 50, 7)),
    ],
)
def test_a_host_that_dies_at_any_instant_is_missed_in_time(
    reaction: AbortConnection, is_safe: Callable[[EmulatedBench], bool], instants: range
) -> None:
    """All of a cycle's ticks, at the first cycle with a host and in motion."""
    bench = EmulatedBench()
    moving(bench, lost_host={INSERTION: reaction, VALVE: AbortConnection.DISABLE_VOLTAGE})
    slowest = 0
    for instant in instants:
        bench.words = {INSERTION: 0x80, VALVE: 0x80}
        bench.command(1)
        bench.cycle()
        bench.words = {INSERTION: 0, VALVE: 0}
        bench.cycle()
        bench.enable(INSERTION, VALVE)
        assert state(bench) == state(bench, VALVE) == PowerState.OPERATION_ENABLED
        drive_in(bench, instant // 8, -10.0 if instant % 2 else 10.0)
        # It dies some ticks after its last heartbeat, or between two heartbeats of 8 ms.
        bench.cycle(ticks=instant % CYCLE_TICKS)
        bench.beats = False
        if instant % 3 == 0:
            bench.cycle()  # SYNC goes on, heartbeats do not
        bench.beats = True
        ticks = 0
        while not (is_safe(bench) and bench.drives.row[5] == 0.0):
            bench.tick()
            ticks += 1
            assert ticks <= LOST_HOST_MS + CYCLE_TICKS
        slowest = max(slowest, ticks)
    assert slowest >= LOST_HOST_MS - 2 * CYCLE_TICKS  # nor sooner than it was told


def test_heartbeats_that_go_on_without_sync_are_a_loop_that_hangs(bench: EmulatedBench) -> None:
    moving(bench)
    for _ in range(LOST_HOST_MS + 2):
        bench.bus.send([CanFrame(objects.HEARTBEAT_ID + 127, b"\5")])
        bench.tick()
    assert withdraws(bench)


def test_some_lost_heartbeats_trip_nothing(bench: EmulatedBench) -> None:
    moving(bench)
    for number in range(100):
        bench.beats = number % 4 == 0
        bench.cycle()
    assert state(bench) == PowerState.OPERATION_ENABLED
    assert not bench.came(objects.EMERGENCY_ID + INSERTION)


def test_the_head_comes_home_alone_and_a_new_master_takes_over_by_a_reset(
    bench: EmulatedBench,
) -> None:
    moving(bench)
    inside = bench.shown("readings.head_mm")
    for _ in range(400):
        bench.tick()
    on_the_way = bench.shown("readings.head_mm")
    assert on_the_way < inside
    bench.command(129)  # a new master resets the nodes: the way home goes on
    bench.tick()
    assert state(bench) == PowerState.FAULT
    for _ in range(50):
        bench.tick()
    assert bench.shown("readings.head_mm") < on_the_way
    assert bench.shown("alone") == 1.0
    bench.operate()
    bench.enable(INSERTION)
    assert state(bench) == PowerState.FAULT  # nobody has reset it
    bench.words[INSERTION] = 0x80
    bench.cycle()
    bench.enable(INSERTION)
    assert state(bench) == PowerState.OPERATION_ENABLED
    assert bench.shown("alone") == 0.0
    before = bench.shown("readings.head_mm")
    drive_in(bench, 50, 10.0)
    assert bench.shown("readings.head_mm") > before
    for _ in range(5000):
        bench.tick()
    assert bench.shown("readings.head_mm") < 0.6
