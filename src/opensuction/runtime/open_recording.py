"""A recording that is being written: rows, changes found in them, and what is told meanwhile.

A chunk that the disk refuses is lost, with all that was added since the one before. Its rows are
given again by whoever has them: then their changes are found again, from the last row that the file
has. Events are kept here for it.
"""

from collections import deque
from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

from opensuction.host.host import NS_PER_S
from opensuction.ipc.ring import ProcessEvent
from opensuction.kernel.record import Array
from opensuction.recording.cycle_file.row_schema import TICKS, RecordedEvent
from opensuction.recording.cycle_file.writer import RecordingWriter
from opensuction.runtime import loop
from opensuction.runtime.loop import ROW_COLUMNS, TIMING_COLUMNS

_TIME, _TICK = ROW_COLUMNS.index("loop.time_s"), ROW_COLUMNS.index("inputs.tick")
_TICKS = slice(len(TIMING_COLUMNS), None)
"""A tick's part of a row: the columns of `tick_table`."""


def utc_ns(rows: Array, began_ns: int) -> npt.NDArray[np.uint64]:
    """UTC of rows. began_ns: of the monotonic clock's zero."""
    times: npt.NDArray[np.uint64] = (began_ns + np.round(rows[:, _TIME] * NS_PER_S)).astype(
        np.uint64
    )
    return times


class OpenRecording:
    """A file that takes rows and events; after a refusal it is as after its last whole chunk.

    All that writes raises OSError where the disk refuses; `go_back` is to be called then.
    """

    def __init__(self, writer: RecordingWriter, began_ns: int, offset: int) -> None:
        """began_ns: see `utc_ns`. offset: number of the row before its first."""
        self._writer, self._began_ns = writer, began_ns
        self._number = self._offset = offset
        self._gap_end = offset
        """Number of the last row that is missing; of the first ones nothing is known either."""
        self._start_rows = writer.written_rows
        """How many of its rows are no ticks, but the state before the first."""
        self._seen = loop.NOTHING
        """In the row that was added last."""
        self._given: deque[Array] = deque()
        """Rows that the file has not, in pieces, behind the last that it has."""
        self._told: list[ProcessEvent] = []
        """Events that the file has not."""
        self._told_chunks = writer.written_chunks
        """How many chunks it had when these were added."""
        self._refused: list[ProcessEvent] = []
        """Events that are to be told again."""

    @property
    def kept(self) -> int:
        """Number of the last row that the file has."""
        return self._offset + self._writer.written_rows - self._start_rows

    def add(self, rows: Array) -> None:
        """Rows, each with the changes in it in the same chunk: both are refused or neither."""
        while len(rows):
            some, rows = rows[: self._writer.room_rows], rows[self._writer.room_rows :]
            times = utc_ns(some, self._began_ns)
            for at, event in loop.find(some, self._seen):
                self._writer.add_event(int(times[at]), event)
            self._seen = loop.seen_in(some[-1])
            self._number += len(some)
            self._given.append(some)
            self._writer.add_rows(TICKS, times, np.ascontiguousarray(some[:, _TICKS]))
        held = sum(map(len, self._given))
        while self._given and held - len(self._given[0]) > self._number - self.kept:
            held -= len(self._given.popleft())

    def tell(self, happened: Iterable[ProcessEvent]) -> None:
        """Add events, and those that the disk has refused before."""
        self._forget_told()
        again, self._refused = self._refused, []
        for one in (*again, *happened):
            self._told.append(one)
            time_ns = self._began_ns + int(one.fields.get("time_ns", 0))
            self._writer.add_event(time_ns, loop.of_happening(one))

    def skip(self, missed: int) -> None:
        """Go on behind so many rows that are missing."""
        self._writer.flush()
        self._offset += missed
        self._number += missed
        self._gap_end = self._number

    def tell_missed(self, missed: int, rows: Array) -> None:
        """Tell how many rows are missing before these, now: a refused row would take it along."""
        event = RecordedEvent(int(rows[0, _TICK]), "gap", "rows-missed", f"{missed} ticks")
        self._writer.add_event(int(utc_ns(rows[:1], self._began_ns)[0]), event)
        self._writer.flush()

    def keep_up(self, now_s: float) -> None:
        """See `RecordingWriter.keep_up`."""
        self._writer.keep_up(now_s)

    def flush(self) -> None:
        """See `RecordingWriter.flush`."""
        self._writer.flush()

    def close(self) -> None:
        """See `RecordingWriter.close`."""
        self._writer.close()

    def go_back(self) -> Array | None:
        """Be as after the last row that the file has, which it returns: the next is given again.

        None where the row before the next is in no file.
        """
        behind = self._number - self.kept
        rows = [row for piece in self._given for row in piece]
        last = rows[-behind - 1 : len(rows) - behind]
        self._seen = loop.seen_in(last[0]) if last else loop.NOTHING
        self._given = deque(row[np.newaxis] for row in last)
        self._number = self.kept
        self._forget_told()
        self._refused, self._told = self._refused + self._told, []
        return last[0] if last and self._number > self._gap_end else None

    def _forget_told(self) -> None:
        """Forget events that the file has."""
        if self._writer.written_chunks != self._told_chunks:
            self._told, self._told_chunks = [], self._writer.written_chunks
