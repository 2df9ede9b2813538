"""Instants: in UTC wherever they are kept, with their zone wherever they are read."""

from datetime import UTC, datetime

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
