"""The trail: an entry for each row that is stored, chained by hashes.

An entry is a JSON object in canonical form: keys in order, no spaces, all but ASCII escaped, times
as ``2026-11-23T15:04:05.000001Z``. Its keys: ``at`` (when it was written), ``previous`` (the hash
of the entry before), ``row`` (what was stored), ``sequence`` (from 1 on), ``table``. Its hash is
the SHA-256 of that text. The first one's ``previous`` is 64 zeros.

Check that the audit trail is complete, and that the stored rows agree with it.
"""

import json
from collections import Counter
from collections.abc import Mapping
from datetime import datetime
from enum import Enum
from typing import Any, NamedTuple

from sqlalchemy import Connection, Table, exc, func, select, text

from opensuction.records.database import schema
from opensuction.records.database.database import find_triggers
from opensuction.records.database.statement import insert_into
from opensuction.records.database.utc_time import to_text
from opensuction.records.entry import HASH_DIGITS, to_hash
from opensuction.settings.wording import show

Value = str | int | bool | datetime | None
Row = Mapping[str, Value]

BEGINNING = "0" * HASH_DIGITS
"""What the first entry follows."""


class Head(NamedTuple):
    """Head of the trail."""

    sequence: int
    """Of the last entry; 0: there is none."""
    hash: str


def to_canonical(data: Any) -> str:
    """The one text that stands for this data."""
    return json.dumps(data, sort_keys=True, separators=(",", ":"), ensure_ascii=True)


def to_plain(row: Row) -> dict[str, str | int | bool | None]:
    """A row as an entry holds it."""
    return {
        name: to_text(value) if isinstance(value, datetime) else value
        for name, value in row.items()
    }


def write_entry(sequence: int, previous: str, at: datetime, table: str, row: Row) -> str:
    """The text of an entry."""
    return to_canonical(
        {
            "at": to_text(at),
            "previous": previous,
            "row": to_plain(row),
            "sequence": sequence,
            "table": table,
        }
    )


_HEAD = select(schema.audit_head.c.sequence, schema.audit_head.c.hash)


def read_head(connection: Connection) -> Head:
    """Head of the trail, as the database has it."""
    row = connection.execute(_HEAD).one()
    return Head(row.sequence, row.hash)


def _to_plain_text(value: Any) -> Value:
    plain: Value = str(value.value) if isinstance(value, Enum) else value
    return plain


class Trail:
    """The trail within one transaction; whoever else writes waits until that has ended."""

    def __init__(self, connection: Connection, now: datetime) -> None:
        self._connection = connection
        self.now = now
        """When its entries are written."""
        if connection.dialect.name == "postgresql":
            connection.execute(text("SELECT id FROM audit_head FOR UPDATE"))
        self._head = read_head(connection)

    def store(self, table: Table, row: Row) -> None:
        """Insert a row and its entry. All columns that are not named are empty."""
        # Drivers differ in what they make of an enumeration.
        row = {name: _to_plain_text(value) for name, value in row.items()}
        self._connection.execute(insert_into(table), row)
        sequence, previous = self._head.sequence + 1, self._head.hash
        entry = write_entry(sequence, previous, self.now, table.name, row)
        self._head = Head(sequence, to_hash(entry))
        # A trigger of the database moves the head.
        told = {"sequence": sequence, "previous": previous, "hash": self._head.hash, "entry": entry}
        self._connection.execute(insert_into(schema.audit), told)


KEYS = {"at", "previous", "row", "sequence", "table"}
TABLES = {table.name: table for table in schema.AUDITED}
AT_ONCE = 500
"""Entries that are held against their rows by one query; databases bound what one may ask."""

UNREADABLE = (TypeError, ValueError, OverflowError, LookupError, exc.InvalidRequestError)
"""Of a column that holds what its type cannot be, as SQLite allows, and of a head that is gone."""


class AuditReport(NamedTuple):
    """Result of an audit."""

    entries: int
    """That were read; of a broken trail those up to where it breaks, the broken one with them."""
    last_hash: str
    """Of the last entry that was read and is whole."""
    broken: str | None = None
    """What is wrong first; None: nothing is."""
    broken_at: int | None = None
    """The entry where it is, where it is in one."""
    recordings: int = 0
    """Files that were held against the hashes on record, once the trail was found whole."""
    faults: tuple[str, ...] = ()
    """What is wrong with them, a sentence each."""
    unbound: int = 0
    """Cycles that have ended whose recording has no hash on record."""
    unbound_since: tuple[str, ...] = ()
    """Which of them came after the first of their machine that has one."""


class _BrokenError(Exception):
    """The first thing that is wrong."""

    def __init__(self, what: str, at: int | None = None) -> None:
        super().__init__(what)
        self.at = at


class _Entry(NamedTuple):
    sequence: int
    table: str
    row: dict[str, Any]


