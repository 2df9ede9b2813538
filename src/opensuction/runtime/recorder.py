"""Rows of the control loop to files: one recording for each time that the machine is not at rest.

A recording begins a second before the machine leaves its rest and ends a second after it is at rest
again. Where a person starts once more within that second, it is in both. The disk may be slow or
full: then rows are asked for again as long as the ring has them, and what is missing in the end is
told; who controls the machine waits for nobody.
"""

from collections import deque
from collections.abc import Callable, Sequence
from contextlib import closing, suppress
from pathlib import Path

import numpy as np
import numpy.typing as npt

from opensuction.controller.loop_tick import AT_REST
from opensuction.host.host import NS_PER_S, Host
from opensuction.host.this_computer import THIS_COMPUTER
from opensuction.ipc.ring import ProcessEvent, Read
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array
from opensuction.recording.cycle_file import row_schema
from opensuction.recording.cycle_file.frame import Extent, Heading
from opensuction.recording.cycle_file.reader import RecordingReader, Rows
from opensuction.recording.cycle_file.row_schema import STARTS, STATE_PART, TICKS, RecordedEvent
from opensuction.recording.cycle_file.writer import FirstRows, RecordingWriter
from opensuction.runtime import loop
from opensuction.runtime.flushed import Flushed, Note
from opensuction.runtime.loop import CONFIGURED, ROW_COLUMNS, TIMING_COLUMNS

AROUND_S = 1.0
"""How much before and after goes with it."""
HEARD = 64
"""Events of that time, at most."""
MOST_ROWS = 1000
"""Of a chunk: a disk that keeps the recorder waiting is asked once for all that came meanwhile."""
PARTS = 1000
"""Files of one recording, at most: each recorder that begins anew makes one."""
NEVER = -1
_LEFT, _TIME, _TICK, _PERIOD = (
    ROW_COLUMNS.index(name)
    for name in ("loop.left_rest", "loop.time_s", "inputs.tick", "inputs.dt_s")
)
_TICKS = slice(len(TIMING_COLUMNS), None)
"""A tick's part of a row: the columns of `tick_table`."""
_STATE = slice(_TICKS.start + STATE_PART.start, _TICKS.start + STATE_PART.stop)


def name_of(run: str, left_rest: float) -> str:
    """The recording of what goes on since a tick in which the machine left its rest."""
    return f"{run}-{int(left_rest):09d}.mcap"


def is_after(recording: str | None, run: str, tick: float) -> bool:
    """True where a recording is of a cycle of this run that began after a tick."""
    head, _, number = (recording or "").removesuffix(".mcap").rpartition("-")
    return head == run and number.isdecimal() and int(number) > tick


