"""A recording played again: the same inputs into the same core, every output and state compared.

The controller runs on by itself from each state that was set; only where rows are missing it goes
on from the state that was recorded. Whoever recorded, a simulation or a machine, it is one call.
"""

from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from opensuction.controller import configuration
from opensuction.controller.real_time_call import RealTimeCall
from opensuction.controller.record import State
from opensuction.kernel.codegen import plain_row
from opensuction.kernel.errors import InputError
from opensuction.recording.cycle_file import row_schema
from opensuction.recording.cycle_file.reader import RecordingReader, Rows
from opensuction.recording.cycle_file.row_schema import (
    INPUT_PART,
    OUTPUT_PART,
    START_COLUMNS,
    STARTS,
    STATE_PART,
    TICK_COLUMNS,
    TICKS,
    SchemaColumn,
)

Table = NDArray[np.float64]
Flags = NDArray[np.bool_]

TOLERANCE = 1e-9
"""Numbers are equivalent that differ by no more, or by no more than this share of the larger one:
what a last bit of a library function comes to [design]."""
PLAYED_ROWS = 250
"""Rows that are played at once, at least: a chunk has fewer."""
_TICK = [column.name for column in TICK_COLUMNS].index(f"{row_schema.INPUTS}.tick")


class Difference(NamedTuple):
    """The first number that came out otherwise."""

    tick: int
    field: str
    recorded: float
    replayed: float


class Replay(NamedTuple):
    """Result of a replay."""

    ticks: int
    """Compared."""
    starts: int
    """States that were set from outside, and played on from."""
    gaps: int
    """Places where ticks are missing; what they did cannot be compared."""
    differing_ticks: int
    first: Difference | None
    identical: bool
    """Every bit is the same."""
    equivalent: bool
    """Every number is within `TOLERANCE`."""


def _differs(recorded: Table, replayed: Table) -> Flags:
    """True at numbers that differ in any bit; two that are not a number count as the same."""
    other: Flags = recorded.view(np.uint64) != replayed.view(np.uint64)
    if other.any():
        other &= ~(np.isnan(recorded) & np.isnan(replayed))
    return other


def _is_far(recorded: Table, replayed: Table) -> Flags:
    """True where two numbers that differ are not equivalent."""
    with np.errstate(invalid="ignore"):
        apart = np.abs(recorded - replayed)
        allowed = TOLERANCE * np.maximum(1.0, np.maximum(np.abs(recorded), np.abs(replayed)))
        far: Flags = ~((apart <= allowed) | (recorded == replayed))
    return far


