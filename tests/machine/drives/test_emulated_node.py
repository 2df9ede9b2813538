"""Services of CiA 301 of a node, over the bus."""

import struct

import pytest
from canopen.objectdictionary import import_od
from canopen.sdo.exceptions import SdoAbortedError

from opensuction.machine.canopen import objects
from opensuction.machine.canopen.frame_bus import CanFrame
from opensuction.machine.canopen.objects import Axis, Communication, Frame, Module
from opensuction.machine.drives import emulated_drive, emulated_module, pdo
from opensuction.machine.drives.pdo import OFF
from tests.machine.drives.emulated_bench import INSERTION, MODULE, VALVE, EmulatedBench


@pytest.fixture
def bench() -> EmulatedBench:
    return EmulatedBench()


def set_up(bench: EmulatedBench, number: int, entries: list[int], on: bool = True) -> None:
    """Map a TPDO of the insertion drive as CiA 301 has it."""
    parameter, mapping = Communication.TPDO + number, Communication.TPDO_MAP + number
    bench.write(INSERTION, parameter, 0x180 + INSERTION | OFF, 4, 1)
    bench.write(INSERTION, mapping, 0, 1)
    for place, entry in enumerate(entries, 1):
        bench.write(INSERTION, mapping, entry, 4, place)
    bench.write(INSERTION, mapping, len(entries), 1)
    if on:
        bench.write(INSERTION, parameter, 0x180 + INSERTION, 4, 1)


def test_it_says_that_it_has_started_and_who_it_is(bench: EmulatedBench) -> None:
    bench.tick()
    for node in bench.device.nodes:
        assert bench.came(objects.HEARTBEAT_ID + node) == [b"\0"]
        assert bench.remote(node).sdo.upload(Communication.IDENTITY, 1) == bytes([1, 0, 0xAF, 0])
    assert bench.remote(VALVE).sdo.upload(Communication.DEVICE_TYPE, 0) == bytes([0x92, 1, 2, 0])


def test_the_files_that_it_ships_map_the_frames_of_a_cycle(bench: EmulatedBench) -> None:
    frames: dict[tuple[int, bool], list[Frame]] = {
        (INSERTION, False): [objects.AXIS_TARGET, objects.AXIS_TORQUE],
        (INSERTION, True): [objects.AXIS_STATUS, objects.AXIS_MOTION],
        (MODULE, False): [objects.MODULE_OUTPUTS, objects.MODULE_ANNUNCIATOR],
        (MODULE, True): [objects.MODULE_DIGITAL, *objects.MODULE_ANALOGUE],
    }
    identifier = {False: objects.rpdo_id, True: objects.tpdo_id}
    for (number, sends), expected in frames.items():
        node = next(one for one in bench.drives.nodes if one.number == number)
        found = pdo.all_on(node.values, node.dictionary, sends)
        assert [one.layout.format for one in found] == [one.layout.format for one in expected]
        assert [one.keys for one in found] == [
            tuple((index, sub) for index, sub, _ in one.objects) for one in expected
        ]
        assert [one.can_id for one in found] == [
            identifier[sends](number, k + 1) for k in range(len(expected))
        ]


def test_every_object_that_the_driver_names_is_there() -> None:
    for eds, names in (
        (emulated_drive.EDS, {*Communication, *Axis}),
        (emulated_module.EDS, {*Communication, *Module}),
    ):
        assert names <= set(import_od(str(eds), 1))


def test_process_data_flow_in_operation_alone(bench: EmulatedBench) -> None:
    bench.write(INSERTION, Axis.MODE, objects.Mode.CYCLIC_POSITION, 1)
    bench.words[INSERTION] = 0x06
    bench.cycle()
    assert not bench.came(objects.tpdo_id(INSERTION, 1))
    assert bench.take(INSERTION, Axis.CONTROL_WORD) == 0
    bench.command(1)
    bench.cycle()
    assert bench.take(INSERTION, Axis.CONTROL_WORD) == 0x06
    assert len(bench.came(objects.tpdo_id(INSERTION, 1))) == 1
    bench.command(2)
    bench.cycle()
    assert len(bench.came(objects.tpdo_id(INSERTION, 1))) == 1


def test_a_sync_that_comes_twice_is_answered_twice_and_moves_nothing_twice(
    bench: EmulatedBench,
) -> None:
    bench.operate()
    bench.enable(INSERTION)
    before = bench.drives.insertion._set_point
    bench.targets[INSERTION] += 100
    bench.cycle(ticks=2)
    half = bench.drives.insertion._set_point
    bench.bus.send([CanFrame(objects.SYNC_ID, b"")])
    answered = len(bench.came(objects.tpdo_id(INSERTION, 1)))
    bench.tick()
    assert len(bench.came(objects.tpdo_id(INSERTION, 1))) == answered + 1
    bench.tick()
    after = bench.drives.insertion._set_point
    assert half.position - before.position == pytest.approx(0.25, abs=1e-3)
    assert after.position - before.position == pytest.approx(0.5, abs=1e-3)


def test_a_mapping_is_taken_as_the_standard_writes_it(bench: EmulatedBench) -> None:
    set_up(bench, 0, [0x60640020, 0x60410010])
    bench.command(1)
    bench.cycle()
    (data,) = bench.came(objects.tpdo_id(INSERTION, 1))
    assert struct.unpack("<iH", data)[1] == bench.take(INSERTION, Axis.STATUS_WORD)


