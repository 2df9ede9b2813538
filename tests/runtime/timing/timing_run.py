"""The real-time runtime for a while beside a busy machine: what is seen of it.

Twin, controller and recorder as processes, a neonate suctioned again and again; beside them a loop
of plain Python that takes what a core gives, and a bare sleeping loop of the same scheduler class,
which shows what the machine lets any loop keep. Or the same over a bus: emulated drives in place
of the twin's process, nothing that keeps the machine busy, and an observer of the bus.
`timing_figures` says what came of it.
"""

import json
import math
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from opensuction.controller.configuration import Configuration
from opensuction.host.host import NS_PER_S, Child
from opensuction.host.this_computer import THIS_COMPUTER
from opensuction.ipc.mailbox import Sender
from opensuction.ipc.ring import EventReader, RingReader
from opensuction.kernel.record import Array
from opensuction.kernel.vocabulary import RESTING
from opensuction.machine import port
from opensuction.machine.canopen import device_file
from opensuction.machine.twin import twin_machine
from opensuction.machine.twin.twin_process import SHOWN
from opensuction.oracle import exposure
from opensuction.runtime import launch, machine_folder
from opensuction.runtime.loop import ROW_COLUMNS
from opensuction.runtime.machine_folder import ASK, EVENTS, RING
from opensuction.simulation.closed_loop import Loop, LoopState
from opensuction.simulation.machine_side import SHOWN_COLUMNS
from tests.controller.bedside import hurried
from tests.runtime.identity import ABOUT
from tests.runtime.room import begin_drives

BARE = Path(__file__).with_name("bare_loop.py")
OBSERVER = Path(__file__).with_name("bus_observer.py")
BUSY = "while True: pass"
REST_S = 2.0
"""Between two passes, instead of the three minutes that a patient has: cycles are what is timed."""
LOOK_S = 0.1
"""How often the rings are read: long before they come round."""
CORE_NS = 500_000
"""How often each core is looked at, where the computer's own standstills are asked."""
SAMPLE_S = 1.0
"""And how often the memory and the machine's load are."""
BUTTONS = ("reset", "assessed", "oxygen_skipped", "start")
"""What a person presses where the machine rests, one at each look."""
PAUSE_S = REST_S + 0.5
"""For how long they wait before the next one, and before they try once more."""
KEPT = (
    "loop.time_s",
    "loop.late_s",
    "loop.computed_s",
    "loop.skipped",
    "inputs.tick",
    "inputs.dt_s",
    "inputs.host.overrun",
    "inputs.host.conditions",
    "outputs.phase",
    "outputs.verdict.trips",
)
"""Columns of the control loop that are kept."""
TRUTH = ("tick", "alone", *(name for name in exposure.COLUMNS if name != "time_s"))
"""And of the machine."""


class TimingRun(NamedTuple):
    """What was seen."""

    loop: Loop
    ticks: dict[str, Array]
    """`KEPT`, one entry a tick of the loop."""
    truth: dict[str, Array]
    """`TRUTH`, one entry a tick of the machine."""
    lost: int
    """Rows of either ring that were overwritten before they were read."""
    bare: dict[str, Any]
    """As `bare_loop` says."""
    began: dict[str, Any]
    """The control process' first event: scheduler class, what the kernel refused."""
    resident_kb: list[int]
    """Memory of the control process that is no file's, each `SAMPLE_S`."""
    load: list[float]
    """Of the machine, averaged over a minute, each `SAMPLE_S`."""
    stolen_percent: float
    """Of the processors' time what their host gave to others."""
    bus: dict[str, Any] | None = None
    """As `bus_observer` says; None without a bus."""
    stood_s: tuple[Array, ...] = ()
    """Begins and ends of the times in which each core was kept from everybody, shape (times, 2);
    none where that was not looked at."""


class Follower:
    """Some columns of a ring, from now on."""

    def __init__(self, path: Path, columns: tuple[str, ...], kept: tuple[str, ...]) -> None:
        self._reader, self._kept = RingReader(path), kept
        self._reader.next = self._reader.newest() + 1
        self._places = [columns.index(name) for name in kept]
        self._parts = [np.empty((0, len(kept)))]
        self.lost = 0

    def look(self) -> None:
        """Keep what came since the last call."""
        found = self._reader.read()
        self.lost += found.missed
        if len(found.rows):
            self._parts.append(found.rows[:, self._places])

    def now(self, name: str) -> float:
        """Of the newest row; not a number before the first."""
        newest = self._parts[-1]
        return float(newest[-1, self._kept.index(name)]) if len(newest) else float("nan")

    def by_name(self) -> dict[str, Array]:
        """All that was kept."""
        return dict(zip(self._kept, np.concatenate(self._parts).T, strict=True))


class Person:
    """Starts a cycle wherever the machine rests."""

    def __init__(self, folder: Path) -> None:
        self._sender, self._number, self._next_s = Sender(folder / ASK, "nurse"), 0, 0.0

    def look(self, phase: float) -> None:
        """Press the next button, where the machine waits for one. phase: not a number: unknown."""
        if math.isnan(phase):
            return
        now_s = time.monotonic()
        if phase not in RESTING:
            self._next_s = now_s + PAUSE_S
        if now_s < self._next_s:
            return
        button = BUTTONS[self._number % len(BUTTONS)]
        self._number += 1
        self._sender.ask(button, f"key {self._number}", "2026-11-23T12:00:00Z")
        if button == BUTTONS[-1]:
            self._next_s = now_s + PAUSE_S

    def close(self) -> None:
        """Go."""
        self._sender.close()


