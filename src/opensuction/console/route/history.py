"""History: past cycles with their reports and recordings, alarms, acts, the trail, trends.

A report as a console serves it: its own scripts run, and nothing else that may be in it.

It is sandboxed, so that it has an origin of its own and no cookie of anybody's; it may ask nobody
for anything. Scripts are let through by the hashes of those that the report is made with, worked
out from the program's files and not from the page: what got into a page by a name or a detail
has another hash.
"""

import base64
import hashlib
from datetime import datetime, timedelta
from functools import cache
from typing import Annotated, Literal

from fastapi import APIRouter, Depends, Header, Path, Query, Request, Response
from fastapi.responses import FileResponse, HTMLResponse
from pydantic import AwareDatetime

from opensuction.accounts.rule.right import Right
from opensuction.accounts.session import Session
from opensuction.console.access import Holder, may, may_begin
from opensuction.console.guard import body
from opensuction.console.guard.problem import Problem, documented
from opensuction.console.history import answer, archive
from opensuction.console.history.archive import Archive
from opensuction.records.entry import Outcome
from opensuction.records.history import LARGEST_NUMBER, LONGEST_SEARCH, PAGE, PastCycle, Wanted
from opensuction.records.recording_check import BoundRecording
from opensuction.report import sheet
from opensuction.report.cycle import page


@cache
def policy() -> str:
    """The content security policy of a report."""
    scripts = [sheet.read("vendor", "uPlot.iife.min.js")]
    scripts += [sheet.read("template", name) for name in page.SCRIPTS]
    hashes = " ".join(f"'sha256-{_hash(one)}'" for one in scripts)
    return "; ".join(
        (
            "sandbox allow-scripts allow-modals",
            "default-src 'none'",
            f"script-src {hashes}",
            # Widths of the phases stand in attributes; a style can fetch nothing here.
            "style-src 'unsafe-inline'",
            "img-src data:",
            "base-uri 'none'",
            "form-action 'none'",
            # It is shown within the console's page: STOP stays in reach.
            "frame-ancestors 'self'",
        )
    )


def _hash(script: str) -> str:
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()


router = APIRouter(tags=["History"])
LONGEST_PAGE = 200
FURTHEST_MIN = 14 * 60
"""No clock on earth is further ahead of UTC, or behind it."""
MCAP = "application/octet-stream"


def find_archive(request: Request) -> Archive:
    """The archive of the application."""
    return archive.of(request.app)


Here = Annotated[Archive, Depends(find_archive)]
Looks = Annotated[Holder, Depends(may(Right.SEE_HISTORY))]
Audits = Annotated[Holder, Depends(may(Right.SEE_AUDIT))]
Id = Annotated[str, Path(pattern=r"^[0-9A-Za-z-]{1,64}$", description="Of a cycle.")]
Before = Annotated[int | None, Query(ge=1, le=LARGEST_NUMBER, description="Numbers below this.")]
Limit = Annotated[int, Query(ge=1, le=LONGEST_PAGE)]
Since = Annotated[AwareDatetime | None, Query(alias="from", description="From this instant on.")]
Until = Annotated[AwareDatetime | None, Query(alias="to", description="Before this instant.")]
Text = Annotated[
    str | None,
    Query(min_length=1, max_length=LONGEST_SEARCH, description="Somewhere in its words."),
]
OfCycle = Annotated[str | None, Query(alias="cycle", pattern=r"^[0-9A-Za-z-]{1,64}$")]


def wanted(since: Since = None, until: Until = None, text: Text = None) -> Wanted:
    """Bounds by which a list is narrowed."""
    return Wanted(_bounded(since), _bounded(until), text)


def _bounded(instant: datetime | None) -> datetime | None:
    """Raises Problem for an instant whose year is none in UTC."""
    if instant is None:
        return None
    if not 2 <= instant.year <= 9998:
        raise Problem(422, "the year of 'from' or 'to' should be one between 2 and 9998")
    return instant


Narrowed = Annotated[Wanted, Depends(wanted)]


def _tell(
    here: Archive, cycle: PastCycle, known: list[BoundRecording], reads_file: bool = False
) -> answer.Cycle:
    """A cycle. known: of its recording. reads_file: it is held against its hash, not its length."""
    file = here.file(cycle)
    fault = here.find_fault(file, known) if reads_file else here.find_size_fault(known)
    return answer.Cycle.of(
        cycle,
        None if file is None else (len(file.parts), file.size),
        bool(known),
        None if fault is None or cycle.outcome is None else fault.sentence,
    )


@router.get("/cycles", responses=documented(401, 403, 422, 503))
def list_cycles(
    here: Here,
    _: Looks,
    narrowed: Narrowed,
    before: Before = None,
    limit: Limit = PAGE,
    outcome: Outcome | None = None,
) -> answer.Cycles:
    """Cycles of this machine, the newest first."""
    found = here.history.list_cycles(here.machine(), limit + 1, before, narrowed, outcome)
    shown = found[:limit]
    following = shown[-1].number if len(found) > limit else None
    known = here.recordings_of(shown)
    told = [_tell(here, one, known[one.id]) for one in shown]
    return answer.Cycles(cycles=told, next=following)


@router.get("/cycles/{id}", responses=documented(401, 403, 404, 422, 503))
def read_cycle(here: Here, _: Looks, id: Id) -> answer.Cycle:  # noqa: A002 - its name in the path
    """One cycle."""
    cycle = here.cycle(id)
    return _tell(here, cycle, here.recordings_of([cycle])[id], reads_file=True)


