"""A console with a past: cycles of each outcome on record, one of them with a real recording."""

import json
import shutil
import threading
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from opensuction.console.history import job_queue, work_process
from opensuction.console.history.job_queue import RecordingFile
from opensuction.records.entry import Action, Alarm, CycleEnd, CycleStart, Outcome
from tests.console.served import Served
from tests.runtime.identity import ABOUT

NOON = datetime(2026, 11, 23, 12, 0, 0, tzinfo=UTC)
ATTACK = "</script><img src=x onerror=alert(1)>"
RECORDING = "20261123T120000-0badcafe-000001250.mcap"
CLOGGED = Alarm("LINE_CLOGGED", "high", f"the suction line is clogged {ATTACK}")


class Past(NamedTuple):
    """Ids of cycles."""

    completed: str
    """With a recording that is there."""
    lost: str
    """Aborted, its recording not there."""
    running: str


ENDS_S = 240.0
"""Longest work of a thread."""


def start(recording: str | None, catheter: str = "c-1", patient: str = "P-1") -> CycleStart:
    return CycleStart(
        machine=ABOUT.machine,
        catheter=ABOUT.catheter._replace(label=catheter),
        protocol=ABOUT.protocol,
        approach="travel",
        requested_by="anna",
        software="opensuction 0.1.0",
        patient=patient,
        recording=recording,
    )


def remember(console: Served, recording: Path | None) -> Past:
    """Put three cycles on record, a day apart; the first one's recording lies in the folder."""
    records = console.site.records
    if recording is not None:
        shutil.copy(recording, console.site.recordings / RECORDING)
    first = records.begin_cycle(start(RECORDING), at=NOON)
    records.act(Action("anna", "start", "pressed", cycle_id=first), at=NOON)
    records.end_cycle(
        first,
        CycleEnd(Outcome.COMPLETED, inside_at_end=False),
        at=NOON + timedelta(seconds=20),
    )
    next_day = NOON + timedelta(days=1)
    lost = records.begin_cycle(start("gone.mcap", "c-2", "P-2"), at=next_day)
    records.add_alarm(ABOUT.machine, CLOGGED, lost, at=next_day + timedelta(seconds=5))
    records.end_cycle(
        lost, CycleEnd(Outcome.ABORTED, f"tripped {ATTACK}"), at=next_day + timedelta(seconds=9)
    )
    records.add_alarm(ABOUT.machine, Alarm("REST", "low"), at=next_day + timedelta(minutes=1))
    return Past(first, lost, records.begin_cycle(start("c.mcap"), at=NOON + timedelta(days=2)))


def fill(console: Served, cycles: int) -> None:
    """Many cycles that ended, none with a recording."""
    records = console.site.records
    for number in range(cycles):
        at = NOON + timedelta(minutes=number)
        one = records.begin_cycle(start(None), at=at)
        records.end_cycle(one, CycleEnd(Outcome.COMPLETED), at=at)


def work_here(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have the console's work on recordings done in this process, which has loaded what it needs.

    What is a process of its own is asked in `test_job_queue.py`, and of each kind of work once in
    `test_recording.py`.
    """

    def work(what: str, files: Sequence[RecordingFile]) -> Iterator[dict[str, Any]]:
        for one in files:
            yield json.loads(json.dumps(work_process.answer(what, list(one.parts))))

    monkeypatch.setattr(job_queue, "_work", work)


def join(work: str) -> None:
    """Wait until the threads of the console that do this have ended. work: their function."""
    for one in threading.enumerate():
        if one.name.endswith(f"({work})"):
            one.join(ENDS_S)
            assert not one.is_alive(), f"{one.name} goes on after {ENDS_S:g} s"
