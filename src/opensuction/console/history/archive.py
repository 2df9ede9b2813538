"""The history of one console: its records, the recordings beside them, and who works on those.

Trends over days: outcomes from the records, quantities from the recordings' figures.

Verification of the whole trail of the records, in a thread: a long trail takes a while.
"""

import logging
import math
import threading
import time
from collections.abc import Iterable, Mapping, Sequence
from datetime import date, datetime, timedelta, timezone
from statistics import median
from typing import Any, NamedTuple

from fastapi import FastAPI

from opensuction.accounts.session import Session
from opensuction.console.access import ConsoleContext, Holder
from opensuction.console.guard.problem import Problem
from opensuction.console.history import job_queue
from opensuction.console.history.job_queue import JobQueue, RecordingFile
from opensuction.kernel.errors import InputError
from opensuction.records import recording_check
from opensuction.records.database import utc_time
from opensuction.records.entry import Action, Outcome
from opensuction.records.history import LONGEST_PAGE, PastCycle, Wanted
from opensuction.records.recording_check import BoundRecording, Fault, Kind
from opensuction.records.records import Records

LOG = logging.getLogger("opensuction.console")
FAILED = "the trail could not be read; the console's log says why"


class Verification:
    """The last look at the whole trail, and the one that goes on."""

    def __init__(self, records: Records) -> None:
        self._records = records
        self._lock = threading.Lock()
        self._is_running = False
        self._known: dict[str, Any] | None = None
        self._checked_at: datetime | None = None
        self._failure: str | None = None

    def tell(self) -> dict[str, Any]:
        """Present head of the trail, and the result of the last audit."""
        head = self._records.head()
        with self._lock:
            state = "running" if self._is_running else "none" if self._known is None else "done"
            if state == "none" and self._failure is not None:
                state = "failed"
            return {
                "state": state,
                "entries": head.sequence,
                "head": head.hash,
                "checked_at": self._checked_at,
                "verdict": self._known,
                "failure": self._failure,
            }

    def begin(self, expected: str | None) -> None:
        """Read the whole trail, unless that goes on already. expected: the hash of a head."""
        with self._lock:
            if self._is_running:
                return
            self._is_running = True
        threading.Thread(target=self._read_trail, args=(expected,), daemon=True).start()

    def _read_trail(self, expected: str | None) -> None:
        known: dict[str, Any] | None = None
        failure: str | None = FAILED
        try:
            found = self._records.audit(expected)
            known = {**found._asdict(), "is_whole": found.broken is None, "expected": expected}
            failure = None
        except InputError as error:
            failure = str(error)
        except Exception:
            LOG.exception("reading the trail failed")
        finally:
            with self._lock:
                self._is_running = False
                self._known, self._failure = known, failure
                self._checked_at = utc_time.now()


QUANTITIES = (
    "removed_ml",
    "dwell_s",
    "suction_s",
    "in_airway_s",
    "vacuum_mmhg",
    "airway_lowest_cmh2o",
    "airway_highest_cmh2o",
    "spo2_percent",
    "heart_rate_per_min",
    "deepest_mm",
    "contact_mm",
    "gap_mm",
    "alarms",
)
"""Names of figures, as `work_process.figures` gives them."""
RUNNING = "running"
OUTCOMES = (*map(str, Outcome), RUNNING)


class DaySpread(NamedTuple):
    """A quantity over a day's cycles."""

    cycles: int
    lowest: float
    median: float
    highest: float
    total: float


class Day(NamedTuple):
    """Outcomes and quantities of one day, in the time zone of the request."""

    day: date
    outcomes: dict[str, int]
    quantities: dict[str, DaySpread | None]
    """None: no recording of that day knows it."""


def _spread(values: list[float]) -> DaySpread | None:
    if not values:
        return None
    return DaySpread(len(values), min(values), median(values), max(values), sum(values))


