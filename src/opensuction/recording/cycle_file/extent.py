"""Extent of a file: a length, and the SHA-256 of the bytes up to it."""

import errno
import os
from hashlib import sha256
from pathlib import Path
from stat import S_ISREG
from typing import NamedTuple

READ_BYTES = 1_000_000


class Extent(NamedTuple):
    """The first bytes of a file, or all of them."""

    size_bytes: int
    sha256: str


EMPTY = Extent(0, sha256().hexdigest())


def measure(path: Path, *until: int) -> list[Extent]:
    """A file as it is: its first bytes until each of these places, and all of it last.

    until: in bytes, ascending; of a place beyond the end all that there is. Raises OSError for a
    file that cannot be read; no link is followed, and nothing but a plain file is read.
    """
    flags = os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK
    with os.fdopen(os.open(path, flags), "rb") as file:
        if not S_ISREG(os.fstat(file.fileno()).st_mode):
            raise OSError(errno.EINVAL, "no plain file", str(path))
        digest, size, found = sha256(), 0, []
        for place in (*until, None):
            while place is None or size < place:
                wanted = READ_BYTES if place is None else min(READ_BYTES, place - size)
                data = file.read(wanted)
                if not data:
                    break
                digest.update(data)
                size += len(data)
            found.append(Extent(size, digest.hexdigest()))
    return found
