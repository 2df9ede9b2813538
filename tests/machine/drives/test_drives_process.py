"""The process of the emulated drives, its faults, and masters that nobody here wrote."""

import importlib
import re
import sys
import tempfile
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, cast

import pytest
from canopen.profiles.p402 import BaseNode402

from opensuction.cli.command import inject
from opensuction.cli.command.inject import InjectOptions
from opensuction.host.host import Host, Steps
from opensuction.kernel.errors import InputError
from opensuction.machine import drives as package
from opensuction.machine.canopen import device_file, objects
from opensuction.machine.canopen.frame_bus import CanFrame, open_bus
from opensuction.machine.canopen.objects import Axis
from opensuction.machine.canopen.power_state import PowerState, read_state
from opensuction.machine.drives import drives_process, emulated_drive, node_fault
from opensuction.machine.drives.drives_process import Playing
from opensuction.machine.drives.node_fault import NodeFault, Request
from opensuction.machine.twin.twin_machine import TwinTruth
from opensuction.safety.condition import Condition
from tests.machine.canopen.stepped_bus import SteppedClock, stepped_host
from tests.machine.drives.emulated_bench import (
    INSERTION,
    MODULE,
    VALVE,
    EmulatedBench,
    loop,
)


class Process:
    """The process' steps, under a clock that a test steps."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.clock = folder, SteppedClock()
        self.ended = False
        self.said: list[str] = []
        self.playing: list[Playing] = []
        self.host: Host = stepped_host(self.clock)._replace(
            terminations=lambda: int(self.ended), say=self.said.append
        )
        self.steps: Steps[None] = drives_process.steps(self.host, folder, self.playing.append)
        self.due_ns = next(self.steps)

    def run(self, ticks: int) -> None:
        for _ in range(ticks):
            self.clock.now_ns = self.due_ns
            self.due_ns = next(self.steps)

    def end(self) -> None:
        self.ended = True
        with pytest.raises(StopIteration):
            next(self.steps)


@pytest.fixture
def folder() -> Iterator[Path]:
    """A short path: a socket's address has room for 107 characters."""
    with tempfile.TemporaryDirectory() as name:
        yield Path(name)


def test_the_process_plays_the_twin_of_its_folder_behind_nodes_on_a_bus(folder: Path) -> None:
    drives_process.prepare(folder, *loop(), seed=1)
    process = Process(folder)
    device = device_file.find(folder)
    bus = open_bus(device.bus, process.host, "host", folder)
    process.run(5)
    bus.send([CanFrame(objects.NMT_ID, b"\1\0"), CanFrame(objects.SYNC_ID, b"")])
    process.run(1)
    came = {one.can_id for one in bus.receive()}
    assert {objects.tpdo_id(node, k) for node in device.nodes for k in (1, 2)} <= came
    assert len(TwinTruth(folder).read().rows) == 6  # a judge has its ring
    node_fault.inject(folder, Request(NodeFault.EMERGENCY, VALVE), process.host)
    process.run(2)
    found = [one.data for one in bus.receive() if one.can_id == objects.EMERGENCY_ID + VALVE]
    assert [one[:2] for one in found] == [b"\x00\x61"]
    node_fault.inject(folder, Request(NodeFault.NODE_LOST, 77), process.host)
    process.run(2)
    assert process.said == ["there is no node 77; nodes: 1, 2, 3"]
    bus.close()
    process.end()
    with pytest.raises(InputError, match="no drives play in"):
        node_fault.mend(folder, process.host)
    # Its memory is not locked: the process is the tests' own.
    assert re.search(r"VmLck:\s+0 kB", Path("/proc/self/status").read_text())


def test_inject_breaks_and_mends_nodes(folder: Path) -> None:
    drives_process.prepare(folder, *loop(), seed=1)
    process = Process(folder)
    wires = process.playing[0].drives.insertion.transceiver
    asked = InjectOptions(folder, node_faults=("bus-off@1", "repeated=0.5"))
    assert inject.run(asked) == 0
    process.run(3)
    assert wires.faults.is_off
    assert not process.playing[0].drives.valve.transceiver.faults.is_off
    node_fault.mend(folder, process.host)
    process.run(2)
    assert wires.faults == node_fault.MENDED
    process.end()


@pytest.mark.parametrize("text", ["none", "bus-off@x", "bus-off@200", "pdo-lost=2", "repeated=x"])
def test_a_fault_that_cannot_be_is_refused_in_one_line(text: str) -> None:
    with pytest.raises(InputError) as refused:
        node_fault.parse(text)
    assert "\n" not in str(refused.value)


