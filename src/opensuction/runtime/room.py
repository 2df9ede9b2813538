"""The folder that the processes of one machine share, and what lies in it.

Rings are written each millisecond, so it lies in memory (`/dev/shm`): a page of a file that a disk
is just writing out makes a tick wait. What must outlive the computer lies elsewhere.
"""

import os
import re
from pathlib import Path

from opensuction.kernel.errors import InputError

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
"""What a controller is to remember of one whose machine is gone (`control_process.hand_on`)."""
MARK = "recorder.mark"
"""How far everything is kept."""
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,31}")
"""Of a machine: sockets lie in its folder, and their paths are short."""


def find(name: str) -> Path:
    """The folder of a machine with this name, there or not. Raises InputError for what is none."""
    if not NAME.fullmatch(name):
        raise InputError(
            f"--name {name}: a machine's name is 1 to 32 letters, digits, '.', '_' and '-'"
        )
    if not MEMORY.is_dir():
        raise InputError(f"no {MEMORY} here: a machine in real time needs Linux")
    return MEMORY / f"opensuction-{os.getuid()}" / name


def make(name: str) -> Path:
    """The same, for this user alone; made where there is none.

    Raises InputError where it cannot be, or is somebody else's.
    """
    folder = find(name)
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        owners = {folder.stat().st_uid, folder.parent.stat().st_uid}
    except OSError as error:
        raise InputError(f"{folder} cannot be used: {error.strerror}") from None
    if owners != {os.getuid()}:
        raise InputError(f"{folder} belongs to another user")
    return folder


def clear(folder: Path) -> None:
    """Nobody needs it any more: what lies in memory is given back."""
    for file in folder.iterdir():
        file.unlink()
