"""The tables. A migration makes them; a test holds both against each other.

The tables of people's accounts: what is on record of them, and what only holds now.

`account_state` and `access_token` are kept for ever, with their entries in the trail. The others
hold secrets, or what passes: they have no entry, and their rows go when they end.

Building blocks of all tables: names of constraints, bounds, types of columns.
"""

from datetime import UTC, datetime
from typing import Any

from sqlalchemy import (
    BigInteger,
    Boolean,
    CheckConstraint,
    Column,
    DateTime,
    Dialect,
    ForeignKey,
    Index,
    Integer,
    MetaData,
    Table,
    Text,
    UniqueConstraint,
)
from sqlalchemy.types import TypeDecorator

from opensuction.records.database.utc_time import to_utc
from opensuction.records.entry import (
    APPROACHES,
    HASH_DIGITS,
    LARGEST_FR,
    LONGEST_FILE,
    LONGEST_LIFE_S,
    LONGEST_NAME,
    LONGEST_TEXT,
    OUTCOMES,
    PRIORITIES,
)

METADATA = MetaData(
    naming_convention={
        "pk": "pk_%(table_name)s",
        "fk": "fk_%(table_name)s_%(column_0_name)s",
        "ck": "ck_%(table_name)s_%(constraint_name)s",
        "uq": "uq_%(table_name)s_%(column_0_name)s",
        "ix": "ix_%(table_name)s_%(column_0_name)s",
    }
)
SEQUENCE = BigInteger().with_variant(Integer, "sqlite")
"""SQLite counts by itself in columns of the plain kind only."""


class UtcTime(TypeDecorator[datetime]):
    """A column of instants; SQLite keeps no zones, so all of them are in UTC."""

    impl = DateTime(timezone=True)
    cache_ok = True

    def process_bind_param(self, value: datetime | None, dialect: Dialect) -> Any:
        """As the database takes it."""
        if value is None:
            return None
        in_utc = to_utc(value)
        return in_utc.replace(tzinfo=None) if dialect.name == "sqlite" else in_utc

    def process_result_value(self, value: Any, dialect: Dialect) -> datetime | None:
        """As the program reads it."""
        if value is None:
            return None
        if dialect.name == "sqlite":
            value = value.replace(tzinfo=UTC)
        return to_utc(value)


def bound(name: str, longest: int, shortest: int = 1) -> CheckConstraint:
    """Constraint on the number of characters in a column."""
    return CheckConstraint(f"length({name}) BETWEEN {shortest} AND {longest}", name=name)


def one_of(name: str, values: tuple[str, ...] | tuple[bool, ...]) -> CheckConstraint:
    """Constraint on the values of a column."""
    return CheckConstraint(f"{name} IN ({', '.join(map(repr, values))})", name=name)


ROLES = ("observer", "clinician", "engineer")
BEARERS = ("session", "device", "token")
LONGEST_PASSWORD_HASH = 512

account_state = Table(
    "account_state",
    METADATA,
    Column("action_id", ForeignKey("action.id"), primary_key=True),
    Column("account", Text, nullable=False),
    Column("number", Integer, nullable=False),
    Column("role", Text, nullable=False),
    Column("is_administrator", Boolean, nullable=False),
    Column("is_active", Boolean, nullable=False),
    bound("account", LONGEST_NAME),
    CheckConstraint("number >= 1", name="number"),
    one_of("role", ROLES),
    one_of("is_administrator", (True, False)),
    one_of("is_active", (True, False)),
    UniqueConstraint("account", "number"),
)
"""What an account is from an action on; the last one of an account holds."""
access_token = Table(
    "access_token",
    METADATA,
    Column("id", Text, primary_key=True),
    Column("action_id", ForeignKey("action.id"), nullable=False),
    Column("label", Text, nullable=False),
    Column("scope", Text, nullable=False),
    Column("expires_at", UtcTime, nullable=False),
    bound("id", LONGEST_NAME),
    bound("label", LONGEST_NAME),
    bound("scope", LONGEST_TEXT),
)
"""What another program may read; what it shows for that is in `bearer`."""

