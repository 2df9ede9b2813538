"""The folder that the processes of one machine share, and what lies in it.

Rings are written each millisecond, so it lies in memory (`/dev/shm`): a page of a file that a disk
is just writing out makes a tick wait. What must outlive the computer lies elsewhere.

The folders of a user's machines lie in one that only that user may enter, `opensuction-UID`.
Anybody may make a folder of that name first; one that is not this user's alone is passed by for
another whose name nobody can guess. Every command of the user finds that one again by its owner,
which nobody can forge. `XDG_RUNTIME_DIR` would not do: a service or `sudo` may not have it.

Identity of machine, catheter, protocol and patient, for recordings and records.
"""

import json
import os
import re
import secrets
from pathlib import Path
from typing import Any, NamedTuple

from opensuction.kernel import private_file
from opensuction.kernel.errors import InputError
from opensuction.records.entry import Catheter, Machine, SettingsFile

MEMORY = Path("/dev/shm")
CONFIGURATION = "configuration.json"
"""What the controller is set to."""
ABOUT = "about.json"
"""Whose machine it is: `about.About`."""
BASIS = "basis.json"
"""What its settings are made from (`session.running.basis`); the controller never reads it."""
BEGUN_WITH = "begun-with"
"""Hash of the settings that the machine began with; people may have set others since."""
RING, EVENTS = "control.ring", "control.events"
SLOTS_S = 10.0
"""How much the ring keeps."""
RING_BEFORE, EVENTS_BEFORE = "control.ring.before", "control.events.before"
"""What the controller left that ran here before this one."""
ASK = "control.ask"
"""Where the control loop takes requests."""
WATCH_EVENTS, WATCH_EVENTS_BEFORE = "supervisor.events", "supervisor.events.before"
CONTROLS, RECORDS, SUPERVISES = "control.lock", "recorder.lock", "supervisor.lock"
CONSOLES = "console.lock"
"""What the process that controls, records, supervises or serves the console holds."""
CONSOLE_ENDS_S = 10.0
"""How long a console's end may take: pages are told of it."""
CONSOLE = "console.json"
"""What the console is set to, where there is one."""
BEFORE = "before.json"
"""What a controller is to remember of one whose machine is gone (`controller_memory.hand_on`)."""
MARK = "recorder.mark"
"""How far everything is kept."""
FLUSHED = "recorder.flushed"
"""How far recordings that are not on record yet were written, and what they hold."""
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,31}")
"""Of a machine: sockets lie in its folder, and their paths are short."""
SECRET_BYTES = 8
"""Of a name that nobody can guess: more guesses than a computer's memory has folders."""


def find(name: str) -> Path:
    """The folder of a machine with this name, there or not. Raises InputError for what is none."""
    if not NAME.fullmatch(name):
        raise InputError(
            f"--name {name}: a machine's name is 1 to 32 letters, digits, '.', '_' and '-'"
        )
    if not MEMORY.is_dir():
        raise InputError(f"no {MEMORY} here: a machine in real time needs Linux")
    own = [one for one in _candidates() if private_file.is_own_folder(one)]
    for one in own:
        if os.path.lexists(one / name):
            return one / name
    return (own[0] if own else _new()) / name


def _usual() -> Path:
    """Usual folder of this user's machines, unless somebody else has made it first."""
    return MEMORY / f"opensuction-{os.geteuid()}"


def _candidates() -> list[Path]:
    """Folders that may hold this user's machines."""
    usual = _usual()
    return [usual, *sorted(MEMORY.glob(f"{usual.name}-*"))]


def _new() -> Path:
    """Folder for this user's machines where there is none yet."""
    usual = _usual()
    if not os.path.lexists(usual):
        return usual
    return usual.with_name(f"{usual.name}-{secrets.token_hex(SECRET_BYTES)}")


def make(name: str) -> Path:
    """The same, for this user alone; made where there is none.

    Raises InputError where it cannot be, or is somebody else's.
    """
    folder = find(name)
    try:
        private_file.make_folder(folder.parent)
        if not private_file.is_own_folder(folder.parent):  # somebody was faster
            folder = find(name)
        private_file.make_folder(folder)
    except OSError as error:
        raise InputError(f"{folder} cannot be used: {error.strerror}") from None
    if not private_file.is_own_folder(folder):
        raise InputError(
            f"{folder} is a link, or not this user's alone: remove it, or give another --name"
        )
    return folder


def passed_by(folder: Path) -> str:
    """Reason why a machine's folder does not lie in the usual place; empty where it does."""
    if folder.parent == (usual := _usual()):
        return ""
    return f"{usual} is not this user's alone, and is left as it is: the machine is in {folder}"


def clear(folder: Path) -> None:
    """Nobody needs it any more: what lies in memory is given back. Raises InputError.

    But for what is noted of recordings that are not on record yet: the next recorder puts it there.
    """
    try:
        private_file.empty_folder(folder, kept=(FLUSHED,))
    except OSError as error:
        raise InputError(f"{folder} cannot be emptied: {error.strerror}") from None


NOWHERE = (0, 0)
"""Identity of a file that is not there."""


class About(NamedTuple):
    """Facts known before a cycle."""

    machine: Machine
    catheter: Catheter
    protocol: SettingsFile
    approach: str
    patient: str | None
    """Pseudonym; None on a bench."""
    parameter_file: SettingsFile | None
    database: str | None
    """Where it is put on record; None: nowhere."""
    heading: dict[str, str]
    """What else recordings say, by name: seed, notice."""
    memory: str | None = None
    """File of its `nonvolatile_memory`; None: none, for its patient goes with the computer."""


def write(folder: Path, about: About, name: str = ABOUT) -> None:
    """Into the machine's folder, whole or not at all. name: of the file."""
    told: dict[str, Any] = about._asdict()
    for field, value in told.items():
        if hasattr(value, "_asdict"):
            told[field] = value._asdict()
    private_file.write(folder / name, json.dumps(told))


def identity(folder: Path) -> tuple[int, int]:
    """Inode and time of change of the file with the machine's identity; `NOWHERE` for none."""
    try:
        found = (folder / ABOUT).stat()
    except OSError:
        return NOWHERE
    return found.st_ino, found.st_mtime_ns


def read(folder: Path) -> About:
    """From the machine's folder. Raises InputError where it is not there or not whole."""
    try:
        told = json.loads((folder / ABOUT).read_text(encoding="utf-8"))
        parameters = told.pop("parameter_file")
        return About(
            machine=Machine(**told.pop("machine")),
            catheter=Catheter(**told.pop("catheter")),
            protocol=SettingsFile(**told.pop("protocol")),
            parameter_file=None if parameters is None else SettingsFile(**parameters),
            **told,
        )
    except (OSError, ValueError, TypeError, KeyError, AttributeError) as error:
        raise InputError(f"{folder / ABOUT} does not say whose machine it is: {error}") from None
