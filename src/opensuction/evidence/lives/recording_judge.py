"""Judge of the recordings of a life: each can be read, replays, and tells what its rows show."""

from collections.abc import Iterator
from contextlib import closing
from functools import partial
from itertools import zip_longest
from pathlib import Path
from typing import NamedTuple

import numpy as np

from opensuction.evidence.lives.witness import Sums, sums_of
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array
from opensuction.recording.cycle_file.reader import (
    NothingRecordedError,
    RecordingReader,
    Rows,
    TimedEvent,
)
from opensuction.recording.cycle_file.row_schema import RecordedEvent
from opensuction.runtime import loop, replay
from opensuction.runtime.loop import ROW_COLUMNS

CHANGES = ("phase", "trip", "alarm")
"""Kinds of events that a recorder finds in the rows."""


class Kept(NamedTuple):
    """Rows that the recordings of a run hold."""

    tick: Array
    sums: Sums


class _HeardReader(RecordingReader):
    """A recording of which the changes are kept that it tells, and those that are in its rows."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self.told: list[RecordedEvent] = []
        self.found: list[RecordedEvent] = []
        self._seen = loop.NOTHING

    def contents(self) -> Iterator[Rows | TimedEvent]:
        """See `RecordingReader.contents`."""
        for one in super().contents():
            if isinstance(one, TimedEvent) and one.event.kind in CHANGES:
                self.told.append(one.event)
            yield one

    def see(self, ticks: Array) -> None:
        """Find the changes in rows of ticks."""
        rows = np.zeros((len(ticks), len(ROW_COLUMNS)))
        rows[:, -ticks.shape[1] :] = ticks
        self.found += [event for _, event in loop.find(rows, self._seen)]
        self._seen = loop.seen_in(rows[-1])


class Recordings:
    """Recordings of a life, each read and judged once, and the rows that they hold."""

    def __init__(self) -> None:
        self._pieces: dict[str, list[Kept]] = {}
        """By the name of the run."""
        self.unfinished: set[Path] = set()
        """Files that no writer has closed."""

    def judge(self, file: Path) -> Iterator[str]:
        """Violations by a recording; one without a row is that of a recorder that died."""
        reader = None
        try:
            with closing(_HeardReader(file)) as reader:
                verdict = replay.replay(reader, partial(self._see, reader))
        except NothingRecordedError:
            return
        except InputError as error:
            said = str(error).rpartition("/")[2]
            yield f"cannot be read: {said}"
            return
        finally:
            if reader is not None and reader.flaw is not None:
                self.unfinished.add(file)
        if not verdict.identical:
            yield f"replay differs: {verdict.first}"
        elif reader.is_damaged:
            yield str(reader.flaw)
        elif reader.told != reader.found:
            first = next(a or b for a, b in zip_longest(reader.told, reader.found) if a != b)
            yield f"its changes are not those of its rows: {first}"

    def _see(self, reader: _HeardReader, rows: Array) -> None:
        found = self._pieces.setdefault(reader.heading.about.get("run", ""), [])
        found.append(Kept(rows[:, 0].copy(), sums_of(rows)))
        reader.see(rows)

    def kept(self) -> dict[str, Kept]:
        """Rows of all that were judged, by the name of the run."""
        return {
            run: Kept(*(np.concatenate(column) for column in zip(*found, strict=True)))
            for run, found in self._pieces.items()
            if found
        }