def test_what_cannot_be_played_is_refused_in_one_line(folder: Path) -> None:
    with pytest.raises(InputError, match="no device file"):
        Process(folder)
    (folder / device_file.NAME).write_bytes(device_file.EMULATED.read_bytes())
    with pytest.raises(InputError, match="no servos in"):
        Process(folder)
    with pytest.raises(InputError):
        drives_process.prepare(folder, *loop(), seed=1, device=folder / "none.toml")
    for request in (
        Request(NodeFault.PDO_LOST, 1, 1.5),
        Request(NodeFault.SYNC_LATE, 1, -1.0),
    ):
        with pytest.raises(InputError):
            request.check()
    with pytest.raises(InputError):
        node_fault.read(b'{"fault": "none", "node": 1, "strength": 1}')


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ("object_index = 0x2300", "object_index = 0x2301", "give 0x2300, or check"),
        ("reversed = false", "reversed = true", "give 0x2301, or check insertion.encoder.reversed"),
    ],
)
def test_a_stop_that_would_hold_the_head_inside_is_refused(
    folder: Path, before: str, after: str, words: str
) -> None:
    file = folder / "mine.toml"
    text = device_file.EMULATED.read_text(encoding="utf-8")
    file.write_text(text.replace(before, after, 1), encoding="utf-8")
    with pytest.raises(InputError, match="holds the head back on its way out") as refused:
        drives_process.prepare(folder, *loop(), seed=1, device=file)
    assert str(refused.value).startswith(f"{file}: contact.stop[1] is object ")
    assert words in str(refused.value)


def test_without_the_packages_one_line_says_what_is_missing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, "canopen", None)
    with pytest.raises(InputError, match="pip install"):
        importlib.reload(package)


def test_a_flooded_bus_keeps_no_node_from_its_work(bench: EmulatedBench) -> None:
    class Flood:
        def receive(self) -> Iterable[CanFrame]:
            while True:
                yield CanFrame(0x123, bytes(8))

        def send(self, frames: Sequence[CanFrame]) -> None: ...

        def close(self) -> None: ...

    bench.drives._bus = Flood()
    for _ in range(30):
        bench.tick()
    assert bench.shown("alone") == 1.0  # it missed its host, and acted


@pytest.fixture
def bench() -> EmulatedBench:
    bench = EmulatedBench()
    bench.operate()
    bench.enable(INSERTION, VALVE)
    return bench


def state(bench: EmulatedBench, node: int) -> PowerState:
    return read_state(bench.take(node, Axis.STATUS_WORD))


def cycles(bench: EmulatedBench, count: int) -> None:
    for _ in range(count):
        bench.cycle()


def test_a_node_without_power_is_silent_and_starts_anew(bench: EmulatedBench) -> None:
    bench.drives.break_down(Request(NodeFault.NODE_LOST, INSERTION))
    told = len(bench.came(objects.tpdo_id(INSERTION, 1)))
    cycles(bench, 30)
    assert len(bench.came(objects.tpdo_id(INSERTION, 1))) == told
    assert bench.drives.row[1:3].tolist() == [0.0, 0.0]
    assert state(bench, VALVE) == PowerState.OPERATION_ENABLED
    bench.drives.break_down(None)
    cycles(bench, 1)
    assert bench.came(objects.HEARTBEAT_ID + INSERTION)[-1] == b"\0"
    assert state(bench, INSERTION) == PowerState.SWITCH_ON_DISABLED


def test_a_drive_that_is_cut_from_the_bus_misses_its_host(bench: EmulatedBench) -> None:
    bench.drives.break_down(Request(NodeFault.BUS_OFF, INSERTION))
    cycles(bench, 6)
    assert bench.shown("alone") == 1.0
    assert state(bench, INSERTION) == PowerState.FAULT
    assert not bench.came(objects.EMERGENCY_ID + INSERTION)  # nobody hears of it
    bench.drives.break_down(None)
    cycles(bench, 2)
    assert state(bench, INSERTION) == PowerState.FAULT


def test_frames_that_are_lost_twice_or_late_trip_nothing(bench: EmulatedBench) -> None:
    for request in (
        Request(NodeFault.PDO_LOST, node_fault.ALL, 0.05),
        Request(NodeFault.REPEATED, node_fault.ALL, 0.05),
        Request(NodeFault.SYNC_LATE, node_fault.ALL, 1.0),
    ):
        bench.drives.break_down(request)
    start = bench.targets[INSERTION]
    for number in range(300):
        bench.targets[INSERTION] = start + 8 * number
        bench.cycle()
    assert state(bench, INSERTION) == state(bench, VALVE) == PowerState.OPERATION_ENABLED
    cycles(bench, 100)
    assert bench.shown("readings.head_mm") == pytest.approx(299 * 0.04, abs=0.3)