def test_a_mapping_that_does_not_fit_is_refused(bench: EmulatedBench) -> None:
    mapping = Communication.TPDO_MAP
    for code, entries in (
        (0x06020000, [0x50000020]),  # there is no such object
        (0x06040041, [0x60640010]),  # of another length
        (0x06040041, [0x60980008]),  # never in a PDO
        (0x06040042, [0x60640020, 0x60640020, 0x60410010]),  # more than 8 bytes
    ):
        with pytest.raises(SdoAbortedError) as refused:
            set_up(bench, 0, entries)
        assert refused.value.code == code
    with pytest.raises(SdoAbortedError):
        bench.write(INSERTION, mapping + 1, 0, 1)  # of a PDO that is on
    with pytest.raises(SdoAbortedError):
        bench.write(INSERTION, Communication.TPDO, 0, 1, 2)  # a kind that it does not have


def test_a_set_point_that_is_cut_short_is_told_and_not_taken(bench: EmulatedBench) -> None:
    bench.operate()
    bench.bus.send([CanFrame(objects.rpdo_id(INSERTION, 1), b"\6\0\0")])
    bench.cycle(ticks=1)
    assert bench.came(objects.EMERGENCY_ID + INSERTION)[0][:2] == b"\x10\x82"


def test_heartbeats_come_as_often_as_they_are_asked_for(bench: EmulatedBench) -> None:
    bench.write(VALVE, Communication.HEARTBEAT_PRODUCER_MS, 10, 2)
    for _ in range(100):
        bench.tick()
    assert bench.came(objects.HEARTBEAT_ID + VALVE)[1:] == [b"\x7f"] * 11
    bench.command(1, VALVE)
    for _ in range(11):
        bench.tick()
    assert bench.came(objects.HEARTBEAT_ID + VALVE)[-1] == b"\5"


def test_a_reset_has_it_as_new(bench: EmulatedBench) -> None:
    bench.operate()
    bench.enable(INSERTION)
    bench.write(INSERTION, Axis.MAX_TORQUE, 7, 2)
    bench.command(129, INSERTION)
    bench.tick()
    assert bench.drives.insertion.nmt == objects.NmtState.PRE_OPERATIONAL
    assert bench.take(INSERTION, Axis.STATUS_WORD) & 0x6F == 0x40
    assert bench.take(INSERTION, Axis.MAX_TORQUE) == 1000
    assert bench.drives.row[2] == 0.0
    assert bench.came(objects.HEARTBEAT_ID + INSERTION)[-1] == b"\0"


@pytest.mark.parametrize(("behaviour", "state"), [(0, 127), (1, 5), (2, 4)])
def test_a_lost_host_is_told_and_the_network_state_is_as_it_was_set(
    bench: EmulatedBench, behaviour: int, state: int
) -> None:
    bench.write(MODULE, Communication.ERROR_BEHAVIOUR, behaviour, 1, 1)
    bench.operate()
    bench.cycle()
    for _ in range(30):
        bench.tick()
    assert bench.came(objects.EMERGENCY_ID + MODULE) == [bytes([0x30, 0x81, 0x11, 0, 0, 0, 0, 0])]
    assert bench.drives.module.nmt == state


def test_the_module_tells_what_the_twin_reads_and_does_what_it_is_told(
    bench: EmulatedBench,
) -> None:
    bench.operate()
    regulator = bench.device.module.regulator
    for _ in range(400):
        bench.bus.send(
            [
                CanFrame(
                    objects.rpdo_id(MODULE, 1),
                    objects.MODULE_OUTPUTS.pack(1, round(100.0 * regulator.counts_per_unit), 0),
                ),
                CanFrame(
                    objects.rpdo_id(MODULE, 2),
                    objects.MODULE_ANNUNCIATOR.pack(5 | 1 << objects.FLAG_SHIFT),
                ),
            ]
        )
        bench.cycle()
    assert bench.drives.row[6:].tolist() == [1.0, 100.0, 5.0, 1.0, 0.0, 0.0]
    assert bench.shown("annunciator.said") == 5.0
    vacuum = bench.device.module.vacuum
    read_mmhg = bench.shown("readings.line_vacuum_mmhg")
    assert read_mmhg > 50.0
    bench.cycle(ticks=1)
    counts = struct.unpack("<hhhh", bench.came(objects.tpdo_id(MODULE, 2))[-1])
    assert counts[0] / vacuum.counts_per_unit == pytest.approx(read_mmhg, abs=0.02)
    for _ in range(30):
        bench.tick()
    assert bench.drives.row[6:8].tolist() == [0.0, 0.0]  # without a host: off


def test_a_sensor_that_tells_nothing_has_no_value() -> None:
    channel = EmulatedBench().device.module.vacuum
    assert emulated_module.counts_of(channel, 10.0, is_valid=False) == objects.NO_VALUE
    assert emulated_module.counts_of(channel, float("nan"), is_valid=True) == objects.NO_VALUE
    assert emulated_module.counts_of(channel, -1e9, is_valid=True) == -0x7FFF
