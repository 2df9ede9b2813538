"""A machine on a simulated computer: its processes, the people at its bed, and who looks after it.

Twin, controller, recorder and supervisor are the real processes with their real files, in a folder
of their own. A nurse starts one cycle as soon as the machine is parked, resets it where it halts,
and presses again where nobody answers. A supervisor that died is started again after some seconds,
as a service manager does. A judge sees the twin's truth from outside.
"""

import errno
import shutil
import tempfile
from bisect import bisect_left
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, contextmanager, suppress
from functools import lru_cache
from pathlib import Path

from opensuction.controller.configuration import Configuration
from opensuction.evidence.lives.bedside import NURSE, VISITOR, Display, People, Situation
from opensuction.evidence.lives.simulated_computer import Main, SimulatedComputer
from opensuction.evidence.lives.simulated_process import KILLED, SimulatedClock
from opensuction.evidence.lives.witness import Witness
from opensuction.host.host import NS_PER_S, Child, Lock
from opensuction.host.this_computer import THIS_COMPUTER
from opensuction.ipc.deadline_scheduler import DeadlineScheduler, Pacing
from opensuction.kernel import private_file
from opensuction.kernel.errors import InputError
from opensuction.machine import port
from opensuction.machine.twin import twin_machine, twin_process
from opensuction.machine.twin.live_judge import LiveJudge
from opensuction.machine.twin.twin_process import Playing
from opensuction.records.entry import Catheter, Machine, SettingsFile
from opensuction.runtime import (
    control_process,
    controller_memory,
    launch,
    machine_folder,
    nonvolatile_memory,
    recorder_process,
    supervisor,
)
from opensuction.runtime.loop import ControlLoop
from opensuction.runtime.machine_folder import About
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.twin.plant import PlantState

MEMORY = Path("/dev/shm")
SERIAL = "simulated-1"
MANAGER_S = 2.0
"""After it a supervisor that died is started again."""
JUDGED_EVERY_S = 1.0
REMEMBERS = "memory.json"
"""File of what a machine remembers while its computer is off."""
RECORDINGS, RECORDS = "recordings", "records.db"
PREPARED = 64
"""Machines that a process keeps for lives to come."""
ROOM = "opensuction-lives-"
"""Begin of the name of a folder for many machines."""
HELD = "held"
"""File in it that a command has locked until it ends, however it ends."""
MIB = 2**20
BEGINS_MIB, ENDS_MIB = 128, 32
"""Space of its folder that a life takes at most; and so much that no ring failed to be made."""
FULL = (errno.ENOSPC, errno.EDQUOT)
CLEARED_TIMES = 5
"""A process that is ending may still write into a folder that goes."""


def machine_processes(computer: Callable[[], SimulatedComputer]) -> Mapping[str, Main]:
    """Processes of a machine, by their modules; its twin and its controller tick in stretches.

    computer: gives the one that they run on, as they begin.
    """

    def take_twin(playing: Playing) -> None:
        stretches, running = computer().stretches, computer().running
        if stretches is not None and running is not None:
            stretches.take_twin(running, playing)

    def take_loop(loop: ControlLoop, pace: Pacing) -> None:
        stretches, running = computer().stretches, computer().running
        if stretches is not None and running is not None and isinstance(pace, DeadlineScheduler):
            stretches.take_loop(running, loop, pace)

    return {
        twin_machine.PROCESS: lambda host, told: twin_process.steps(host, Path(told[0]), take_twin),
        launch.CONTROL: lambda host, told: control_process.steps(
            host, Path(told[0]), int(told[1]), tell=take_loop
        ),
        launch.RECORDER: lambda host, told: recorder_process.steps(
            host, Path(told[0]), Path(told[1])
        ),
        launch.SUPERVISOR: lambda host, told: supervisor.steps(host, *map(Path, told)),
    }


@lru_cache(PREPARED)
def _prepare(seed: int) -> Prepared:
    """A neonate and a machine, drawn by a seed."""
    rig = RigChoice(patient="neonate", seed=seed)
    return cycle_run.prepare(resolution.resolve(CycleChoice(rig)))


class NatureClock:
    """From the twin's time to the computer's: the twin does not make up for a long standstill."""

    def __init__(self) -> None:
        self._played_s: list[float] = []
        self._at_ns: list[int] = []

    def note(self, played_s: float, at_ns: int) -> None:
        """Note when the twin had played so much."""
        if not self._played_s or played_s > self._played_s[-1]:
            self._played_s.append(played_s)
            self._at_ns.append(at_ns)

    def at_ns(self, played_s: float) -> float:
        """Instant at which the twin had played so much, by the next that was noted."""
        place = min(bisect_left(self._played_s, played_s), len(self._played_s) - 1)
        return self._at_ns[place] - (self._played_s[place] - played_s) * NS_PER_S


