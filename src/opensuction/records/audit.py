"""A database's trail, read whole, and the recordings that it binds; nothing is written."""

from pathlib import Path
from typing import NamedTuple

from sqlalchemy import Connection, select

from opensuction.records import entry, recording_check
from opensuction.records.database import schema
from opensuction.records.database.database import Database, connect, parse
from opensuction.records.database.failure import refused
from opensuction.records.history import to_recording
from opensuction.records.migration import upgrade
from opensuction.records.recording_check import BoundRecording
from opensuction.records.trail import chain
from opensuction.records.trail.chain import AuditReport

WAIT_S = 5.0
"""Longest wait for another program that writes."""


class AuditScope(NamedTuple):
    """Scope of an audit."""

    expected: str | None = None
    """Hash of a head that was noted before."""
    recordings: Path | None = None
    """Folder where all recordings lie by now; None: where each was written."""
    reads_recordings: bool = True
    """Otherwise the trail alone."""


class _Recordings(NamedTuple):
    """Recordings on record."""

    bound: list[BoundRecording]
    unbound: int
    """Of cycles that have ended."""
    unbound_since: list[str]
    """Of those the ones after the first of their machine that is bound."""


def audit(database: Database, asked: AuditScope = AuditScope()) -> AuditReport:  # noqa: B008 - frozen
    """Read the whole trail of a database, then the recordings; writes nothing.

    Raises RecordsError for one that is empty, or not of the version that this program knows.
    """
    report, on_record = _audit_trail(database, asked.expected)
    if on_record is None:
        return report
    report = report._replace(
        unbound=on_record.unbound, unbound_since=tuple(on_record.unbound_since)
    )
    if not asked.reads_recordings:
        return report
    faults = [one.sentence for one in recording_check.check_all(on_record.bound, asked.recordings)]
    return report._replace(
        recordings=len(on_record.bound), faults=tuple(faults), broken=faults[0] if faults else None
    )


def _audit_trail(
    database: Database, expected: str | None
) -> tuple[AuditReport, _Recordings | None]:
    """The trail alone, and what it says of recordings; None where it is broken."""
    if expected is not None:
        entry.check_hash("the expected head", expected)
    with database.reading() as connection:
        require_newest(connection, database.address.shown)
        triggers = upgrade.name_triggers(connection.dialect.name)
        report = chain.check(connection, triggers, expected)
        return report, None if report.broken else _read_recordings(connection)


def require_newest(connection: Connection, shown: str) -> None:
    """Raises RecordsError for a database that is empty, or not of the version that is known."""
    version = upgrade.find_version(connection, shown)
    newest = upgrade.list_versions()[-1]
    if version is None:
        raise refused(shown, "is empty: nothing was ever put on record")
    if version != newest:
        raise refused(
            shown,
            f"is of an older opensuction (version {version}, this one knows {newest}): audit "
            "it with that one, or bring it up to date by a run of this one first",
        )


def _read_recordings(connection: Connection) -> _Recordings:
    """All files on record, and cycles that have ended and have none."""
    cycle, end, recording = schema.cycle, schema.cycle_end, schema.recording
    cycles = connection.execute(
        select(cycle.c.machine_serial, cycle.c.number, cycle.c.recording, end.c.cycle_id)
        .outerjoin(end, end.c.cycle_id == cycle.c.id)
        .where(cycle.c.recording.is_not(None))
        .order_by(cycle.c.machine_serial, cycle.c.number)
    ).all()
    numbers = {(row.machine_serial, row.recording): row.number for row in cycles}
    bound = [
        one._replace(cycle=numbers.get((one.machine, one.file.cycle_recording)))
        for one in map(
            to_recording, connection.execute(select(recording).order_by(recording.c.name))
        )
    ]
    known = {(one.machine, one.file.cycle_recording) for one in bound if one.file.part == 1}
    first: dict[str, int] = {}
    for one in bound:
        if one.cycle is not None:
            first[one.machine] = min(one.cycle, first.get(one.machine, one.cycle))
    unbound = [
        row
        for row in cycles
        if row.cycle_id is not None and (row.machine_serial, row.recording) not in known
    ]
    since = [
        f"{row.recording} of cycle {row.number} of machine {row.machine_serial}"
        for row in unbound
        if row.number > first.get(row.machine_serial, row.number)
    ]
    return _Recordings(bound, len(unbound), since)


def open_for_audit(url: str | None = None, wait_s: float = WAIT_S) -> Database:
    """A database that is only read. Raises RecordsError for one that is not there."""
    where = parse(url)
    if where.file is not None and not where.file.exists():
        raise refused(
            where.shown, "no such file; name the database with --database or OPENSUCTION_DATABASE"
        )
    return connect(where, wait_s, read_only=True)