@pytest.mark.parametrize("node", [INSERTION, VALVE])
def test_a_blind_drive_takes_its_torque_off(bench: EmulatedBench, node: int) -> None:
    bench.drives.break_down(Request(NodeFault.ENCODER, node))
    cycles(bench, 2)
    assert state(bench, node) == PowerState.FAULT
    assert bench.came(objects.EMERGENCY_ID + node)[-1][:2] == (
        emulated_drive.ENCODER_LOST.to_bytes(2, "little")
    )


def test_a_module_that_fails_switches_its_outputs_off(bench: EmulatedBench) -> None:
    frame = CanFrame(objects.rpdo_id(MODULE, 1), objects.MODULE_OUTPUTS.pack(1, 4000, 0))
    bench.bus.send([frame])
    bench.cycle()
    assert bench.drives.row[6:8].tolist() == [1.0, 100.0]
    bench.drives.break_down(Request(NodeFault.EMERGENCY, MODULE))
    bench.cycle()
    assert bench.drives.row[6:8].tolist() == [0.0, 0.0]


@pytest.mark.parametrize("fault", [NodeFault.BUS_OFF, NodeFault.NODE_LOST])
def test_a_module_that_nobody_reaches_is_told_at_the_bedside(
    bench: EmulatedBench, fault: NodeFault
) -> None:
    bench.drives.break_down(Request(fault, MODULE))
    cycles(bench, 10)
    assert bench.drives.row[8] == 1 << Condition.WATCHDOG_FIRED


class Pumped(threading.Condition):
    """canopen waits for a frame in a thread; here the bus goes on meanwhile."""

    def __init__(self, pump: Callable[[], None]) -> None:
        super().__init__()
        self.pump = pump

    def wait(self, timeout: float | None = None) -> bool:
        del timeout
        self.pump()
        return True


def test_canopens_own_master_leads_a_drive_through_its_states() -> None:
    """`BaseNode402` reads mapping and objects from our EDS file and node, and moves the drive."""
    bench = EmulatedBench()
    master = cast(Any, BaseNode402)(INSERTION, str(emulated_drive.EDS))
    bench.network.add_remote(master)

    def pump() -> None:
        bench.network.step()
        bench.bus.send([CanFrame(objects.SYNC_ID, b"")])
        for _ in range(4):
            bench.tick()
        bench.network.step()

    bench.tick()
    bench.network.step()
    assert master.nmt.state == "PRE-OPERATIONAL"
    for pdo in (*master.tpdo.values(), *master.rpdo.values()):
        pdo.receive_condition = Pumped(pump)
    master.setup_402_state_machine()
    assert 0x6041 in master.tpdo_values
    assert 0x6040 in master.rpdo_pointers
    master.nmt.state = "OPERATIONAL"
    master.rpdo[1].start(0.004)
    pump()
    assert master.state == "SWITCH ON DISABLED"
    master.op_mode = "CYCLIC SYNCHRONOUS POSITION"
    assert master.sdo[0x6061].raw == objects.Mode.CYCLIC_POSITION
    for wanted in ("READY TO SWITCH ON", "SWITCHED ON", "OPERATION ENABLED"):
        master.state = wanted
        assert state(bench, INSERTION) == PowerState[wanted.replace(" ", "_")]
    position = master.rpdo_pointers[Axis.TARGET_POSITION]
    start = master.tpdo_values[Axis.POSITION]
    for number in range(100):
        position.raw = start + 8 * number
        pump()
    assert bench.shown("readings.head_mm") == pytest.approx(start / 200.0 + 99 * 0.04, abs=1.5)
    assert master.tpdo_values[Axis.POSITION] > start + 300
    bench.drives.insertion.fail(emulated_drive.FOLLOWING)
    pump()
    pump()
    assert master.state == "FAULT"
    assert [one.code for one in master.emcy.active] == [emulated_drive.FOLLOWING]
    master.TIMEOUT_RESET_FAULT = 0.0
    master.reset_from_fault()
    assert master.state == "OPERATION ENABLED"
    assert not master.emcy.active
    master.state = "SWITCH ON DISABLED"
    assert bench.drives.row[2] == 0.0