class _Walk:
    """The trail from its beginning on."""

    def __init__(self, connection: Connection, expected: str | None) -> None:
        self._connection = connection
        self._expected = expected
        self.head = Head(0, BEGINNING)
        self.seen_expected = expected in (None, BEGINNING)
        self.counted: Counter[str] = Counter()

    def check(self, triggers: frozenset[str]) -> None:
        """Raises _BrokenError for the first thing that is wrong."""
        if self._connection.dialect.name == "sqlite":
            said = self._connection.exec_driver_sql("PRAGMA integrity_check(1)").scalar_one()
            if said != "ok":
                raise _BrokenError(f"the file is damaged: {' '.join(str(said).split())}")
        while some := self._read_some():
            self._hold_against_rows(some)
        end = read_head(self._connection)
        if end != self.head:
            raise _BrokenError(
                f"the trail ends with entry {self.head.sequence}, its head says {end.sequence} "
                f"({end.hash[:12]}...): the end was cut off, or the head was changed"
            )
        for name, table in TABLES.items():
            count = self._connection.execute(select(func.count()).select_from(table)).scalar_one()
            if count != self.counted[name]:
                raise _BrokenError(
                    f"the table '{name}' has {count} rows, the trail tells of "
                    f"{self.counted[name]}: rows were added or taken away"
                )
        if not self.seen_expected:
            raise _BrokenError(
                f"no entry has the expected hash {str(self._expected)[:12]}...: the trail was "
                "written anew, was cut off before it, or is another one"
            )
        if missing := triggers - find_triggers(self._connection):
            raise _BrokenError(
                f"the trigger '{min(missing)}' of the database is missing or off: since when, "
                "and what was changed without it, nothing here can tell"
            )

    def _read_some(self) -> list[_Entry]:
        audit = schema.audit
        query = select(audit).order_by(audit.c.sequence).limit(AT_ONCE)
        if self.head.sequence:
            query = query.where(audit.c.sequence > self.head.sequence)
        return [self._read_entry(row) for row in self._connection.execute(query)]

    def _read_entry(self, row: Any) -> _Entry:
        due = self.head.sequence + 1
        if row.sequence != due:
            raise _BrokenError(f"entry {due} is missing, {row.sequence} comes after it", due)
        if not isinstance(row.entry, str) or to_hash(row.entry) != row.hash:
            raise _BrokenError(f"entry {due} was changed: its hash is not that of its text", due)
        entry = _parse(row.entry)
        if entry is None:
            raise _BrokenError(f"entry {due} is not in the trail's form", due)
        if (entry["sequence"], entry["previous"]) != (due, self.head.hash) or (
            row.previous != self.head.hash
        ):
            raise _BrokenError(f"entry {due} does not follow entry {due - 1}", due)
        if not _is_of_a_table(entry["table"], entry["row"]):
            raise _BrokenError(f"entry {due} is no row of a table that is known", due)
        self.head = Head(due, row.hash)
        self.seen_expected = self.seen_expected or row.hash == self._expected
        self.counted[entry["table"]] += 1
        return _Entry(due, entry["table"], entry["row"])

    def _hold_against_rows(self, entries: list[_Entry]) -> None:
        stored: dict[tuple[str, Any], dict[str, Any]] = {}
        for name, table in TABLES.items():
            key = _key(table)
            wanted = [entry.row[key] for entry in entries if entry.table == name]
            if wanted:
                query = select(table).where(table.c[key].in_(wanted))
                for row in self._connection.execute(query).mappings():
                    stored[name, row[key]] = dict(row)
        for entry in entries:
            _compare(entry, stored)


def _parse(content: str) -> dict[str, Any] | None:
    """An entry's text as data; None for one that is not in canonical form."""
    try:
        entry = json.loads(content)
        is_canonical = to_canonical(entry) == content
    except (ValueError, RecursionError):
        return None
    return entry if is_canonical and isinstance(entry, dict) and entry.keys() == KEYS else None


def _is_of_a_table(table: Any, row: Any) -> bool:
    if not isinstance(table, str) or table not in TABLES or not isinstance(row, dict):
        return False
    key = row.get(_key(TABLES[table]))
    return isinstance(key, str) and "\0" not in key


def _key(table: Table) -> str:
    (column,) = table.primary_key.columns
    return column.name


def _compare(entry: _Entry, stored: dict[tuple[str, Any], dict[str, Any]]) -> None:
    """Check that a row is what its entry says; columns that it does not name must be empty."""
    key = entry.row[_key(TABLES[entry.table])]
    where = f"{entry.table} {show(key)} of entry {entry.sequence}"
    if (entry.table, key) not in stored:
        raise _BrokenError(f"{where} is missing", entry.sequence)
    row = to_plain(stored[entry.table, key])
    for name, value in row.items():
        said = entry.row.get(name)
        if value != said or isinstance(value, bool) != isinstance(said, bool):
            raise _BrokenError(
                f"{where} was changed: its {name} is not what it was", entry.sequence
            )
    if extra := entry.row.keys() - row.keys():
        raise _BrokenError(f"{where} lacks its {show(min(extra))}", entry.sequence)
    content = row.get("content")
    if isinstance(content, str) and to_hash(content) != key:
        raise _BrokenError(f"{where} has another content than its hash", entry.sequence)


def check(
    connection: Connection, triggers: frozenset[str], expected: str | None = None
) -> AuditReport:
    """Read the whole trail and hold it against all that is stored.

    triggers: that must be there. expected: the hash of an entry, noted when it was the last one.
    """
    walk = _Walk(connection, expected)
    try:
        walk.check(triggers)
    except _BrokenError as broken:
        read = broken.at or walk.head.sequence
        return AuditReport(read, walk.head.hash, str(broken), broken.at)
    except UNREADABLE as error:
        said = show(str(error).partition("\n")[0])
        what = f"after entry {walk.head.sequence} there is what cannot be read ({said})"
        return AuditReport(walk.head.sequence, walk.head.hash, what)
    return AuditReport(walk.head.sequence, walk.head.hash)
