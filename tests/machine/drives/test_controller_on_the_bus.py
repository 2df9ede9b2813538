"""The controller's own process before the drives' own, on a bus of a simulated computer."""

import signal
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from opensuction.controller.configuration import Configuration
from opensuction.evidence.lives.simulated_computer import SimulatedComputer
from opensuction.host.host import NS_PER_S, Child, Host, Steps, after
from opensuction.ipc.mailbox import Sender
from opensuction.ipc.ring import RingReader
from opensuction.kernel.vocabulary import Phase
from opensuction.machine import port
from opensuction.machine.drives import drives_process
from opensuction.machine.twin.twin_machine import TwinTruth
from opensuction.runtime import control_process, launch
from opensuction.runtime.loop import ROW_COLUMNS
from opensuction.runtime.machine_folder import ASK, RING
from tests.machine.drives.emulated_bench import DEVICE, loop

DRIVES = "opensuction.machine.drives.drives_process"
OUTSIDE = "outside"


class Room:
    """Both processes, and who looks at them from outside."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.computer = SimulatedComputer(
            1,
            {
                DRIVES: lambda host, told: drives_process.steps(host, Path(told[0])),
                launch.CONTROL: lambda host, told: control_process.steps(
                    host, Path(told[0]), int(told[1])
                ),
                OUTSIDE: lambda host, _: self._stand(host),
            },
        )
        self._hosts: list[Host] = []
        self.spawn(OUTSIDE)
        made, state = loop()
        drives_process.prepare(folder, made, state, seed=1)
        port.name_backend(folder, port.CANOPEN)
        launch.configure(folder, Configuration(made.controller, made.heads_mm))
        self.drives = self.spawn(DRIVES)
        self.run = ""
        """Of the controller that was begun last."""
        self.rest(2.0)
        self.control = self.begin()

    def _stand(self, host: Host) -> Steps[None]:
        """Have a process that does nothing: somebody at the machine."""
        self._hosts.append(host)

        def idle() -> Steps[None]:
            while True:
                yield after(host.clock, 0.1)

        return idle()

    def press(self, button: str) -> None:
        """Press a button."""
        person = Sender(self.folder / ASK, "nurse", 1.0, self._hosts[0])
        person.ask(button, "key 1", "2026-11-29T12:00:00Z")
        person.close()

    def cycle_until(self, phase: Phase) -> None:
        """Have a person start a cycle, until it comes to a phase."""
        self.press("start")
        for _ in range(200):
            self.rest(0.1)
            if self.now("outputs.phase") == phase:
                return
        raise AssertionError(f"no {phase.name} within 20 s")

    def spawn(self, module: str, *arguments: str) -> Child:
        log = self.folder / f"{module}.log"
        return self.computer.spawn(module, (str(self.folder), *arguments), log)

    def begin(self) -> Child:
        """A controller, which ticks."""
        process = self.spawn(launch.CONTROL, str(control_process.MACHINES_OWN))
        before, self.run = self.run, ""
        for _ in range(200):
            self.rest(0.05)
            if (self.folder / RING).exists():
                self.rows = RingReader(self.folder / RING)
                self.run = self.rows.facts.told["run"]
                if self.run != before and self.rows.newest() > 100:
                    return process
        raise AssertionError("no new controller ticks")

    def rest(self, seconds: float) -> None:
        self.computer.run_until(self.computer.now_ns + round(seconds * NS_PER_S))

    def now(self, name: str) -> float:
        newest = self.rows.snapshot()
        assert newest is not None
        return float(newest[1][ROW_COLUMNS.index(name)])

    def truth(self, name: str) -> float:
        truth = TwinTruth(self.folder)
        newest = truth.newest()
        assert newest is not None
        return float(newest[truth.columns.index(name)])


@pytest.fixture
def room() -> Iterator[Room]:
    with tempfile.TemporaryDirectory() as name:  # a socket's address is short
        made = Room(Path(name))
        yield made
        made.computer.close()


def test_the_controller_ticks_with_the_sync_of_its_machine(room: Room) -> None:
    assert room.control.poll() is None
    assert room.rows.facts.told["period_ns"] == str(round(DEVICE.bus.period_s * NS_PER_S))
    before = room.now("inputs.tick")
    room.rest(1.0)
    assert room.now("inputs.tick") - before == pytest.approx(250, abs=2)
    for flag in ("head_valid", "carriage_valid", "cam_valid", "vacuum_valid", "contact_valid"):
        assert room.now(f"inputs.readings.{flag}") == 1.0
    assert room.now("outputs.signals.present") == 0.0


@pytest.mark.sweep
def test_a_controller_that_is_killed_in_the_airway_leaves_the_head_home(room: Room) -> None:
    room.cycle_until(Phase.INSERTING)
    room.rest(3.0)
    assert room.truth("truth.head_mm") > 20.0
    room.control.send_signal(signal.SIGKILL)
    room.rest(6.0)
    assert room.truth("truth.head_mm") < 1.0
    room.control = room.begin()
    room.rest(1.0)
    assert room.control.poll() is None
    assert room.now("inputs.readings.head_valid") == 1.0


@pytest.mark.parametrize(
    "inside_s", [3.0, *(pytest.param(one, marks=pytest.mark.soak) for one in (0.5, 1.0, 2.0, 4.0))]
)
def test_a_reset_after_a_death_brings_the_head_quite_home_and_ends_the_alarm(
    room: Room, inside_s: float
) -> None:
    """The drives leave it beside its home, for a servo stands within a dead band: it has to move.

    A drive whose torque a reset takes off for a while would count as stalled, at each reset anew.
    """
    room.cycle_until(Phase.INSERTING)
    room.rest(inside_s)
    room.control.send_signal(signal.SIGKILL)
    room.rest(6.0)
    room.control = room.begin()
    assert room.now("outputs.phase") == Phase.HALTED
    assert room.now("outputs.signals.present") != 0.0
    before_mm = room.truth("truth.head_mm")
    room.press("reset")
    room.rest(1.0)
    assert room.now("outputs.signals.present") == 0.0
    assert room.now("outputs.phase") == Phase.PARKED
    assert room.truth("truth.head_mm") < before_mm - 0.05
