"""Rules of a sign-in: waiting time after failures, names, lifetimes, network addresses.

Waiting time after failed sign-ins, before the next attempt is accepted.

Failures are counted for the account and for the address of the request at once; or, where a browser
shows that this account signed in there before, for the account on that browser alone. Somebody who
guesses a password from elsewhere therefore never locks out a person on a known browser, and no wait
is longer than `longest_s`. A refused attempt is not counted: it makes no wait longer.

Source: [OWASP-Device-Cookies]; the numbers are [assumed].

The name of an account.

Lifetimes of sessions, known browsers, one-time passwords and access tokens.

They are counted by the computer's clock: a sign-in outlives the console's process.

Network address of a request, in the form that is counted and put on record.
"""

import ipaddress
import re
import unicodedata
from datetime import datetime, timedelta
from typing import NamedTuple

from opensuction.kernel.errors import InputError
from opensuction.records.account_rows import Attempt, Bearer
from opensuction.settings.wording import one_line, show

LONGEST = 45
"""Characters of an address."""
NETWORK_V6 = 64
"""Bits of an IPv6 address that one customer has at least: the rest is his to choose."""


def normalise_origin(origin: str) -> str:
    """An address as it is counted: of IPv6 its network; of anything else what it says.

    >>> normalise_origin("::ffff:10.0.0.7"), normalise_origin("2001:db8::1:2")
    ('10.0.0.7', '2001:db8::/64')
    >>> normalise_origin("command line")
    'command line'
    """
    try:
        address = ipaddress.ip_address(origin.partition("%")[0])
    except ValueError:
        return one_line(origin)[:LONGEST] or "nowhere"
    if isinstance(address, ipaddress.IPv4Address):
        return str(address)
    if address.ipv4_mapped is not None:
        return str(address.ipv4_mapped)
    if address.is_loopback:
        return str(address)
    return str(ipaddress.ip_network((address, NETWORK_V6), strict=False))


IDLE = timedelta(minutes=30)
"""A session ends when nothing was asked for so long. [assumed]"""
ABSOLUTE = timedelta(hours=12)
"""And in any case after so long: a shift. [assumed]"""
GRAIN = timedelta(seconds=60)
"""A session's last use is written down at most so often."""
SET_BACK = timedelta(minutes=5)
"""A clock that shows so much before a session's last use was set back: the session ends."""
KNOWN_DEVICE = timedelta(days=90)
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


FORM = re.compile(r"[a-z][a-z0-9._-]{1,31}")
RESERVED = frozenset({"anybody", "nobody", "somebody", "schedule", "console", "command-line"})
"""Who stands in the records without an account."""


def normalise_name(typed: str) -> str:
    """A name as it was meant: without spaces around it, in small letters."""
    return unicodedata.normalize("NFC", typed).strip().casefold()


def can_be(name: str) -> bool:
    """True for a possible account name; no database is asked for any other."""
    return FORM.fullmatch(name) is not None


def check(name: str) -> None:
    """Raises InputError for what cannot be the name of a new account."""
    if not can_be(name):
        raise InputError(
            f"the name {show(name)} is none: 2 to 32 small letters, digits, '.', '_' and '-', a "
            "letter first"
        )
    if name in RESERVED:
        raise InputError(f"the name {show(name)} is kept for the records themselves")


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
