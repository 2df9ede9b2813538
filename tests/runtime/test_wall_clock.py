"""The wall clock is set while a cycle runs: nothing but the names of instants goes by it."""

from pathlib import Path

import numpy as np

from opensuction.kernel.vocabulary import RESTING, Phase
from opensuction.records.entry import Outcome
from opensuction.records.records import Records
from tests.runtime.kept import replayed, ticks_of
from tests.runtime.room import INSIDE_MM
from tests.runtime.simulated_room import HOUR_S, simulated


def test_a_clock_that_is_set_changes_nothing(tmp_path: Path) -> None:
    with simulated() as room:
        room.record(tmp_path / "kept")
        room.reach(lambda: room.truth("truth.tip_mm") > INSIDE_MM)
        room.set_clock(HOUR_S)
        assert room.wait(lambda: room.phase() in (Phase.WITHDRAWING, Phase.ABORTING))
        room.set_clock(-25.0 * HOUR_S)
        assert room.wait(lambda: room.phase() in RESTING)
        assert not room.is_recorder_missed()
        room.end_recorder()
        path = sorted((tmp_path / "kept").glob("*.mcap"))[-1]
        ticks = ticks_of(path)
        assert (np.diff(ticks[:, 0]) == 1.0).all()
        verdict = replayed(path)
        assert verdict.identical, verdict.first
        with Records.open(str(room.folder / "records.db")) as records:
            cycle = records.history.list_cycles("twin-1", 1)[0]
            assert cycle.outcome in (Outcome.COMPLETED, Outcome.ABORTED)
            assert cycle.ended_at is not None
            # By one clock from begin to end.
            assert 0.0 < (cycle.ended_at - cycle.started_at).total_seconds() < 60.0
