"""Result of a machine's run in real time, from its records and what its processes left."""

import json
from datetime import timedelta
from pathlib import Path
from typing import cast

import numpy as np
import pytest

from opensuction.ipc.ring import EventWriter, RingWriter
from opensuction.records.entry import CycleEnd, Outcome
from opensuction.records.records import Records
from opensuction.result.plain import to_json
from opensuction.runtime import launch, machine_folder
from opensuction.runtime.loop import ROW_COLUMNS
from opensuction.runtime.supervisor import SupervisorNotice
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.session.running import run
from opensuction.session.running.machine import Running
from opensuction.session.running.run import Done, RunResult, Tally
from tests.records.example import CLOGGED, COMPLETED, MACHINE, NOON, start
from tests.runtime.identity import ABOUT

STARTED = SupervisorNotice("control-started", "")
KEYS = [
    *("machine", "patient", "cycles", "alarms", "reason", "not_kept", "notices", "scheduler"),
    *("not_granted", "ticks", "missed_ticks", "tick_us", "recordings", "database", "in_silico"),
    "wall_s",
]


def sum_up(folder: Path, reason: str = "") -> RunResult:
    """The result of a run that began at noon in this folder, with its records in ``ward.db``."""
    if not (folder / machine_folder.EVENTS).exists():
        EventWriter(folder / machine_folder.EVENTS).close()
    about = ABOUT._replace(machine=MACHINE)
    running = Running("m", folder, cast("Prepared", None), about, None)
    done = Done([STARTED], reason, True, tally_of(folder), NOON, 0.0)
    return run.sum_up(running, done, Path("kept"), str(folder / "ward.db"))


def tally_of(folder: Path) -> Tally:
    tally = Tally(folder)
    tally.look()
    return tally


@pytest.fixture
def ward(tmp_path: Path) -> Path:
    """A folder with a cycle of before the run, and two of the run: one ended, one did not."""
    with Records.open(str(tmp_path / "ward.db")) as records:
        before = records.begin_cycle(start(), at=NOON - timedelta(hours=1))
        records.end_cycle(before, COMPLETED, at=NOON - timedelta(minutes=59))
        first = records.begin_cycle(start(), at=NOON + timedelta(minutes=1))
        records.add_alarm(MACHINE, CLOGGED, first, at=NOON + timedelta(seconds=70))
        ended = CycleEnd(Outcome.ABORTED, "LINE_CLOGGED", False)
        records.end_cycle(first, ended, at=NOON + timedelta(minutes=2))
        records.begin_cycle(start(), at=NOON + timedelta(minutes=30))
    return tmp_path


def test_the_cycles_and_alarms_of_the_run_itself_are_told_the_first_one_first(ward: Path) -> None:
    found = sum_up(ward)
    assert [one.number for one in found.cycles] == [2, 3]
    assert found.cycles[0].outcome == "aborted"
    assert found.cycles[0].ended_at == "2026-11-23T12:02:00.000007+00:00"
    assert (found.cycles[1].outcome, found.cycles[1].ended_at) == (None, None)
    (alarm,) = found.alarms
    assert (alarm.condition, alarm.cycle_id) == ("LINE_CLOGGED", found.cycles[0].id)


def test_the_json_has_the_promised_keys_and_null_for_what_was_not_measured(ward: Path) -> None:
    data = json.loads(json.dumps(to_json(sum_up(ward)), allow_nan=False))
    assert list(data) == KEYS
    assert (data["machine"], data["patient"]) == ("M-1", "neonate")
    assert data["tick_us"] == {"p99": None, "p99_9": None, "most": None}
    assert (data["reason"], data["not_kept"], data["scheduler"]) == (None, None, None)
    assert data["notices"] == [{"what": "control-started", "detail": ""}]
    assert [one["outcome"] for one in data["cycles"]] == ["aborted", None]


def test_what_the_loop_and_the_recorder_said_is_told(ward: Path) -> None:
    with EventWriter(ward / machine_folder.EVENTS) as events:
        events.write("began", 0, scheduler="other", refusals="no locked memory; no fifo")
    launch.log_of(ward, launch.RECORDER).write_text("begun\nopensuction: no space left\n")
    row = np.zeros(len(ROW_COLUMNS))
    with RingWriter(ward / machine_folder.RING, ROW_COLUMNS, 100, {}) as ring:
        row[ROW_COLUMNS.index("loop.computed_s")] = 2e-4
        ring.write(row)
        row[ROW_COLUMNS.index("loop.skipped")] = 2.0
        ring.write(row)
        found = sum_up(ward)
    assert (found.scheduler, found.not_granted) == ("other", ("no locked memory", "no fifo"))
    assert found.not_kept == "no space left"
    assert (found.ticks, found.missed_ticks) == (2, 2)
    assert found.tick_us.most == pytest.approx(200.0)


@pytest.mark.parametrize(
    ("outcomes", "reason", "asked", "is_good"),
    [
        ((Outcome.COMPLETED,), "", 1, True),
        ((Outcome.COMPLETED,), "", 2, False),
        ((Outcome.COMPLETED, Outcome.ABORTED), "", 1, False),
        ((Outcome.COMPLETED, None), "", 1, False),
        ((Outcome.COMPLETED,), "a person must look", 1, False),
    ],
)
def test_a_run_is_good_once_all_that_were_asked_for_are_completed(
    tmp_path: Path, outcomes: tuple[Outcome | None, ...], reason: str, asked: int, is_good: bool
) -> None:
    with Records.open(str(tmp_path / "ward.db")) as records:
        for number, outcome in enumerate(outcomes, 1):
            cycle = records.begin_cycle(start(), at=NOON + timedelta(minutes=number))
            if outcome is not None:
                at = NOON + timedelta(minutes=number, seconds=20)
                records.end_cycle(cycle, CycleEnd(outcome), at=at)
    assert sum_up(tmp_path, reason).is_good(asked) is is_good
