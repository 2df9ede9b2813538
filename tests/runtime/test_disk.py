"""A disk that is full or does not answer: people are told, and the cycle knows nothing of it."""

import signal
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from opensuction.kernel.vocabulary import RESTING, Phase
from opensuction.runtime.machine_folder import SLOTS_S
from tests.runtime.kept import replayed, ticks_of, told_of
from tests.runtime.simulated_room import SimulatedRoom, full_disk, simulated

LARGEST_BYTES = 400_000
"""Of a file on the full disk: some seconds of a recording."""


@pytest.fixture
def room(tmp_path: Path) -> Iterator[SimulatedRoom]:
    with simulated() as made:
        made.record(tmp_path)
        yield made


def test_what_a_full_disk_refused_is_written_once_there_is_room(
    room: SimulatedRoom, tmp_path: Path
) -> None:
    with full_disk(LARGEST_BYTES):
        room.reach(room.is_recorder_missed)
    skipped = room.now("loop.skipped")
    assert room.wait(lambda: not room.is_recorder_missed(), 8.0)
    assert room.wait(lambda: room.phase() in RESTING)
    room.end_recorder("opensuction: not kept: ")
    kept = ticks_of(sorted(tmp_path.glob("*.mcap"))[-1])
    assert (np.diff(kept[:, 0]) == 1.0).all(), "the ring had what the disk did not take"
    assert replayed(sorted(tmp_path.glob("*.mcap"))[-1]).identical
    assert skipped <= 20.0


def test_a_disk_that_does_not_answer_leaves_a_gap_that_is_told(
    room: SimulatedRoom, tmp_path: Path
) -> None:
    """The recorder stands still, as it does in a call to a disk that has gone to sleep."""
    assert room.recorder is not None
    room.reach(lambda: room.phase() == Phase.CHECKING)
    room.recorder.send_signal(signal.SIGSTOP)
    stopped = room.now("inputs.tick")
    assert room.wait(room.is_recorder_missed, 4.0)
    assert room.wait(lambda: room.now("inputs.tick") > stopped + 1000.0 * SLOTS_S + 500.0, 30.0)
    room.recorder.send_signal(signal.SIGCONT)
    assert room.wait(lambda: not room.is_recorder_missed(), 8.0)
    assert room.wait(lambda: room.phase() in RESTING)
    room.end_recorder()
    path = sorted(tmp_path.glob("*.mcap"))[0]
    assert ("gap", "rows-missed") in told_of(path)
    verdict = replayed(path)
    assert (verdict.gaps, verdict.identical) == (1, True), verdict.first
