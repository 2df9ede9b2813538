"""Writers of an SQLite file take turns, with the checkpoint that may follow their commit.

SQLite up to 3.51.2 may lose a commit where a checkpoint runs beside another writer
(benbjohnson/litestream#1432), and is what many systems have. A lock on a file of its own: one on
the database itself would be lost whenever SQLite closes a file of that name.
"""

import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from opensuction.kernel import private_file

AGAIN_S = 0.005
"""How soon the lock is asked for again."""


def name_of(database: Path) -> Path:
    """The file that is locked."""
    return database.with_name(f"{database.name}-lock")


@contextmanager
def hold(database: Path, wait_s: float) -> Iterator[None]:
    """Nobody else writes in here. Raises TimeoutError where somebody did for longer than wait_s.

    It is given back by the system when its process dies.
    """
    if sys.platform == "win32":  # one program at a time is what can be promised there
        yield
        return
    handle = private_file.opener(str(name_of(database)), os.O_RDWR | os.O_CREAT)
    try:
        _take(handle, wait_s)
        yield
    finally:
        os.close(handle)


def _take(handle: int, wait_s: float) -> None:
    import fcntl

    end_s = time.monotonic() + wait_s
    while True:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if time.monotonic() >= end_s:
                raise TimeoutError from None
            time.sleep(AGAIN_S)
        else:
            return
