"""The control loop's interface to a machine, whether it turns motors or only computes.

A machine keeps its own time. The loop reads its newest readings, and the machine takes the loop's
newest commands; neither waits for the other. Without new commands for `MachineFacts.watchdog_s` the
machine's drives act on their own, and obey nothing until a controller says that it has started anew
(`DriveMessage.released`).

Backends: the kinds of machines that a controller can be attached to, chosen by name.

Whoever prepares a machine's folder writes down its kind there (`name_backend`); the controller, the
console and whoever else works on that folder load the backend by that name when they need it. So
nothing of theirs is bound to a kind of machine, and none is loaded that is not there.
"""

import json
from collections.abc import Mapping
from enum import StrEnum
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple, Protocol, cast

from opensuction.host.host import Host
from opensuction.kernel import private_file
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array

if TYPE_CHECKING:
    from opensuction.twin.machine.machine import Machine


DESCRIPTION: Final = "machine"
"""What a controller's ring tells of its machine: `describe`."""


class Capabilities(NamedTuple):
    """Capabilities of a machine, beyond what every machine has; none is taken for granted."""

    monitor: bool
    """Its readings carry what a patient monitor says."""
    mouth_barrier: bool
    """A light barrier at the tube's mouth says whether a catheter is in its beam."""
    taught_by_hand: bool
    """A hand at the catheter head moves it while its drive has let go."""
    simulated_hand: bool
    """Software moves that hand: `SimulatedHand`."""
    truth: bool
    """It tells what is so: `TruthPort`. Only a twin knows."""
    faults: bool
    """Faults are put into it on request. Only a twin takes any."""

    @property
    def lacking(self) -> tuple[str, ...]:
        """Capabilities that it does not have, in words."""
        return tuple(WORDS[name] for name, has in self._asdict().items() if not has)


WORDS: Final = {
    "monitor": "patient monitor",
    "mouth_barrier": "light barrier at the tube's mouth",
    "taught_by_hand": "teaching by hand",
    "simulated_hand": "simulated hand",
    "truth": "truth for a judge",
    "faults": "faults on request",
}
"""A capability in the words that people are told."""
NOTHING: Final = Capabilities(*(False for _ in Capabilities._fields))
EVERYTHING: Final = Capabilities(*(True for _ in Capabilities._fields))
"""Of a twin before a patient; and of one that an older version started, which does not say."""


class MachineFacts(NamedTuple):
    """Self-description of a machine."""

    name: str
    version: str
    """Of whatever drives it."""
    in_silico: bool
    """Nothing moves but numbers."""
    period_s: float
    """How often it reads and obeys."""
    watchdog_s: float
    """Without new commands for longer than this its drives act on their own."""
    most: dict[str, float]
    """Highest magnitude of what it obeys, by the name of the command's column; more is cut."""
    capabilities: Capabilities
    answers_s: float = 2.0
    """How long it may take to give its first readings."""


class Description(NamedTuple):
    """A machine's self-description, as far as others than its controller go by it."""

    in_silico: bool
    capabilities: Capabilities


UNDESCRIBED: Final = Description(in_silico=True, capabilities=EVERYTHING)
"""Of a machine under a controller of an older version: there were only twins."""


def describe(facts: MachineFacts) -> str:
    """The facts as one line of JSON, for a ring's header; how long it takes to answer is none."""
    told = {**facts._asdict(), "capabilities": facts.capabilities._asdict()}
    del told["answers_s"]
    return json.dumps(told)


def read_description(told: Mapping[str, str]) -> Description:
    """The description of a machine in what its controller's ring tells.

    A capability that is not named is none. Where an older version has named none, a twin has all
    of them, and another machine has none. Raises InputError for what is no description.
    """
    if DESCRIPTION not in told:
        return UNDESCRIBED
    try:
        facts = json.loads(told[DESCRIPTION])
        in_silico = facts["in_silico"] is True
        if "capabilities" not in facts:
            return Description(in_silico, EVERYTHING if in_silico else NOTHING)
        return Description(in_silico, read_capabilities(facts["capabilities"]))
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(f"the controller does not describe its machine: {error!r}") from None


def read_capabilities(told: Mapping[str, object]) -> Capabilities:
    """Capabilities from JSON; what is not named, or is not true, is none.

    Raises TypeError for what is no object.
    """
    if not isinstance(told, Mapping):
        raise TypeError(f"capabilities are no object: {told!r}")
    return Capabilities(*(told.get(name) is True for name in Capabilities._fields))


