"""``run`` and ``ask``: a machine in real time.

Help texts of ``run`` and ``ask``.
"""

from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from opensuction.cli import delivery, entry
from opensuction.cli.completion import REQUESTS
from opensuction.cli.delivery import show
from opensuction.cli.entry import Command
from opensuction.cli.interruption import Stopped
from opensuction.kernel.vocabulary import NOT_A_DEVICE
from opensuction.result.plain import to_json
from opensuction.session.choice import CycleChoice, RigChoice

if TYPE_CHECKING:
    from rich.console import Console

    from opensuction.cli.progress import ProgressTeller
    from opensuction.session.cycle.cycle_run import Prepared
    from opensuction.session.running.bus_machine import BusMachine
    from opensuction.session.running.cycle_scheduler import CycleScheduler
    from opensuction.session.running.machine import Running
    from opensuction.session.running.run import Done, RunResult


NOTICE = f"In-silico: the machine and the patient are a digital twin. {NOT_A_DEVICE}"

RUN_DETAILS = (
    "The twin plays machine and patient in a process of its own, the controller runs beside it at "
    "1 kHz, a recorder writes a recording for each cycle and puts it on record, and this command "
    "looks after them: what dies is started anew, the controller never into motion. It brings the "
    "catheter out then, and waits for a person: no other cycle is started. The person who looks at "
    "the patient, gives oxygen and presses start between the cycles is simulated. With --device "
    "the machine is on a CANopen bus, and the controller runs at its pace. Ctrl-C breaks a cycle "
    "off; the catheter comes out first. Linux only."
)
RUN_EXAMPLES = """\b
Examples:
  opensuction run                                one cycle, now
  opensuction run --patient neonate --cycles 3 --every 5
  opensuction run --patient child --preoxygenation skipped --json
  opensuction run --device device.toml           drives on a bus, as emulated
  opensuction ask abort                          from another terminal: stop

\b
Files:
  /dev/shm/opensuction-UID/NAME   what the processes share, in memory
  runs/TIME-NAME/*.mcap           a recording for each cycle"""

ASK_DETAILS = (
    f"REQUEST is one of: {', '.join(REQUESTS)}. It is answered in the next millisecond: the button "
    "went down, or why not; what came of it, phase and alarms say. Who asked is put on record. "
    "Linux only."
)
ASK_EXAMPLES = """\b
Examples:
  opensuction ask start --who "nurse Kim"
  opensuction ask abort --name ward-3
  opensuction ask reset --json"""


class MachineOptions(NamedTuple):
    """Options of a machine in real time."""

    rig: RigChoice = RigChoice()
    protocol: str | None = None
    approach: str = "travel"
    compensation: str = "preview"
    taught_mm: float | None = None
    preoxygenation: str | None = None
    name: str = "twin"
    anew: bool = False
    bus_device: Path | None = None
    database: str | None = None
    out: Path | None = None
    as_json: bool = False

    @property
    def choice(self) -> CycleChoice:
        """The cycle that it makes."""
        return CycleChoice(
            rig=self.rig,
            protocol=self.protocol,
            approach=self.approach,
            compensation=self.compensation,
            taught_mm=self.taught_mm,
            preoxygenation=self.preoxygenation,
        )


class RunOptions(NamedTuple):
    """Options of ``run``."""

    wanted: int = 1
    apart_min: float = 30.0
    machine: MachineOptions = MachineOptions()


class AskOptions(NamedTuple):
    """Options of ``ask``."""

    request: str
    who: str | None = None
    name: str = "twin"
    as_json: bool = False


def run(options: RunOptions) -> int:
    """Carry out ``run``; returns the exit status. Raises InputError for bad input."""
    from opensuction.session.running import cycle_scheduler, run

    every_s = 60.0 * options.apart_min
    with machine_of(options.machine, starts_itself=True) as (running, out, progress):
        with closing(
            cycle_scheduler.CycleScheduler(running, options.wanted, every_s, progress.tell)
        ) as made:
            done = supervise(running, out, made, progress)
        found = run.sum_up(running, done, out, options.machine.database)
    show(options.machine.as_json, to_json(found), lambda console: _summarise(console, found))
    good = done.ended and found.is_good(options.wanted)
    return entry.DONE if good else entry.FAILED


