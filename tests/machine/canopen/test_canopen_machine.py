"""The driver before nodes that nobody of this project wrote."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from opensuction.host.this_computer import THIS_COMPUTER
from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import MESSAGE_COLUMNS
from opensuction.machine import port as backends
from opensuction.machine.canopen import canopen_machine, device_file
from opensuction.machine.canopen.device import AxisMode
from opensuction.machine.canopen.frame_bus import CanFrame
from opensuction.machine.canopen.objects import (
    HEARTBEAT_ID,
    SYNC_ID,
    rpdo_id,
    tpdo_id,
)
from opensuction.machine.canopen.power_state import PowerState
from tests.machine.canopen.durand_nodes import Bench, virtual_time
from tests.machine.canopen.node_frames import DEVICE

INSERTION, VALVE, MODULE = DEVICE.nodes
ON = {"insertion_on": True, "valve_on": True}


@pytest.fixture
def bench() -> Iterator[Bench]:
    with virtual_time():
        yield Bench()


def test_it_moves_a_machine_of_foreign_nodes(bench: Bench) -> None:
    bench.run_up()
    found = bench.cycle(100, head_mm=25.0, cam_rad=0.5, pump_on=True, vacuum_mmhg=90.0, **ON)
    assert found.head_mm == pytest.approx(25.0, abs=0.01)
    assert found.cam_rad == pytest.approx(0.5, abs=0.001)
    assert all((found.head_valid, found.cam_valid, found.vacuum_valid, found.contact_valid))
    assert all((found.mouth_clear, found.monitor.connected, not found.contact_closed))
    assert bench.module.read(0x6411, 1) == 90 * DEVICE.module.regulator.counts_per_unit
    assert bench.module.read(0x6200, 1) == 1
    found = bench.cycle(100, head_mm=0.0)  # torque off: it stays
    assert found.head_mm == pytest.approx(25.0, abs=0.01)
    assert not bench.insertion.is_enabled
    assert bench.said == []


def test_nodes_are_told_how_to_live_without_a_host(bench: Bench) -> None:
    bench.run_up()
    for node in bench.nodes:
        assert node.read(0x1016, 1) == DEVICE.host_node << 16 | DEVICE.heartbeats.lost_host_ms
        assert node.read(0x1017) == DEVICE.heartbeats.node_ms
    assert bench.insertion.read(0x6007) == DEVICE.insertion.lost_host == -1
    assert bench.valve.read(0x6007) == DEVICE.valve.lost_host == 2
    assert bench.insertion.read(0x6060) == 8
    assert (bench.insertion.read(0x60C2, 1), bench.insertion.read(0x60C2, 2)) == (4, -3)
    assert bench.insertion.read(0x6080) == DEVICE.insertion.most_rpm
    assert bench.insertion.read(0x607D, 2) == 450 * 200
    assert (bench.module.read(0x6206, 1), bench.module.read(0x6443, 1)) == (0xFF, 1)


def test_each_cycle_has_its_set_points_then_one_sync_and_a_heartbeat_when_due(
    bench: Bench,
) -> None:
    bench.run_up()
    del bench.wire.sent[:]
    bench.cycle(50, **ON)
    ids = [one.can_id for one in bench.wire.sent]
    assert ids.count(SYNC_ID) == ids.count(rpdo_id(INSERTION, 1)) == 50
    assert ids.index(rpdo_id(INSERTION, 1)) < ids.index(SYNC_ID) < ids.index(tpdo_id(INSERTION, 1))
    assert ids.count(HEARTBEAT_ID + DEVICE.host_node) == 50


def test_readings_come_before_the_first_command_and_after_the_last(bench: Bench) -> None:
    bench.start()
    bench.run_up()
    bench.port.read(bench.row)
    before, beats = bench.number, len(bench.wire.sent)
    for _ in range(100):
        bench.pass_ms()
        bench.number = bench.port.read(bench.row)
    assert bench.number > before + 15
    sent = bench.wire.sent[beats:]
    assert HEARTBEAT_ID + DEVICE.host_node not in [one.can_id for one in sent]
    assert rpdo_id(INSERTION, 1) not in [one.can_id for one in sent]


def test_a_node_that_is_slow_to_set_up_is_waited_for(bench: Bench) -> None:
    bench.valve.is_alive = False
    for _ in range(8000):
        assert bench.port.read(bench.row) == 0
        bench.pass_ms()
    bench.valve.is_alive = True
    bench.start()
    assert bench.readings.cam_valid


def test_an_axis_that_gets_no_torque_for_where_it_stands_is_named_once(bench: Bench) -> None:
    bench.insertion.position = -180.0
    bench.start()
    bench.cycle(10, released=True)
    assert bench.said == []
    bench.cycle(50, **ON)
    assert (bench.insertion.is_enabled, bench.valve.is_enabled) == (False, True)
    assert bench.said == [
        "node 1 (insertion drive) stands at -180.00, beyond its range of -160 to 450: it gets no "
        "torque"
    ]
    bench.insertion.position = -159.0  # a person has moved it
    bench.cycle(20, **ON)
    assert bench.insertion.is_enabled
    assert len(bench.said) == 1


def test_a_node_that_does_not_answer_is_named(bench: Bench) -> None:
    bench.module.is_alive = False
    assert "node 3 (input module): it does not answer within 10 s" in bench.refusal()


def test_every_difference_of_every_node_is_told_at_once(bench: Bench) -> None:
    identity = DEVICE.insertion.identity._replace(vendor=0x147, product=7)
    bench.drive(DEVICE._replace(insertion=DEVICE.insertion._replace(identity=identity)))
    bench.insertion.write(0x1018, 1, 0x99)
    bench.insertion.write(0x6502, 0, 1)
    bench.module.write(0x1000, 0, 402)
    message = bench.refusal()
    assert "node 1 (insertion drive): its vendor is 0x99, not 0x147; its product is 0x0" in message
    assert "no cyclic synchronous position mode" in message
    assert "node 3 (input module): its profile is CiA 402, not CiA 401" in message


def test_a_drive_without_the_mode_that_it_shall_be_driven_in_is_named(bench: Bench) -> None:
    bench.drive(DEVICE._replace(insertion=DEVICE.insertion._replace(mode=AxisMode.TORQUE)))
    assert "it has no cyclic synchronous torque mode (0x6502)" in bench.refusal()


def test_objects_that_a_node_does_not_have_are_named(bench: Bench) -> None:
    del bench.valve.objects._variables[0x6007]
    del bench.valve.objects._objects[0x60C2]
    message = bench.refusal()
    assert "node 2 (valve drive): object 0x6007:00 does not exist; object 0x60c2:01" in message


def test_a_value_that_a_node_does_not_keep_is_told(bench: Bench) -> None:
    bench.insertion.objects.set_read_callback(0x6007, 0, lambda: 0)
    assert "object 0x6007:00 is 0x0, not 0xffff" in bench.refusal()


def test_the_insertion_drives_own_stop_at_contact_is_armed(bench: Bench) -> None:
    bench.start()
    assert bench.insertion.read(0x2300) == 0x10000
    assert bench.valve.read(0x2300) == 0


def test_a_drive_whose_stop_at_contact_cannot_be_armed_is_not_driven(bench: Bench) -> None:
    bench.insertion.objects.set_read_callback(0x2300, 0, lambda: 0)
    assert "node 1 (insertion drive): object 0x2300:00 is 0x0, not 0x10000" in bench.refusal()


def test_a_drive_without_the_objects_of_its_stop_is_not_driven(bench: Bench) -> None:
    other = DEVICE.contact.stop[0]._replace(object_index=0x3240, sub=1)
    bench.drive(DEVICE._replace(contact=DEVICE.contact._replace(stop=(other,))))
    assert "node 1 (insertion drive): object 0x3240:01 does not exist" in bench.refusal()


def test_a_node_that_answers_nonsense_is_not_driven(bench: Bench) -> None:
    node = bench.insertion.node
    answer = bytes((0x11, 0x00, 0x10, 0x00)) + bytes(4)
    node.network.add_subscription(
        0x600 + INSERTION, lambda *_: node.network.send(0x580 + INSERTION, answer)
    )
    assert "it answers nonsense to object 0x1000:00: 11 00 10 00" in bench.refusal()


def test_a_quick_stop_that_passes_within_two_frames_is_noticed(bench: Bench) -> None:
    bench.run_up()
    bench.insertion.leave(PowerState.QUICK_STOP_ACTIVE)
    bench.insertion.leave(PowerState.SWITCH_ON_DISABLED)
    found = bench.cycle(50, head_mm=50.0, **ON)
    assert not found.head_valid
    assert found.cam_valid
    assert bench.insertion.position < 1.0
    assert bench.said == [
        "node 1 (insertion drive) left operation without being told: switch on disabled"
    ]


@pytest.mark.parametrize("state", [PowerState.SWITCHED_ON, PowerState.READY_TO_SWITCH_ON])
def test_a_drive_that_leaves_operation_is_not_put_back_by_itself(
    bench: Bench, state: PowerState
) -> None:
    bench.run_up()
    bench.valve.leave(state)
    bench.pass_ms()
    assert not bench.cycle(3, **ON).cam_valid
    bench.cycle(100, cam_rad=0.5, **ON)
    assert not bench.valve.is_enabled
    bench.cycle(2, insertion_on=True)  # the controller takes it off, and wants it anew
    assert bench.cycle(30, cam_rad=0.5, **ON).cam_valid
    assert bench.valve.is_enabled


def test_a_fault_stays_until_a_controller_starts_anew(bench: Bench) -> None:
    bench.run_up()
    bench.insertion.leave(PowerState.FAULT)
    bench.insertion.node.emcy.set(0x7305, 0x21)
    found = bench.cycle(100, **ON)
    assert bench.insertion.power.state == PowerState.FAULT
    assert not any((found.head_valid, found.contact_valid))
    assert bench.said == ["node 1 (insertion drive) reports emergency 0x7305"]
    bench.insertion.node.emcy.set(0, 0)
    bench.cycle(20, released=True)
    assert bench.cycle(30, **ON).head_valid
    assert bench.insertion.is_enabled
    # A reset is an edge: low before it.
    high = [bool(word & 0x80) for word in bench.insertion.words]
    assert not high[high.index(True) - 1]


def test_control_words_before_the_node_is_operational_are_not_given(bench: Bench) -> None:
    bench.run_up()
    bench.insertion.node.nmt.handle_msg(0, bytes((0x80, INSERTION)))
    bench.cycle(6, **ON)
    del bench.wire.sent[:]
    assert not bench.cycle(20, **ON).head_valid
    assert rpdo_id(INSERTION, 1) not in [one.can_id for one in bench.wire.sent]
    bench.insertion.node.nmt.handle_msg(0, bytes((0x01, INSERTION)))
    assert bench.cycle(40, **ON).head_valid
    assert bench.insertion.is_enabled


def test_a_node_that_is_lost_is_told_within_its_time_and_alone(bench: Bench) -> None:
    bench.run_up()
    bench.module.is_alive = False
    bench.module.node.heartbeat_producer._update_interval(0)
    cycles = 0
    while bench.readings.vacuum_valid:
        bench.cycle(**ON)
        cycles += 1
    most_s = DEVICE.heartbeats.lost_node_ms * 1e-3
    assert cycles * DEVICE.bus.period_s <= most_s + 2 * DEVICE.bus.period_s
    found = bench.cycle(50, head_mm=10.0, **ON)
    assert all((found.head_valid, found.cam_valid, found.contact_valid))
    assert not any((found.carriage_valid, found.mouth_clear, found.monitor.connected))
    assert found.head_mm == pytest.approx(10.0, abs=0.01)
    assert bench.said[0] == "node 3 (input module) gives no readings"
    assert bench.said[1] == "node 3 (input module) is lost: no heartbeat"
    assert len(bench.said) == 2


def test_one_lost_heartbeat_takes_nothing_down(bench: Bench) -> None:
    bench.run_up()
    deaf = [HEARTBEAT_ID + node for node in DEVICE.nodes]
    receive = bench.port._bus.receive
    count = 0

    def lossy() -> Iterator[CanFrame]:
        nonlocal count
        for frame in receive():
            count += frame.can_id in deaf
            if not (frame.can_id in deaf and count % 2):
                yield frame

    bench.port._bus.receive = lossy  # type: ignore[method-assign]
    for _ in range(100):
        assert bench.cycle(**ON).head_valid
    assert bench.said == []


def test_a_drive_that_starts_again_is_set_up_and_waits_for_a_new_controller(bench: Bench) -> None:
    bench.run_up()
    bench.cycle(100, head_mm=30.0, **ON)
    bench.insertion.reboot()
    bench.insertion.write(0x1000, 0, 402)
    bench.insertion.write(0x6502, 0, 0x80)
    bench.insertion.leave(PowerState.SWITCH_ON_DISABLED)
    bench.insertion.position = 0.0  # its encoder is an incremental one
    found = bench.cycle(300, head_mm=30.0, **ON)
    assert bench.insertion.read(0x6007) == -1
    assert bench.insertion.read(0x2300) == 0x10000
    assert not found.head_valid
    assert found.cam_valid
    assert not bench.insertion.is_enabled
    assert bench.said[-1].endswith("has started again, and may have lost its position")
    assert bench.cycle(10, released=True).head_valid


def test_a_node_that_floods_neither_holds_the_loop_up_nor_counts(bench: Bench) -> None:
    bench.run_up()
    other = bench.wire.join()
    frame = CanFrame(tpdo_id(INSERTION, 1), b"\x27\x02" + bytes(6))
    for _ in range(5):
        other.send([frame] * 5000)
        bench.cycle(**ON)
    found = bench.cycle(**ON)
    assert not any((found.head_valid, found.cam_valid, found.vacuum_valid))
    assert 0 < len(bench.said) <= 6
    assert all("\n" not in line for line in bench.said)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_command_that_is_no_number_is_none_and_no_sign_of_life(
    bench: Bench, value: float
) -> None:
    bench.run_up()
    del bench.wire.sent[:]
    for column in range(len(MESSAGE_COLUMNS)):
        row = np.zeros(len(MESSAGE_COLUMNS))
        row[column] = value
        bench.port.write(row)
    assert {one.can_id for one in bench.wire.sent} == {SYNC_ID}


def test_a_sync_of_another_producer_changes_nothing(bench: Bench) -> None:
    bench.run_up()
    other = bench.wire.join()
    for _ in range(50):
        other.send([CanFrame(SYNC_ID, b"")])
        found = bench.cycle(head_mm=5.0, **ON)
    assert found.head_valid
    assert found.head_mm == pytest.approx(5.0, abs=0.01)
    assert bench.said == []


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    text = device_file.EMULATED.read_text(encoding="utf-8")
    (tmp_path / device_file.NAME).write_text(text, encoding="utf-8")
    backends.name_backend(tmp_path, backends.CANOPEN)
    return tmp_path


def test_a_folder_with_a_device_file_is_a_machine(folder: Path) -> None:
    port = backends.attach(folder, THIS_COMPUTER)
    try:
        assert port.facts.name == "emulated"
        assert port.facts.in_silico
        assert port.facts.period_s == DEVICE.bus.period_s
        kind = backends.load(folder)
        assert kind.capabilities_of(folder) == port.facts.capabilities
        assert kind.hand_of(folder) is None
        assert kind.truth_of(folder) is None
        with pytest.raises(InputError, match="driven by another process"):
            backends.attach(folder, THIS_COMPUTER)
    finally:
        port.close()
    backends.attach(folder, THIS_COMPUTER).close()


def test_a_folder_without_a_device_file_is_refused(tmp_path: Path) -> None:
    backends.name_backend(tmp_path, backends.CANOPEN)
    for ask in (backends.attach, lambda one, _: backends.load(one).capabilities_of(one)):
        with pytest.raises(InputError, match="no device file"):
            ask(tmp_path, THIS_COMPUTER)


def test_a_bus_that_is_not_there_is_refused_and_the_machine_let_go(folder: Path) -> None:
    path = folder / device_file.NAME
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace('interface = "unix"', 'interface = "no-such"'), encoding="utf-8")
    for _ in range(2):
        with pytest.raises(InputError, match="no bus on interface 'no-such'"):
            canopen_machine.attach(folder, THIS_COMPUTER)
