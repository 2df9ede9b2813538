"""File of a cycle's recording: its name on record, looked up in the recordings' folder alone."""

import re
import stat
from pathlib import Path
from typing import NamedTuple

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,120}\.mcap")
"""Of what a recorder writes. What a record says otherwise is no file of this folder."""
MOST_PARTS = 1000


class RecordingFile(NamedTuple):
    """A recording: its file, and further parts where a recorder died."""

    name: str
    parts: tuple[Path, ...]
    size: int
    """Bytes of all parts."""
    changed_ns: int
    """When the last of them was written to, or put in its place."""


def _is_file(path: Path) -> bool:
    """True for a plain file; a link could lead out of the folder."""
    try:
        return stat.S_ISREG(path.lstat().st_mode)
    except OSError:
        return False


def find(folder: Path, name: str | None) -> RecordingFile | None:
    """The recording of this name; None where there is none here.

    name: as it is on record; it never comes from whoever asks.
    """
    if name is None or not NAME.fullmatch(name) or ".." in name:
        return None
    first = folder / name
    if not _is_file(first):
        return None
    parts = [first]
    for number in range(2, MOST_PARTS):
        part = folder / f"{first.stem}-{number}.mcap"
        if not _is_file(part):
            break
        parts.append(part)
    facts = [part.stat() for part in parts]
    return RecordingFile(
        name,
        tuple(parts),
        sum(one.st_size for one in facts),
        max(max(one.st_mtime_ns, one.st_ctime_ns) for one in facts),
    )
