"""The recorder beside a machine that runs: what it keeps, and what its death does."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from opensuction.kernel.phase import Phase
from opensuction.recording.cycle_file.chunk_content import Rows, Told
from opensuction.recording.cycle_file.reader import RecordingReader
from opensuction.recording.cycle_file.tick_table import TICKS
from opensuction.runtime import launch, replay
from opensuction.runtime.loop import ROW_COLUMNS
from opensuction.safety.condition import Condition
from tests.runtime.machine_room import INSIDE_MM, Room, running, wait


@pytest.fixture
def room() -> Iterator[Room]:
    with running() as made:
        yield made


def ticks_of(path: Path) -> np.ndarray:
    reader = RecordingReader(path)
    rows = [one.table for one in reader.contents() if isinstance(one, Rows) and one.topic == TICKS]
    reader.close()
    return np.concatenate(rows)


def told_of(path: Path) -> list[tuple[str, str]]:
    reader = RecordingReader(path)
    found = [one.event for one in reader.contents() if isinstance(one, Told)]
    reader.close()
    return [(event.kind, event.name) for event in found]


def is_recorder_missed(room: Room) -> bool:
    return int(room.now("outputs.signals.present")) >> Condition.RECORDER_LOST & 1 == 1


def test_a_cycle_is_kept_whole_and_replays_to_the_last_bit(room: Room, tmp_path: Path) -> None:
    recorder = launch.start_recorder(room.folder, tmp_path / "kept")
    room.reach(lambda: room.phase() == Phase.CLOSING)
    assert wait(lambda: room.phase() == Phase.PARKED)
    assert wait(lambda: recorder.poll() is not None or room.phase() == Phase.PARKED)
    recorder.terminate()
    assert recorder.wait(10.0) == 0
    assert recorder.communicate()[1] == b""
    path = sorted((tmp_path / "kept").glob("*.mcap"))[-1]
    ticks = ticks_of(path)
    assert (np.diff(ticks[:, 0]) == 1.0).all()
    told = told_of(path)
    assert ("request", "start") in told
    assert [name for kind, name in told if kind == "phase"][:3] == [
        "parked",
        "checking",
        "preloading",
    ]
    reader = RecordingReader(path)
    verdict = replay.replay(reader)
    reader.close()
    assert verdict.identical, verdict.first
    assert verdict.ticks == len(ticks)
    assert verdict.gaps == 0


def test_killed_it_is_missed_the_cycle_goes_on_and_what_it_wrote_is_read(
    room: Room, tmp_path: Path
) -> None:
    recorder = launch.start_recorder(room.folder, tmp_path)
    room.reach(lambda: room.truth("truth.tip_mm") > INSIDE_MM)
    recorder.kill()
    recorder.communicate()
    last = room.now("inputs.tick")
    assert wait(lambda: is_recorder_missed(room), 2.0)
    kept = ticks_of(sorted(tmp_path.glob("*.mcap"))[-1])
    assert last - kept[-1, 0] < 250.0  # this test's own way to look included
    again = launch.start_recorder(room.folder, tmp_path)
    assert wait(lambda: not is_recorder_missed(room), 2.0)
    again.terminate()
    again.communicate()


def test_of_a_controller_that_was_killed_everything_is_kept(room: Room, tmp_path: Path) -> None:
    recorder = launch.start_recorder(room.folder, tmp_path)
    room.reach(lambda: room.truth("truth.tip_mm") > INSIDE_MM)
    room.stop()
    last = room.now("inputs.tick")
    before = sorted(tmp_path.glob("*.mcap"))[-1]
    room.begin()
    assert wait(lambda: len(list(tmp_path.glob("*.mcap"))) > 1, 10.0)
    recorder.terminate()
    assert recorder.wait(10.0) == 0
    recorder.communicate()
    kept = ticks_of(before)
    assert kept[-1, 0] == last
    assert ROW_COLUMNS[4] == "inputs.tick"
