"""Witness of all that the controllers of a machine publish, beside the recorder and without it.

What it has seen is to be found in recordings and records, once.
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.controller.loop_tick import AT_REST
from opensuction.ipc.ring import EventReader, FollowedRing, ProcessEvent
from opensuction.kernel.record import Array
from opensuction.kernel.vocabulary import CYCLE
from opensuction.runtime import machine_folder
from opensuction.runtime.loop import ROW_COLUMNS, TIMING_COLUMNS, told

Numbers = npt.NDArray[np.int64]
Sums = npt.NDArray[np.uint64]
Flags = npt.NDArray[np.bool_]
_RECORDED = slice(len(TIMING_COLUMNS), None)
"""Part of a row that a recording holds."""
_KEPT = {
    "tick": "inputs.tick",
    "time_s": "loop.time_s",
    "skipped": "loop.skipped",
    "left_rest": "loop.left_rest",
    "phase": "outputs.phase",
    "passes": "outputs.counters.passes",
    "rest_left_s": "outputs.counters.rest_left_s",
    "age_s": "state.core.upkeep.catheter_age_s",
}
_PLACES = [ROW_COLUMNS.index(name) for name in _KEPT.values()]


def sums_of(rows: Array) -> Sums:
    """A sum of the bits of each row, which another row hardly has."""
    bits = rows.view(np.uint64)
    weights = 2 * np.arange(bits.shape[1], dtype=np.uint64) + 1
    sums: Sums = bits @ weights
    return sums


class Published(NamedTuple):
    """Rows of a controller's run, a number for each in every field."""

    tick: Array
    time_s: Array
    skipped: Array
    left_rest: Array
    phase: Array
    passes: Array
    rest_left_s: Array
    age_s: Array
    told: Numbers
    """Conditions that people shall be told."""
    sums: Sums
    """See `sums_of`, of what a recording holds."""

    @property
    def has_left(self) -> Flags:
        """True where the machine is not at rest: a recording holds these rows."""
        found: Flags = self.left_rest != AT_REST
        return found

    @property
    def in_cycle(self) -> Flags:
        """True where the phase is one of a cycle."""
        found: Flags = np.isin(self.phase, [int(phase) for phase in CYCLE])
        return found


class WitnessedRun:
    """Run of one controller."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.events: list[ProcessEvent] = []
        self._pieces: list[tuple[Array, Numbers, Sums]] = []

    def add(self, rows: Array, events: list[ProcessEvent]) -> None:
        """Take what came since the last call."""
        self.events += events
        if len(rows):
            self._pieces.append((rows[:, _PLACES], told(rows), sums_of(rows[:, _RECORDED])))

    def published(self) -> Published | None:
        """All of its rows; None where there were none."""
        if not self._pieces:
            return None
        kept = np.concatenate([one for one, _, _ in self._pieces])
        masks = np.concatenate([one for _, one, _ in self._pieces])
        sums = np.concatenate([one for _, _, one in self._pieces])
        columns = dict(zip(_KEPT, kept.T, strict=True))
        return Published(**columns, told=masks, sums=sums)


class Witness:
    """Follows the controllers of a folder.

    It is to look more often than their rings come round, and after the end of each of them: there
    is no other place for what one has published that it has never seen.
    """

    def __init__(self, folder: Path) -> None:
        self._events_path = folder / machine_folder.EVENTS
        self._ring = FollowedRing(folder / machine_folder.RING, lambda told: told == ROW_COLUMNS)
        self._events: EventReader | None = None
        self.runs: list[WitnessedRun] = []

    def look(self) -> None:
        """Take what has come since the last call."""
        self._take()
        if self._ring.look() and self._ring.reader is not None:
            self._events = EventReader(self._events_path)
            self.runs.append(WitnessedRun(self._ring.reader.facts.told["run"]))
            self._take()

    def _take(self) -> None:
        if self._ring.reader is not None and self._events is not None:
            self.runs[-1].add(self._ring.reader.read().rows, self._events.read()[0])