class SimulatedMachine:
    """One machine and all who have to do with it."""

    def __init__(self, folder: Path, seed: int, machine_seed: int) -> None:
        """machine_seed: draws machine and patient."""
        self.folder, self.out = folder, folder / RECORDINGS
        self.database = folder / RECORDS
        self.prepared = _prepare(machine_seed)
        self.people = People(folder)
        self.computer = SimulatedComputer(
            seed,
            {
                **machine_processes(lambda: self.computer),
                launch.RECORDER: lambda host, told: recorder_process.steps(
                    host, Path(told[0]), Path(told[1]), self.computer.disk.open_records
                ),
                NURSE: lambda host, _: self.people.nurse(host),
                VISITOR: lambda host, _: self.people.visitor(host),
            },
        )
        self.display, self.witness = Display(folder), Witness(folder)
        self.nature = NatureClock()
        self._supervisor: Child | None = None
        self.is_closing = False
        """Nobody starts a supervisor again."""
        self._dark_until_ns = 0
        self._begin()

    def _begin(self) -> None:
        """The twin plays, and a supervisor starts the rest."""
        loop, start = self.prepared.loop, self.prepared.start
        seed = self.prepared.resolved.equipment.seed
        side = twin_machine.side_of(loop, seed)
        twin_machine.prepare(self.folder, side, PlantState(start.machine, start.bedside))
        self._lay()
        self.twin = self._spawn(twin_machine.PROCESS, str(self.folder))
        while not (self.folder / twin_process.SHOWN).exists():
            self.computer.run_until(self.computer.now_ns + NS_PER_S)
        self.judge = LiveJudge(port.open_truth(self.folder), loop.controller.limits.cap_mm)
        self._twins = {one.name for one in self.folder.iterdir()}
        self._supervise()
        self._spawn(NURSE)

    def _lay(self) -> None:
        """Have the machine's folder as whoever begins a machine lays it."""
        loop, used = self.prepared.loop, self.prepared.resolved.equipment
        launch.configure(self.folder, Configuration(loop.controller, loop.heads_mm))
        machine_folder.write(
            self.folder,
            About(
                machine=Machine(SERIAL, "clinical", is_twin=True),
                catheter=Catheter("catheter-1", 6, 86_400),
                protocol=SettingsFile("neonate", "{}"),
                approach="travel",
                patient=f"twin-neonate-{used.seed}",
                parameter_file=None,
                database=str(self.database),
                heading={},
                memory=str(self.folder / REMEMBERS),
            ),
        )

    def _spawn(self, module: str, *arguments: str) -> Child:
        log = self.folder / f"{module.rpartition('.')[2]}.log"
        return self.computer.spawn(module, arguments, log)

    def _supervise(self) -> None:
        self._supervisor = self._spawn(launch.SUPERVISOR, str(self.folder), str(self.out))

    def run(self, seconds: float) -> None:
        """Let time go by, with a judge who looks on and a manager who starts supervisors."""
        ends_ns = self.computer.now_ns + round(seconds * NS_PER_S)
        while self.computer.now_ns < ends_ns:
            step_ns = round(JUDGED_EVERY_S * NS_PER_S)
            self.computer.run_until(min(self.computer.now_ns + step_ns, ends_ns))
            self.judge.look()
            self.witness.look()
            twin = self.computer.processes[self.twin.pid]
            self.nature.note(self.judge.now_s, twin.busy_until_ns)
            self._manage()

    def lose_power(self, seconds: float) -> None:
        """Have the computer off for a time: its memory is lost, and what the disk was not sent.

        Twin and people go on, for they are not the computer's.
        """
        self.judge.look()
        self.witness.look()
        for process in self.computer.processes.values():
            if (
                process.module not in (twin_machine.PROCESS, NURSE, VISITOR)
                and process.poll() is None
            ):
                process.end(KILLED)
        for one in self.folder.iterdir():
            is_on_disk = one.name in (REMEMBERS, RECORDINGS) or one.name.startswith(RECORDS)
            if not is_on_disk and one.name not in self._twins:
                one.unlink()
        if self.out.is_dir():
            self.computer.disk.lose_power(self.out)
        self._supervisor = None
        ends_ns = self.computer.now_ns + round(seconds * NS_PER_S)
        self._dark_until_ns = max(self._dark_until_ns, ends_ns)
        self.computer.at(ends_ns, self._power_up)

    def _power_up(self) -> None:
        """Lay the machine's folder anew, with what the disk remembers, and start it."""
        if self.computer.now_ns < self._dark_until_ns or self._supervisor is not None:
            return
        self._lay()
        now_ns = self.computer.now_ns + self.computer.wall_offset_ns
        recalled = nonvolatile_memory.recall(self.folder / REMEMBERS, now_ns, 0.0)
        if recalled is not None:
            clock = SimulatedClock(self.computer)
            controller_memory.hand_on(self.folder, recalled, clock)
        self._supervise()

    def _manage(self) -> None:
        died = self._supervisor is not None and self._supervisor.poll() is not None
        if died and not self.is_closing:
            self._supervisor = None
            due_ns = self.computer.now_ns + round(MANAGER_S * NS_PER_S)
            self.computer.at(due_ns, self._supervise_again)

    def _supervise_again(self) -> None:
        """Start a supervisor in place of one that died, while the computer is on."""
        if self.computer.now_ns >= self._dark_until_ns and self._supervisor is None:
            self._supervise()

    def look(self) -> Situation | None:
        """State of the machine now; see `Display.look`."""
        return self.display.look()

    def pid_of(self, name: str) -> int | None:
        """Number of the process ``control``, ``recorder`` or ``supervisor``; None of none."""
        return self.computer.holder(self.folder / f"{name}.lock")

    def visit(self) -> None:
        """Have a second person stop the machine."""
        self._spawn(VISITOR)

    def end(self, seconds: float) -> bool:
        """Tell the supervisor to end, and all with it; true where they do within a time."""
        self.is_closing = True
        if self._supervisor is None or self._supervisor.poll() is not None:
            self._supervise()
            self.run(10.0)
        assert self._supervisor is not None
        self._supervisor.terminate()
        ends_ns = self.computer.now_ns + round(seconds * NS_PER_S)
        while self._supervisor.poll() is None and self.computer.now_ns < ends_ns:
            self.run(JUDGED_EVERY_S)
        return self._supervisor.poll() == 0

    def close(self) -> None:
        """Let go of all that its processes have open."""
        self.computer.close()


