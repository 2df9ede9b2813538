"""The history of one console: its records, the recordings beside them, and who works on those."""

import math
import threading
import time
from datetime import datetime, timedelta
from typing import NamedTuple

from fastapi import FastAPI

from opensuction.accounts.session import Session
from opensuction.console.access import Holder
from opensuction.console.guard.problem import Problem
from opensuction.console.history import recording_file, trend
from opensuction.console.history.desk import Desk
from opensuction.console.history.recording_file import RecordingFile
from opensuction.console.history.trend import Day
from opensuction.console.history.verification import Verification
from opensuction.console.site import Site
from opensuction.kernel.errors import InputError
from opensuction.records.entry import Action
from opensuction.records.history import LONGEST_PAGE, PastCycle, Wanted

MOST_CYCLES = 5000
"""That a trend is made of."""
TAKEN = "take-recording"
"""In the records, of who took one."""
TAKEN_AGAIN_S = 3600.0
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

    def __init__(self, site: Site) -> None:
        self.site = site
        self.history = site.records.history
        self.desk = Desk(site.recordings)
        self.verification = Verification(site.records)
        self._lock = threading.Lock()
        self._taken: dict[tuple[str, str, int], float] = {}
        """Who took which part of which cycle's recording within the last hour, and when."""

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
        return recording_file.find(self.site.recordings, cycle.recording)

    def finished_file(self, cycle_id: str) -> tuple[PastCycle, RecordingFile]:
        """A cycle with its recording. Raises Problem where that is not here, or not finished."""
        cycle = self.cycle(cycle_id)
        if cycle.outcome is None:
            raise Problem(409, "the cycle has not ended: its recording is being written")
        file = self.file(cycle)
        if file is None:
            raise Problem(404, "the cycle's recording does not lie in this console's folder")
        return cycle, file

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
        joined, pending, without = [], [], 0
        for cycle in cycles:
            file = None if cycle.outcome is None else self.file(cycle)
            figures = None if file is None else self.desk.figures(file)
            if file is None or (figures is not None and "refused" in figures):
                without += 1
                figures = None
            elif figures is None:
                pending.append(file)
            joined.append((cycle, figures))
        self.desk.fill(pending)
        return Trends(trend.days(joined, ahead_of_utc), len(cycles), len(pending), without, cut)

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