credential = Table(
    "credential",
    METADATA,
    Column("account", Text, primary_key=True),
    Column("password_hash", Text, nullable=False),
    Column("is_one_time", Boolean, nullable=False),
    Column("set_at", UtcTime, nullable=False),
    Column("expires_at", UtcTime),
    bound("account", LONGEST_NAME),
    bound("password_hash", LONGEST_PASSWORD_HASH),
    one_of("is_one_time", (True, False)),
)
bearer = Table(
    "bearer",
    METADATA,
    Column("digest", Text, primary_key=True),
    Column("kind", Text, nullable=False),
    Column("account", Text),
    Column("token_id", ForeignKey("access_token.id")),
    Column("made_at", UtcTime, nullable=False),
    Column("seen_at", UtcTime, nullable=False),
    Column("expires_at", UtcTime, nullable=False),
    bound("digest", HASH_DIGITS, HASH_DIGITS),
    one_of("kind", BEARERS),
    bound("account", LONGEST_NAME),
    Index(None, "account"),
)
"""Who shows a secret of this SHA-256 is that session, device or program."""
attempt = Table(
    "attempt",
    METADATA,
    Column("key", Text, primary_key=True),
    Column("failures", Integer, nullable=False),
    Column("last_at", UtcTime, nullable=False),
    bound("key", HASH_DIGITS, HASH_DIGITS),
    CheckConstraint("failures >= 0", name="failures"),
)
"""Sign-ins that failed in a row; the key is a hash: of what somebody typed nothing is kept."""


def _file_table(name: str) -> Table:
    return Table(
        name,
        METADATA,
        Column("sha256", Text, primary_key=True),
        Column("name", Text, nullable=False),
        Column("content", Text, nullable=False),
        Column("known_since", UtcTime, nullable=False),
        bound("sha256", HASH_DIGITS, HASH_DIGITS),
        bound("name", LONGEST_NAME),
        bound("content", LONGEST_FILE, 0),
    )