def days(
    cycles: Iterable[tuple[PastCycle, Mapping[str, Any] | None]], ahead_of_utc: timedelta
) -> list[Day]:
    """Days with a cycle on them, the first one first.

    cycles: each with the figures of its recording, where they are known. ahead_of_utc: the clock by
    which a day is one.
    """
    zone = timezone(ahead_of_utc)
    found: dict[date, list[tuple[PastCycle, Mapping[str, Any] | None]]] = {}
    for cycle, figures in cycles:
        found.setdefault(_day_of(cycle.started_at, zone), []).append((cycle, figures))
    return [_day(on, found[on]) for on in sorted(found)]


def _day_of(instant: datetime, zone: timezone) -> date:
    return instant.astimezone(zone).date()


def _day(on: date, cycles: list[tuple[PastCycle, Mapping[str, Any] | None]]) -> Day:
    outcomes = dict.fromkeys(OUTCOMES, 0)
    for cycle, _ in cycles:
        outcomes[RUNNING if cycle.outcome is None else str(cycle.outcome)] += 1
    quantities = {}
    for name in QUANTITIES:
        known = [figures.get(name) for _, figures in cycles if figures is not None]
        quantities[name] = _spread([float(one) for one in known if isinstance(one, int | float)])
    return Day(on, outcomes, quantities)


MOST_CYCLES = 5000
"""That a trend is made of."""
TAKEN = "take-recording"
"""In the records, of who took one."""
TAKEN_AGAIN_S = 3600.0
MOST_CHECKED = 10_000
"""Recordings of which it is remembered whether they are what was put on record."""
_MAKING = threading.Lock()


class Trends(NamedTuple):
    """Days, and how much of them is known yet."""

    days: list[Day]
    cycles: int
    pending: int
    without_recording: int
    cut: bool