class Port(Protocol):
    """A machine, as the loop sees it."""

    facts: MachineFacts

    def read(self, readings: Array) -> int:
        """Write the newest readings into a row by the columns of `Readings`; their number.

        Numbers grow with what is new. 0: there are none yet, and the row is as it was. Never waits.
        """

    def write(self, sent: Array) -> None:
        """Give a row by `MESSAGE_COLUMNS`, which the drives' watchdog waits for, too.

        Never waits.
        """

    def close(self) -> None:
        """Let go of the machine: it gets no more commands."""


class HandTask(StrEnum):
    """Task of a hand at the catheter head."""

    PUSH = "push"
    DRAW = "draw"
    LET_GO = "let-go"


class SimulatedHand(Protocol):
    """A hand at the catheter head that software moves, where a machine has one: a twin."""

    def hold(self, task: HandTask, park_head_mm: float, quick_mm: float) -> None:
        """Have it do something from now on.

        park_head_mm: where it lets go on the way back. quick_mm: length of the way inside the tube.
        Raises InputError or OSError where the machine does not answer.
        """

    def feels_carina(self) -> bool | None:
        """True while it feels the carina; None where the machine does not say."""


class TruthRead(NamedTuple):
    """Truth of some ticks."""

    rows: Array
    """Shape (ticks, columns), oldest first."""
    missed: int
    """Ticks before them that were overwritten before they were read."""


class TruthPort(Protocol):
    """The true state of a machine and its patient, tick by tick, beside what the bedside shows.

    For a judge, and for no controller, console or recorder: a real machine has none. It reads
    alone: the machine does not know of it, and is played to any number of judges.
    """

    columns: tuple[str, ...]
    """Names of a row's numbers: `tick`, `truth.*`, `annunciator.*`, and whatever else it tells."""
    period_s: float
    """Length of a tick."""

    @property
    def built(self) -> "Machine":
        """The machine as it was built, before any fault. Raises InputError where nothing tells."""

    def read(self) -> TruthRead:
        """Truth of the ticks since the last call. Never waits."""

    def newest(self) -> Array | None:
        """The newest row; None before the first."""


BACKEND: Final = "machine.kind"
"""File of a machine's folder that names its backend."""
TWIN: Final = "twin"
CANOPEN: Final = "canopen"
MODULES: Final = {
    TWIN: "opensuction.machine.twin.twin_machine",
    CANOPEN: "opensuction.machine.canopen.canopen_machine",
}
"""Module of each backend, which is a `Backend`."""


class Backend(Protocol):
    """One kind of machine."""

    def attach(self, folder: Path, host: Host) -> Port:
        """Take hold of the machine of a folder.

        Raises InputError where there is none, or another controller has it.
        """

    def capabilities_of(self, folder: Path) -> Capabilities:
        """Capabilities of the machine of a folder, attached to a controller or not.

        The same as its port's facts say. Raises InputError where there is none.
        """

    def hand_of(self, folder: Path) -> SimulatedHand | None:
        """The hand at the catheter head that software moves; None where a person's own does."""

    def truth_of(self, folder: Path) -> TruthPort | None:
        """Its truth, for a judge; None of a machine that cannot know it.

        Raises InputError where nothing plays.
        """


def name_backend(folder: Path, name: str) -> None:
    """Write down which backend the machine of a folder has."""
    private_file.write(folder / BACKEND, name)


def kind_of(folder: Path) -> str:
    """Name of the backend of a folder's machine.

    A folder that names none has a twin: older versions wrote no name, and had no other kind. Raises
    InputError for a name that cannot be read, or is not known.
    """
    path = folder / BACKEND
    try:
        name = path.read_text(encoding="ascii").strip()
    except FileNotFoundError:
        return TWIN
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path} does not name the kind of machine: {error}") from None
    if name not in MODULES:
        raise InputError(
            f"{path}: unknown kind of machine '{name[:40]}'; known: {', '.join(MODULES)}"
        )
    return name


def load(folder: Path) -> Backend:
    """The backend of a folder's machine. Raises InputError as `kind_of`."""
    return cast(Backend, import_module(MODULES[kind_of(folder)]))


def attach(folder: Path, host: Host) -> Port:
    """Take hold of the machine of a folder, of whatever kind. Raises InputError as its backend."""
    return load(folder).attach(folder, host)


def open_truth(folder: Path) -> TruthPort:
    """The truth of a folder's machine. Raises InputError where nothing plays, or knows none."""
    found = load(folder).truth_of(folder)
    if found is None:
        raise InputError(
            f"the machine in {folder} ({kind_of(folder)}) tells no truth: only a twin is judged"
        )
    return found


def check_faults(folder: Path) -> None:
    """Refuse to put faults into a machine that takes none; raises InputError."""
    if not load(folder).capabilities_of(folder).faults:
        raise InputError(
            f"the machine in {folder} ({kind_of(folder)}) takes no faults on request: only a twin "
            "does"
        )
