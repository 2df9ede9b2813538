"""Counters of failed sign-ins: one for each account, address and known browser."""

from typing import NamedTuple

from opensuction.accounts import secret
from opensuction.accounts.rule import back_off
from opensuction.accounts.rule.back_off import BackOff
from opensuction.accounts.site import AccountChange


class RateLimitKey(NamedTuple):
    """Something whose failures are counted."""

    key: str
    """A hash: what somebody typed for a name may be a password."""
    rule: BackOff
    is_shared: bool
    """Others fail in it, too: who succeeds takes only the own attempt back."""


def of_account(name: str) -> RateLimitKey:
    """Of an account, from wherever."""
    return RateLimitKey(secret.digest("account", name), back_off.ACCOUNT, False)


def of_origin(origin: str) -> RateLimitKey:
    """Of an address."""
    return RateLimitKey(secret.digest("origin", origin), back_off.ORIGIN, True)


def of_device(device_digest: str) -> RateLimitKey:
    """Of an account on a browser where it has signed in."""
    return RateLimitKey(secret.digest("device", device_digest), back_off.DEVICE, False)


def charge(change: AccountChange, lanes: tuple[RateLimitKey, ...]) -> float:
    """Count an attempt in all lanes as failed, or in none where one must wait.

    Returns how long to wait, in s; 0: it is counted, look at the password.
    """
    rows, now = change.rows, change.now
    attempts = [rows.find_attempt(lane.key) for lane in lanes]
    for index, (lane, attempt) in enumerate(zip(lanes, attempts, strict=True)):
        if attempt is not None and back_off.is_of_the_future(attempt, now):
            # The clock was set back: the wait is not to last until the clock is there again.
            attempts[index] = attempt._replace(last_at=now)
            rows.put_attempt(lane.key, attempts[index])
    waits = [
        back_off.wait_s(lane.rule, attempt, now)
        for lane, attempt in zip(lanes, attempts, strict=True)
    ]
    if max(waits) == 0.0:
        for lane, attempt in zip(lanes, attempts, strict=True):
            rows.put_attempt(lane.key, back_off.charge(attempt, now))
    return max(waits)


def forgive(change: AccountChange, lanes: tuple[RateLimitKey, ...]) -> None:
    """Forget the failures of who succeeded; in a lane that is shared only the own attempt."""
    for lane in lanes:
        if lane.is_shared:
            refund(change, (lane,))
        else:
            change.rows.put_attempt(lane.key, None)


def refund(change: AccountChange, lanes: tuple[RateLimitKey, ...]) -> None:
    """Take an attempt back that neither failed nor succeeded."""
    for lane in lanes:
        attempt = change.rows.find_attempt(lane.key)
        change.rows.put_attempt(lane.key, back_off.refund(attempt, change.now))
