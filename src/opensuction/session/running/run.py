"""A machine that runs: begun, looked after, ended, and what it has done.

A button of a machine that runs, pressed from elsewhere, and its answer.
"""

import time
from collections.abc import Callable, Mapping
from datetime import datetime
from pathlib import Path
from typing import Annotated, NamedTuple
from uuid import uuid4

import numpy as np

from opensuction.ipc.ring import EventReader, FollowedRing, RingReader
from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import Phase
from opensuction.records.database import utc_time
from opensuction.records.entry import Outcome
from opensuction.records.history import PastAlarm, PastCycle
from opensuction.records.records import Records
from opensuction.result.plain import FLAT, IF_FINITE
from opensuction.runtime import launch, machine_folder
from opensuction.runtime.loop import ROW_COLUMNS
from opensuction.runtime.machine_button import BY_NAME
from opensuction.runtime.supervisor import LOOKS_S, Supervisor, SupervisorNotice
from opensuction.session.running.cycle_scheduler import CycleScheduler, Doing
from opensuction.session.running.machine import Running
from opensuction.settings.validation import choose

ANSWERS_S = 1.0
"""Within this time an answer is there: a thousand ticks."""


class Answer(NamedTuple):
    """Answer of a machine to a button."""

    machine: str
    """Name."""
    request: str
    """Name of the button, as people type it."""
    who: str
    key: str
    """Of this press alone."""
    verdict: str
    """See `controller_request`."""
    phase: str | None
    """Of the machine then; None: its controller has not ticked yet."""


def ask(name: str, request: str, who: str) -> Answer:
    """Press a button of a machine; what became of it.

    Raises InputError for a button that there is not, and where no machine answers.
    """
    button = choose(request.replace("_", "-"), BY_NAME, "request")
    folder, key = machine_folder.find(name), uuid4().hex
    if not (folder / machine_folder.EVENTS).exists():
        raise InputError(f"no machine '{name}' runs here: start one with opensuction serve")
    verdict = launch.ask(folder, button.field, who, key, ANSWERS_S)
    if verdict is not None:
        return Answer(name, button.name, who, key, verdict, _find_phase(folder))
    raise InputError(f"the machine '{name}' does not answer: does its controller run?")


def _find_phase(folder: Path) -> str | None:
    newest = RingReader(folder / machine_folder.RING).snapshot()
    if newest is None:
        return None
    return Phase(int(newest[1][ROW_COLUMNS.index("outputs.phase")])).name.lower()


def say(answer: Answer) -> str:
    """The answer in words."""
    words = "the button went down"
    if answer.verdict != launch.PRESSED:
        words = f"refused: {launch.explain(answer.verdict)}"
    return f"{answer.request}: {words}; the machine is {answer.phase}"


LISTED = 1000
"""Cycles and alarms of a run that are told, at most."""
COUNTED = 20_001
"""Microseconds that a tick's time is counted by; whatever takes longer is one to be seen alone."""
SENTENCES = {
    "control-started": "The controller has been started",
    "control-found": "The controller of an earlier run still works",
    "control-restarted": "The controller died and has been started anew: it brings the catheter "
    "out and waits for a person",
    "control-given-up": "The controller dies again and again: it is not started any more",
    "recorder-started": "The recorder has been started",
    "recorder-found": "The recorder of an earlier run still works",
    "recorder-restarted": "The recorder died and has been started anew",
    "recorder-keeps-nothing": "The recorder lives, and keeps nothing of what it hears",
    "recorder-keeps": "The recorder keeps what it hears again",
    "recorder-given-up": "The recorder dies again and again: nothing is recorded any more",
    "console-started": "The console has been started",
    "console-found": "The console of an earlier run still works",
    "console-restarted": "The console died and has been started anew",
    "console-given-up": "The console dies again and again: it is not started any more; the machine "
    "goes on, and opensuction ask abort stops it",
}
_SKIPPED, _COMPUTED = (ROW_COLUMNS.index(name) for name in ("loop.skipped", "loop.computed_s"))


class Tally:
    """Timing of the control loop, from every row of it."""

    def __init__(self, folder: Path) -> None:
        self._ring = FollowedRing(
            folder / machine_folder.RING, lambda columns: columns == ROW_COLUMNS
        )
        self.ticks = self.missed = 0
        self._most_s = 0.0
        self._counts = np.zeros(COUNTED, np.int64)
        """Of ticks by the microseconds that they took; the last one of all that took longer."""

    def look(self) -> None:
        """Count what has come."""
        self._ring.look()
        if self._ring.reader is None:
            return
        rows = self._ring.reader.read().rows
        self.ticks += len(rows)
        self.missed += int(rows[:, _SKIPPED].sum())
        if len(rows):
            took_s = rows[:, _COMPUTED]
            self._most_s = max(self._most_s, float(took_s.max()))
            places = np.clip(np.floor(1e6 * took_s), 0, COUNTED - 1).astype(np.int64)
            self._counts += np.bincount(places, minlength=COUNTED)

    def computed_s(self, share: float) -> float:
        """Time within which this share of the ticks was computed, to 1 us; nan before the first."""
        if not self.ticks:
            return float("nan")
        place = int(np.searchsorted(np.cumsum(self._counts), share * self.ticks))
        return self._most_s if place >= COUNTED - 1 else min(1e-6 * (place + 1), self._most_s)


class Done(NamedTuple):
    """Result of a run."""

    notices: list[SupervisorNotice]
    reason: str
    """Why it ended before its time; empty where it did not."""
    ended: bool
    """Controller and recorder ended as they should."""
    tally: Tally
    began_at: datetime
    began_s: float