machine = Table(
    "machine",
    METADATA,
    Column("serial", Text, primary_key=True),
    Column("kind", Text, nullable=False),
    Column("is_twin", Boolean, nullable=False),
    Column("known_since", UtcTime, nullable=False),
    bound("serial", LONGEST_NAME),
    bound("kind", LONGEST_NAME),
    one_of("is_twin", (True, False)),
)
catheter = Table(
    "catheter",
    METADATA,
    Column("label", Text, primary_key=True),
    Column("size_fr", Integer, nullable=False),
    Column("life_s", Integer, nullable=False),
    Column("first_used_at", UtcTime, nullable=False),
    bound("label", LONGEST_NAME),
    CheckConstraint(f"size_fr BETWEEN 1 AND {LARGEST_FR}", name="size_fr"),
    CheckConstraint(f"life_s BETWEEN 1 AND {LONGEST_LIFE_S}", name="life_s"),
)
patient = Table(
    "patient",
    METADATA,
    Column("pseudonym", Text, primary_key=True),
    Column("known_since", UtcTime, nullable=False),
    bound("pseudonym", LONGEST_NAME),
)
protocol = _file_table("protocol")
parameter_file = _file_table("parameter_file")
cycle = Table(
    "cycle",
    METADATA,
    Column("id", Text, primary_key=True),
    Column("machine_serial", ForeignKey("machine.serial"), nullable=False),
    Column("number", Integer, nullable=False),
    Column("catheter_label", ForeignKey("catheter.label"), nullable=False),
    Column("patient_pseudonym", ForeignKey("patient.pseudonym")),
    Column("protocol_sha256", ForeignKey("protocol.sha256"), nullable=False),
    Column("parameter_file_sha256", ForeignKey("parameter_file.sha256")),
    Column("approach", Text, nullable=False),
    Column("requested_by", Text, nullable=False),
    Column("software", Text, nullable=False),
    Column("settings_sha256", Text),
    Column("recording", Text),
    Column("started_at", UtcTime, nullable=False),
    bound("id", LONGEST_NAME),
    one_of("approach", APPROACHES),
    bound("requested_by", LONGEST_NAME),
    bound("software", LONGEST_NAME),
    bound("settings_sha256", HASH_DIGITS, HASH_DIGITS),
    bound("recording", LONGEST_TEXT),
    CheckConstraint("number >= 1", name="number"),
    UniqueConstraint("machine_serial", "number"),
    Index(None, "catheter_label"),
)
cycle_end = Table(
    "cycle_end",
    METADATA,
    Column("cycle_id", ForeignKey("cycle.id"), primary_key=True),
    Column("outcome", Text, nullable=False),
    Column("detail", Text, nullable=False),
    Column("inside_at_end", Boolean),
    Column("ended_at", UtcTime, nullable=False),
    one_of("outcome", OUTCOMES),
    one_of("inside_at_end", (True, False)),
    bound("detail", LONGEST_TEXT, 0),
)
alarm = Table(
    "alarm",
    METADATA,
    Column("id", Text, primary_key=True),
    Column("machine_serial", ForeignKey("machine.serial"), nullable=False),
    Column("number", Integer, nullable=False),
    Column("cycle_id", ForeignKey("cycle.id")),
    Column("condition", Text, nullable=False),
    Column("priority", Text, nullable=False),
    Column("detail", Text, nullable=False),
    Column("raised_at", UtcTime, nullable=False),
    bound("id", LONGEST_NAME),
    bound("condition", LONGEST_NAME),
    one_of("priority", PRIORITIES),
    bound("detail", LONGEST_TEXT, 0),
    CheckConstraint("number >= 1", name="number"),
    UniqueConstraint("machine_serial", "number"),
    Index(None, "cycle_id"),
)
action = Table(
    "action",
    METADATA,
    Column("id", Text, primary_key=True),
    Column("number", Integer, nullable=False),
    Column("done_by", Text, nullable=False),
    Column("what", Text, nullable=False),
    Column("detail", Text, nullable=False),
    Column("machine_serial", ForeignKey("machine.serial")),
    Column("cycle_id", ForeignKey("cycle.id")),
    Column("done_at", UtcTime, nullable=False),
    bound("id", LONGEST_NAME),
    bound("done_by", LONGEST_NAME),
    bound("what", LONGEST_NAME),
    bound("detail", LONGEST_TEXT, 0),
    CheckConstraint("number >= 1", name="number"),
    UniqueConstraint("number"),
    Index(None, "machine_serial"),
)
recording = Table(
    "recording",
    METADATA,
    Column("name", Text, primary_key=True),
    Column("machine_serial", ForeignKey("machine.serial"), nullable=False),
    Column("cycle_recording", Text, nullable=False),
    Column("part", Integer, nullable=False),
    Column("folder", Text, nullable=False),
    Column("size_bytes", SEQUENCE, nullable=False),
    Column("sha256", Text, nullable=False),
    Column("is_closed", Boolean, nullable=False),
    Column("bound_at", UtcTime, nullable=False),
    bound("name", LONGEST_NAME),
    bound("cycle_recording", LONGEST_NAME),
    CheckConstraint("part >= 1", name="part"),
    bound("folder", LONGEST_TEXT),
    CheckConstraint("size_bytes >= 0", name="size_bytes"),
    bound("sha256", HASH_DIGITS, HASH_DIGITS),
    one_of("is_closed", (True, False)),
    Index(None, "cycle_recording"),
)
"""A file that a recorder has written; the cycle is the one that names `cycle_recording`."""
request = Table(
    "request",
    METADATA,
    Column("key", Text, primary_key=True),
    Column("digest", Text, nullable=False),
    Column("result", Text, nullable=False),
    Column("taken_at", UtcTime, nullable=False),
    bound("key", LONGEST_NAME),
    bound("digest", HASH_DIGITS, HASH_DIGITS),
    bound("result", LONGEST_NAME, 0),
)
AUDITED = (
    machine,
    catheter,
    patient,
    protocol,
    parameter_file,
    cycle,
    cycle_end,
    alarm,
    action,
    recording,
    request,
    account_state,
    access_token,
)
"""Each row of these has its entry in the trail."""

audit = Table(
    "audit",
    METADATA,
    Column("sequence", SEQUENCE, primary_key=True, autoincrement=False),
    Column("previous", Text, nullable=False, unique=True),
    Column("hash", Text, nullable=False, unique=True),
    Column("entry", Text, nullable=False),
    CheckConstraint("sequence >= 1", name="sequence"),
    bound("previous", HASH_DIGITS, HASH_DIGITS),
    bound("hash", HASH_DIGITS, HASH_DIGITS),
)
audit_head = Table(
    "audit_head",
    METADATA,
    Column("id", Integer, primary_key=True, autoincrement=False),
    Column("sequence", SEQUENCE, nullable=False),
    Column("hash", Text, nullable=False),
    CheckConstraint("id = 1", name="id"),
    bound("hash", HASH_DIGITS, HASH_DIGITS),
)
"""One row: where the trail ends, and what writers lock."""

KEPT = (*AUDITED, audit)
"""Tables of which no row is ever changed or removed."""
