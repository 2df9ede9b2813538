"""Signing in and out, and changing one's password.

A sign-in is two transactions with the slow look at the password between them, so that the recorder
never waits for a hash. The first counts it as failed, or refuses it; the second takes that back. A
name that nobody has goes the same way through both.

Counters of failed sign-ins: one for each account, address and known browser.
"""

from datetime import datetime
from typing import NamedTuple

from opensuction.accounts import session
from opensuction.accounts.rule import password as password_rule
from opensuction.accounts.rule import sign_in_rule
from opensuction.accounts.rule.sign_in_rule import BackOff
from opensuction.accounts.session import Session
from opensuction.accounts.site import (
    AccountChange,
    AccountStore,
    BusyError,
    PasswordOverError,
    WaitError,
    WrongPasswordError,
)
from opensuction.kernel.errors import InputError
from opensuction.records.account_rows import AccountState, Bearer, Credential
from opensuction.records.entry import LONGEST_NAME


class RateLimitKey(NamedTuple):
    """Something whose failures are counted."""

    key: str
    """A hash: what somebody typed for a name may be a password."""
    rule: BackOff
    is_shared: bool
    """Others fail in it, too: who succeeds takes only the own attempt back."""


def of_account(name: str) -> RateLimitKey:
    """Of an account, from wherever."""
    return RateLimitKey(session.digest_of("account", name), sign_in_rule.ACCOUNT, False)


def of_origin(origin: str) -> RateLimitKey:
    """Of an address."""
    return RateLimitKey(session.digest_of("origin", origin), sign_in_rule.ORIGIN, True)


def of_device(device_digest: str) -> RateLimitKey:
    """Of an account on a browser where it has signed in."""
    return RateLimitKey(session.digest_of("device", device_digest), sign_in_rule.DEVICE, False)


def charge(change: AccountChange, lanes: tuple[RateLimitKey, ...]) -> float:
    """Count an attempt in all lanes as failed, or in none where one must wait.

    Returns how long to wait, in s; 0: it is counted, look at the password.
    """
    rows, now = change.rows, change.now
    attempts = [rows.find_attempt(lane.key) for lane in lanes]
    for index, (lane, attempt) in enumerate(zip(lanes, attempts, strict=True)):
        if attempt is not None and sign_in_rule.is_of_the_future(attempt, now):
            # The clock was set back: the wait is not to last until the clock is there again.
            attempts[index] = attempt._replace(last_at=now)
            rows.put_attempt(lane.key, attempts[index])
    waits = [
        sign_in_rule.wait_s(lane.rule, attempt, now)
        for lane, attempt in zip(lanes, attempts, strict=True)
    ]
    if max(waits) == 0.0:
        for lane, attempt in zip(lanes, attempts, strict=True):
            rows.put_attempt(lane.key, sign_in_rule.charge(attempt, now))
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
        change.rows.put_attempt(lane.key, sign_in_rule.refund(attempt, change.now))


SOMEBODY = "somebody"
"""Who failed to sign in, in the records: nobody knows who it was."""

NOT_A_NAME = "?"
"""What is asked for instead of a name that no account can have, by the same way."""


class SignedIn(NamedTuple):
    """Tokens that a browser is given, with its session."""

    session_token: str
    """Its secret: a cookie that no script reads."""
    csrf_token: str
    """For the page, to be sent along with each change."""
    device_token: str
    """Another such cookie, kept when the session ends: failures elsewhere do not count here."""
    session: Session


class _Tried(NamedTuple):
    """A sign-in that was counted, before its password was looked at."""

    name: str
    origin: str
    device: str | None
    lanes: tuple[RateLimitKey, ...]
    credential: Credential | None


def sign_in(
    site: AccountStore, typed: str, password: str, origin: str, device: str | None = None
) -> SignedIn:
    """Sign somebody in.

    typed: the name as it was typed. origin: the address that the request comes from, never what it
    says of itself. device: what the browser was given before (`SignedIn.device_token`).
    A one-time password signs in once: whoever leaves before choosing another needs a new one.
    Raises WrongPasswordError, which does not say what was wrong; PasswordOverError; WaitError, with
    nothing looked at; BusyError.
    """
    name = sign_in_rule.normalise_name(typed[: 2 * LONGEST_NAME])
    tried, wait_s = _count(site, name, sign_in_rule.normalise_origin(origin), device)
    if wait_s > 0.0:
        raise WaitError(wait_s)
    credential = tried.credential
    try:
        is_right = site.hasher.matches(credential and credential.password_hash, password)
        anew = None
        if is_right and credential and site.hasher.is_outdated(credential.password_hash):
            anew = site.hasher.make(password)
    except BusyError:
        with site.changing() as change:
            refund(change, tried.lanes)
        raise
    with site.changing() as change:
        known = _find_holder(change, tried) if is_right else None
        if known is not None and not _is_over(known[1], change.now):
            return _let_in(change, tried, *known, anew)
        _put_failure_on_record(change, tried)
    raise WrongPasswordError if known is None else PasswordOverError


