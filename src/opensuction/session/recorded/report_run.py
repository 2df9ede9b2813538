"""The report of a recording: the page that a simulated cycle gets, from its file alone.

A recording held against the records: whether it is what was put on record under its name.
"""

from pathlib import Path
from typing import Annotated, NamedTuple

from opensuction.controller.record import Settings
from opensuction.kernel.errors import InputError
from opensuction.recording.cycle_file import frame
from opensuction.records import audit, recording_check
from opensuction.records.database.database import parse
from opensuction.records.database.failure import RecordsError
from opensuction.records.history import History
from opensuction.records.recording_check import WRITTEN, BoundRecording, Fault, Kind
from opensuction.report.cycle import page
from opensuction.result.cycle_result import CycleResult
from opensuction.result.plain import FLAT, Json
from opensuction.session.recorded import recorded_cycle, recorded_summary, replay_run
from opensuction.session.recorded.recorded_cycle import RecordedCycle

BOUND, UNBOUND, UNKNOWN = "bound", "unbound", "unknown"


class OnRecord(NamedTuple):
    """State of a file by the records."""

    state: str
    """Bound, unbound, unknown where there are no records, or the kind of its fault."""
    sentence: str

    @property
    def is_faulty(self) -> bool:
        """True if it is not what was put on record."""
        return self.state not in (BOUND, UNBOUND, UNKNOWN)


def find(path: Path, database: str | None) -> OnRecord:
    """State of a recording by the records.

    database: see `Records.open`; None: the default one, where there is one. Raises InputError for
    a file that is the recording of something else, and where a database that was named cannot be
    read.
    """
    misnamed = recording_check.find_misnaming(path)
    if misnamed is not None:
        raise InputError(misnamed.sentence)
    place = parse(database)
    if database is None and place.file is not None and not place.file.exists():
        return OnRecord(UNKNOWN, "no records are here to hold it against")
    try:
        opened = audit.open_for_audit(database)
        try:
            with opened.reading() as connection:
                audit.require_newest(connection, opened.address.shown)
            return _look_up(path, History(opened))
        finally:
            opened.engine.dispose()
    except RecordsError as error:
        if database is not None:
            raise
        return OnRecord(UNKNOWN, f"it was not held against the records: {error}")


def _look_up(path: Path, history: History) -> OnRecord:
    """By its name, by what it holds, and by the name that it gives itself."""

    def find_owner(sha256: str) -> BoundRecording | None:
        return history.find_recording(sha256=sha256)

    known = history.find_recording(name=path.name)
    if known is None:
        known = _find_by_content(path, history)
    if known is None:
        return OnRecord(UNBOUND, "unbound: no hash of it is on record")
    fault = recording_check.check(known, path, find_owner)
    if fault is None and known.file.name != path.name and WRITTEN.fullmatch(path.name):
        fault = Fault(Kind.SWAPPED, f"{path.name} is not what it is called: it is {known.said}")
    if fault is None:
        return OnRecord(BOUND, f"{known.said}, as its recorder left it")
    if fault.kind in (Kind.SWAPPED, Kind.MISSING, Kind.UNREADABLE):
        raise InputError(fault.sentence)
    return OnRecord(fault.kind, fault.sentence)


def _find_by_content(path: Path, history: History) -> BoundRecording | None:
    try:
        (found,) = frame.measure(path)
    except OSError:
        return None  # whoever reads it says why
    own = recording_check.find_own_name(path)
    by_hash = history.find_recording(sha256=found.sha256)
    return by_hash or (None if own is None else history.find_recording(name=own))


class Report(NamedTuple):
    """Report on a recording."""

    result: CycleResult
    html: str
    flaw: str | None
    """Why the file is not whole."""
    is_damaged: bool


class ReportedCycle(NamedTuple):
    """A recorded cycle, and what the records say of its file."""

    cycle: Annotated[CycleResult, FLAT]
    on_record: OnRecord


def sections(
    cycle: RecordedCycle, shown: CycleResult, on_record: str | None = None
) -> dict[str, Json]:
    """Tables for the end of the page: what was recorded, and what the controller was set to.

    shown: what the page says of it already. on_record: what the records say of the file, where it
    was held against them.
    """
    settings: Settings = cycle.settings
    recorded = {
        name: value
        for name, value in replay_run.describe(cycle.heading).items()
        if name not in page.ran(shown) and name != "notice"
    }
    said = {} if on_record is None else {"on_record": on_record}
    return {
        "Recording": {
            **recorded,
            **said,
            "missing_ticks": cycle.missing,
            "tick_s": cycle.dt_s,
        },
        "Plan": {
            "preload_s": settings.plan.preload_s,
            "dwell_s": settings.plan.dwell_s,
            "vacuum_mmhg": settings.plan.vacuum_mmhg,
            "nothing_comes_s": settings.plan.pace.nothing_comes_s,
            **settings.plan.motion._asdict(),
        },
        "Governor limits": {
            name: value
            for name, value in settings.limits._asdict().items()
            if isinstance(value, float)
        },
        "Insertion servo": settings.insertion_servo._asdict(),
    }


def run(paths: list[Path], on_record: str | None = None) -> Report:
    """The report of a recording.

    paths: its file, or the parts of it in their order. on_record: see `sections`. Raises InputError
    for what is no recording, holds no cycle, or cannot be read so far.
    """
    cycle = recorded_cycle.read(paths)
    found = recorded_summary.summary(cycle)
    html = page.render(found, cycle.columns, sections(cycle, found, on_record))
    return Report(found, html, cycle.flaw, cycle.is_damaged)
