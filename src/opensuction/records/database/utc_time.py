"""Instants: in UTC wherever they are kept, with their zone wherever they are read."""

from datetime import UTC, datetime
from typing import Any

from sqlalchemy import DateTime, Dialect
from sqlalchemy.types import TypeDecorator

from opensuction.kernel.errors import InputError


def now() -> datetime:
    """By the computer's clock, which may step: no order is ever taken from it."""
    return datetime.now(tz=UTC)


def to_utc(instant: datetime) -> datetime:
    """The same instant in UTC. Raises InputError for one without a zone."""
    if instant.utcoffset() is None:
        raise InputError(f"the time {instant.isoformat()} has no zone; give it in UTC")
    return instant.astimezone(UTC)


def to_text(instant: datetime) -> str:
    """As the trail holds it: ``2026-11-23T15:04:05.000001Z``."""
    return to_utc(instant).replace(tzinfo=None).isoformat(timespec="microseconds") + "Z"


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
