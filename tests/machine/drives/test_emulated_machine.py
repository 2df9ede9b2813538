"""The driver before the emulated drives."""

import numpy as np
import pytest

from opensuction.kernel.codegen import plain_row
from opensuction.kernel.interface import Commands, DriveMessage, Readings
from opensuction.kernel.record import make_zero
from opensuction.kernel.vocabulary import Phase
from opensuction.machine.canopen.device import Device
from opensuction.machine.canopen.frame_bus import FrameBus
from opensuction.machine.canopen.objects import Axis, Module
from opensuction.machine.canopen.power_state import PowerState
from opensuction.machine.twin.twin_machine import SHOWN_READINGS
from opensuction.simulation.machine_side import SHOWN_COLUMNS
from tests.machine.drives.driven_bench import Course, DrivenBench, NoisyBus, cycle
from tests.machine.drives.emulated_bench import DEVICE, INSERTION, MODULE, VALVE, EmulatedBench

ON = {"insertion_on": True, "valve_on": True}
CONTACT = SHOWN_COLUMNS.index("readings.contact_closed")
LOST_HOST_TICKS = DEVICE.heartbeats.lost_host_ms + round(DEVICE.bus.period_s * 1e3)


@pytest.fixture
def bench() -> DrivenBench:
    made = DrivenBench()
    made.greet()
    made.drive(10, **ON)
    return made


def insert(bench: DrivenBench, to_mm: float) -> float:
    """Move the head in at 15 mm/s; where it is."""
    here = bench.readings.head_mm
    while here < to_mm:
        here = min(here + 15.0 * DEVICE.bus.period_s, to_mm)
        bench.drive(head_mm=here, **ON)
    return bench.drive(120, head_mm=to_mm, **ON).head_mm


def test_it_moves_the_twin_and_reads_it(bench: DrivenBench) -> None:
    assert insert(bench, 12.0) == pytest.approx(12.0, abs=0.15)
    found = bench.drive(100, head_mm=12.0, cam_rad=0.3, pump_on=True, vacuum_mmhg=80.0, **ON)
    assert found.cam_rad == pytest.approx(0.3, abs=0.02)
    assert found.line_vacuum_mmhg > 20.0
    assert all((found.head_valid, found.carriage_valid, found.cam_valid, found.vacuum_valid))
    assert all((found.contact_valid, not found.contact_closed))
    assert found.carriage_mm == pytest.approx(found.head_mm, abs=0.5)
    assert bench.said == []


def test_nodes_have_what_the_device_file_says(bench: DrivenBench) -> None:
    assert bench.take(INSERTION, Axis.ABORT_CONNECTION) == -1
    assert bench.take(VALVE, Axis.ABORT_CONNECTION) == 2
    assert bench.take(INSERTION, Axis.POSITION_LIMIT, 2) == 90_000
    assert bench.take(MODULE, Module.OUTPUT_ERROR_MODE, 1) == 0xFF


def test_the_head_comes_home_without_a_host_and_obeys_who_starts_anew(bench: DrivenBench) -> None:
    """The motor does not run on after the master has died."""
    insert(bench, 12.0)
    bench.drive(50, head_mm=12.0, cam_rad=0.3, pump_on=True, vacuum_mmhg=80.0, **ON)
    bench.stand(LOST_HOST_TICKS)
    assert bench.drives.insertion.withdraws
    assert bench.drives.valve.power.state != PowerState.OPERATION_ENABLED
    assert not bench.drives.module.outputs.pump_on
    bench.stand(3000)
    assert bench.shown("readings.head_mm") < 1.0
    assert bench.shown("truth.valve_open_ratio") == 0.0
    # It is back, but has not started anew.
    found = bench.drive(30, head_mm=5.0, **ON)
    assert found.head_mm < 1.0
    assert not any((found.head_valid, found.cam_valid))
    assert bench.drives.valve.power.state == PowerState.SWITCH_ON_DISABLED
    assert all(bench.drive(30, released=True)[1:4:2])
    insert(bench, 5.0)
    found = bench.drive(50, head_mm=5.0, **ON)
    assert found.head_mm == pytest.approx(5.0, abs=0.15)
    assert all((found.head_valid, found.cam_valid, found.vacuum_valid))


def test_a_controller_that_takes_the_place_of_another_is_obeyed(bench: DrivenBench) -> None:
    insert(bench, 8.0)
    bench.stand(200)
    bench.attach()
    bench.greet()
    bench.drive(10, **ON)
    assert insert(bench, 10.0) == pytest.approx(10.0, abs=0.15)
    assert bench.readings.head_valid


