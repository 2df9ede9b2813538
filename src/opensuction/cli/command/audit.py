"""``audit``: whether the records, their trail and their recordings are whole."""

from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from opensuction.cli import entry
from opensuction.cli.delivery import show
from opensuction.cli.entry import Command
from opensuction.result.plain import to_json

if TYPE_CHECKING:
    from rich.console import Console


class AuditOptions(NamedTuple):
    """Options of ``audit``."""

    database: str | None = None
    expect_head: str | None = None
    recordings: Path | None = None
    trail_only: bool = False
    as_json: bool = False


class RecordingsAudit(NamedTuple):
    """Recordings, held against their hashes on record."""

    read: int
    faults: tuple[str, ...]
    """What is wrong with them, a sentence each."""
    unbound: int
    """Without a hash on record."""
    unbound_since: tuple[str, ...]
    """Which of them came after the first of their machine that has one."""


class AuditResult(NamedTuple):
    """Result of an audit: the trail, and the recordings that it binds."""

    ok: bool
    database: str
    entries: int
    """That were read."""
    last_hash: str
    broken: str | None
    """What is wrong first; None: nothing is."""
    broken_at: int | None
    """The entry where it is, where it is in one."""
    expected_head: str | None
    """Hash that was noted before; None: none was given."""
    recordings: RecordingsAudit


def run(options: AuditOptions) -> int:
    """Read the whole trail and the recordings; returns the exit status.

    Raises InputError where the trail cannot be read, or the folder of recordings is none.
    """
    from opensuction.cli.progress import ProgressTeller
    from opensuction.kernel.errors import InputError
    from opensuction.records import audit

    folder = options.recordings
    if folder is not None and not folder.is_dir():
        raise InputError(f"--recordings {folder}: no such folder")
    asked = audit.AuditScope(options.expect_head, folder, not options.trail_only)
    database = audit.open_for_audit(options.database)
    try:
        report = ProgressTeller().wait(lambda: audit.audit(database, asked), "Reading the trail")
    finally:
        database.engine.dispose()
    found = AuditResult(
        ok=report.broken is None,
        database=database.address.shown,
        entries=report.entries,
        last_hash=report.last_hash,
        broken=report.broken,
        broken_at=report.broken_at,
        expected_head=options.expect_head,
        recordings=RecordingsAudit(
            report.recordings, report.faults, report.unbound, report.unbound_since
        ),
    )
    show(options.as_json, to_json(found), lambda console: _summarise(console, found))
    return entry.DONE if found.ok else entry.FAILED


def _summarise(console: "Console", found: AuditResult) -> None:
    recordings = found.recordings
    lines = [f"BROKEN: {one}" for one in recordings.faults or filter(None, [found.broken])]
    if found.ok:
        entries = "1 entry" if found.entries == 1 else f"{found.entries} entries"
        lines.append(f"OK: {entries}, last hash {found.last_hash}")
        if recordings.read:
            lines.append(f"OK: {_count(recordings.read)} as their recorders left them")
    if recordings.unbound:
        lines.append(f"{_count(recordings.unbound)} unbound: no hash on record")
    lines += [
        f"unbound although others before it are not: {one}" for one in recordings.unbound_since
    ]
    for line in lines:
        console.print(f"{found.database}: {line}", soft_wrap=True)


def _count(recordings: int) -> str:
    return "1 recording" if recordings == 1 else f"{recordings} recordings"


COMMAND = Command(
    name="audit",
    options=AuditOptions,
    run=run,
    sentence="Whether the records are whole: nothing changed, removed, added or swapped.",
    details="Reads the trail of a database of records from its first entry to its last, each "
    "chained to the one before by its hash, and holds every stored row against it; then every "
    "recording against its size and hash on record. It says OK with the number of entries and the "
    "last hash, or what is wrong: of the trail first, of the recordings each. It writes nothing. "
    "Recordings of earlier releases have no hash on record and are said to be unbound. "
    "Without --expect-head nobody can tell a trail that was written anew as a whole, or whose end "
    "was cut off together with its head: note the last hash elsewhere, now and then.",
    examples="""\b
Examples:
  opensuction audit                           your own records
  opensuction audit --database ward.db        of a file
  opensuction audit --database postgresql://auditor@host/records
  opensuction audit --recordings /mnt/archive  where they lie by now
  opensuction audit --json | jq -r .last_hash
  opensuction audit --expect-head $(cat noted)  also: what was noted then

\b
Environment:
  OPENSUCTION_DATABASE  the database where --database names none
  PGPASSWORD            of a server; or use ~/.pgpass, not the command line""",
    ends="0 whole, 1 broken, without the expected head, or a recording is not as it was",
)