def _is_over(credential: Credential, now: datetime) -> bool:
    """True for a one-time password that was used or has expired."""
    ends_at = credential.expires_at
    return credential.is_one_time and (ends_at is None or now >= ends_at)


def _count(site: AccountStore, name: str, origin: str, device: str | None) -> tuple[_Tried, float]:
    """Count a sign-in as failed, or say how long to wait, in s."""
    with site.changing() as change:
        change.rows.drop_old(change.now, change.now - sign_in_rule.MEMORY)
        digest = session.digest_of(device or "", name)
        known = change.rows.find_bearer(digest, "device")
        own = name if sign_in_rule.can_be(name) else NOT_A_NAME
        lanes: tuple[RateLimitKey, ...] = (
            of_account(name),
            of_origin(origin),
        )
        if known is not None and known.account == name:
            lanes = (of_device(digest),)
        wait_s = charge(change, lanes)
        return _Tried(own, origin, device, lanes, change.rows.find_credential(own)), wait_s


def _find_holder(change: AccountChange, tried: _Tried) -> tuple[AccountState, Credential] | None:
    """The account, where it may be used and its password is still the one that was looked at."""
    state = change.rows.find_state(tried.name)
    credential = change.rows.find_credential(tried.name)
    if state is None or not state.is_active or credential is None:
        return None
    if tried.credential is None or credential.password_hash != tried.credential.password_hash:
        return None
    return state, credential


def _let_in(
    change: AccountChange,
    tried: _Tried,
    state: AccountState,
    credential: Credential,
    anew: str | None,
) -> SignedIn:
    rows, now = change.rows, change.now
    forgive(change, tried.lanes)
    kept = credential if anew is None else credential._replace(password_hash=anew)
    if kept.is_one_time:
        kept = kept._replace(expires_at=None)  # used: see `_is_over`
    if kept != credential:
        rows.put_credential(kept)
    token = session.make()
    bearer = Bearer(
        session.digest_of(token),
        "session",
        state.account,
        None,
        now,
        now,
        now + sign_in_rule.ABSOLUTE,
    )
    rows.put_bearer(bearer)
    device = _remember_device(change, tried)
    change.note(state.account, "sign-in", f"from {tried.origin}")
    return SignedIn(token, session.csrf_token(token), device, session.of(state, credential, bearer))


def _remember_device(change: AccountChange, tried: _Tried) -> str:
    """Remember that this account signed in on this browser, which others may use, too."""
    rows, now = change.rows, change.now
    device = tried.device
    if device is None or rows.find_bearer(session.digest_of(device), "device") is None:
        device = session.make()  # one that the browser made up is not taken
    ends_at = now + sign_in_rule.KNOWN_DEVICE
    rows.put_bearer(Bearer(session.digest_of(device), "device", None, None, now, now, ends_at))
    of_account = session.digest_of(device, tried.name)
    rows.put_bearer(Bearer(of_account, "device", tried.name, None, now, now, ends_at))
    return device


def _put_failure_on_record(change: AccountChange, tried: _Tried) -> None:
    # The same rows for a name that nobody has: its letters are not kept, it may be a password.
    is_known = change.rows.find_state(tried.name) is not None
    who = f"as {tried.name}" if is_known else "with a name that nobody has"
    change.note(SOMEBODY, "sign-in-refused", f"{who}, from {tried.origin}")


def sign_out(site: AccountStore, token: str) -> None:
    """End a session; one that is over already is no error."""
    digest = session.digest_of(token)
    with site.changing() as change:
        bearer = change.rows.find_bearer(digest, "session")
        if bearer is not None and bearer.account is not None:
            change.rows.drop_bearer(digest)
            change.note(bearer.account, "sign-out")


def change_password(site: AccountStore, token: str, present: str, wanted: str) -> Session:
    """Change one's own password; all other sessions of the account end.

    Raises WrongPasswordError where the present one is wrong, WaitError after several of those,
    InputError for a password that is not taken, NotSignedInError.
    """
    holder = session.find(site, token)
    name = holder.account
    password_rule.check(wanted, name)
    if password_rule.normalise(present) == password_rule.normalise(wanted):
        raise InputError("the new password is the present one")
    lanes = (of_device(holder.digest),)
    with site.changing() as change:
        wait_s = charge(change, lanes)
        credential = change.rows.find_credential(name)
    if wait_s > 0.0:
        raise WaitError(wait_s)
    try:
        is_right = site.hasher.matches(credential and credential.password_hash, present)
        password_hash = site.hasher.make(wanted) if is_right else ""
    except BusyError:
        with site.changing() as change:
            refund(change, lanes)
        raise
    if not is_right:
        with site.changing() as change:
            change.note(name, "change-password-refused", "the present one is wrong")
        raise WrongPasswordError
    with site.changing() as change:
        if credential is None or change.rows.find_credential(name) != credential:
            raise WrongPasswordError  # an administrator was faster
        forgive(change, lanes)
        change.rows.put_credential(Credential(name, password_hash, False, change.now, None))
        change.rows.drop_bearers(name, "session", but=holder.digest)
        change.note(name, "change-password")
    return session.find(site, token)
