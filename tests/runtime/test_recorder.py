"""Recordings of a machine that is started again before the last recording has ended."""

import errno
import itertools
import os
import stat
from collections.abc import Iterator, Sequence
from io import FileIO
from pathlib import Path

import numpy as np
import pytest

from opensuction.controller import configuration
from opensuction.controller.configuration import Configuration
from opensuction.host.host import NS_PER_S
from opensuction.host.this_computer import THIS_COMPUTER
from opensuction.ipc.ring import ProcessEvent, Read
from opensuction.kernel import arithmetic_fingerprint
from opensuction.kernel.interface import ABORT, ASSESSED, OXYGEN_SKIPPED, RESET, START
from opensuction.kernel.record import Array
from opensuction.kernel.vocabulary import RESTING
from opensuction.recording.cycle_file.frame import Heading
from opensuction.recording.cycle_file.reader import RecordingReader, TimedEvent
from opensuction.recording.cycle_file.row_schema import STATE_PART
from opensuction.runtime.loop import ROW_COLUMNS, TIMING_COLUMNS
from opensuction.runtime.recorder import Recorder
from tests.controller.bedside import hurried
from tests.runtime.kept import replayed, ticks_of, told_of
from tests.runtime.stepped_room import SteppedRoom

STATE = slice(len(TIMING_COLUMNS) + STATE_PART.start, len(TIMING_COLUMNS) + STATE_PART.stop)
"""Of a row: the controller's state."""
_TICK = ROW_COLUMNS.index("inputs.tick")
PIECE = 50
"""Rows that are read at once."""
BUTTONS = (RESET, ASSESSED, OXYGEN_SKIPPED)
"""What a person who is in haste presses before the start, a tick each."""
REST_S = 2.0


@pytest.fixture
def room(tmp_path: Path) -> Iterator[SteppedRoom]:
    made = SteppedRoom(tmp_path, *hurried(REST_S))
    yield made
    made.close()


def heading() -> Heading:
    loop, _ = hurried(REST_S)
    chosen = Configuration(loop.controller, loop.heads_mm)
    return Heading(
        software_version="0",
        settings=configuration.to_json(chosen),
        settings_hash=configuration.hash_of(chosen),
        fingerprint=arithmetic_fingerprint.fingerprint(),
        began_ns=0,
        about={},
    )


def broken_off(room: SteppedRoom) -> None:
    """A cycle that a person begins and ends half a second later; until it rests."""
    for button in BUTTONS:
        room.step(button)
    room.step(START)
    assert room.phase() not in RESTING, "it has begun"
    room.run(0.5)
    room.step(ABORT)
    while room.phase() not in RESTING:
        room.step()


def take(recorder: Recorder, rows: Array, after: int) -> None:
    """Hand over those after so many, in pieces."""
    for first in range(after, len(rows), PIECE):
        recorder.take(Read(rows[first : first + PIECE], first + 1, 0), [])
        assert not recorder.lost


def record(rows: Array, folder: Path) -> list[Path]:
    """As a recorder does that knows the first row, and what the controller was in then."""
    recorder = Recorder(folder, "run", heading, rows[0, STATE], after=1)
    take(recorder, rows, 1)
    recorder.close()
    return sorted(folder.glob("run*.mcap"))


@pytest.mark.parametrize("umask", [0o000, 0o077], ids=oct)
def test_a_recording_is_its_user_s_alone_whatever_the_umask(
    room: SteppedRoom, tmp_path: Path, umask: int
) -> None:
    broken_off(room)
    before = os.umask(umask)
    try:
        (recording,) = record(np.array(room.rows), tmp_path)
    finally:
        os.umask(before)
    assert stat.S_IMODE(recording.stat().st_mode) == 0o600


@pytest.mark.parametrize("rest_s", [0.0, 0.3, 1.2, 2.5])
def test_each_of_two_cycles_begins_with_its_rest_and_replays(
    room: SteppedRoom, tmp_path: Path, rest_s: float
) -> None:
    """However soon a person starts again: the recording of the first still goes on then."""
    room.run(0.2)
    broken_off(room)
    room.run(rest_s)
    broken_off(room)
    room.run(2.0)
    paths = record(np.array(room.rows), tmp_path)
    assert len(paths) == 2
    for path in paths:
        ticks = ticks_of(path)[:, 0]
        assert (np.diff(ticks) == 1.0).all()
        verdict = replayed(path)
        assert verdict.identical, verdict.first
        assert (verdict.ticks, verdict.gaps, verdict.starts) == (len(ticks), 0, 1)
        phases = [name for kind, name in told_of(path) if kind == "phase"]
        assert phases[phases.index("checking") - 1] in {"halted", "parked"}