class Watch(NamedTuple):
    """Callbacks during a run."""

    tell: Callable[[str], None]
    """Takes a line."""
    pause: Callable[[float], None] = time.sleep
    """Waits; what it raises ends the run."""
    look: Callable[[tuple[str, ...]], None] = lambda _: None
    """Called now and then with the processes that do not work yet; with none once all do."""


def supervise(
    running: Running, supervisor: Supervisor, rounds: CycleScheduler | None, watch: Watch
) -> Done:
    """Look after the machine until its rounds are done; without any, until ``pause`` raises.

    Whatever ends it, the catheter comes out first and everything is written.
    """
    began_at, began_s = utc_time.now(), time.monotonic()
    notices: list[SupervisorNotice] = []
    tally = Tally(running.folder)

    def tell(notice: SupervisorNotice) -> None:
        notices.append(notice)
        about = f" ({notice.detail})" if notice.detail else ""
        watch.tell(f"{SENTENCES[notice.what]}{about}")
        if rounds is not None and notice.what in ("control-restarted", "control-given-up"):
            rounds.stop(SENTENCES[notice.what])

    ended = False
    try:
        supervisor.begin(tell, watch.look)
        while rounds is None or rounds.doing != Doing.DONE:
            for notice in supervisor.look():
                tell(notice)
            watch.look(())
            tally.look()
            if rounds is not None:
                rounds.look()
            watch.pause(LOOKS_S)
    finally:
        watch.tell("Ending: the catheter comes out first, then everything is written")
        ended = supervisor.end(tally.look)
    return Done(notices, rounds.reason, ended, tally, began_at, began_s)


class RunCycle(NamedTuple):
    """Cycle of a run, as it is on record."""

    number: int
    """From 1 on for each machine."""
    id: str
    outcome: Outcome | None
    """None: no end is on record."""
    detail: str
    inside_at_end: bool | None
    requested_by: str
    started_at: str
    """UTC, in the form of ISO 8601."""
    ended_at: str | None
    """Likewise; None: no end is on record."""
    recording: str | None
    """Name of its file."""


class RunAlarm(NamedTuple):
    """Alarm of a run, as it is on record."""

    condition: str
    priority: str
    raised_at: str
    """UTC, in the form of ISO 8601."""
    cycle_id: str | None
    """None: the machine was at rest."""


class TickTime(NamedTuple):
    """Time that ticks took at most, by their share, in us; nan before the first tick."""

    p99: Annotated[float, IF_FINITE]
    p99_9: Annotated[float, IF_FINITE]
    most: Annotated[float, IF_FINITE]
    """Of all of them."""


class RunResult(NamedTuple):
    """Result of a machine's run in real time."""

    heading: Annotated[Mapping[str, str], FLAT]
    """What its recordings say of the machine, by name: machine, patient, protocol, seed."""
    cycles: tuple[RunCycle, ...]
    """The first one first."""
    alarms: tuple[RunAlarm, ...]
    """The first one first."""
    reason: str | None
    """Why no other cycle was started; None: as many were as were asked for."""
    not_kept: str | None
    """Last words of the recorder; None: it had nothing to say."""
    notices: tuple[SupervisorNotice, ...]
    scheduler: str | None
    """Of the operating system, for the control loop; None: the loop never began."""
    not_granted: tuple[str, ...]
    """What the operating system refused to the control loop."""
    ticks: int
    missed_ticks: int
    tick_us: TickTime
    recordings: str
    """Folder."""
    database: str
    in_silico: bool
    wall_s: float

    def is_good(self, asked: int) -> bool:
        """True if as many cycles as asked for are completed, and nothing was in the way."""
        completed = [one for one in self.cycles if one.outcome == Outcome.COMPLETED]
        return len(completed) == len(self.cycles) >= asked and self.reason is None


def sum_up(running: Running, done: Done, out: Path, database: str | None) -> RunResult:
    """Put together what a run has done, from its records and the ring of its events."""
    told = EventReader(running.folder / machine_folder.EVENTS).read()[0]
    began = next((one.fields for one in told if one.fields["kind"] == "began"), {})
    serial = running.about.machine.serial
    with Records.open(database) as records:
        history, shown = records.history, records.database.address.shown
        cycles = [
            one for one in history.list_cycles(serial, LISTED) if one.started_at >= done.began_at
        ]
        alarms = [
            one for one in history.list_alarms(serial, LISTED) if one.raised_at >= done.began_at
        ]
    return RunResult(
        heading={"machine": serial, **running.about.heading},
        cycles=tuple(_cycle(one) for one in reversed(cycles)),
        alarms=tuple(_alarm(one) for one in reversed(alarms)),
        reason=done.reason or None,
        not_kept=launch.last_words(running.folder, launch.RECORDER) or None,
        notices=tuple(done.notices),
        scheduler=began.get("scheduler"),
        not_granted=tuple(filter(None, str(began.get("refusals", "")).split("; "))),
        ticks=done.tally.ticks,
        missed_ticks=done.tally.missed,
        tick_us=TickTime(*(1e6 * done.tally.computed_s(share) for share in (0.99, 0.999, 1.0))),
        recordings=str(out),
        database=shown,
        in_silico=running.in_silico,
        wall_s=time.monotonic() - done.began_s,
    )


def _cycle(one: PastCycle) -> RunCycle:
    return RunCycle(
        number=one.number,
        id=one.id,
        outcome=one.outcome,
        detail=one.detail,
        inside_at_end=one.inside_at_end,
        requested_by=one.requested_by,
        started_at=one.started_at.isoformat(),
        ended_at=None if one.ended_at is None else one.ended_at.isoformat(),
        recording=one.recording,
    )


def _alarm(one: PastAlarm) -> RunAlarm:
    return RunAlarm(one.condition, one.priority, one.raised_at.isoformat(), one.cycle_id)
