"""A ring whose writer may end, and another one begin: then its file is another one."""

from collections.abc import Callable
from pathlib import Path

from opensuction.ipc.ring import RingReader
from opensuction.kernel.errors import InputError


class FollowedRing:
    """Whoever follows it looks now and then whether the file is another one by now."""

    def __init__(self, path: Path, wanted: Callable[[tuple[str, ...]], bool]) -> None:
        """wanted: says of a ring's columns whether it is one to be read; others are left alone."""
        self._path, self._wanted = path, wanted
        self._inode = 0
        self.reader: RingReader | None = None
        """Of the newest file that was found; None before there was one."""

    def look(self) -> bool:
        """Open the ring where there is another one than before; whether there was."""
        try:
            inode = self._path.stat().st_ino
            if inode == self._inode:
                return False
            reader = RingReader(self._path)
        except (OSError, InputError):
            return False
        if not self._wanted(reader.facts.columns):
            return False
        self.reader, self._inode = reader, inode
        return True