def _resident_kb(pid: int) -> int:
    """Memory of its own: the rings' pages are files, which come as they are first written."""
    lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("RssAnon"))


def _processor_time() -> tuple[int, int]:
    """All of it so far, and what was stolen."""
    numbers = [int(word) for word in Path("/proc/stat").read_text().split("\n", 1)[0].split()[1:9]]
    return sum(numbers), numbers[7]


@contextmanager
def _process(command: list[str]) -> Iterator[subprocess.Popen[bytes]]:
    process = subprocess.Popen(command)
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def _start_drives(folder: Path, loop: Loop, state: LoopState, period_ns: int) -> Child:
    """Emulated drives, which play."""
    text = device_file.EMULATED.read_text(encoding="utf-8")
    usual = "period_s = 0.004 "
    assert text.count(usual) == 1
    given = folder / "given.toml"
    given.write_text(text.replace(usual, f"period_s = {period_ns / NS_PER_S} "), encoding="utf-8")
    process = begin_drives(folder, loop, state, THIS_COMPUTER, given)
    port.name_backend(folder, port.CANOPEN)
    return process


@contextmanager
def _machine(
    folder: Path, out: Path, loop: Loop, state: LoopState, period: int, on_bus: bool
) -> Iterator[int]:
    """Twin or drives, controller and recorder; the controller's process number."""
    processes = []
    try:
        launch.configure(folder, Configuration(loop.controller, loop.heads_mm))
        machine_folder.write(folder, ABOUT._replace(database=str(folder / "records.db")))
        if on_bus:
            processes.append(_start_drives(folder, loop, state, period))
        else:
            processes.append(twin_machine.start(folder, loop, state, seed=1))
        processes.append(launch.start_control(folder, period))
        processes.append(launch.start_recorder(folder, out))
        yield processes[1].pid
    finally:
        for process in reversed(processes):
            process.kill()
            process.wait()


def run(out: Path, seconds: float, period_ns: int, on_bus: bool = False) -> TimingRun:
    """Let it run for so long. out: where the recorder may write. on_bus: over drives on a bus."""
    folder = Path(tempfile.mkdtemp(dir="/dev/shm"))
    loop, state = hurried(REST_S)
    try:
        with ExitStack() as stack:
            made = _machine(folder, out, loop, state, period_ns, on_bus)
            control = stack.enter_context(made)
            heard, observer = folder / "observed.json", None
            cores: list[tuple[Path, subprocess.Popen[bytes]]] = []
            if on_bus:
                for core in sorted(os.sched_getaffinity(0)):
                    told = folder / f"core-{core}.json"
                    command = [sys.executable, str(BARE), str(told), str(CORE_NS), str(core)]
                    cores.append((told, stack.enter_context(_process(command))))
                command = [sys.executable, str(OBSERVER), str(folder), str(heard)]
                observer = stack.enter_context(_process(command))
            else:
                stack.enter_context(_process([sys.executable, "-c", BUSY]))
            told = folder / "bare.json"
            command = [sys.executable, str(BARE), str(told), str(period_ns)]
            bare = stack.enter_context(_process(command))
            person = stack.enter_context(closing(Person(folder)))
            found = _watch(folder, loop, seconds, control, person)
            found = found._replace(bare=_end(bare, told))
            if observer is not None:
                found = found._replace(bus=_end(observer, heard))
            stood_ns = [_end(core, path)["stood_ns"] for path, core in cores]
            return found._replace(
                stood_s=tuple(np.reshape(one, (-1, 2)) / NS_PER_S for one in stood_ns)
            )
    finally:
        shutil.rmtree(folder)


def _end(process: subprocess.Popen[bytes], told: Path) -> dict[str, Any]:
    """Tell a process to end; what it has written then."""
    process.terminate()
    process.wait(10.0)
    found: dict[str, Any] = json.loads(told.read_text(encoding="utf-8"))
    return found


def _watch(folder: Path, loop: Loop, seconds: float, control: int, person: Person) -> TimingRun:
    ticks = Follower(folder / RING, ROW_COLUMNS, KEPT)
    truth = Follower(folder / SHOWN, SHOWN_COLUMNS, TRUTH)
    resident_kb, load, before = [], [], _processor_time()
    began_s = next_s = time.monotonic()
    while (now_s := time.monotonic()) < began_s + seconds:
        ticks.look()
        truth.look()
        person.look(ticks.now("outputs.phase"))
        if now_s >= next_s:
            next_s += SAMPLE_S
            resident_kb.append(_resident_kb(control))
            load.append(float(Path("/proc/loadavg").read_text().split()[0]))
        time.sleep(LOOK_S)
    after = _processor_time()
    return TimingRun(
        loop=loop,
        ticks=ticks.by_name(),
        truth=truth.by_name(),
        lost=ticks.lost + truth.lost,
        bare={},
        began=EventReader(folder / EVENTS).read()[0][0].fields,
        resident_kb=resident_kb,
        load=load,
        stolen_percent=100.0 * (after[1] - before[1]) / (after[0] - before[0]),
    )
