"""Rows of the control loop to files: one recording for each time that the machine is not at rest.

A recording begins a second before the machine leaves its rest and ends a second after it is at rest
again. Where a person starts once more within that second, it is in both. The disk may be slow or
full: then rows are asked for again as long as the ring has them, and what is missing in the end is
told; who controls the machine waits for nobody.
"""

from collections import deque
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from opensuction.controller.loop_tick import AT_REST
from opensuction.host.host import NS_PER_S, Host
from opensuction.host.this_computer import THIS_COMPUTER
from opensuction.ipc.ring import ProcessEvent, Read
from opensuction.kernel.record import Array
from opensuction.recording.cycle_file import row_schema
from opensuction.recording.cycle_file.frame import Extent, Heading
from opensuction.recording.cycle_file.row_schema import STARTS, STATE_PART
from opensuction.recording.cycle_file.writer import FirstRows, RecordingWriter
from opensuction.runtime import loop, recording_part
from opensuction.runtime.flushed import Flushed, Note
from opensuction.runtime.loop import CONFIGURED, ROW_COLUMNS, TIMING_COLUMNS
from opensuction.runtime.open_recording import OpenRecording, utc_ns
from opensuction.runtime.recording_part import NEVER, PARTS

AROUND_S = 1.0
"""How much before and after goes with it."""
HEARD = 64
"""Events of that time, at most."""
MOST_ROWS = 1000
"""Of a chunk: a disk that keeps the recorder waiting is asked once for all that came meanwhile."""
_LEFT, _TIME, _TICK, _PERIOD = (
    ROW_COLUMNS.index(name)
    for name in ("loop.left_rest", "loop.time_s", "inputs.tick", "inputs.dt_s")
)
_STATE = slice(len(TIMING_COLUMNS) + STATE_PART.start, len(TIMING_COLUMNS) + STATE_PART.stop)


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
        self._recording: OpenRecording | None = None
        self._left = AT_REST
        """What of it has been written: when the machine left its rest."""
        self._moved_s = 0.0
        """Time of its last row that is not of a rest."""
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
        if self._recording is None:
            return self._number - sum(map(len, self._before))
        return self._recording.kept

    @property
    def is_recording(self) -> bool:
        """True while a recording goes on."""
        return self._recording is not None

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
            self._tell_missed(found.rows)
            self._heard.extend(happened)
            if self._recording is not None:
                self._recording.tell(happened)
            for rows in _split(found.rows, self._new_from):
                self._take(rows)
            if self._recording is not None:
                self._recording.keep_up(self._clock.monotonic_ns() / NS_PER_S)
            self.lost = ""
        except OSError as error:
            self.lost = error.strerror or str(error)
            self._number = self.kept
            if self._recording is None:
                self._before.clear()
            else:
                self._forget_after(self._recording.go_back())

    def _forget_after(self, row: Array | None) -> None:
        """Remember nothing of rows that are given again. row: the last that is not, if known."""
        if row is not None:
            left = [piece[piece[:, _TICK] <= row[_TICK]] for piece in self._before]
            self._before = deque(piece for piece in left if len(piece))
        if row is None or not self._before:
            self._before.clear()
            self._last = None if row is None else row[_STATE]

    def close(self) -> None:
        """End what is being recorded."""
        ended, self._recording = self._recording, None
        if ended is None:
            return
        self._left = AT_REST
        assert self.path is not None
        self._ended.append(self.path.name)
        try:
            ended.close()
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
        if self._recording is not None:
            self._recording.skip(found.missed)
        self._missed += found.missed

    def _tell_missed(self, rows: Array) -> None:
        """That rows are missing before these, where something is recorded."""
        if self._recording is not None and self._missed and len(rows):
            self._recording.tell_missed(self._missed, rows)
            self._missed = 0

    def _take(self, rows: Array) -> None:
        """Rows of one rest, or of one time between two."""
        left = float(rows[0, _LEFT])
        if rows[0, _TICK] == self._new_from:
            self._begin_anew(rows)
            return
        if left != AT_REST:
            if left != self._left:
                self._end()
                rows = self._leave_out_written(rows)
                if not len(rows):
                    return
                self._begin(rows)
            self._moved_s = float(rows[-1, _TIME])
            self._write(rows)
            self._last = rows[-1, _STATE]
        elif self._recording is None:
            self._number += len(rows)
            self._remember(rows)
        else:
            self._write(rows)
            # Where the disk has refused them rows of the rest before the motion are given again.
            if rows[-1, _TICK] > self._left:
                self._remember(rows)
                if self._has_rested(rows):
                    self._end()

    def _end(self) -> None:
        """End what is being recorded, where the disk takes what is left of it."""
        if self._recording is not None:
            self._recording.flush()
        self.close()

    def _has_rested(self, rows: Array) -> bool:
        """True where rows of a rest end so long after the last motion that the recording ends.

        By times, which are the same where the disk has refused rows and they are given again.
        """
        half_s = 0.5 * float(rows[-1, _PERIOD])
        return bool(rows[-1, _TIME] - self._moved_s > AROUND_S - half_s)

    def _begin_anew(self, rows: Array) -> None:
        """Other settings, in another state: no recording holds both."""
        self._end()
        self._new_from = NEVER
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

    def _leave_out_written(self, rows: Array) -> Array:
        """Rows that no recorder before this one has written: it may have died before it noted so.

        rows: the first of a recording. Those of the rest before them are left out likewise.
        """
        name = recording_part.name_of(self._run, rows[0, _LEFT])
        if name != self._looked_for:
            self._looked_for, self._written = name, recording_part.last_tick(self._folder, name)
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

    def _begin(self, rows: Array) -> None:
        """A new file, with what was before."""
        first = self._before[0][:1] if self._before else rows[:1]
        start: FirstRows | None = None
        if self._last is not None:
            row = np.concatenate(([first[0, _TICK]], self._last))[np.newaxis]
            start = (STARTS, utc_ns(first, self._heading.began_ns), row)
        name = recording_part.name_of(self._run, rows[0, _LEFT])
        writer = self._create(name, first, start)
        self._left = float(rows[0, _LEFT])
        offset = self._number - sum(map(len, self._before))
        self._recording = OpenRecording(writer, self._heading.began_ns, offset)
        if start is None:
            self._tell_missed(first)
        before, self._before, self._last = list(self._before), deque(), None
        heard = [one for one in self._heard if one.fields["time_ns"] >= first[0, _TIME] * NS_PER_S]
        self._recording.tell(heard)
        for piece in before:
            self._number -= len(piece)
            self._write(piece)

    def _create(self, name: str, row: Array, start: FirstRows | None) -> RecordingWriter:
        """The file; where a recorder before this one has begun it, another part of it.

        row: its first. start: the state before it, where that is known.
        """
        began_ns = int(utc_ns(row, self._heading.began_ns)[0])
        for part in range(1, PARTS):
            self.path = self._folder / recording_part.file_of(name, part)
            if self._flushed is not None and self.path.name in self._flushed:
                continue  # it was written, whether it is there still or not
            about = {"run": self._run, "recording": name, "file": self.path.name}
            heading = self._heading._replace(
                began_ns=began_ns, about={**self._heading.about, **about}
            )
            try:
                return self._make(heading, Note(name, part, str(self._folder.absolute())), start)
            except FileExistsError:
                continue
        raise OSError(f"{PARTS} recordings of {name} are there already")

    def _make(self, heading: Heading, note: Note, start: FirstRows | None) -> RecordingWriter:
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
        assert self._recording is not None
        self._recording.add(rows)
        self._number += len(rows)


def _split(rows: Array, new_from: int) -> list[Array]:
    """Rows in pieces: where the machine leaves its rest or comes to it, or gets other settings."""
    if not len(rows):
        return []
    if loop.is_steady(rows, (_LEFT,)) and not (rows[1:, _TICK] == new_from).any():
        return [rows]
    parts = np.diff(rows[:, _LEFT]) != 0
    parts |= rows[1:, _TICK] == new_from
    return np.split(rows, np.flatnonzero(parts) + 1)
