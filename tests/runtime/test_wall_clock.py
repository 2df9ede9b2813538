"""The wall clock is set while a cycle runs: nothing but the names of instants goes by it."""

from pathlib import Path

import numpy as np
import pytest

from opensuction.kernel.vocabulary import RESTING, Phase
from opensuction.records.entry import Outcome
from opensuction.records.records import Records
from tests.runtime.kept import replayed, ticks_of
from tests.runtime.machine_room import INSIDE_MM, PACES, running, wait

pytestmark = pytest.mark.real_time

STEPPED = """
import datetime, os, time
_time, _time_ns, _Real = time.time, time.time_ns, datetime.datetime

def _step():
    try:
        with open({path!r}) as file:
            return float(file.read() or 0.0)
    except OSError:
        return 0.0

class Any(type):
    def __instancecheck__(cls, one):
        return isinstance(one, _Real)

class Stepped(_Real, metaclass=Any):
    @classmethod
    def now(cls, tz=None):
        return _Real.now(tz) + datetime.timedelta(seconds=_step())

time.time = lambda: _time() + _step()
time.time_ns = lambda: _time_ns() + round(_step() * 1e9)
datetime.datetime = Stepped
"""
"""Read by every interpreter that starts with this in its path: a clock that somebody sets."""


@pytest.mark.parametrize("in_step", PACES)
def test_a_clock_that_is_set_changes_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, in_step: bool
) -> None:
    step = tmp_path / "step"
    (tmp_path / "sitecustomize.py").write_text(STEPPED.format(path=str(step)))
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    with running(in_step=in_step) as room:
        room.record(tmp_path / "kept")
        room.reach(lambda: room.truth("truth.tip_mm") > INSIDE_MM)
        step.write_text("3600")
        assert wait(lambda: room.phase() in (Phase.WITHDRAWING, Phase.ABORTING))
        step.write_text("-86400")
        assert wait(lambda: room.phase() in RESTING)
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
