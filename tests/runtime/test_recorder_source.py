"""Place where a recorder goes on after another one, whatever the ring still has."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from opensuction.controller.loop_tick import AT_REST
from opensuction.ipc.ring import EventWriter, Place, RingWriter
from opensuction.recording.cycle_file.row_schema import STATE_PART
from opensuction.runtime.loop import ROW_COLUMNS, STARTED_FROM, TIMING_COLUMNS
from opensuction.runtime.recorder_source import Source

SLOTS = 64
LEFT_AT = 30
"""Tick in which the machine leaves its rest."""
_STATE = slice(len(TIMING_COLUMNS) + STATE_PART.start, len(TIMING_COLUMNS) + STATE_PART.stop)
STARTED = np.arange(_STATE.stop - _STATE.start, dtype=np.float64)


def row(tick: int) -> np.ndarray:
    made = np.full(len(ROW_COLUMNS), float(tick))
    made[ROW_COLUMNS.index("loop.left_rest")] = AT_REST if tick < LEFT_AT else LEFT_AT
    return made


@pytest.fixture
def ring(tmp_path: Path) -> Iterator[RingWriter]:
    told = {
        "run": "run",
        "began_utc_ns": "0",
        "settings": "",
        "version": "",
        STARTED_FROM: STARTED.tobytes().hex(),
    }
    with (
        EventWriter(tmp_path / "events"),
        RingWriter(tmp_path / "ring", ROW_COLUMNS, SLOTS, told) as made,
    ):
        yield made


def source(folder: Path) -> Source:
    return Source(folder / "ring", folder / "events")


def test_the_first_one_begins_with_the_state_that_the_controller_started_from(
    ring: RingWriter, tmp_path: Path
) -> None:
    assert source(tmp_path).begin(Place(0, 0)).state is not None  # also before the first row
    for tick in range(10):
        ring.write(row(tick))
    made = source(tmp_path)
    left = made.begin(Place(0, 0))
    assert (left.before, left.goes_on) == (None, AT_REST)
    assert left.state is not None
    assert np.array_equal(left.state, STARTED)
    found = made.read()[0]
    assert (found.first, found.missed, len(found.rows)) == (1, 0, 10)


def test_another_one_goes_on_behind_the_last_row_that_was_kept(
    ring: RingWriter, tmp_path: Path
) -> None:
    for tick in range(60):
        ring.write(row(tick))
    made = source(tmp_path)
    left = made.begin(Place(41, 0))  # row 41 is tick 40
    assert left.before is not None
    assert left.state is not None
    assert (left.before[0], left.goes_on) == (40.0, LEFT_AT)
    assert np.array_equal(left.state, left.before[_STATE])
    found = made.read()[0]
    assert (found.first, found.missed, found.rows[0, 0]) == (42, 0, 41.0)


@pytest.mark.parametrize("kept", [0, 5])
def test_one_that_comes_too_late_knows_what_goes_on_and_how_much_it_has_missed(
    ring: RingWriter, tmp_path: Path, kept: int
) -> None:
    for tick in range(200):
        ring.write(row(tick))
    made = source(tmp_path)
    left = made.begin(Place(kept, 0))
    assert (left.before, left.state, left.goes_on) == (None, None, LEFT_AT)
    found = made.read()[0]
    assert found.missed == found.first - kept - 1 > 100
    assert found.rows[-1, 0] == 199.0
