"""The trail: an entry for each row that is stored, chained by hashes.

An entry is a JSON object in canonical form: keys in order, no spaces, all but ASCII escaped, times
as ``2026-11-23T15:04:05.000001Z``. Its keys: ``at`` (when it was written), ``previous`` (the hash
of the entry before), ``row`` (what was stored), ``sequence`` (from 1 on), ``table``. Its hash is
the SHA-256 of that text. The first one's ``previous`` is 64 zeros.
"""

import hashlib
import json
from collections.abc import Mapping
from datetime import datetime
from enum import Enum
from typing import Any, NamedTuple

from sqlalchemy import Connection, Table, select, text

from opensuction.records.database import column, schema
from opensuction.records.database.utc_time import to_text

Value = str | int | bool | datetime | None
Row = Mapping[str, Value]

BEGINNING = "0" * column.HASH_DIGITS
"""What the first entry follows."""


class Head(NamedTuple):
    """Head of the trail."""

    sequence: int
    """Of the last entry; 0: there is none."""
    hash: str


def to_canonical(data: Any) -> str:
    """The one text that stands for this data."""
    return json.dumps(data, sort_keys=True, separators=(",", ":"), ensure_ascii=True)


def to_hash(content: str) -> str:
    """SHA-256 in hexadecimal."""
    return hashlib.sha256(content.encode("utf-8")).hexdigest()


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


def read_head(connection: Connection) -> Head:
    """Head of the trail, as the database has it."""
    row = connection.execute(select(schema.audit_head.c.sequence, schema.audit_head.c.hash)).one()
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
        self._connection.execute(table.insert().values(row))
        sequence, previous = self._head.sequence + 1, self._head.hash
        entry = write_entry(sequence, previous, self.now, table.name, row)
        self._head = Head(sequence, to_hash(entry))
        # A trigger of the database moves the head.
        self._connection.execute(
            schema.audit.insert().values(
                sequence=sequence, previous=previous, hash=self._head.hash, entry=entry
            )
        )
