"""Dates and times of day in a table's cells, as seconds."""

import re
from datetime import UTC, datetime

_DATE = re.compile(
    r"\d{1,4}([-/.:]\d{1,2}){2}([ T].*|[.,].*)?|(\d{1,2}[-/.]){2}\d{4}([ T].*)?|\d{1,2}:\d{2}"
)
_YEAR_FIRST = re.compile(r"\d{4}([-/])\d\d\1\d\d[T ]\d\d:\d\d")
"""How a date begins that can be meant in one way only: ISO 8601, also with slashes."""
_DAY_FIRST = re.compile(r"(\d{1,2})\.(\d{1,2})\.(\d{4})[T ]+(\d{1,2}:\d\d.*)")
"""With points between them the day comes first everywhere; with strokes it may be the month."""
_TIME_OF_DAY = re.compile(r"(\d{1,4}):([0-5]\d):([0-5]\d(?:[.,]\d+)?)")
"""Hours, minutes and seconds, also of a clock that counts on beyond a day."""


def is_date(cell: str) -> bool:
    """True for a cell that is a date or a time of day."""
    return bool(_DATE.fullmatch(cell.strip()))


def is_instant(cell: str) -> bool:
    """True for a cell that begins with a date and time, or a time of day, that is read."""
    text = cell.strip()
    return bool(
        _YEAR_FIRST.match(text) or _DAY_FIRST.fullmatch(text) or _TIME_OF_DAY.fullmatch(text)
    )


def read_instant(cell: str) -> float:
    """Seconds since 1970 of a date with its time, UTC where it names no zone.

    Of a time of day without a date, seconds since midnight. Raises ValueError for anything else.
    """
    text = cell.strip()
    if clock := _TIME_OF_DAY.fullmatch(text):
        hours, minutes, seconds = clock.groups()
        return int(hours) * 3600.0 + int(minutes) * 60.0 + float(seconds.replace(",", "."))
    if parts := _DAY_FIRST.fullmatch(text):
        day, month, year, rest = parts.groups()
        text = f"{year}-{month:>02}-{day:>02} {'0' if rest[1] == ':' else ''}{rest}"
    found = datetime.fromisoformat(text.replace("/", "-"))
    return (found if found.tzinfo else found.replace(tzinfo=UTC)).timestamp()
