"""A machine's processes on a computer, real or simulated, and who asks them and looks."""

import math
import signal
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from opensuction.controller.configuration import Configuration
from opensuction.host.host import NS_PER_S, Child, Host, after
from opensuction.ipc.mailbox import PATIENCE_S, Sender
from opensuction.ipc.ring import RingReader
from opensuction.kernel.vocabulary import CYCLE, RESTING, Phase
from opensuction.machine import port
from opensuction.machine.canopen import device_file
from opensuction.machine.drives import drives_process
from opensuction.machine.twin import twin_machine
from opensuction.machine.twin.twin_process import SHOWN
from opensuction.procedure.cycle.lock_out import Refusal
from opensuction.runtime import launch, machine_folder
from opensuction.runtime.loop import ROW_COLUMNS
from opensuction.runtime.machine_folder import ASK, CONTROLS, RECORDS, RING
from opensuction.safety.condition import Condition
from opensuction.session.running import bus_machine
from opensuction.simulation.closed_loop import Loop, LoopState
from opensuction.twin.plant import PlantState
from tests.controller.bedside import hurried
from tests.runtime.identity import ABOUT

PHASE_TICKS = "state.core.procedure.phase_ticks"
DRIVES = "opensuction.machine.drives.drives_process"
STARTS_S = 300.0
"""Until drives play, where their machine code has to be made first."""
REST_S = 1.0
"""Between passes."""
TOLD_LATE = 30
"""Late ticks that a failed test lists, the last ones."""
INSIDE_MM = 3.0
"""Below the tube's end."""


def begin_drives(
    folder: Path, loop: Loop, state: LoopState, host: Host, device: Path = device_file.EMULATED
) -> Child:
    """Emulated drives of a device file that play a loop's twin in a folder."""
    drives_process.prepare(folder, loop, state, 1, device)
    process = host.processes.spawn(DRIVES, (str(folder),), folder / "drives.log")
    ends_ns, shown = after(host.clock, STARTS_S), folder / SHOWN
    while not (shown.exists() and RingReader(shown).newest() > 0):
        assert host.clock.monotonic_ns() < ends_ns, (folder / "drives.log").read_text()
        host.clock.sleep_until(after(host.clock, 0.05))
    return process


