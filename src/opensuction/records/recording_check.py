"""Files of recordings held against what is on record of them: swapped, cut, changed, missing.

What is found is one sentence in words, without the folder: whoever shows it knows that.
"""

import re
import time
from collections.abc import Callable, Iterable, Mapping
from enum import StrEnum
from pathlib import Path
from stat import S_ISREG
from typing import NamedTuple

from opensuction.kernel.errors import InputError
from opensuction.recording.cycle_file import frame
from opensuction.records.entry import BoundFile

WRITTEN = re.compile(r"\d{8}T\d{6}-[0-9a-f]{8}-\d{9}(-\d{1,4})?\.mcap")
"""Name that a recorder gives a file."""
FURTHER_PART = re.compile(r"(.+)-\d{1,4}\.mcap")
RECENT_S = 10.0
"""A file that was written to so lately may have a recorder that goes on."""


class BoundRecording(NamedTuple):
    """A file on record, with the cycle that it is of."""

    file: BoundFile
    machine: str
    """Serial."""
    cycle: int | None
    """Number; None: the machine moved outside of a cycle."""

    @property
    def said(self) -> str:
        """Name of a recording, with its cycle and machine."""
        whose = "no cycle" if self.cycle is None else f"cycle {self.cycle}"
        return f"the recording {self.file.name} of {whose} of machine {self.machine}"


class Kind(StrEnum):
    """Kind of fault of a file."""

    MISSING = "missing"
    SWAPPED = "swapped"
    CUT = "cut"
    CHANGED = "changed"
    STRANGE = "strange"
    """Put beside what a recorder wrote."""
    UNREADABLE = "unreadable"


class Fault(NamedTuple):
    """That a file is not what is on record."""

    kind: Kind
    sentence: str


FindOwner = Callable[[str], BoundRecording | None]
"""The recording on record with this hash."""


def find_own_name(path: Path) -> str | None:
    """The name that a recorder gave a file, as it says itself; None where it does not say."""
    from opensuction.recording.cycle_file.reader import RecordingReader

    try:
        reader = RecordingReader(path)
    except InputError:
        return None
    reader.close()
    about = reader.heading.about
    return about.get("file")


def find_misnaming(path: Path) -> Fault | None:
    """That a file under a recorder's name says that it is another; of others nobody can tell."""
    own = find_own_name(path) if WRITTEN.fullmatch(path.name) else None
    if own in (None, path.name):
        return None
    return Fault(
        Kind.SWAPPED,
        f"{path.name} is not what it is called: the file says that it is the recording {own}",
    )


def check(one: BoundRecording, path: Path, find_owner: FindOwner) -> Fault | None:
    """Fault of the file at a path; None: it is what was put on record."""
    file, said = one.file, one.said
    try:
        if not S_ISREG(path.lstat().st_mode):
            return Fault(Kind.CHANGED, f"{said} is a link or no plain file")
        (found,) = frame.measure(path)
    except FileNotFoundError:
        return Fault(Kind.MISSING, f"{said} is missing")
    except OSError as error:
        return Fault(Kind.UNREADABLE, f"{said} cannot be read: {error.strerror}")
    if found == (file.size_bytes, file.sha256):
        return None
    owner = find_owner(found.sha256)
    if owner is not None:
        return Fault(Kind.SWAPPED, f"{said} was swapped: the file there is {owner.said}")
    own = find_own_name(path)
    if own not in (None, file.name):
        return Fault(
            Kind.SWAPPED, f"{said} was swapped: the file there says that it is the recording {own}"
        )
    there = f"{found.size_bytes} bytes are there, {file.size_bytes} were put on record"
    if found.size_bytes < file.size_bytes:
        return Fault(Kind.CUT, f"{said} was cut: {there}")
    if found.size_bytes > file.size_bytes:
        return Fault(Kind.CHANGED, f"{said} was added to: {there}")
    return Fault(
        Kind.CHANGED, f"{said} was changed: its bytes have another hash than the one on record"
    )


def check_size(one: BoundRecording, path: Path) -> Fault | None:
    """The same by its presence and length alone, which costs nothing."""
    try:
        status = path.lstat()
    except OSError:
        return Fault(Kind.MISSING, f"{one.said} is missing")
    if S_ISREG(status.st_mode) and status.st_size == one.file.size_bytes:
        return None
    return Fault(Kind.CHANGED, f"{one.said} has another length than the one on record")


def find_strange(known: Mapping[str, BoundRecording], folder: Path) -> list[Fault]:
    """Files that lie as further parts beside recordings on record, and are none.

    known: what is on record of the folder, by name.
    """
    try:
        names = sorted(one.name for one in folder.iterdir())
    except OSError as error:
        return [Fault(Kind.UNREADABLE, f"the list of files cannot be read: {error.strerror}")]
    found = []
    for name in names:
        part = FURTHER_PART.fullmatch(name)
        first = None if part is None else known.get(f"{part[1]}.mcap")
        if first is None or name in known or may_be_written(folder / name):
            continue
        sentence = f"{name} lies beside {first.said}, and no recorder has put it on record"
        found.append(Fault(Kind.STRANGE, sentence))
    return found


def may_be_written(path: Path) -> bool:
    """True if a recorder may have it open, or died before it wrote to it."""
    try:
        status = path.lstat()
    except OSError:
        return True
    if not S_ISREG(status.st_mode):
        return False
    return status.st_size == 0 or time.time() - status.st_ctime < RECENT_S


def check_all(recordings: Iterable[BoundRecording], folder: Path | None) -> list[Fault]:
    """Faults of all recordings that are on record.

    folder: where all of it lies by now; None: where each was written.
    """
    by_hash: dict[str, BoundRecording] = {}
    by_folder: dict[Path, dict[str, BoundRecording]] = {}
    for one in recordings:
        by_hash.setdefault(one.file.sha256, one)
        place = Path(one.file.folder) if folder is None else folder
        by_folder.setdefault(place, {})[one.file.name] = one
    found = []
    for place, known in by_folder.items():
        if not place.is_dir():
            sentence = (
                f"the folder {place} of {len(known)} recording{'' if len(known) == 1 else 's'} on "
                "record is not here; name the one where they lie with --recordings"
            )
            found.append(Fault(Kind.MISSING, sentence))
            continue
        faults = [check(one, place / name, by_hash.get) for name, one in known.items()]
        found += [
            fault._replace(sentence=f"{fault.sentence} in {place}")
            for fault in (*filter(None, faults), *find_strange(known, place))
        ]
    return found