@router.get(
    "/cycles/{id}/report",
    response_class=HTMLResponse,
    responses=documented(401, 403, 404, 409, 422, 503),
)
def read_report(here: Here, _: Looks, id: Id) -> Response:  # noqa: A002
    """The report of a cycle: the page that the command line writes, from its recording."""
    _cycle, file = here.finished_file(id)
    headers = {
        "Content-Security-Policy": policy(),
        "X-Frame-Options": "SAMEORIGIN",
        "Cache-Control": "no-store",
    }
    return HTMLResponse(here.desk.report(file), headers=headers)


@router.get(
    "/cycles/{id}/recording",
    response_class=FileResponse,
    responses={
        200: {"content": {MCAP: {}}, "description": "The recording"},
        206: {"content": {MCAP: {}}, "description": "A part of it, as the header Range asks"},
        **documented(401, 403, 404, 409, 416, 422, 503),
    },
)
def read_recording(
    here: Here,
    holder: Looks,
    id: Id,  # noqa: A002
    part: Annotated[int, Query(ge=1, le=1000, description="More where a recorder died.")] = 1,
    wanted_bytes: Annotated[str | None, Header(alias="Range")] = None,
) -> FileResponse:
    """The recording of a cycle (MCAP), to keep; a range of it is given too. It goes on record."""
    cycle, file = here.finished_file(id)
    if part > len(file.parts):
        raise Problem(404, f"the recording has {len(file.parts)} parts")
    path = file.parts[part - 1]
    asked = body.read_byte_range(wanted_bytes)
    if asked is None or asked.find_start(path.stat().st_size) == 0:  # the rest of it is the same
        here.note_taken(cycle, part, holder)
    suffix = "" if part == 1 else f"-{part}"
    name = f"cycle-{cycle.number}{suffix}.mcap"
    return FileResponse(path, media_type=MCAP, filename=name)


@router.get("/cycles/{id}/replay", responses=documented(401, 403, 404, 409, 422, 503))
def read_replay(here: Here, _: Looks, id: Id) -> answer.Replay:  # noqa: A002
    """Result of the replay of the cycle's recording, where it was replayed."""
    return answer.Replay(**here.desk.verdict(here.finished_file(id)[1]))


@router.post(
    "/cycles/{id}/replay", status_code=202, responses=documented(401, 403, 404, 409, 422, 503)
)
def begin_replay(
    here: Here,
    _: Annotated[Session, Depends(may_begin(Right.SEE_HISTORY))],
    id: Id,  # noqa: A002
) -> answer.Replay:
    """Play the cycle's recording through the controller again and compare every bit."""
    return answer.Replay(**here.desk.replay(here.finished_file(id)[1]))


@router.get("/alarms", responses=documented(401, 403, 422, 503))
def list_alarms(
    here: Here,
    _: Looks,
    narrowed: Narrowed,
    before: Before = None,
    limit: Limit = PAGE,
    cycle: OfCycle = None,
    priority: Literal["low", "medium", "high"] | None = None,
) -> answer.Alarms:
    """Alarms of this machine, the newest first."""
    machine = here.machine()
    found = here.history.list_alarms(machine, limit + 1, before, cycle, narrowed, priority)
    shown = found[:limit]
    following = shown[-1].number if len(found) > limit else None
    return answer.Alarms(alarms=[answer.Alarm.of(one) for one in shown], next=following)


@router.get("/actions", responses=documented(401, 403, 422, 503))
def list_actions(
    here: Here,
    _: Audits,
    narrowed: Narrowed,
    before: Before = None,
    limit: Limit = PAGE,
    cycle: OfCycle = None,
) -> answer.Actions:
    """List the actions of people on all machines, the newest first."""
    found = here.history.list_actions(None, limit + 1, before, cycle, narrowed)
    shown = found[:limit]
    following = shown[-1].number if len(found) > limit else None
    return answer.Actions(actions=[answer.Action.of(one) for one in shown], next=following)


@router.get("/audit", responses=documented(401, 403, 503))
def read_audit(here: Here, _: Audits) -> answer.Audit:
    """Head of the records' trail, and the result of the last audit."""
    return answer.Audit(**here.verification.tell())


@router.post("/audit", status_code=202, responses=documented(401, 403, 422, 503))
def begin_audit(
    here: Here,
    _: Annotated[Session, Depends(may_begin(Right.SEE_AUDIT))],
    asked: answer.AuditRequest,
) -> answer.Audit:
    """Read the whole trail and hold it against all that is on record."""
    here.verification.begin(asked.expected)
    return answer.Audit(**here.verification.tell())


@router.get("/trends", responses=documented(401, 403, 422, 503))
def read_trends(
    here: Here,
    _: Looks,
    since: Since = None,
    until: Until = None,
    ahead_min: Annotated[
        int,
        Query(
            ge=-FURTHEST_MIN, le=FURTHEST_MIN, description="Of UTC, by the clock that days are of"
        ),
    ] = 0,
) -> answer.Trends:
    """Outcomes and quantities of this machine, day by day."""
    found = here.trends(_bounded(since), _bounded(until), timedelta(minutes=ahead_min))
    days = [answer.TrendDay.of(one) for one in found.days]
    return answer.Trends(**{**found._asdict(), "days": days})
