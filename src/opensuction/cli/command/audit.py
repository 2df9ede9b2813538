"""``audit``: whether the records and their trail are whole."""

from typing import TYPE_CHECKING, NamedTuple

from opensuction.cli import exit_status
from opensuction.cli.delivery import show
from opensuction.cli.entry import Command
from opensuction.session.plain import Json

if TYPE_CHECKING:
    from rich.console import Console


class AuditOptions(NamedTuple):
    """What the command takes."""

    database: str | None = None
    expect_head: str | None = None
    as_json: bool = False


def run(options: AuditOptions) -> int:
    """Read the whole trail; returns the exit status. Raises InputError where it cannot be read."""
    from opensuction.cli.progress import ProgressTeller
    from opensuction.records import audit

    database = audit.open_for_audit(options.database)
    try:
        report = ProgressTeller().wait(
            lambda: audit.audit(database, options.expect_head), "Reading the trail"
        )
    finally:
        database.engine.dispose()
    data: Json = {
        "ok": report.broken is None,
        "database": database.address.shown,
        "entries": report.entries,
        "last_hash": report.last_hash,
        "broken": report.broken,
        "broken_at": report.broken_at,
        "expected_head": options.expect_head,
    }
    show(options.as_json, data, lambda console: _summarise(console, data))
    return exit_status.DONE if data["ok"] else exit_status.FAILED


def _summarise(console: "Console", data: Json) -> None:
    if data["ok"]:
        entries = "1 entry" if data["entries"] == 1 else f"{data['entries']} entries"
        line = f"OK: {entries}, last hash {data['last_hash']}"
    else:
        line = f"BROKEN: {data['broken']}"
    console.print(f"{data['database']}: {line}", soft_wrap=True)


COMMAND = Command(
    name="audit",
    options=AuditOptions,
    run=run,
    sentence="Whether the records are whole: nothing changed, removed, added.",
    details="Reads the trail of a database of records from its first entry to its last, each "
    "chained to the one before by its hash, and holds every stored row against it. It says OK "
    "with the number of entries and the last hash, or what is wrong first. It writes nothing. "
    "Without --expect-head nobody can tell a trail that was written anew as a whole, or whose end "
    "was cut off together with its head: note the last hash elsewhere, now and then.",
    examples="""\b
Examples:
  opensuction audit                           your own records
  opensuction audit --database ward.db        of a file
  opensuction audit --database postgresql://auditor@host/records
  opensuction audit --json | jq -r .last_hash
  opensuction audit --expect-head $(cat noted)  also: what was noted then

\b
Environment:
  OPENSUCTION_DATABASE  the database where --database names none
  PGPASSWORD            of a server; or use ~/.pgpass, not the command line""",
    ends="0 whole, 1 broken or without the expected head",
)