class _Player:
    """Plays rows as they come, and keeps count."""

    def __init__(self, reader: RecordingReader) -> None:
        chosen = configuration.from_json(reader.heading.settings)
        blank = plain_row.unpack(State, np.zeros(STATE_PART.stop - STATE_PART.start))
        self._call = RealTimeCall(chosen.settings, chosen.heads_mm, blank)
        self._starts: dict[int, Table] = {}
        self._next_tick: int | None = None
        self._waiting: list[Table] = []
        """Rows that were not played yet."""
        self.ticks = self.starts = self.gaps = self.differing = 0
        self.first: Difference | None = None
        self.is_far = False

    def take_starts(self, table: Table) -> None:
        """Keep states until their ticks come."""
        self.end()
        for row in table:
            self._starts[int(row[0])] = row[1:]

    def take(self, table: Table) -> None:
        """Take rows of ticks, and play them as soon as there are some."""
        self._waiting.append(table)
        if sum(map(len, self._waiting)) >= PLAYED_ROWS:
            self.end()

    def end(self) -> None:
        """Play what was taken."""
        tables, self._waiting = self._waiting, []
        for part in self._continuous(np.concatenate(tables)) if tables else ():
            tick = int(part[0, _TICK])
            start = self._starts.pop(tick, None)
            if start is not None:
                self.starts += 1
                self._call.state_row[:] = start
            elif tick != self._next_tick and not self._goes_on(part[:1]):
                # Nobody knows the state before this tick, but the one after it.
                self.gaps += 1
                self._call.state_row[:] = part[0, STATE_PART]
                self._play(part[1:])
                continue
            self._play(part)

    def _goes_on(self, row: Table) -> bool:
        """True where the controller itself made none of the ticks before a row: they were missed.

        Then the row is what comes of the state that the last one left, and nothing is missing.
        """
        if self._next_tick is None:
            return False
        before = self._call.state_row.copy()
        played = self._compute(row)
        self._call.state_row[:] = before
        return not (_is_far(row, played) & _differs(row, played)).any()

    def _continuous(self, table: Table) -> Iterator[Table]:
        """Parts of a table in which one tick follows the other, and no state is set."""
        ticks = table[:, _TICK]
        begins = np.diff(ticks, prepend=ticks[0]) != 1.0
        begins |= np.isin(ticks, list(self._starts))
        begins[0] = True
        for first, end in pairwise([*np.flatnonzero(begins), len(ticks)]):
            yield table[first:end]

    def _compute(self, part: Table) -> Table:
        """Rows with the outputs and states that come of their inputs now."""
        played = part.copy()
        outputs = np.empty((len(part), OUTPUT_PART.stop - OUTPUT_PART.start))
        states = np.empty((len(part), STATE_PART.stop - STATE_PART.start))
        self._call.run(np.ascontiguousarray(part[:, INPUT_PART]), outputs, states)
        played[:, OUTPUT_PART], played[:, STATE_PART] = outputs, states
        return played

    def _play(self, part: Table) -> None:
        if not len(part):
            return
        self._next_tick = int(part[-1, _TICK]) + 1
        played = self._compute(part)
        self.ticks += len(part)
        other = _differs(part, played)
        rows = np.flatnonzero(other.any(axis=1))
        if not rows.size:
            return
        self.differing += rows.size
        self.is_far |= bool((_is_far(part, played) & other).any())
        if self.first is None:
            row = int(rows[0])
            column = int(np.argmax(other[row]))
            self.first = Difference(
                tick=int(part[row, _TICK]),
                field=TICK_COLUMNS[column].name,
                recorded=float(part[row, column]),
                replayed=float(played[row, column]),
            )


def _check_columns(reader: RecordingReader, topic: str, columns: tuple[SchemaColumn, ...]) -> None:
    """Refuse a recording of a controller with other fields; raises InputError."""
    found = reader.tables.get(topic, ())
    if found == columns:
        return
    theirs, ours = ({column.name for column in one} for one in (found, columns))
    missing, unknown = sorted(ours - theirs), sorted(theirs - ours)
    what = [f"without {missing[0]!r}"] if missing else []
    what += [f"with {unknown[0]!r}"] if unknown else []
    raise InputError(
        f"{reader.path}: was recorded by opensuction {reader.heading.software_version!r}, whose "
        f"controller has other fields ({', '.join(what) or 'in another order'}); replay it with "
        "that version"
    )


def replay(reader: RecordingReader, see: Callable[[Table], None] = lambda _: None) -> Replay:
    """Play a recording again, and close it.

    see: given the rows of ticks as they are read; shape (rows, columns) by `TICK_COLUMNS`.

    Raises InputError for one of a controller with other fields, for settings that this version
    does not take, and for one without a tick.
    """
    try:
        player = _play_all(reader, see)
    finally:
        reader.close()
    return Replay(
        ticks=player.ticks,
        starts=player.starts,
        gaps=player.gaps,
        differing_ticks=player.differing,
        first=player.first,
        identical=player.differing == 0,
        equivalent=not player.is_far,
    )


def _play_all(reader: RecordingReader, see: Callable[[Table], None]) -> _Player:
    _check_columns(reader, TICKS, TICK_COLUMNS)
    _check_columns(reader, STARTS, START_COLUMNS)
    player = _Player(reader)
    for one in reader.contents():
        if isinstance(one, Rows) and one.topic == STARTS:
            player.take_starts(one.table)
        elif isinstance(one, Rows) and one.topic == TICKS:
            see(one.table)
            player.take(one.table)
    player.end()
    if player.ticks == 0:
        reader.refuse_empty("has no tick that could be replayed")
    return player
