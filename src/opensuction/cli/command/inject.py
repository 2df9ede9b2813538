"""``inject``: faults, and a bus, into a twin that plays in real time."""

from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from opensuction.cli import entry
from opensuction.cli.delivery import show
from opensuction.cli.entry import Command
from opensuction.kernel.errors import InputError
from opensuction.result.plain import to_json

if TYPE_CHECKING:
    from rich.console import Console

    from opensuction.twin.fault.bus import Bus

MS_PER_S = 1000.0
PERCENT = 100.0


class InjectOptions(NamedTuple):
    """Options of ``inject``."""

    folder: Path
    faults: tuple[str, ...] = ()
    node_faults: tuple[str, ...] = ()
    mend: bool = False
    latency_ms: float | None = None
    jitter_ms: float | None = None
    lost_percent: float | None = None
    as_json: bool = False


class FaultTaken(NamedTuple):
    """A fault that the twin has taken."""

    name: str
    at: str
    """Its instant as the command line writes it."""
    strength: float
    """0 for a fault that has none."""


class FaultCome(NamedTuple):
    """A fault that has come."""

    name: str
    strength: float
    """0 for a fault that has none."""
    tick: int
    """The machine's first with it."""


class BusOnTwin(NamedTuple):
    """A bus that the twin has taken, both ways alike."""

    latency_s: float
    jitter_s: float
    lost_share: float


class InjectionResult(NamedTuple):
    """Result of the command."""

    folder: str
    """Of the machine."""
    mended: bool
    bus: BusOnTwin | None
    """None where none was asked for."""
    injected: tuple[FaultTaken, ...]
    came: tuple[FaultCome, ...]
    """Since the twin plays, in their order, mended or not."""
    node_faults: tuple[str, ...] = ()
    """Faults of nodes that emulated drives were sent."""


def _bus(options: InjectOptions) -> "Bus | None":
    """The bus that is wanted; None where none was named."""
    from opensuction.twin.fault.bus import Bus

    named = (options.latency_ms, options.jitter_ms, options.lost_percent)
    if all(value is None for value in named):
        return None
    latency_ms, jitter_ms, lost_percent = (value or 0.0 for value in named)
    carrier = Bus(latency_ms / MS_PER_S, jitter_ms / MS_PER_S, lost_percent / PERCENT)
    carrier.check()
    return carrier


def _find(machine: Path) -> Path:
    """The folder of a machine that was named, or the one that was given."""
    from opensuction.runtime import machine_folder

    if machine.name == str(machine) and not machine.is_dir():
        machine = machine_folder.find(str(machine))
    if not machine.is_dir():
        raise InputError(f"no machine plays in {machine}: name one that runs, or its folder")
    return machine


def run(options: InjectOptions) -> int:
    """Ask the twin; returns the exit status. Raises InputError where it refuses."""
    from opensuction.machine import port
    from opensuction.machine.twin import twin_faults
    from opensuction.session.cycle import resolution

    faults = [resolution.parse(text) for text in options.faults]
    twin_faults.check(faults)
    carrier = _bus(options)
    folder = _find(options.folder)
    port.check_faults(folder)
    _send_node_faults(options, folder)
    if options.mend:
        twin_faults.heal(folder)
    if carrier is not None:
        twin_faults.ride(folder, carrier)
    if faults:
        twin_faults.inject(folder, faults)
    done = InjectionResult(
        folder=str(folder),
        mended=options.mend,
        bus=None if carrier is None else BusOnTwin(*carrier),
        injected=tuple(FaultTaken(one.fault.title, one.at.title, one.strength) for one in faults),
        came=tuple(
            FaultCome(one.fault.title, one.strength, one.tick) for one in twin_faults.came(folder)
        ),
        node_faults=options.node_faults,
    )
    show(options.as_json, to_json(done), lambda console: _summarise(console, done))
    return entry.DONE


def _send_node_faults(options: InjectOptions, folder: Path) -> None:
    """Break nodes of emulated drives, or mend them. Raises InputError where none play."""
    from opensuction.machine.canopen import device_file

    mends = options.mend and (folder / device_file.NAME).exists()
    if not (mends or options.node_faults):
        return
    from opensuction.host.this_computer import THIS_COMPUTER
    from opensuction.machine.drives import node_fault

    requests = [node_fault.parse(text) for text in options.node_faults]
    if mends and node_fault.is_played(folder):
        node_fault.mend(folder, THIS_COMPUTER)
    for request in requests:
        node_fault.inject(folder, request, THIS_COMPUTER)


def _summarise(console: "Console", done: InjectionResult) -> None:
    if done.mended:
        console.print("Mended: it is the machine that it was")
    if done.bus is not None:
        bus = done.bus
        console.print(
            f"Bus: {MS_PER_S * bus.latency_s:g} ms +- {MS_PER_S * bus.jitter_s:g} ms, "
            f"{PERCENT * bus.lost_share:g} % lost"
        )
    for taken in done.injected:
        console.print(f"Taken: {taken.name}{taken.at}{_strength(taken.strength)}")
    for name in done.node_faults:
        console.print(f"Sent to the nodes: {name}")
    if not (done.mended or done.bus or done.injected or done.node_faults):
        for come in done.came:
            console.print(f"Came in tick {come.tick}: {come.name}{_strength(come.strength)}")
        if not done.came:
            console.print("No fault has come")


def _strength(strength: float) -> str:
    return f"={strength:g}" if strength else ""


COMMAND = Command(
    name="inject",
    options=InjectOptions,
    run=run,
    sentence="Let something go wrong in a twin that plays in real time.",
    details="The machine is one that opensuction run or serve began, by its name, or the folder "
    "that its processes share. Faults are those of opensuction cycle, with their "
    "strengths; @S counts from now, @PHASE+S from the next time that the controller's "
    "phase begins. At most two are there or to come until --mend. The bus between "
    "controller and machine is set while nothing is broken: each message takes the "
    "latency plus or minus up to the jitter, drawn evenly for each, both ways alike, and "
    "so many never come. Without an option it says what has come so far. All faults: "
    "docs/reference/faults.md. What is wrong with the controller is done to its process "
    "(kill, kill -STOP). Nodes of opensuction drives break one by one: node-lost, bus-off, "
    "encoder, emergency, pdo-lost=SHARE, repeated=SHARE, sync-late=MS. Linux only.",
    examples="""\b
Examples:
  opensuction inject twin --fault line-leak=0.5           now
  opensuction inject twin --fault valve-jammed@suctioning+2
  opensuction inject twin --fault encoder-frozen@12 --fault power-lost@20
  opensuction inject twin --mend                          all is well again
  opensuction inject twin --latency-ms 0.5 --jitter-ms 0.3 --lost-percent 0.1
  opensuction inject drives --node-fault bus-off@1   cut node 1 off
  opensuction inject twin --json | jq .came""",
    ends="0 the twin has it",
)
