"""Lifetimes of sessions, known browsers, one-time passwords and access tokens.

They are counted by the computer's clock: a sign-in outlives the console's process.
"""

from datetime import datetime, timedelta

from opensuction.records.account_rows import Bearer

IDLE = timedelta(minutes=30)
"""A session ends when nothing was asked for so long. [assumed]"""
ABSOLUTE = timedelta(hours=12)
"""And in any case after so long: a shift. [assumed]"""
GRAIN = timedelta(seconds=60)
"""A session's last use is written down at most so often."""
SET_BACK = timedelta(minutes=5)
"""A clock that shows so much before a session's last use was set back: the session ends."""
DEVICE = timedelta(days=90)
"""A browser where somebody signed in is remembered for so long after the last time."""
ONE_TIME = timedelta(hours=24)
"""A one-time password holds for so long."""
SHORTEST_TOKEN = timedelta(minutes=1)
LONGEST_TOKEN = timedelta(days=366)
"""Of a token for another program."""


def has_ended(bearer: Bearer, now: datetime) -> bool:
    """True once a session is over."""
    return (
        now >= bearer.expires_at or now >= bearer.seen_at + IDLE or now < bearer.seen_at - SET_BACK
    )


def ends_at(bearer: Bearer) -> datetime:
    """Time at which a session ends if nothing more is asked."""
    return min(bearer.expires_at, bearer.seen_at + IDLE)


def is_worth_writing(bearer: Bearer, now: datetime) -> bool:
    """True once the time of a session's last use is worth an update."""
    return abs(now - bearer.seen_at) >= GRAIN