def test_the_drive_stops_at_contact_by_itself_and_stays_in_operation(bench: DrivenBench) -> None:
    insert(bench, 10.0)

    def touch() -> None:
        bench.call.shown_row[CONTACT] = 1.0

    bench.measured = touch
    found = bench.drive(100, head_mm=20.0, **ON)
    assert found.contact_closed
    assert found.head_mm == pytest.approx(10.0, abs=0.5)
    assert found.head_valid
    assert bench.drive(150, head_mm=5.0, **ON).head_mm == pytest.approx(5.0, abs=0.15)
    assert bench.said == []


def test_a_fault_of_the_encoder_is_alarmed_and_stays(bench: DrivenBench) -> None:
    bench.drives.valve.fail(0x7305, 0x20)
    found = bench.drive(3, **ON)
    assert not found.cam_valid
    assert found.head_valid
    assert bench.said == ["node 2 (valve drive) reports emergency 0x7305"]
    assert not bench.drive(100, **ON).cam_valid
    bench.greet()
    assert bench.drive(20, **ON).cam_valid


def test_a_node_that_starts_again_is_set_up_again(bench: DrivenBench) -> None:
    bench.drives.module.boot()
    assert not bench.drive(2, **ON).vacuum_valid
    found = bench.drive(100, pump_on=True, vacuum_mmhg=50.0, **ON)
    assert found.vacuum_valid
    assert bench.take(MODULE, Module.OUTPUT_ERROR_MODE, 1) == 0xFF
    assert bench.drives.module.outputs.pump_on


def noisy(bus: FrameBus) -> FrameBus:
    return NoisyBus(bus, 3, lost=0.02, repeated=0.02)


def test_frames_that_are_lost_or_come_twice_trip_nothing() -> None:
    bench = DrivenBench(wire=noisy)
    bench.greet()
    bench.drive(20, **ON)
    for _ in range(200):
        found = bench.drive(**ON)
        flags = (found.head_valid, found.carriage_valid, found.cam_valid, found.vacuum_valid)
        assert all(flags)
        assert found.contact_valid
    assert bench.said == []


def over_the_bus(bench: DrivenBench) -> Course:
    """One cycle of the paper's protocol."""
    return cycle(
        lambda: bench.readings,
        lambda commands, released: bench.obey(commands, released=released),
        lambda: bench.shown("truth.tip_mm"),
        bench.device.bus.period_s,
    )


def in_process(period_ms: int) -> Course:
    """The same by our own servos, without a bus."""
    bench = EmulatedBench()
    bench.call.step(bench.drives.row, new=True)

    def obey(commands: Commands, released: bool) -> None:
        sent = make_zero(DriveMessage, commands=commands, released=released)
        message = plain_row.pack(DriveMessage, sent)
        for _ in range(period_ms):
            bench.call.step(message, new=True)

    def read() -> Readings:
        return plain_row.unpack(Readings, bench.call.shown_row[SHOWN_READINGS])

    return cycle(read, obey, lambda: bench.shown("truth.tip_mm"), period_ms * 1e-3)


def device(period_ms: int) -> Device:
    beats = DEVICE.heartbeats._replace(host_ms=max(period_ms, 2))
    return DEVICE._replace(bus=DEVICE.bus._replace(period_s=period_ms * 1e-3), heartbeats=beats)


@pytest.mark.sweep
@pytest.mark.parametrize("period_ms", [pytest.param(4, marks=pytest.mark.soak), 2])
def test_a_cycle_over_the_bus_is_the_cycle_without(period_ms: int) -> None:
    bench = DrivenBench(device(period_ms))
    found, expected = over_the_bus(bench), in_process(period_ms)
    assert found.phases == expected.phases
    assert Phase.SUCTIONING in found.phases
    assert found.alarms == expected.alarms == 0
    assert bench.said == []
    assert max(found.tip_mm) == pytest.approx(max(expected.tip_mm), abs=0.05)


@pytest.mark.soak  # `test_bus_cycle.py` has a controller before a noisy bus
def test_a_cycle_over_a_noisy_bus_trips_nothing() -> None:
    bench = DrivenBench(wire=noisy)
    found = over_the_bus(bench)
    assert Phase.SUCTIONING in found.phases
    assert found.alarms == 0
    assert bench.said == []


@pytest.mark.sweep
def test_a_host_that_dies_at_any_instant_leaves_the_drives_safe() -> None:
    random = np.random.default_rng(7)
    bench = DrivenBench()
    for _ in range(10):
        bench.greet()
        bench.drive(10, **ON)
        insert(bench, float(random.uniform(2.0, 15.0)))
        bench.drive(5, head_mm=20.0, cam_rad=0.3, pump_on=True, vacuum_mmhg=80.0, **ON)
        bench.stand(int(random.integers(0, 4)))
        bench.stand(LOST_HOST_TICKS)
        assert bench.drives.insertion.withdraws
        assert bench.drives.valve.power.state != PowerState.OPERATION_ENABLED
        assert not bench.drives.module.outputs.pump_on
        bench.stand(1500)
        assert bench.shown("readings.head_mm") < 1.0
        bench.attach()