class Archive:
    """Made once for each application."""

    def __init__(self, site: ConsoleContext) -> None:
        self.site = site
        self.history = site.records.history
        self.desk = JobQueue(site.recordings)
        self.verification = Verification(site.records)
        self._lock = threading.Lock()
        self._taken: dict[tuple[str, str, int], float] = {}
        """Who took which part of which cycle's recording within the last hour, and when."""
        self._checked: dict[tuple[RecordingFile, tuple[BoundRecording, ...]], Fault | None] = {}

    def machine(self) -> str:
        """Serial of the machine whose console it is. Raises Problem where there is none."""
        try:
            return self.site.about().machine.serial
        except InputError as error:
            raise Problem(503, f"no machine is set up: {error}") from None

    def cycle(self, cycle_id: str) -> PastCycle:
        """A cycle of this machine. Raises Problem where there is none."""
        found = self.history.find_cycle(cycle_id)
        if found is None or found.machine != self.machine():
            raise Problem(404, "no such cycle is on record")
        return found

    def file(self, cycle: PastCycle) -> RecordingFile | None:
        """The recording of a cycle, finished or not; None: it is not here."""
        return job_queue.find(self.site.recordings, cycle.recording)

    def finished_file(self, cycle_id: str) -> tuple[PastCycle, RecordingFile]:
        """A cycle with its recording.

        Raises Problem where that is not here, not finished, or not what was put on record.
        """
        cycle = self.cycle(cycle_id)
        if cycle.outcome is None:
            raise Problem(409, "the cycle has not ended: its recording is being written")
        file = self.file(cycle)
        fault = self.find_fault(file, self.history.list_recordings([cycle]))
        if fault is not None:
            raise Problem(404 if fault.kind == Kind.MISSING else 422, fault.sentence)
        if file is None:
            raise Problem(404, "the cycle's recording does not lie in this console's folder")
        return cycle, file

    def recordings_of(self, cycles: Sequence[PastCycle]) -> dict[str, list[BoundRecording]]:
        """Recordings of these cycles that are on record, by the cycles' ids."""
        of: dict[tuple[str, str], list[BoundRecording]] = {}
        for one in self.history.list_recordings(cycles):
            of.setdefault((one.machine, one.file.cycle_recording), []).append(one)
        return {one.id: of.get((one.machine, one.recording or ""), []) for one in cycles}

    def find_size_fault(self, known: Sequence[BoundRecording]) -> Fault | None:
        """Fault of a recording by its presence and length alone; None: there is none."""
        for one in known:
            fault = recording_check.check_size(one, self.site.recordings / one.file.name)
            if fault is not None:
                return fault
        return None

    def find_fault(
        self, file: RecordingFile | None, known: Sequence[BoundRecording]
    ) -> Fault | None:
        """Fault of a recording; None: it is what was put on record, or nothing was.

        known: what is on record of it. What was read once is read again when it has changed.
        """
        if file is None:
            return self.find_size_fault(known)
        key = (file, tuple(known))
        if key in self._checked:
            return self._checked[key]
        found = self._check(file, known)
        # Of one that was written to a moment ago a further part may be let pass.
        if time.time() - file.changed_ns * 1e-9 > recording_check.RECENT_S:
            if len(self._checked) >= MOST_CHECKED:
                self._checked.clear()
            self._checked[key] = found
        return found

    def _check(self, file: RecordingFile, known: Sequence[BoundRecording]) -> Fault | None:
        """See `find_fault`; reads every byte."""
        for one in known:
            path = self.site.recordings / one.file.name
            fault = recording_check.check(one, path, self._find_owner)
            if fault is not None:
                return fault
        if known:
            by_name = {one.file.name: one for one in known}
            found = recording_check.find_strange(by_name, self.site.recordings)
        else:
            found = [
                fault for path in file.parts if (fault := recording_check.find_misnaming(path))
            ]
        return found[0] if found else None

    def _find_owner(self, sha256: str) -> BoundRecording | None:
        return self.history.find_recording(sha256=sha256)

    def note_taken(self, cycle: PastCycle, part: int, holder: Holder) -> None:
        """Put on record who took a recording: it leaves what guards it.

        Once an hour for the same one: who takes it a thousand times shall not fill the records.
        """
        if holder is None:
            return
        who = holder.account if isinstance(holder, Session) else holder.label
        key, now_s = (who, cycle.id, part), time.monotonic()
        with self._lock:
            if now_s - self._taken.get(key, -math.inf) < TAKEN_AGAIN_S:
                return
            self._taken = {
                one: at_s for one, at_s in self._taken.items() if now_s - at_s < TAKEN_AGAIN_S
            }
            self._taken[key] = now_s
        detail = f"cycle {cycle.number}" + (f", part {part}" if part > 1 else "")
        action = Action(who, TAKEN, detail, machine=cycle.machine, cycle_id=cycle.id)
        self.site.records.act(action)

    def trends(
        self, since: datetime | None, until: datetime | None, ahead_of_utc: timedelta
    ) -> Trends:
        """Trends of this machine; figures that are not known yet are begun to be worked out."""
        cycles, cut = self._cycles(Wanted(since, until))
        joined, pending, without = [], {}, 0
        for cycle in cycles:
            file = None if cycle.outcome is None else self.file(cycle)
            figures = None if file is None else self.desk.figures(file)
            if file is None or (figures is not None and "refused" in figures):
                without += 1
                figures = None
            elif figures is None:
                pending[file] = cycle
            joined.append((cycle, figures))

        def refuse(file: RecordingFile) -> str | None:
            fault = self.find_fault(file, self.history.list_recordings([pending[file]]))
            return None if fault is None else fault.sentence

        self.desk.fill(list(pending), refuse)
        return Trends(days(joined, ahead_of_utc), len(cycles), len(pending), without, cut)

    def _cycles(self, wanted: Wanted) -> tuple[list[PastCycle], bool]:
        """The newest cycles, and whether there are more."""
        found: list[PastCycle] = []
        before = None
        machine = self.machine()
        while len(found) < MOST_CYCLES:
            page = self.history.list_cycles(machine, LONGEST_PAGE, before, wanted)
            found += page
            if len(page) < LONGEST_PAGE:
                return found, False
            before = page[-1].number
        return found, True


def of(app: FastAPI) -> Archive:
    """The archive of an application."""
    with _MAKING:
        found = getattr(app.state, "archive", None)
        if found is None:
            found = app.state.archive = Archive(app.state.site)
    archive: Archive = found
    return archive
