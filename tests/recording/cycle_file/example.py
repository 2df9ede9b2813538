"""A small recording, and what is in it."""

from pathlib import Path

import numpy as np

from opensuction.recording.cycle_file.frame import NOTICE, Heading
from opensuction.recording.cycle_file.row_schema import RecordedEvent, SchemaColumn, Table
from opensuction.recording.cycle_file.writer import RecordingWriter

BEGAN_NS = 1_795_000_000_000_000_000
COLUMNS = (
    SchemaColumn("inputs.tick", int),
    SchemaColumn("inputs.readings.head_mm", float),
    SchemaColumn("inputs.readings.head_valid", bool),
    SchemaColumn("outputs.phase", int),
    SchemaColumn("state.plays_mm.0", float),
    SchemaColumn("state.plays_mm.1", float),
)
STARTS = (SchemaColumn("tick", int), SchemaColumn("state.plays_mm.0", float))
HEADING = Heading(
    software_version="1.2.3",
    settings='{"plan.travel_mm": "0x1.0p+6"}',
    settings_hash="ab" * 32,
    fingerprint="cd" * 8,
    began_ns=BEGAN_NS,
    about={"patient": "adult-icu", "seed": "7", "notice": NOTICE},
)
EVENT = RecordedEvent(
    tick=3, kind="request", name="start", who="nurse 4", key="k-1", detail="at once"
)


def rows(count: int, first: int = 0) -> Table:
    """Rows that can be told from one another."""
    tick = np.arange(first, first + count, dtype=np.float64)
    head_mm = np.sin(tick) * 1e-3
    return np.column_stack((tick, head_mm, tick % 2, tick // 10, -0.0 * tick, head_mm / 3.0))


def times_ns(count: int, first: int = 0) -> np.ndarray[tuple[int], np.dtype[np.uint64]]:
    """Their times: one a millisecond."""
    return np.uint64(BEGAN_NS) + np.arange(first, first + count, dtype=np.uint64) * np.uint64(10**6)


def write(path: Path, count: int = 230, chunk_rows: int = 50) -> Path:
    """A recording with a start, so many rows and an event."""
    with RecordingWriter(path, HEADING, {"/tick": COLUMNS, "/start": STARTS}, chunk_rows) as file:
        file.add_rows("/start", times_ns(1), np.array([[0.0, 5.5]]))
        file.add_rows("/tick", times_ns(count), rows(count))
        file.add_event(BEGAN_NS + 3_000_000, EVENT)
    return path
