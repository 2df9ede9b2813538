"""What happens once, in words: a ring of short texts, from the one process that knows.

Rows say what is so in each tick; who asked for it and what was answered is said here.
"""

import json
import time
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np

from opensuction.exchange.ring import RingReader, RingWriter

WORDS = 128
"""Longest text, 8 bytes each; a longer one is cut, and says so."""
SLOTS = 4096
COLUMNS = tuple(f"word.{i}" for i in range(WORDS))
CUT = b'{"kind": "too long"}'


class Event(NamedTuple):
    """One of them."""

    number: int
    fields: dict[str, Any]


class EventWriter:
    """Who tells them."""

    def __init__(self, path: Path, before: Path | None = None) -> None:
        """See `RingWriter`."""
        self._ring = RingWriter(path, COLUMNS, SLOTS, {}, before)

    def write(self, kind: str, tick: int, **fields: str) -> None:
        """Tell that something happened in a tick, now."""
        told = {"kind": kind, "tick": tick, "time_ns": time.monotonic_ns(), **fields}
        text = json.dumps(told, ensure_ascii=False).encode()
        if len(text) > 8 * WORDS:
            text = CUT
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
    """Who hears them."""

    def __init__(self, source: Path | RingReader) -> None:
        """source: see `RingReader`; or one that was opened already."""
        self._ring = source if isinstance(source, RingReader) else RingReader(source)

    def go_on_after(self, number: int) -> None:
        """Read on after this event."""
        self._ring.next = number + 1

    def read(self) -> tuple[list[Event], int]:
        """What has been told since the last call, and how many were missed before it."""
        found = self._ring.read()
        told = [json.loads(row.tobytes()) for row in found.rows]
        events = [Event(found.first + i, fields) for i, fields in enumerate(told)]
        return events, found.missed
