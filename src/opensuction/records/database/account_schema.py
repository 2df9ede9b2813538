"""The tables of people's accounts: what is on record of them, and what only holds now.

`account_state` and `access_token` are kept for ever, with their entries in the trail. The others
hold secrets, or what passes: they have no entry, and their rows go when they end.
"""

from sqlalchemy import (
    Boolean,
    CheckConstraint,
    Column,
    ForeignKey,
    Index,
    Integer,
    Table,
    Text,
    UniqueConstraint,
)

from opensuction.records.database.column import (
    HASH_DIGITS,
    LONGEST_NAME,
    LONGEST_TEXT,
    METADATA,
    bound,
    one_of,
)
from opensuction.records.database.utc_time import UtcTime

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
