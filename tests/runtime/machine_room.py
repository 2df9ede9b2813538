"""A machine's processes in real time on this computer."""

import os
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from opensuction.host.this_computer import THIS_COMPUTER
from tests.runtime.room import Room

LOCKSTEP = "tests.runtime.lockstep_process"
OPEN: list[Room] = []
"""Those that run now: of a test that fails it is told what they did."""


@contextmanager
def running(begins: bool = True, in_step: bool = False, on_bus: bool = False) -> Iterator[Room]:
    """Both of them, in a folder of their own. begins: the controller, too.

    in_step: no process of its own plays the machine, see `lockstep_process`. on_bus: it is drives
    on a bus.
    """
    folder = Path(tempfile.mkdtemp(dir="/dev/shm"))
    drives = folder / "drives" if on_bus else None
    if drives is not None:
        drives.mkdir()
    made = Room(folder, THIS_COMPUTER, os.getpid(), LOCKSTEP if in_step else "", drives)
    OPEN.append(made)
    try:
        if begins:
            made.begin()
        yield made
    finally:
        OPEN.remove(made)
        made.close()
        shutil.rmtree(folder)


def wait(holds: Callable[[], bool], seconds: float = 30.0) -> bool:
    ends = time.monotonic() + seconds
    while not holds():
        if time.monotonic() > ends:
            return False
        time.sleep(0.005)
    return True