@pytest.mark.parametrize("died_at", [200, 950, 1100, 1420])
@pytest.mark.parametrize("noted", [1, 30, 400])
def test_one_that_died_before_it_had_noted_how_far_it_was_leaves_no_row_twice(
    room: SteppedRoom, tmp_path: Path, died_at: int, noted: int
) -> None:
    """died_at: rows that were written. noted: how many fewer the next one is told of."""
    room.run(1.2)
    broken_off(room)
    room.run(2.0)
    rows = np.array(room.rows)
    first = Recorder(tmp_path, "run", heading, rows[0, STATE], after=1)
    take(first, rows[:died_at], 1)
    if first._recording is not None:
        first._recording.flush()
    kept = first.kept
    left = {path: path.read_bytes() for path in tmp_path.glob("run*.mcap")}
    first.close()
    for path, content in left.items():
        path.write_bytes(content)
    came = max(kept - noted, 1)
    second = Recorder(tmp_path, "run", heading, rows[came - 1, STATE], after=came)
    take(second, rows, came)
    second.close()
    parts = sorted(tmp_path.glob("run*.mcap"), key=lambda path: len(path.name))
    assert len(parts) == 1 + len(left)
    ticks = np.concatenate([ticks_of(path)[:, 0] for path in parts])
    assert (np.diff(ticks) == 1.0).all()
    for path in parts:
        assert replayed(path).identical


class RefusingFile(FileIO):
    """A file of a disk that is full for some of the writes to it, in the order of all of them."""

    def __init__(self, path: Path, count: Iterator[int], refused: frozenset[int]) -> None:
        super().__init__(path, "xb")
        self._count, self._refused = count, refused

    def write(self, data: memoryview, /) -> int:  # type: ignore[override]
        if next(self._count) in self._refused:
            super().write(data[: len(data) // 2])
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return super().write(data)


def told(rows: Array) -> list[ProcessEvent]:
    """An event for every 97th row: a person has asked something."""
    return [
        ProcessEvent(
            number, {"kind": "request", "time_ns": round(row[0] * 1e9), "key": f"{number}"}
        )
        for number, row in enumerate(rows, 1)
        if number % 97 == 0
    ]


def events_of(path: Path) -> list[TimedEvent]:
    reader = RecordingReader(path)
    found = [one for one in reader.contents() if isinstance(one, TimedEvent)]
    reader.close()
    return sorted(
        found, key=lambda one: (one.time_ns, one.event.kind, one.event.name, one.event.key)
    )


def record_on(
    rows: Array, folder: Path, refused: frozenset[int], pieces: Sequence[int]
) -> tuple[list[Path], int]:
    """Recordings on a disk that refuses these writes, and how many writes there were.

    pieces: how many rows come at once, in turn.
    """
    folder.mkdir()
    count, sizes = itertools.count(), itertools.cycle(pieces)

    class Files(type(THIS_COMPUTER.files)):  # type: ignore[misc]
        def create(self, path: Path) -> FileIO:
            return RefusingFile(path, count, refused)

    host = THIS_COMPUTER._replace(files=Files())
    recorder = Recorder(folder, "run", heading, rows[0, STATE], after=1, host=host)
    waiting, after, size = told(rows), 1, next(sizes)
    while after < len(rows):
        some = rows[after : after + size]
        came = [one for one in waiting if one.number <= after + len(some)]
        waiting = waiting[len(came) :]
        recorder.take(Read(some, after + 1, 0), came)
        after = recorder.kept if recorder.lost else after + len(some)
        size = next(sizes)
    assert not recorder.lost
    recorder.close()
    return sorted(folder.glob("run*.mcap")), next(count)


@pytest.mark.parametrize(
    "pieces",
    [
        (50,),
        *(pytest.param(one, marks=pytest.mark.soak) for one in ((1,), (700, 20, 300), (13, 1500))),
    ],
    ids=str,
)
@pytest.mark.parametrize(
    "rest_s", [0.3, *(pytest.param(one, marks=pytest.mark.soak) for one in (0.02, 1.4))]
)
def test_a_refused_write_changes_nothing_in_what_is_recorded(
    room: SteppedRoom, tmp_path: Path, rest_s: float, pieces: Sequence[int]
) -> None:
    """Wherever the disk refuses, once or three times: rows, changes in them and what was told."""
    room.run(0.2)
    broken_off(room)
    room.run(rest_s)
    broken_off(room)
    room.run(1.5)
    rows = np.array(room.rows)
    wanted, writes = record_on(rows, tmp_path / "sound", frozenset(), pieces)
    for first in range(0, writes, 1 + writes // 40):
        refused = frozenset((first,) if first % 2 else (first, first + 1, first + 4))
        found, _ = record_on(rows, tmp_path / f"{first}", refused, pieces)
        assert [path.name for path in found] == [path.name for path in wanted]
        for have, want in zip(found, wanted, strict=True):
            both = [ticks_of(path) for path in (have, want)]
            lo, hi = max(one[0, 0] for one in both), min(one[-1, 0] for one in both)
            # It begins and ends with a piece, and pieces are others where one was refused.
            assert max(max(abs(one[0, 0] - lo), abs(one[-1, 0] - hi)) for one in both) <= max(
                pieces
            )
            same = [one[(one[:, 0] >= lo) & (one[:, 0] <= hi)] for one in both]
            assert np.array_equal(*same), first
            begin_ns, end_ns = (rows[rows[:, _TICK] == one, 0] * NS_PER_S for one in (lo, hi))
            heard = [
                [one for one in events_of(path) if begin_ns < one.time_ns <= end_ns]
                for path in (have, want)
            ]
            assert heard[0] == heard[1], first
            verdict = replayed(have)
            assert verdict.identical
            assert (verdict.gaps, verdict.starts) == (0, 1)
