"""Recordings of a machine that is started again before the last recording has ended."""

import os
import stat
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from opensuction.controller import configuration
from opensuction.controller.configuration import Configuration
from opensuction.ipc.ring import Read
from opensuction.kernel import arithmetic_fingerprint
from opensuction.kernel.interface import ABORT, ASSESSED, OXYGEN_SKIPPED, RESET, START
from opensuction.kernel.record import Array
from opensuction.kernel.vocabulary import RESTING
from opensuction.recording.cycle_file.frame import Heading
from opensuction.recording.cycle_file.row_schema import STATE_PART
from opensuction.runtime.loop import TIMING_COLUMNS
from opensuction.runtime.recorder import Recorder
from tests.controller.bedside import hurried
from tests.runtime.kept import replayed, ticks_of, told_of
from tests.runtime.stepped_room import SteppedRoom

STATE = slice(len(TIMING_COLUMNS) + STATE_PART.start, len(TIMING_COLUMNS) + STATE_PART.stop)
"""Of a row: the controller's state."""
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
    if first._writer is not None:
        first._writer.flush()
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
