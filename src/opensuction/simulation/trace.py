"""Recorded runs of the closed loop: columns by name.

Log of the controller's inputs that the trace of a run lacks, so that the run can be replayed.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.controller import controller
from opensuction.controller.record import State
from opensuction.kernel.interface import NO_REQUESTS, Requests
from opensuction.kernel.vocabulary import RESTING, Phase
from opensuction.simulation import closed_loop
from opensuction.simulation.closed_loop import COLUMNS, DT_S, Loop, LoopState
from opensuction.twin.machine import machine as twin
from opensuction.twin.plant import PlantState

BEGUN = "begun"
"""Sets the first state of a run."""
RESTARTED = "restarted"
"""A new controller started, with what the one before had to remember."""
EXPIRED = "catheter-aged"
"""The catheter was made older than it is."""


class InputSpan(NamedTuple):
    """Ticks that follow each other, and what the controller got in them."""

    first: int
    """Row of the trace of the first tick."""
    ticks: int
    tick: int
    """Number of the first tick, as the controller counts."""
    requests: Requests
    """Pressed in the first tick only."""
    late_until_tick: int = 0
    """Ticks before this one are told that the one before them was late."""
    runs: bool = True
    """Whether a controller ran at all."""
    set_by: str = ""
    """What set its state before the first tick; empty where it is what the ticks before left."""
    state: State | None = None
    """That state, where something set it."""

    @property
    def end(self) -> int:
        """Row of the trace after the last tick."""
        return self.first + self.ticks


def _goes_on(span: InputSpan, after: InputSpan) -> bool:
    """True where nothing tells a span from the one before it."""
    same = (after.runs, after.late_until_tick) == (span.runs, span.late_until_tick)
    follows = after.end == span.first and after.tick + after.ticks == span.tick
    return same and follows and not span.set_by and span.requests == NO_REQUESTS


class InputLog:
    """The spans of a run, noted piece by piece as it is played."""

    def __init__(self) -> None:
        self.spans: list[InputSpan] = []
        self._set_by = BEGUN

    def set_state(self, by: str) -> None:
        """Note that the controller's state is another than the last tick left. by: a name."""
        self._set_by = by

    def note(self, span: InputSpan, state: State) -> None:
        """Add a span, in place of what was noted of its ticks before: they are played anew.

        state: before its first tick.
        """
        while self.spans and self.spans[-1].first >= span.first:
            gone = self.spans.pop()
            self._set_by = self._set_by or gone.set_by
        if self.spans:
            last = self.spans[-1]
            self.spans[-1] = last._replace(ticks=span.first - last.first)
        if self._set_by:
            span = span._replace(set_by=self._set_by, state=state)
        if self.spans and _goes_on(span, self.spans[-1]):
            last = self.spans[-1]
            self.spans[-1] = last._replace(ticks=last.ticks + span.ticks)
        else:
            self.spans.append(span)
        self._set_by = ""


Columns = dict[str, npt.NDArray[np.float64]]
"""Trace of a run: one array for each column of `closed_loop.COLUMNS`, one entry a tick."""

CACHED_ROWS = 256
"""Rows that are turned into columns at once: both fit into the first caches of a processor, which
makes it three times as fast as one column after the other."""
RECORDED_ROWS = 5000
"""Rows that are written before their columns are kept: 3 MB, used again and again. A table of all
rows costs a fifth of the run, for memory that is touched once."""
_PHASE = COLUMNS.index("phase")
_RESTING = np.array(RESTING, dtype=np.float64)


class PhaseSpan(NamedTuple):
    """One phase of a run, from its first tick to the first tick of the next."""

    phase: Phase
    start_s: float
    end_s: float


def power_up(loop: Loop, plant: PlantState, catheter_age_s: float) -> LoopState:
    """Closed loop at its first tick, the plant as given, its head read by the encoder."""
    head_mm = twin.read(loop.machine, plant.machine).head_mm
    return LoopState(
        tick=0,
        controller=controller.start(loop.controller, head_mm, catheter_age_s),
        machine=plant.machine,
        bedside=plant.bedside,
    )


def rows(limit_s: float) -> npt.NDArray[np.float64]:
    """Room for a trace of at most ``limit_s``."""
    return np.zeros((round(limit_s / DT_S), len(COLUMNS)))


def by_name(table: npt.NDArray[np.float64], names: Sequence[str] = COLUMNS) -> Columns:
    """Rows as columns by name.

    names: the columns that are wanted.
    """
    columns = np.empty((len(names), len(table)))
    transpose(table, indices(names), columns)
    return dict(zip(names, columns, strict=True))


def indices(names: Sequence[str]) -> list[int]:
    """Indices of the columns of these names in a row."""
    return [COLUMNS.index(name) for name in names]


def transpose(
    table: npt.NDArray[np.float64], index: Sequence[int], columns: npt.NDArray[np.float64]
) -> None:
    """Write some columns of a table's rows as rows of another. index: which ones, in order."""
    for first in range(0, len(table), CACHED_ROWS):
        rows_of_block = table[first : first + CACHED_ROWS]
        columns[:, first : first + CACHED_ROWS] = rows_of_block[:, index].T


def copy_columns(rows_of_piece: npt.NDArray[np.float64], names: Sequence[str]) -> Columns:
    """`by_name` for as many rows as fit into the caches whole: one column after the other."""
    return {name: rows_of_piece[:, COLUMNS.index(name)].copy() for name in names}


def join(parts: Sequence[Columns]) -> Columns:
    """The trace of a run from those of its pieces, at least one."""
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


class Watcher(NamedTuple):
    """Observer of a run while it is played."""

    hear: Callable[[npt.NDArray[np.float64]], None]
    """Hears of the last row of each piece, and may take its time."""
    piece_s: float
    """Length of a piece."""


NOBODY = Watcher(lambda _: None, float("inf"))


def record(
    loop: Loop,
    state: LoopState,
    requests: Requests,
    limit_s: float,
    names: Sequence[str] = COLUMNS,
    watcher: Watcher = NOBODY,
) -> tuple[LoopState, Columns]:
    """Run until the machine rests again, at most ``limit_s``; returns the state and the trace.

    names: the columns that are wanted.
    """
    left = round(limit_s / DT_S)
    table = np.empty((min(left, RECORDED_ROWS), len(COLUMNS)))
    piece = round(min(watcher.piece_s / DT_S, left))
    active = state.controller.core.procedure.phase not in RESTING
    parts, filled, at_rest = [], 0, False
    while left and not at_rest:
        rows_of_piece = table[filled : filled + min(piece, left)]
        state, ticks = closed_loop.run(loop, state, requests, rows_of_piece)
        requests = NO_REQUESTS
        filled, left = filled + ticks, left - ticks
        watcher.hear(table[filled - 1])
        moving = ~np.isin(rows_of_piece[:ticks, _PHASE], _RESTING)
        active |= bool(moving.any())
        at_rest = active and not moving[-1]
        if at_rest or not left or filled == len(table):
            parts.append(copy_columns(table[:filled], names))
            filled = 0
    return state, join(parts)


def phase_spans(trace: Columns) -> list[PhaseSpan]:
    """Phases of a run in order."""
    phase, time_s = trace["phase"], trace["time_s"]
    starts = np.concatenate(([0], np.flatnonzero(np.diff(phase)) + 1))
    ends = np.append(time_s[starts[1:]], time_s[-1] + DT_S)
    return [
        PhaseSpan(Phase(int(phase[i])), float(time_s[i]), float(end))
        for i, end in zip(starts, ends, strict=True)
    ]
