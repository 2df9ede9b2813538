"""Position of a reader, in a file that outlives it: the next reader resumes there."""

import mmap
import os
from hashlib import sha256
from pathlib import Path
from typing import NamedTuple

import numpy as np

from opensuction.kernel import private_file
from opensuction.kernel.errors import InputError

WORD = 8


class Place(NamedTuple):
    """Place of a reader in its rings."""

    row: int
    """Number of the last row that it need not read again."""
    event: int
    """Likewise of the events."""


class ReadCheckpoint:
    """The file."""

    def __init__(self, path: Path) -> None:
        """Made where it is not there yet. Raises InputError where it cannot be."""
        size = WORD * 3
        try:
            with private_file.append(path) as file:
                os.posix_fallocate(file.fileno(), 0, size)
                self._words = np.frombuffer(mmap.mmap(file.fileno(), size), np.int64)
        except OSError as error:
            raise InputError(f"{path} cannot be written: {error.strerror}") from None

    def find(self, run: str) -> Place | None:
        """Place to which the run of this name was read; None of another one."""
        own, row, event = (int(word) for word in self._words)
        return Place(row, event) if own == _number_of(run) else None

    def set(self, run: str, place: Place) -> None:
        """Note how far the run of this name has been read."""
        self._words[0] = 0
        self._words[1:] = place
        self._words[0] = _number_of(run)


def _number_of(run: str) -> int:
    """A name as a word that is not 0."""
    return int.from_bytes(sha256(run.encode()).digest()[:7], "big") + 1
