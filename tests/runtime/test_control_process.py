"""The control loop as a process, before the twin in real time: both are what a machine would be."""

import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from opensuction.devices.twin_process import SHOWN
from opensuction.exchange.event_ring import EventReader
from opensuction.exchange.mailbox import Sender
from opensuction.exchange.ring import RingReader
from opensuction.kernel.phase import CYCLE, Phase
from opensuction.runtime import launch
from opensuction.runtime.control_process import ASK, EVENTS, RING
from opensuction.runtime.loop import ROW_COLUMNS
from opensuction.simulation.machine_side import SHOWN_COLUMNS
from tests.controller.bedside import at_bed

ATTEMPTS = 4
"""A machine that is busy with other things may stop this one for 30 ms, and a cycle is broken off
then, as it should be: it is begun again."""
INSIDE_MM = 3.0
"""Below the tube's end."""


class Room:
    """Both processes, and who asks and looks."""

    def __init__(self, folder: Path) -> None:
        loop, state = at_bed("neonate")
        self.folder, self.mouth_mm, self.asked = folder, loop.machine.mouth_mm, 0
        launch.configure(folder, loop)
        self.twin = launch.start_twin(folder, loop, state, seed=1)
        self.control: subprocess.Popen[bytes] | None = None
        self.person = Sender(folder / ASK, "nurse")

    def begin(self) -> None:
        """Start a controller."""
        self.control = launch.start_control(self.folder)
        self.rows = RingReader(self.folder / RING)

    def stop(self) -> None:
        """Kill the controller."""
        assert self.control is not None
        self.control.kill()
        self.control.communicate()

    def close(self) -> None:
        self.person.close()
        for process in (self.control, self.twin):
            if process is not None:
                process.kill()
                process.communicate()

    def now(self, name: str) -> float:
        newest = self.rows.snapshot()
        assert newest is not None
        return float(newest[1][ROW_COLUMNS.index(name)])

    def phase(self) -> Phase:
        return Phase(int(self.now("outputs.phase")))

    def truth(self, name: str) -> float:
        newest = RingReader(self.folder / SHOWN).snapshot()
        assert newest is not None
        return float(newest[1][SHOWN_COLUMNS.index(name)])

    def ask(self, ask: str, key: str) -> None:
        self.person.ask(ask, key, "2026-11-23T12:00:00Z")

    def press(self, *buttons: str) -> None:
        """One after the other, each with a key of its own."""
        for button in buttons:
            self.asked += 1
            self.ask(button, f"key {self.asked}")
            time.sleep(0.05)

    def is_out(self) -> bool:
        return self.truth("truth.tip_mm") < self.mouth_mm

    def reach(self, there: Callable[[], bool]) -> None:
        """Begin cycles until one has come so far; each that was broken off has come out."""
        for _ in range(ATTEMPTS):
            self.press("oxygen_skipped", "start")
            assert wait(lambda: self.phase() in CYCLE, 2.0)
            if wait(lambda: there() or self.phase() == Phase.HALTED, 60.0) and there():
                return
            assert wait(self.is_out)
            self.press("reset", "assessed")
        raise AssertionError(f"no cycle came so far: {self.phase().name}")


@pytest.fixture
def room() -> Iterator[Room]:
    folder = Path(tempfile.mkdtemp(dir="/dev/shm"))
    made = Room(folder)
    try:
        made.begin()
        yield made
    finally:
        made.close()
        shutil.rmtree(folder)


def wait(holds: Callable[[], bool], seconds: float = 30.0) -> bool:
    ends = time.monotonic() + seconds
    while not holds():
        if time.monotonic() > ends:
            return False
        time.sleep(0.005)
    return True


def test_a_person_starts_a_cycle_and_it_is_done(room: Room) -> None:
    seen: list[Phase] = []

    def is_done() -> bool:
        rows = room.rows.read().rows
        seen.extend(Phase(int(value)) for value in rows[:, ROW_COLUMNS.index("outputs.phase")])
        return Phase.CLOSING in seen and seen[-1] == Phase.PARKED

    room.reach(is_done)
    assert Phase.SUCTIONING in seen
    assert room.truth("truth.secretion_removed_ml") > 0.0
    assert room.is_out()
    events = EventReader(room.folder / EVENTS).read()[0]
    told = [
        (one.fields["kind"], one.fields.get("ask"), one.fields.get("verdict")) for one in events
    ]
    assert told[:3] == [
        ("began", None, None),
        ("request", "oxygen_skipped", "pressed"),
        ("request", "start", "pressed"),
    ]


def test_killed_in_the_airway_the_drives_bring_it_out_and_the_next_one_waits_for_a_person(
    room: Room,
) -> None:
    room.reach(lambda: room.truth("truth.tip_mm") > INSIDE_MM)
    passes = room.now("outputs.counters.passes")
    room.stop()
    assert wait(lambda: room.truth("annunciator.watchdog_fired") == 1.0, 1.0)
    room.begin()
    assert wait(room.is_out)
    assert wait(lambda: room.phase() in (Phase.HALTED, Phase.PARKED))
    first = EventReader(room.folder / EVENTS).read()[0][0]
    assert first.fields["recovered"] == "yes"
    assert room.now("outputs.counters.passes") >= passes  # the plug undoes no limit
    # Whoever had been told stays told until a person resets it.
    assert room.truth("annunciator.watchdog_fired") == 1.0


def test_told_to_end_in_a_cycle_it_comes_out_first(room: Room) -> None:
    room.reach(lambda: room.truth("truth.tip_mm") > INSIDE_MM)
    assert room.control is not None
    room.control.send_signal(signal.SIGTERM)
    assert room.control.wait(20.0) == 0
    assert room.is_out()
    assert EventReader(room.folder / EVENTS).read()[0][-1].fields["kind"] == "ended"


def test_a_machine_that_says_nothing_any_more_is_a_fault_within_a_tenth_of_a_second(
    room: Room,
) -> None:
    room.twin.send_signal(signal.SIGSTOP)
    try:
        assert wait(lambda: room.now("inputs.readings.head_valid") == 0.0, 1.0)
        assert wait(lambda: room.now("outputs.verdict.trips") != 0.0, 1.0)
    finally:
        room.twin.send_signal(signal.SIGCONT)


def test_a_second_controller_is_refused_in_a_line(room: Room) -> None:
    command = [sys.executable, "-m", "opensuction.runtime.control_process", str(room.folder)]
    found = subprocess.run(command, capture_output=True, text=True, check=False)
    assert found.returncode == 1
    assert "written by another process" in found.stderr
    assert found.stderr.count("\n") == 1
    assert wait(lambda: room.phase() == Phase.PARKED, 1.0)


def test_ticks_come_by_the_clock_and_what_is_missed_is_counted(room: Room) -> None:
    time.sleep(2.0)
    rows = room.rows.read().rows
    columns = {name: rows[:, i] for i, name in enumerate(ROW_COLUMNS)}
    steps = np.diff(columns["loop.time_s"])
    assert steps == pytest.approx(1e-3 * (1.0 + columns["loop.skipped"][1:]), abs=1e-6)
    assert (columns["inputs.dt_s"] == 1e-3).all()
    late = columns["inputs.host.overrun"] == 1.0
    assert (late == (columns["loop.skipped"] > 0)).all()
    assert (np.diff(columns["inputs.tick"]) == 1.0).all()
    assert np.median(columns["loop.computed_s"]) < 0.5e-3
