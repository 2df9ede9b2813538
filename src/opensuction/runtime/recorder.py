"""Rows of the control loop to files: one recording for each time that the machine is not at rest.

A recording begins a second before the machine leaves its rest and ends a second after it is at rest
again. The disk may be slow or full: then rows are missed, and that is told; who controls the
machine waits for nobody.
"""

import time
from collections import deque
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
import numpy.typing as npt

from opensuction.exchange.event_ring import Event as Happening
from opensuction.kernel.phase import RESTING, Phase
from opensuction.kernel.record import Array
from opensuction.recording.cycle_file import tick_table
from opensuction.recording.cycle_file.event import Event
from opensuction.recording.cycle_file.heading import Heading
from opensuction.recording.cycle_file.tick_table import STARTS, STATE_PART, TICKS
from opensuction.recording.cycle_file.writer import RecordingWriter
from opensuction.runtime.loop import ROW_COLUMNS, TIMING_COLUMNS

Times = npt.NDArray[np.uint64]
Flags = npt.NDArray[np.bool_]

AROUND_S = 1.0
"""How much before and after goes with it."""
HEARD = 64
"""Events of that time, at most."""
NS_PER_S = 1e9
_PHASE, _TIME, _TICK = (
    ROW_COLUMNS.index(name) for name in ("outputs.phase", "loop.time_s", "inputs.tick")
)
_TICKS = slice(len(TIMING_COLUMNS), None)
"""A tick's part of a row: the columns of `tick_table`."""
_STATE = slice(_TICKS.start + STATE_PART.start, _TICKS.start + STATE_PART.stop)


class Recorder:
    """Takes rows and events in their order; writes where there is something to keep."""

    def __init__(self, folder: Path, heading: Heading, started_from: Array) -> None:
        """folder: of the recordings. heading: what each says; its beginning is set here.

        ``heading.began_ns`` is the UTC of the monotonic clock's zero. started_from: the
        controller's state before its first tick.
        """
        self._folder, self._heading = folder, heading
        self._before: deque[Array] = deque()
        """Rows of the last second at rest, in pieces."""
        self._heard: deque[Happening] = deque(maxlen=HEARD)
        """What was told meanwhile."""
        self._last: Array | None = started_from
        """The state before them; None where rows are missing there."""
        self._writer: RecordingWriter | None = None
        self._resting_s = 0.0
        """Since when the machine has been at rest again."""
        self._phase = -1
        self.path: Path | None = None
        """The recording that was begun last."""
        self.lost = ""
        """Why rows are not kept; empty where they are."""

    def take(self, rows: Array, missed: int, happened: Iterable[Happening]) -> None:
        """Rows by `loop.ROW_COLUMNS`, how many were missed before them, and events till then."""
        if len(rows):
            active = ~np.isin(rows[:, _PHASE], RESTING)
            if self._writer is None and active.any():
                self._begin(rows)
            if self._writer is None:
                if missed:
                    self._before.clear()
                    self._last = None
                self._keep(rows)
                self._heard.extend(happened)
            else:
                self._write(rows, missed, happened)
                self._end_when_at_rest(rows, active)
        if self._writer is not None:
            self._try(lambda writer: writer.keep_up(time.monotonic()))

    def close(self) -> None:
        """End what is being recorded."""
        if self._writer is not None:
            self._try(lambda writer: writer.close())
        self._writer = None

    def _keep(self, rows: Array) -> None:
        """Remember the last second."""
        self._before.append(rows)
        since_s = rows[-1, _TIME] - AROUND_S
        while len(self._before) > 1 and self._before[0][-1, _TIME] < since_s:
            self._last = self._before.popleft()[-1, _STATE]

    def _utc_ns(self, time_s: Array) -> Times:
        return (self._heading.began_ns + np.round(time_s * NS_PER_S)).astype(np.uint64)

    def _begin(self, rows: Array) -> None:
        """A new file, with what was before."""
        first = self._before[0][0] if self._before else rows[0]
        began_ns = int(self._utc_ns(first[_TIME : _TIME + 1])[0])
        stamp = time.strftime("%Y%m%dT%H%M%S", time.gmtime(began_ns / NS_PER_S))
        self.path = self._folder / f"{stamp}-{int(first[_TICK]):09d}.mcap"
        self._resting_s, self._phase = 0.0, -1
        try:
            self._writer = RecordingWriter(
                self.path, self._heading._replace(began_ns=began_ns), tick_table.TABLES
            )
        except OSError as error:
            self.lost = str(error)
            return
        self.lost = ""
        if self._last is not None:
            self._start(int(first[_TICK]), first, self._last)
        before, self._before, self._last = list(self._before), deque(), None
        heard = [one for one in self._heard if one.fields["time_ns"] >= first[_TIME] * NS_PER_S]
        self._heard.clear()
        for piece in before:
            self._write(piece, 0, heard)
            heard = []

    def _start(self, tick: int, first: Array, state: Array) -> None:
        """The state that a replay begins from: after the tick before the first."""
        row = np.concatenate(([float(tick)], state))[np.newaxis]
        times = self._utc_ns(first[_TIME : _TIME + 1])
        self._try(lambda writer: writer.add_rows(STARTS, times, row))

    def _write(self, rows: Array, missed: int, happened: Iterable[Happening]) -> None:
        times = self._utc_ns(rows[:, _TIME])
        if missed:
            gap = Event(int(rows[0, _TICK]), "gap", "rows-missed", f"{missed} ticks")
            self._add(int(times[0]), gap)
        for event in happened:
            self._tell(event)
        for at in np.flatnonzero(np.diff(rows[:, _PHASE], prepend=self._phase)):
            phase = Phase(int(rows[at, _PHASE]))
            name = phase.name.lower().replace("_", "-")
            self._add(int(times[at]), Event(int(rows[at, _TICK]), "phase", name))
        self._phase = int(rows[-1, _PHASE])
        table = np.ascontiguousarray(rows[:, _TICKS])
        self._try(lambda writer: writer.add_rows(TICKS, times, table))

    def _tell(self, happening: Happening) -> None:
        """What the loop has told in words."""
        fields = happening.fields
        told = Event(
            int(fields.get("tick", 0)),
            str(fields["kind"]),
            str(fields.get("ask", fields["kind"])),
            str(fields.get("verdict", "")),
            str(fields.get("who", "")),
            str(fields.get("key", "")),
        )
        time_ns = self._heading.began_ns + int(fields.get("time_ns", 0))
        self._add(time_ns, told)

    def _end_when_at_rest(self, rows: Array, active: Flags) -> None:
        if active[-1]:
            self._resting_s = 0.0
            return
        begun = np.flatnonzero(active)
        if begun.size or not self._resting_s:
            self._resting_s = float(rows[begun[-1] + 1 if begun.size else 0, _TIME])
        if rows[-1, _TIME] - self._resting_s >= AROUND_S:
            self._last = rows[-1, _STATE]
            self.close()

    def _add(self, time_ns: int, event: Event) -> None:
        self._try(lambda writer: writer.add_event(time_ns, event))

    def _try(self, what: Callable[[RecordingWriter], None]) -> None:
        """Do something with the file; a disk that is full is told, and tried again."""
        if self._writer is None:
            return
        try:
            what(self._writer)
            self.lost = ""
        except OSError as error:
            self.lost = str(error)