class Room:
    """Both processes, and who asks and looks."""

    looks_s = 0.005
    """How often it is looked at what is waited for."""

    def __init__(
        self, folder: Path, host: Host, pid: int, lockstep: str = "", drives: Path | None = None
    ) -> None:
        """pid: of who asks and looks. lockstep: module of a controller that plays the machine, too;
        empty: a twin plays it. drives: folder in which the twin plays behind drives on a bus."""
        self.host, self.pid = host, pid
        self.truth_folder = drives or folder
        self.alone_s = math.inf
        """So long after a controller's death at most its machine acts on its own; asked of drives
        on a bus."""
        # Or a campaign of two hundred deaths would last half a day.
        loop, state = hurried(REST_S)
        self.folder, self.mouth_mm, self.asked = folder, loop.machine.mouth_mm, 0
        self.cap_mm = loop.controller.limits.cap_mm
        launch.configure(folder, Configuration(loop.controller, loop.heads_mm))
        self.twin: Child | None = None
        self.controller = lockstep or launch.CONTROL
        if lockstep:
            plant = PlantState(state.machine, state.bedside)
            twin_machine.prepare(folder, twin_machine.side_of(loop, seed=1), plant)
        elif drives is not None:
            self.twin = begin_drives(drives, loop, state, host)
            on_bus = bus_machine.load(drives / device_file.NAME)
            bus_machine.lay(folder, on_bus)
            # The host is missed, at the latest, from a period before its death on.
            self.alone_s = 1e-3 * on_bus.device.heartbeats.lost_host_ms + on_bus.device.bus.period_s
        else:
            self.twin = twin_machine.start(folder, loop, state, seed=1, host=host)
        self.control: Child | None = None
        self.recorder: Child | None = None
        self.person = Sender(folder / ASK, "nurse", PATIENCE_S, host)
        self.mend()

    def begin(self) -> None:
        """Start a controller."""
        self.control = launch.start_control(self.folder, module=self.controller, host=self.host)
        self.reopen()

    def mend(self) -> None:
        """Undo what a test has done: a controller runs, and no recorder does."""
        machine_folder.write(self.folder, ABOUT._replace(database=str(self.folder / "records.db")))
        if self.recorder is not None:
            self.recorder.kill()
            self.recorder.wait()
            self.recorder = None
        if self.control is not None and self.control.poll() is not None:
            self.begin()

    def reopen(self) -> None:
        """Look at the controller that there is now."""
        self.rows = RingReader(self.folder / RING)

    def stop(self) -> None:
        """Kill the controller."""
        assert self.control is not None
        self.control.kill()
        self.control.wait()

    def record(self, out: Path) -> None:
        """Start a recorder."""
        log = launch.log_of(self.folder, launch.RECORDER)
        self.said_before = len(log.read_text()) if log.exists() else 0
        self.recorder = launch.start_recorder(self.folder, out, self.host)

    def end_recorder(self, words: str = "") -> None:
        """As it should end. words: with which what it has said begins; of a sound one nothing."""
        assert self.recorder is not None
        self.recorder.terminate()
        assert self.ended(self.recorder, 10.0) == 0
        said = launch.log_of(self.folder, launch.RECORDER).read_text()[self.said_before :]
        assert said.startswith(words), said
        assert bool(said) == bool(words), said

    def close(self) -> None:
        self.person.close()
        for process in (self.control, self.recorder, self.twin):
            if process is not None:
                process.kill()
                process.wait()
        # What a supervisor of this folder has started, where a test has failed.
        for lock in (RECORDS, CONTROLS):
            self.signal(self.holder(lock), signal.SIGKILL)

    def now_s(self) -> float:
        """By the computer's monotonic clock."""
        return self.host.clock.monotonic_ns() / NS_PER_S

    def rest(self, seconds: float) -> None:
        """Let time go by."""
        self.host.clock.sleep_until(after(self.host.clock, seconds))

    def wait(self, holds: Callable[[], bool], seconds: float = 30.0, every_s: float = 0.0) -> bool:
        """Wait until something is so, so long at most; whether it is.

        every_s: how often it is looked at; 0: as often as at anything.
        """
        ends_ns = after(self.host.clock, seconds)
        while not holds():
            if self.host.clock.monotonic_ns() > ends_ns:
                return False
            self.rest(every_s or self.looks_s)
        return True

    def ended(self, process: Child, seconds: float) -> int | None:
        """Status of a process that ends by itself; None where it does not within a time."""
        self.wait(lambda: process.poll() is not None, seconds)
        return process.poll()

    def holder(self, lock: str) -> int | None:
        """Number of the process that has a task."""
        return self.host.locks.holder(self.folder / lock)

    def signal(self, pid: int | None, number: int) -> None:
        """Send a signal to a process; None: to none."""
        if pid is not None:
            self.host.processes.signal(pid, number)

    def now(self, name: str) -> float:
        newest = self.rows.snapshot()
        assert newest is not None
        return float(newest[1][ROW_COLUMNS.index(name)])

    def phase(self) -> Phase:
        return Phase(int(self.now("outputs.phase")))

    def is_recorder_missed(self) -> bool:
        return int(self.now("outputs.signals.present")) >> Condition.RECORDER_LOST & 1 == 1

    def truth(self, name: str) -> float:
        truth = port.open_truth(self.truth_folder)
        newest = truth.newest()
        assert newest is not None
        return float(newest[truth.columns.index(name)])

    def ask(self, ask: str, key: str) -> None:
        self.person.ask(ask, key, "2026-11-23T12:00:00Z")

    def press(self, *buttons: str) -> None:
        """One after the other, each with a key of its own."""
        for button in buttons:
            self.asked += 1
            self.ask(button, f"key {self.asked}")
            self.rest(0.05)

    def is_out(self) -> bool:
        return self.truth("truth.tip_mm") < self.mouth_mm

    def park(self, meanwhile: Callable[[], object] = lambda: None) -> None:
        """From whatever rest it has come to, to parked.

        meanwhile: done now and then.
        """

        def comes(holds: Callable[[], bool], seconds: float) -> bool:
            return self.wait(lambda: (meanwhile(), holds())[1], seconds)

        assert comes(lambda: self.phase() in RESTING, 60.0), self.state()
        if self.now("outputs.counters.locked_out"):
            self.press("service", "return_to_service")
        # A reset brings home a head that is not there, and the machine halts again: the next parks.
        for _ in range(2):
            if self.phase() == Phase.HALTED:
                halted_ticks = self.now(PHASE_TICKS)
                self.press("reset")
                assert comes(partial(self.is_past, halted_ticks), 2.0), self.state()
                assert comes(lambda: self.phase() in RESTING, 60.0), self.state()
        assert comes(lambda: self.phase() == Phase.PARKED, 5.0), self.state()

    def is_past(self, halted_ticks: float) -> bool:
        """Whether a halt that had lasted so long is over, if only for the next one.

        A head that is nearly home gets there in a tick or two, which may be seen by nobody.
        """
        return self.phase() != Phase.HALTED or self.now(PHASE_TICKS) < halted_ticks

    def begin_cycle(self, meanwhile: Callable[[], object] = lambda: None) -> None:
        """From rest to a cycle that has begun, once the patient has rested.

        meanwhile: done now and then.
        """
        self.park(meanwhile)
        assert self.wait(lambda: (meanwhile(), self.now("outputs.counters.rest_left_s") == 0.0)[1])
        self.press("assessed", "oxygen_skipped", "start")
        begun = self.wait(lambda: (meanwhile(), self.phase() in CYCLE)[1], 2.0)
        assert begun, f"no cycle begins: {self.state()}"

    def reach(
        self, there: Callable[[], bool], meanwhile: Callable[[], object] = lambda: None
    ) -> None:
        """Begin a cycle, and wait until it has come so far.

        meanwhile: done now and then.
        """
        self.begin_cycle(meanwhile)
        assert self.wait(lambda: (meanwhile(), there() or self.phase() == Phase.HALTED)[1], 60.0)
        assert there(), f"the cycle did not come so far: {self.state()}"

    def state(self) -> str:
        """Phase, refusal and alarms in words, for a test that fails."""
        refused = Refusal(int(self.now("outputs.counters.refusal")))
        masks = {kind: int(self.now(f"outputs.signals.{kind}")) for kind in ("present", "latched")}
        alarms = ", ".join(
            f"{kind} {[one.name for one in Condition if mask >> one & 1]}"
            for kind, mask in masks.items()
        )
        rows = RingReader(self.folder / RING).drain().rows
        skipped = rows[:, ROW_COLUMNS.index("loop.skipped")]
        late = np.flatnonzero(skipped)[-TOLD_LATE:]
        where = ", ".join(f"{skipped[at]:.0f} before tick {at}" for at in late)
        return (
            f"{self.phase().name}, refused {refused.name}, {alarms}; in the last {len(rows)} ticks "
            f"{skipped.sum():.0f} skipped{': ' * bool(where)}{where}"
        )
