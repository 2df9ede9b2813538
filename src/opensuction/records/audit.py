"""A database's trail, read whole; nothing is written."""

from opensuction.records import entry_check
from opensuction.records.database import address
from opensuction.records.database.database import Database, connect
from opensuction.records.database.failure import refused
from opensuction.records.migration import guard, upgrade
from opensuction.records.trail import check
from opensuction.records.trail.check import AuditReport

WAIT_S = 5.0
"""Longest wait for another program that writes."""


def audit(database: Database, expected: str | None = None) -> AuditReport:
    """Read the whole trail of a database; writes nothing.

    Raises RecordsError for one that is empty, or not of the version that this program knows.
    """
    if expected is not None:
        entry_check.check_hash("the expected head", expected)
    shown = database.address.shown
    with database.reading() as connection:
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
        return check.check(connection, guard.name_triggers(connection.dialect.name), expected)


def open_for_audit(url: str | None = None, wait_s: float = WAIT_S) -> Database:
    """A database that is only read. Raises RecordsError for one that is not there."""
    where = address.parse(url)
    if where.file is not None and not where.file.exists():
        raise refused(
            where.shown, "no such file; name the database with --database or OPENSUCTION_DATABASE"
        )
    return connect(where, wait_s, read_only=True)
