"""A ring of rows in a file: one process writes and never waits, any number read.

The file is mapped into memory by all of them, so what was written outlives its writer: after a
crash whoever finds the file reads what is in it. A reader that is overtaken is told how many rows
it has missed. The newest row is the state of the machine now.

A ring whose writer may end, and another one begin: then its file is another one.

Ring of events as short texts, from one writing process to any number of readers.

Rows hold the state of each tick; events hold what happens once, such as who made a request and what
the answer was.

Position of a reader, in a file that outlives it: the next reader resumes there.
"""

import json
import mmap
import os
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np
import numpy.typing as npt

from opensuction.host.host import Host
from opensuction.host.this_computer import THIS_COMPUTER
from opensuction.kernel import private_file, slot
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


MAGIC = 0x6F73_7263_5F72_696E
VERSION = 1
HEADER_WORDS = 8
"""Magic, version, slots, columns, bytes of what is said of them, number of the newest row, and two
to spare."""
PAGE = 4096
ONE = np.uint64(1)
HASTE_ROWS = 16
"""How much nearer than a whole ring to the writer an overtaken reader goes on: while it copies, the
writer does not come upon it again."""

Rows = npt.NDArray[np.float64]


class RingFacts(NamedTuple):
    """Description that a ring gives of itself."""

    columns: tuple[str, ...]
    slots: int
    told: dict[str, str]
    """Whatever its writer says: settings, versions, when it began."""


class Read(NamedTuple):
    """Rows that a reader found."""

    rows: Rows
    """Shape (rows, columns), oldest first."""
    first: int
    """Number of the first of them; counted from 1."""
    missed: int
    """How many before it were overwritten before they were read."""


