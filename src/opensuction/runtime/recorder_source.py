"""Source of a recorder: the rows and events of one controller, followed from a given place on."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from opensuction.controller.loop_tick import AT_REST
from opensuction.ipc.ring import EventReader, Place, ProcessEvent, Read, RingReader
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array
from opensuction.runtime.journal import ControllerRun
from opensuction.runtime.loop import ROW_COLUMNS, STARTED_FROM

_LEFT = ROW_COLUMNS.index("loop.left_rest")
_STATE = [i for i, name in enumerate(ROW_COLUMNS) if name.startswith("state.")]


class Left(NamedTuple):
    """State that is known where following a controller begins."""

    before: Array | None
    """The row before the first; None of none, and where rows are missing."""
    state: Array | None
    """The controller's before the first row; None where rows are missing."""
    goes_on: float
    """When the machine left its rest, of what goes on there; `AT_REST` of nothing. Where rows are
    missing, of what goes on behind them."""
    behind: Array | None = None
    """The first row behind those that are missing."""


class Source:
    """The ring and the events of one controller."""

    def __init__(self, rows: Path, events: Path) -> None:
        """Raises InputError where there is none yet, or one of another version."""
        self._path, self._inode = rows, rows.stat().st_ino
        self._rows, self._events = RingReader(rows), EventReader(events)
        if self._rows.facts.columns != ROW_COLUMNS:
            raise InputError(f"{rows} is of another version of the controller")
        told = self._rows.facts.told
        self.run = ControllerRun(told["run"], int(told["began_utc_ns"]))
        self.settings_hash, self.version = told["settings"], told["version"]
        self.told = told
        """What the ring says of itself; see `machine.port.read_description`."""
        self._first = np.frombuffer(bytes.fromhex(told[STARTED_FROM]))
        self.event = 0
        """Number of the last event that was read."""

    def begin(self, place: Place) -> Left:
        """Go on after a place, or begin."""
        if place.row:
            self.event = place.event
            self._events.go_on_after(place.event)
        self._rows.next = max(place.row, 1)
        found = self._rows.read(1)
        goes_on = float(found.rows[0, _LEFT]) if len(found.rows) else AT_REST
        self._rows.next = place.row + 1
        if found.missed:
            return Left(None, None, goes_on, found.rows[0] if len(found.rows) else None)
        if place.row == 0:
            return Left(None, self._first, AT_REST)
        if not len(found.rows):
            return Left(None, None, AT_REST)
        return Left(found.rows[0], found.rows[0, _STATE], goes_on)

    def read(self) -> tuple[Read, list[ProcessEvent]]:
        """Rows and events since the last call."""
        return self._rows.read(), self._hear()

    def drain(self) -> tuple[Read, list[ProcessEvent]]:
        """All that a controller left that writes no more."""
        return self._rows.drain(), self._hear()

    def _hear(self) -> list[ProcessEvent]:
        events = self._events.read()[0]
        self.event = events[-1].number if events else self.event
        return events

    def go_back(self, row: int) -> None:
        """Read on after this row."""
        self._rows.next = row + 1

    def is_replaced(self) -> bool:
        """True once another controller writes."""
        try:
            return self._path.stat().st_ino != self._inode
        except OSError:
            return False
