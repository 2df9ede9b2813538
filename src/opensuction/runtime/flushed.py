"""Extent and checksum of each recording as last flushed, kept for after a recorder's death.

The notes lie in the machine's folder, in memory, and outlive the recorder: its successor puts on
record what it had written. Each write of a recording is noted before and after it is made. So a
file is as it is noted, or its recorder died in a write: then the file is as before that write, or
as after it, or ends within it.

A line of the file is the note of one recording, and the last of a name counts. So a write of a
recording costs a line, and whoever dies within one leaves the note before it.
"""

import contextlib
import json
import os
import sys
import threading
from pathlib import Path
from typing import NamedTuple

from opensuction.kernel import private_file
from opensuction.recording.cycle_file import frame
from opensuction.recording.cycle_file.frame import EMPTY, Extent
from opensuction.records.entry import BoundFile


class Note(NamedTuple):
    """Extents on disk of a recording that is being written."""

    cycle_recording: str
    """Name of its first part."""
    part: int
    folder: str
    before: Extent = EMPTY
    """What it held before the last write."""
    after: Extent = EMPTY
    """What it holds after it."""
    is_closed: bool = False


LONGEST_BYTES = 64_000
"""A file of notes that is longer is written anew: it lies in memory."""


class Flushed:
    """The notes of a machine's recorder, by the names of the files. Several threads may ask."""

    def __init__(self, path: Path) -> None:
        """Takes up what a recorder before has left there."""
        self._path, self._lock, self._failed = path, threading.Lock(), False
        self._notes = _read(path)
        self._room_bytes = 0
        """How much longer the file may be; whoever begins writes it anew."""
        self._used = set(self._notes)
        """Names that were written to, whether the files are still there or not."""

    def __contains__(self, name: str) -> bool:
        with self._lock:
            return name in self._used

    def left(self) -> dict[str, Note]:
        """All that are kept."""
        with self._lock:
            return dict(self._notes)

    def put(self, name: str, note: Note) -> None:
        """Keep a note, in place of the one before."""
        with self._lock:
            self._notes[name] = note
            self._used.add(name)
            if not self._add(_line_of(name, note)):
                self._write()

    def drop(self, name: str, was_made: bool = True) -> None:
        """Forget a file: it is on record, or was never made, and the name is free again."""
        with self._lock:
            if not was_made:
                self._used.discard(name)
            if self._notes.pop(name, None) is not None:
                self._write()

    def _add(self, line: bytes) -> bool:
        """Add a line; false where the file is to be written anew."""
        if len(line) > self._room_bytes:
            return False
        self._room_bytes -= len(line)
        try:
            handle = private_file.opener(str(self._path), os.O_WRONLY | os.O_APPEND)
            try:
                return os.write(handle, line) == len(line)
            finally:
                os.close(handle)
        except OSError:
            return False

    def _write(self) -> None:
        """Whole or not at all. Where it cannot be, recordings go on, and are bound as they end."""
        self._room_bytes = 0
        try:
            if not self._notes:
                self._path.unlink(missing_ok=True)
                return
            lines = b"".join(_line_of(name, note) for name, note in self._notes.items())
            private_file.write(self._path, lines)
            self._room_bytes = LONGEST_BYTES - len(lines)
        except OSError as error:
            if not self._failed:
                sys.stderr.write(f"opensuction: {self._path} cannot be written: {error.strerror}\n")
            self._failed = True


def _line_of(name: str, note: Note) -> bytes:
    return json.dumps((name, *note)).encode() + b"\n"


def _read(path: Path) -> dict[str, Note]:
    """Notes that are kept there; none where they cannot be read.

    One that was not written to its end is left out, and counts for nothing: what it announces was
    not begun.
    """
    notes: dict[str, Note] = {}
    with contextlib.suppress(OSError, ValueError, TypeError, AttributeError):
        for line in path.read_text(encoding="utf-8").splitlines():
            name, *fields = json.loads(line)
            notes[str(name)] = _to_note(*fields)
    return notes


def _to_note(
    cycle_recording: str,
    part: int,
    folder: str,
    before: list[int | str],
    after: list[int | str],
    is_closed: bool,
) -> Note:
    (size, digest), (later_size, later_digest) = before, after
    return Note(
        str(cycle_recording),
        int(part),
        str(folder),
        Extent(int(size), str(digest)),
        Extent(int(later_size), str(later_digest)),
        bool(is_closed),
    )


def bind(name: str, note: Note) -> BoundFile:
    """Entry for the records on a file, from its note and from the file that lies there.

    A file that is neither as before its last write nor as after it, nor ends within it, was cut or
    changed: what its recorder wrote goes on record, and an audit finds the file otherwise.
    """
    found = note.after
    if not note.is_closed and note.before != note.after:
        with contextlib.suppress(OSError):
            first, whole = frame.measure(Path(note.folder) / name, note.before.size_bytes)
            if first != note.before:
                found = note.before
            elif whole.size_bytes < note.after.size_bytes:
                found = whole
    return BoundFile(
        name, note.cycle_recording, note.part, note.folder, *found, is_closed=note.is_closed
    )