@contextmanager
def room() -> Iterator[Path]:
    """A folder in memory for the machines of many lives; it goes with all that is in it.

    Those of commands that were killed before they could remove theirs go first.
    """
    for abandoned in _memory().glob(f"{ROOM}*"):
        _remove_abandoned(abandoned)
    made, lock = _make_room()
    try:
        with closing(lock):
            yield made
    finally:
        _remove(made)


def _make_room() -> tuple[Path, Lock]:
    """A new folder with its lock; another command may take one for abandoned until it has it."""
    while True:
        made = Path(tempfile.mkdtemp(prefix=ROOM, dir=_memory()))
        with suppress(FileNotFoundError):
            lock = THIS_COMPUTER.locks.take_file(made / HELD)
            if lock is not None and (made / HELD).exists():
                return made, lock


def _remove_abandoned(room: Path) -> None:
    """Remove a folder of this user whose command has ended."""
    if not private_file.is_own_folder(room):
        return
    with suppress(OSError):
        lock = THIS_COMPUTER.locks.take_file(room / HELD)
        if lock is not None:
            with closing(lock):
                _remove(room)


def _remove(room: Path) -> None:
    for _ in range(CLEARED_TIMES):
        if room.exists():
            shutil.rmtree(room, ignore_errors=True)


@contextmanager
def simulated(
    seed: int, machine_seed: int, within: Path | None = None
) -> Iterator[SimulatedMachine]:
    """A machine in a folder that is gone afterwards.

    within: where that folder is; None: memory. Raises InputError where there is no space for it,
    and where there was none left in the end: what became of the machine says nothing then.
    """
    place = _memory() if within is None else within
    _check_space(place, BEGINS_MIB)
    folder = Path(tempfile.mkdtemp(dir=place))
    try:
        with closing(SimulatedMachine(folder, seed, machine_seed)) as made:
            yield made
        _check_space(place, ENDS_MIB)
    except OSError as error:
        if error.errno not in FULL:
            raise
        raise _no_space(place) from None
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _memory() -> Path:
    return MEMORY if MEMORY.is_dir() else Path(tempfile.gettempdir())


def _check_space(place: Path, least_mib: int) -> None:
    """Raises InputError where a folder has not so much space."""
    if shutil.disk_usage(place).free < least_mib * MIB:
        raise _no_space(place)


def _no_space(place: Path) -> InputError:
    free_mib = shutil.disk_usage(place).free / MIB
    where = place.parent if place.name.startswith(ROOM) else place
    return InputError(
        f"no space for the files of a life: {free_mib:.0f} MiB are free in {where}, and it "
        f"needs {BEGINS_MIB}; free some, or give fewer --workers"
    )
