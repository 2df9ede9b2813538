"""Contents of a recorder's files."""

from pathlib import Path

import numpy as np

from opensuction.recording.cycle_file.reader import RecordingReader, Rows, TimedEvent
from opensuction.recording.cycle_file.row_schema import TICKS
from opensuction.runtime import replay
from opensuction.runtime.replay import Replay


def ticks_of(path: Path) -> np.ndarray:
    reader = RecordingReader(path)
    rows = [one.table for one in reader.contents() if isinstance(one, Rows) and one.topic == TICKS]
    reader.close()
    return np.concatenate(rows)


def told_of(path: Path) -> list[tuple[str, str]]:
    reader = RecordingReader(path)
    found = [one.event for one in reader.contents() if isinstance(one, TimedEvent)]
    reader.close()
    return [(event.kind, event.name) for event in found]


def replayed(path: Path) -> Replay:
    reader = RecordingReader(path)
    verdict = replay.replay(reader)
    reader.close()
    return verdict