@contextmanager
def machine_of(
    options: MachineOptions, starts_itself: bool = False
) -> Iterator[tuple["Running", Path, "ProgressTeller"]]:
    """A machine that is played, with the folder of its recordings; it is gone afterwards.

    starts_itself: cycles are started without a person.
    """
    from opensuction.cli.progress import ProgressTeller
    from opensuction.session.cycle import cycle_run, resolution
    from opensuction.session.running import bus_machine, machine

    progress = ProgressTeller()
    resolved = resolution.resolve(options.choice)
    machine.check_free(options.name)
    bus = None
    if options.bus_device is not None:
        bus = bus_machine.load(options.bus_device)
        bus_machine.check_choice(bus, resolved, starts_itself)
    shown = machine.check_records(options.database)
    with delivery.reserve(options.out, options.name, private=True) as out:
        prepared = progress.wait(
            lambda: cycle_run.prepare(resolved, progress.tell, "A machine in real time"),
            "Preparing",
        )
        if bus is not None:
            bus_machine.check_prepared(bus, prepared, starts_itself)
        running = _begin(options, prepared, bus, progress)
        progress.tell(f"Recordings: {out}; records: {shown}")
        try:
            yield running, out, progress
        finally:
            running.end()


def _begin(
    options: MachineOptions,
    prepared: "Prepared",
    bus: "BusMachine | None",
    progress: "ProgressTeller",
) -> "Running":
    """The machine, whose twin plays, or which is on a bus."""
    from opensuction.runtime import machine_folder, nonvolatile_memory
    from opensuction.session.running import machine

    running = progress.wait(
        lambda: machine.begin(options.name, prepared, options.database, options.anew, bus),
        "Starting the twin" if bus is None else "Taking the machine on the bus",
    )
    if bus is not None:
        nodes = ", ".join(map(str, bus.device.nodes))
        kind = "emulated drives" if bus.device.in_silico else "real drives"
        progress.tell(f"Machine: {kind} of {options.bus_device}, nodes {nodes}")
        if running.recalled is not None:
            progress.tell(nonvolatile_memory.describe(running.recalled))
    elif running.twin is None:
        progress.tell("The twin of an earlier run still plays: it is taken up")
    elif running.lost is not None:
        progress.tell(running.lost.succession)
    if elsewhere := machine_folder.passed_by(running.folder):
        progress.tell(elsewhere)
    return running


def supervise(
    running: "Running",
    out: Path,
    rounds: "CycleScheduler | None",
    progress: "ProgressTeller",
    look: Callable[[tuple[str, ...]], None] = lambda _: None,
) -> "Done":
    """Look after a machine until its rounds are done. look: see `session.running.run.Watch`."""
    from opensuction.runtime.supervisor import Supervisor
    from opensuction.session.running import run

    try:
        with Supervisor(running.folder, out.absolute()) as supervisor:
            return run.supervise(running, supervisor, rounds, run.Watch(progress.tell, look=look))
    except Stopped as ending:
        made = any(out.iterdir())
        ending.add_note(f"the recordings are in {out}" if made else "nothing was recorded")
        raise


def _summarise(console: "Console", found: "RunResult") -> None:
    for one in found.cycles:
        detail = f" ({one.detail})" if one.detail else ""
        outcome = one.outcome or "no end on record"
        console.print(f"Cycle {one.number}: {outcome}{detail}, {one.recording}")
    if found.reason:
        console.print(f"No other cycle was started: {found.reason}")
    if found.not_kept:
        console.print(f"The recorder: {found.not_kept}")
    us, ticks, missed = found.tick_us, found.ticks, found.missed_ticks
    share = 100.0 * missed / max(ticks + missed, 1)
    console.print(
        f"{ticks} ticks, {missed} missed ({share:.2f} %); scheduler {found.scheduler}; "
        f"a tick took {us.p99_9:.0f} us at p99.9, {us.most:.0f} at most"
    )
    for refused in found.not_granted:
        console.print(f"Not granted: {refused}")
    console.print(f"Written: {found.recordings}")
    console.print(NOTICE if found.in_silico else NOT_A_DEVICE)


def ask(options: AskOptions) -> int:
    """Carry out ``ask``; returns the exit status. Raises InputError where nobody answers."""
    import getpass

    from opensuction.runtime.launch import PRESSED
    from opensuction.session.running import run as runs

    who = options.who or getpass.getuser()
    answer = runs.ask(options.name, options.request, who)
    show(options.as_json, to_json(answer), lambda console: console.print(runs.say(answer)))
    return entry.DONE if answer.verdict == PRESSED else entry.FAILED


RUN = Command(
    name="run",
    options=RunOptions,
    run=run,
    sentence="A machine in real time: the twin, its controller and recorder, cycles by the clock.",
    details=RUN_DETAILS,
    examples=RUN_EXAMPLES,
    ends="0 as many cycles completed as were asked for, 1 not",
)
ASK = Command(
    name="ask",
    options=AskOptions,
    run=ask,
    sentence="Press a button of a machine that runs, such as start or abort.",
    details=ASK_DETAILS,
    examples=ASK_EXAMPLES,
    ends="0 the button went down, 1 it was refused",
)
