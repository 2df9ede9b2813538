"""Waiting time after failed sign-ins, before the next attempt is accepted.

Failures are counted for the account and for the address of the request at once; or, where a browser
shows that this account signed in there before, for the account on that browser alone. Somebody who
guesses a password from elsewhere therefore never locks out a person on a known browser, and no wait
is longer than `longest_s`. A refused attempt is not counted: it makes no wait longer.

Source: [OWASP-Device-Cookies]; the numbers are [assumed].
"""

from datetime import datetime, timedelta
from typing import NamedTuple

from opensuction.records.account_rows import Attempt


class BackOff(NamedTuple):
    """Rule by which failed attempts delay the next one."""

    free: int
    """Failures without any wait."""
    first_s: float
    """Wait after the first one that is not free; doubled by each that follows."""
    longest_s: float


ACCOUNT = BackOff(free=5, first_s=30.0, longest_s=900.0)
"""Of an account from anywhere: at most some 100 guesses a day."""
ORIGIN = BackOff(free=20, first_s=5.0, longest_s=60.0)
"""Of an address, whatever the names: a ward may share one, so its longest wait is short."""
DEVICE = BackOff(free=5, first_s=30.0, longest_s=900.0)
"""Of an account on a browser where it has signed in."""

MEMORY = timedelta(hours=24)
"""Failures are forgotten when none has followed for so long."""


def wait_s(rule: BackOff, attempt: Attempt | None, now: datetime) -> float:
    """Time until the next attempt may be made, in s; 0: now."""
    if attempt is None or attempt.failures < rule.free or now - attempt.last_at >= MEMORY:
        return 0.0
    doublings = min(attempt.failures - rule.free, 30)
    delay_s = min(rule.first_s * float(2**doublings), rule.longest_s)
    since_s = (now - attempt.last_at).total_seconds()
    return max(0.0, delay_s - max(0.0, since_s))


def is_of_the_future(attempt: Attempt | None, now: datetime) -> bool:
    """True where a clock that was set back would lengthen the wait of an attempt."""
    return attempt is not None and attempt.last_at > now


def charge(attempt: Attempt | None, now: datetime) -> Attempt:
    """Count an attempt as failed, before its password is looked at: many at once gain nothing."""
    before = 0 if attempt is None or now - attempt.last_at >= MEMORY else attempt.failures
    return Attempt(before + 1, now)


def refund(attempt: Attempt | None, now: datetime) -> Attempt | None:
    """Take one back that did not fail."""
    if attempt is None or attempt.failures <= 1:
        return None
    return Attempt(attempt.failures - 1, min(attempt.last_at, now))
