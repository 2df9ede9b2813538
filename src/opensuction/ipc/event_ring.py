"""Ring of events as short texts, from one writing process to any number of readers.

Rows hold the state of each tick; events hold what happens once, such as who made a request and what
the answer was.
"""

import json
import time
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np

from opensuction.ipc.ring import RingReader, RingWriter

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

    def __init__(self, path: Path, before: Path | None = None) -> None:
        """See `RingWriter`."""
        self._ring = RingWriter(path, COLUMNS, SLOTS, {}, before)

    def write(self, kind: str, tick: int, **fields: str) -> None:
        """Tell that something happened in a tick, now."""
        told = {"kind": kind, "tick": tick, "time_ns": time.monotonic_ns()}
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