class Recorder:
    """Takes rows and events in their order; writes where there is something to keep."""

    def __init__(
        self,
        folder: Path,
        run: str,
        describe: Callable[[], Heading],
        state: Array | None,
        after: int = 0,
        flushed: Flushed | None = None,
        host: Host = THIS_COMPUTER,
    ) -> None:
        """folder: of the recordings. run: name of the controller's.

        describe: what each recording says of itself; its ``began_ns`` is the UTC of the monotonic
        clock's zero. state: the controller's before the first row; None where it is not known.
        after: number of the row before the first. flushed: where it is noted how far recordings
        go; None: nowhere.
        """
        self._folder, self._run, self._describe = folder, run, describe
        self._flushed, self._clock, self._files = flushed, host.clock, host.files
        self._heading = describe()
        for columns in row_schema.TABLES.values():
            row_schema.layout_of(columns)  # compiled or loaded before there is anything to write
        self._before: deque[Array] = deque()
        """Rows of the last second at rest, in pieces."""
        self._heard: deque[ProcessEvent] = deque(maxlen=HEARD)
        """What was told last."""
        self._last = state
        """The state before them; None where rows are missing there."""
        self._missed = 0
        """How many rows are missing there; no recording tells of them yet."""
        self._writer: RecordingWriter | None = None
        self._left = AT_REST
        """What of it has been written: when the machine left its rest."""
        self._moved_s = 0.0
        """Time of its last row that is not of a rest."""
        self._seen = loop.NOTHING
        """In the row that was written or remembered last."""
        self._offset = 0
        """Number of the row before the first of the recording."""
        self._start_rows = 0
        """How many of its rows are no ticks, but the state before the first."""
        self._number = after
        """Of the row that was taken last."""
        self._new_from = NEVER
        """Tick from which on the controller goes by other settings."""
        self._looked_for, self._written = "", float(NEVER)
        """Recording of which a recorder before this one may have written a part, and how far."""
        self.path: Path | None = None
        """The recording that was begun last."""
        self.lost = ""
        """Why rows are not kept; empty where they are."""
        self._ended: list[str] = []

    def take_ended(self) -> list[str]:
        """Names of the recordings that have ended since the last call."""
        ended, self._ended = self._ended, []
        return ended

    @property
    def kept(self) -> int:
        """Number of the last row that need not be given again."""
        if self._writer is None:
            return self._number - sum(map(len, self._before))
        return self._offset + max(self._writer.written_rows - self._start_rows, 0)

    @property
    def is_recording(self) -> bool:
        """True while a recording goes on."""
        return self._writer is not None

    def take(self, found: Read, happened: Sequence[ProcessEvent]) -> None:
        """Take the rows that the ring has given, and the events until then.

        Where it cannot be kept `lost` says why, and all after `kept` is to be given again.
        """
        for event in happened:
            if event.fields["kind"] == CONFIGURED:
                self._new_from = int(event.fields["tick"])
        try:
            if found.missed:
                self._skip(found)
            self._number = max(self._number, found.first - 1)
            if self._writer is not None:
                self._tell_missed(self._writer, found.rows)
            self._tell(happened)
            for rows in _split(found.rows, self._new_from):
                self._take(rows)
            if self._writer is not None:
                self._writer.keep_up(self._clock.monotonic_ns() / NS_PER_S)
            self.lost = ""
        except OSError as error:
            self.lost = error.strerror or str(error)
            self._number = self.kept
            self._before.clear()
            if self._writer is not None:
                self._last = None  # it is of a later row than the next that is given

    def close(self) -> None:
        """End what is being recorded."""
        writer, self._writer = self._writer, None
        if writer is None:
            return
        self._left = AT_REST
        assert self.path is not None
        self._ended.append(self.path.name)
        try:
            writer.close()
        except OSError as error:
            self.lost = error.strerror or str(error)
            return
        if self._flushed is not None:
            note = self._flushed.left()[self.path.name]
            self._flushed.put(self.path.name, note._replace(is_closed=True))

    def _skip(self, found: Read) -> None:
        """Rows are missing before these."""
        self._before.clear()
        self._last = None
        if self._writer is not None:
            self._writer.flush()
            self._offset += found.missed
        self._missed += found.missed

    def _tell_missed(self, writer: RecordingWriter, rows: Array) -> None:
        """That rows are missing before these."""
        if self._missed and len(rows):
            tick, time_ns = int(rows[0, _TICK]), int(self._utc_ns(rows[:1])[0])
            writer.add_event(
                time_ns, RecordedEvent(tick, "gap", "rows-missed", f"{self._missed} ticks")
            )
            writer.flush()  # a disk that refuses the rows behind it would take it along
            self._missed = 0

    def _tell(self, happened: Sequence[ProcessEvent]) -> None:
        """Take events: for now, and for a recording that begins soon."""
        self._heard.extend(happened)
        if self._writer is not None:
            self._add(self._writer, happened)

    def _add(self, writer: RecordingWriter, happened: Sequence[ProcessEvent]) -> None:
        for one in happened:
            time_ns = self._heading.began_ns + int(one.fields.get("time_ns", 0))
            writer.add_event(time_ns, loop.of_happening(one))

    def _take(self, rows: Array) -> None:
        """Rows of one rest, or of one time between two."""
        left = float(rows[0, _LEFT])
        if rows[0, _TICK] == self._new_from:
            self._begin_anew(rows)
            return
        if left != AT_REST:
            if left != self._left:
                self.close()
                rows = self._leave_out_written(rows)
                if not len(rows):
                    return
                self._begin(rows)
            self._moved_s = float(rows[-1, _TIME])
            self._write(rows)
            self._last = rows[-1, _STATE]
        elif self._writer is None:
            self._number += len(rows)
            self._seen = loop.seen_in(rows[-1])
            self._remember(rows)
        else:
            self._write(rows)
            self._remember(rows)
            if self._has_rested(rows):
                self._writer.flush()
                self.close()

    def _has_rested(self, rows: Array) -> bool:
        """True where rows of a rest end so long after the last motion that the recording ends.

        By times, which are the same where the disk has refused rows and they are given again. Rows
        of the rest before the motion are among those.
        """
        is_after = self._left != AT_REST and rows[-1, _TICK] > self._left
        half_s = 0.5 * float(rows[-1, _PERIOD])
        return bool(is_after and rows[-1, _TIME] - self._moved_s > AROUND_S - half_s)

    def _begin_anew(self, rows: Array) -> None:
        """Other settings, in another state: no recording holds both."""
        self._new_from = NEVER
        if self._writer is not None:
            self._writer.flush()
        self.close()
        self._heading = self._describe()
        self._before.clear()
        self._number += 1
        self._last = rows[0, _STATE]
        if len(rows) > 1:
            self._take(rows[1:])

    def _remember(self, rows: Array) -> None:
        """Keep the last second."""
        self._before.append(rows)
        since_s = rows[-1, _TIME] - AROUND_S
        while len(self._before) > 1 and self._before[0][-1, _TIME] < since_s:
            self._last, self._missed = self._before.popleft()[-1, _STATE], 0

    def _utc_ns(self, rows: Array) -> npt.NDArray[np.uint64]:
        return (self._heading.began_ns + np.round(rows[:, _TIME] * NS_PER_S)).astype(np.uint64)

    def _leave_out_written(self, rows: Array) -> Array:
        """Rows that no recorder before this one has written: it may have died before it noted so.

        rows: the first of a recording. Those of the rest before them are left out likewise.
        """
        name = name_of(self._run, rows[0, _LEFT])
        if name != self._looked_for:
            self._looked_for, self._written = name, self._last_written(name)
        before = [self._new_of(piece) for piece in self._before]
        self._before = deque(piece for piece in before if len(piece))
        new = self._new_of(rows)
        self._number += len(rows) - len(new)
        return new

    def _new_of(self, rows: Array) -> Array:
        """Those that are not written yet."""
        count = int(np.count_nonzero(rows[:, _TICK] <= self._written))
        if count:
            self._last, self._missed = rows[count - 1, _STATE], 0
        return rows[count:]

    def _last_written(self, name: str) -> float:
        """Last tick that the parts of a recording hold; `NEVER` of none."""
        found = list(self._folder.glob(f"{name.removesuffix('.mcap')}*.mcap"))
        return max(map(_last_tick, found), default=NEVER)

    def _begin(self, rows: Array) -> None:
        """A new file, with what was before."""
        first = self._before[0][:1] if self._before else rows[:1]
        start: FirstRows | None = None
        if self._last is not None:
            row = np.concatenate(([first[0, _TICK]], self._last))[np.newaxis]
            start = (STARTS, self._utc_ns(first), row)
        self._writer = self._create(name_of(self._run, rows[0, _LEFT]), first, start)
        self._left = float(rows[0, _LEFT])
        self._offset = self._number - sum(map(len, self._before))
        self._start_rows = self._writer.written_rows
        self._seen = loop.NOTHING
        if start is None:
            self._tell_missed(self._writer, first)
        before, self._before, self._last = list(self._before), deque(), None
        heard = [one for one in self._heard if one.fields["time_ns"] >= first[0, _TIME] * NS_PER_S]
        self._add(self._writer, heard)
        for piece in before:
            self._number -= len(piece)
            self._write(piece)

    def _create(self, name: str, row: Array, start: FirstRows | None) -> RecordingWriter:
        """The file; where a recorder before this one has begun it, another part of it.

        row: its first. start: the state before it, where that is known.
        """
        stem, began_ns = name.removesuffix(".mcap"), int(self._utc_ns(row)[0])
        for part in range(1, PARTS):
            self.path = self._folder / (name if part == 1 else f"{stem}-{part}.mcap")
            if self._flushed is not None and self.path.name in self._flushed:
                continue  # it was written, whether it is there still or not
            about = {"run": self._run, "recording": name, "file": self.path.name}
            heading = self._heading._replace(
                began_ns=began_ns, about={**self._heading.about, **about}
            )
            try:
                return self._open(heading, Note(name, part, str(self._folder.absolute())), start)
            except FileExistsError:
                continue
        raise OSError(f"{PARTS} recordings of {name} are there already")

    def _open(self, heading: Heading, note: Note, start: FirstRows | None) -> RecordingWriter:
        """A new file of which every write is noted. Raises OSError, and leaves none then."""
        flushed, path = self._flushed, self.path
        assert path is not None

        def tell(before: Extent, after: Extent) -> None:
            if flushed is not None:
                flushed.put(path.name, note._replace(before=before, after=after))

        try:
            return RecordingWriter(
                path,
                heading,
                row_schema.TABLES,
                most_rows=MOST_ROWS,
                create=self._files.create,
                flushing=None if flushed is None else tell,
                first=start,
            )
        except OSError:
            if flushed is not None:
                flushed.drop(path.name, was_made=False)
            raise

    def _write(self, rows: Array) -> None:
        writer, times = self._writer, self._utc_ns(rows)
        assert writer is not None
        for at, event in loop.find(rows, self._seen):
            writer.add_event(int(times[at]), event)
        self._seen = loop.seen_in(rows[-1])
        self._number += len(rows)
        writer.add_rows(TICKS, times, np.ascontiguousarray(rows[:, _TICKS]))


def _last_tick(path: Path) -> float:
    """Of a recording, whole or cut off; `NEVER` where it holds none."""
    last = float(NEVER)
    with suppress(InputError), closing(RecordingReader(path)) as reader:
        for content in reader.contents():
            if isinstance(content, Rows) and content.topic == TICKS and len(content.table):
                last = float(content.table[-1, 0])
    return last


def _split(rows: Array, new_from: int) -> list[Array]:
    """Rows in pieces: where the machine leaves its rest or comes to it, or gets other settings."""
    if not len(rows):
        return []
    if loop.is_steady(rows, (_LEFT,)) and not (rows[1:, _TICK] == new_from).any():
        return [rows]
    parts = np.diff(rows[:, _LEFT]) != 0
    parts |= rows[1:, _TICK] == new_from
    return np.split(rows, np.flatnonzero(parts) + 1)