def _place(words: int) -> int:
    """Bytes of the header with that many bytes of text, to whole pages."""
    return -(-(HEADER_WORDS * WORD + words) // PAGE) * PAGE


@cache
def _warm_up() -> None:
    """Load the machine code of a slot, before anybody waits for it: it takes some ten ticks."""
    slots = np.zeros((2, 1 + slot.AROUND), np.uint64)
    row, rows, first = np.zeros(1, np.uint64), np.zeros((1, 1), np.uint64), np.uint64(1)
    slot.write(slots, first, row)
    slots.flags.writeable = False  # as a reader has them: machine code of another kind
    slot.read(slots, first, row)
    slot.read_newest(slots, 1, HASTE_ROWS, row)
    slot.read_many(slots, first, rows)
    slot.find_newest(slots)


class RingWriter:
    """The one that writes."""

    def __init__(
        self,
        path: Path,
        columns: Sequence[str],
        slots: int,
        told: Mapping[str, str],
        before: Path | None = None,
        host: Host = THIS_COMPUTER,
    ) -> None:
        """Make the file anew, or refuse where another process writes it; raises InputError.

        slots: how many rows are kept. told: see `RingFacts.told`. before: where the file goes that
        was there; None: it goes.
        """
        _warm_up()
        lock = host.locks.take_file(path.with_name(path.name + ".lock"))
        if lock is None:
            raise InputError(f"{path} is being written by another process")
        self._lock = lock
        text = json.dumps({"columns": list(columns), "told": dict(told)}).encode()
        width = len(columns) + slot.AROUND
        start, size = _place(len(text)), slots * width * WORD
        # A file of its own, put in place when whole: what a reader still has mapped stays as it is.
        new = path.with_name(path.name + ".new")
        with private_file.create(new) as file:
            os.posix_fallocate(file.fileno(), 0, start + size)
            self._memory = mmap.mmap(file.fileno(), start + size)
        self._words = np.frombuffer(self._memory, dtype=np.uint64)
        self._memory[HEADER_WORDS * WORD : HEADER_WORDS * WORD + len(text)] = text
        self._words[1:HEADER_WORDS] = (VERSION, slots, len(columns), len(text), 0, 0, 0)
        self.slots = self._words[start // WORD :].reshape(slots, width)
        self._words[0] = MAGIC
        if before is not None and path.exists():
            path.replace(before)
        new.replace(path)
        self.header = self._words[:HEADER_WORDS]

    def write(self, row: Rows) -> int:
        """Publish a row; its number, from 1 on."""
        number = self.header[slot.NEWEST] + ONE
        slot.write(self.slots, number, row.view(np.uint64))
        self.header[slot.NEWEST] = number
        return int(number)

    def close(self) -> None:
        """Let another one write; the file stays, with all that is in it."""
        self._lock.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class RingReader:
    """One of those that read; it keeps where it is."""

    def __init__(self, path: Path) -> None:
        """Open a ring; raises InputError where there is none, or one of another version."""
        _warm_up()
        try:
            with path.open("rb") as file:
                self._memory = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        except (OSError, ValueError) as error:
            raise InputError(f"no ring at {path}: {error}") from None
        words = np.frombuffer(self._memory, np.uint64, len(self._memory) // WORD)
        if len(words) < HEADER_WORDS or int(words[0]) != MAGIC:
            raise InputError(f"{path} is not a ring, or not whole yet")
        version, slots, width, said = (int(words[i]) for i in range(1, slot.NEWEST))
        start = _place(said)
        if version != VERSION:
            raise InputError(
                f"{path} is a ring of version {version}; this software reads {VERSION}"
            )
        if len(self._memory) < start + slots * (width + slot.AROUND) * WORD:
            raise InputError(f"{path} is cut off: {len(self._memory)} bytes")
        text = json.loads(self._memory[HEADER_WORDS * WORD : HEADER_WORDS * WORD + said])
        self.facts = RingFacts(tuple(text["columns"]), slots, text["told"])
        self.header = words[:HEADER_WORDS]
        self.slots = words[start // WORD :][: slots * (width + slot.AROUND)].reshape(slots, -1)
        self.next = 1
        """Number of the row that is read next."""

    def newest(self) -> int:
        """Number of the newest row, 0 before the first: as its writer says."""
        return int(self.header[slot.NEWEST])

    def peek(self, column: int) -> float:
        """A column of the newest row, for whoever knows that nobody writes meanwhile."""
        place = self.newest() % self.facts.slots
        return float(self.slots[place, 1 + column : 2 + column].view(np.float64)[0])

    def snapshot(self) -> tuple[int, Rows] | None:
        """The newest row with its number; None before the first."""
        row = np.empty(len(self.facts.columns), np.uint64)
        number = int(slot.read_newest(self.slots, self.newest(), HASTE_ROWS, row))
        return (number, row.view(np.float64)) if number else None

    def read(self, most: int | None = None) -> Read:
        """Rows since the last call, at most so many; none is an empty array."""
        newest, missed = self.newest(), 0
        oldest = max(newest - self.facts.slots + 1, 1)
        if self.next < oldest:
            kept = min(oldest + HASTE_ROWS, newest)
            missed, self.next = kept - self.next, kept
        wanted = newest - self.next + 1
        if wanted == 0:  # as mostly for events: there is nothing to be looked up
            return Read(np.empty((0, len(self.facts.columns))), self.next, 0)
        rows = np.empty((min(wanted, most or wanted), len(self.facts.columns)), np.uint64)
        count = slot.read_many(self.slots, np.uint64(self.next), rows)
        first, self.next = self.next, self.next + count
        if count == 0 and wanted > 0 and missed == 0:
            # The writer has come upon it while it looked.
            self.next = min(self.next + HASTE_ROWS, self.newest() + 1)
            missed = self.next - first
            first = self.next
        return Read(rows[:count].view(np.float64), first, missed)

    def drain(self) -> Read:
        """All whole rows that are left from where it is, of a writer that is dead."""
        newest = int(slot.find_newest(self.slots))
        oldest = max(newest - self.facts.slots + 1, self.next, 1)
        rows = np.empty((max(newest - oldest + 1, 0), len(self.facts.columns)), np.uint64)
        whole = np.array(
            [slot.read(self.slots, np.uint64(oldest + i), rows[i]) for i in range(len(rows))], bool
        )
        missed = max(oldest - self.next, 0) + int(np.count_nonzero(~whole))
        self.next = newest + 1
        return Read(rows[whole].view(np.float64), oldest, missed)


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


WORDS = 128
"""Longest text, 8 bytes each; the longest words of a longer one are cut."""
SLOTS = 4096
COLUMNS = tuple(f"word.{i}" for i in range(WORDS))
CUT = "..."
"""Ends words that were cut."""


class ProcessEvent(NamedTuple):
    """One of them."""

    number: int
    fields: dict[str, Any]


def _write(told: dict[str, Any]) -> bytes:
    # Half a surrogate pair is a letter to JSON, and none to anybody else.
    return json.dumps(told, ensure_ascii=False).encode(errors="replace")


class EventWriter:
    """Writer of events."""

    def __init__(self, path: Path, before: Path | None = None, host: Host = THIS_COMPUTER) -> None:
        """See `RingWriter`."""
        self._clock = host.clock
        self._ring = RingWriter(path, COLUMNS, SLOTS, {}, before, host)

    def write(self, kind: str, tick: int, **fields: str) -> None:
        """Tell that something happened in a tick, now."""
        told = {"kind": kind, "tick": tick, "time_ns": self._clock.monotonic_ns()}
        text = _write({**told, **fields})
        while len(text) > 8 * WORDS:
            longest = max(fields, key=lambda name: len(_write({name: fields[name]})))
            fields[longest] = fields[longest].removesuffix(CUT)[: len(fields[longest]) // 2] + CUT
            text = _write({**told, **fields})
        # Of numbers that may be written to, as any row is: others take machine code of their own.
        self._ring.write(np.frombuffer(bytearray(text.ljust(8 * WORDS)), np.float64))

    def close(self) -> None:
        """Let another one tell; the file stays, with all that is in it."""
        self._ring.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class EventReader:
    """Reader of events."""

    def __init__(self, source: Path | RingReader) -> None:
        """source: see `RingReader`; or one that was opened already."""
        self._ring = source if isinstance(source, RingReader) else RingReader(source)

    def go_on_after(self, number: int) -> None:
        """Read on after this event."""
        self._ring.next = number + 1

    def read(self) -> tuple[list[ProcessEvent], int]:
        """Events since the last call, and how many were missed before them."""
        found = self._ring.read()
        told = [json.loads(row.tobytes()) for row in found.rows]
        events = [ProcessEvent(found.first + i, fields) for i, fields in enumerate(told)]
        return events, found.missed
