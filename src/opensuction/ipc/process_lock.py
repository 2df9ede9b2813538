"""A task that one process has at a time, and which one that is.

The system lets go of the lock when the process ends, however it ends.
"""

import contextlib
import fcntl
import os
import signal
import struct
import time
from pathlib import Path
from typing import Self

from opensuction.kernel import private_file
from opensuction.kernel.errors import InputError

LOOKS_S = 0.005
KILLED_S = 5.0
"""Within this time a process that was killed has gone."""
_QUESTION = "hhqqi4x"
"""The system's ``struct flock``: kind, from where, start, length, process."""


class ProcessLock:
    """The task, held by this process."""

    def __init__(self, path: Path, what: str) -> None:
        """path: a file that all of them know. what: begins the refusal.

        Raises InputError where another process has it, or where the file cannot be.
        """
        try:
            self._file = private_file.append(path)
        except OSError as error:
            raise InputError(f"{path} cannot be written: {error.strerror}") from None
        try:
            fcntl.lockf(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            self._file.close()
            raise InputError(f"{what} already: process {holder(path)}, by {path}") from None

    def close(self) -> None:
        """Let another process have it."""
        self._file.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def holder(path: Path) -> int | None:
    """Number of the process that has the task; None where nobody has it.

    Not for the process that has it itself: to close the file again lets go of it.
    """
    try:
        with path.open("r+b") as file:
            asked = struct.pack(_QUESTION, fcntl.F_WRLCK, os.SEEK_SET, 0, 0, 0)
            kind, _, _, _, process = struct.unpack(
                _QUESTION, fcntl.fcntl(file, fcntl.F_GETLK, asked)
            )
    except OSError:
        return None
    return None if kind == fcntl.F_UNLCK else int(process)


def end_holder(path: Path, seconds: float, *, kills: bool = False) -> None:
    """Tell the process that has the task, where one has it, to end, and wait until it has.

    kills: one that does not within that time is killed; for a process that moves nothing.
    Raises InputError where it does not end.
    """
    pid = holder(path)
    if pid is None or _ends(path, pid, signal.SIGTERM, seconds):
        return
    if not kills or not _ends(path, pid, signal.SIGKILL, KILLED_S):
        raise InputError(f"process {pid} of {path.parent} does not end")


def _ends(path: Path, pid: int, number: signal.Signals, seconds: float) -> bool:
    with contextlib.suppress(ProcessLookupError):  # it ended by itself
        os.kill(pid, number)
    ends_s = time.monotonic() + seconds
    while holder(path) == pid:
        if time.monotonic() > ends_s:
            return False
        time.sleep(LOOKS_S)
    return True
