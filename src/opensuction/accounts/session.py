"""Sessions of people and access tokens of programs, and the check of their rights.

Secrets of sessions, programs and known browsers. Only their hashes are stored.

Somebody who reads the database therefore cannot sign in with it.
"""

import hashlib
import hmac
import secrets
from contextlib import suppress
from datetime import datetime
from typing import NamedTuple

from opensuction.accounts.rule import right, sign_in_rule
from opensuction.accounts.rule.right import RIGHTS, Right, Role
from opensuction.accounts.site import AccountStore, NotAllowedError, NotSignedInError
from opensuction.kernel.errors import InputError
from opensuction.records import entry
from opensuction.records.account_rows import AccountRows, AccountState, Bearer, Credential
from opensuction.records.database.failure import RecordsError

BYTES = 32
ONE_TIME_LETTERS = "abcdefghjkmnpqrstuvwxyz23456789"
"""None is taken for another when it is copied by hand."""
GROUPS, GROUP = 4, 5
"""Of a one-time password: 20 of 31 letters are 99 bits."""
LONGEST = 256
"""Characters that are looked at."""


def make() -> str:
    """A secret of 256 bits, in letters that a header may carry."""
    return secrets.token_urlsafe(BYTES)


def make_one_time_password() -> str:
    """A password to be copied by hand."""
    groups = (
        "".join(secrets.choice(ONE_TIME_LETTERS) for _ in range(GROUP)) for _ in range(GROUPS)
    )
    return "-".join(groups)


def digest_of(*parts: str) -> str:
    """SHA-256 of a secret, kept in its place. 256 random bits need no salt and no slow hash."""
    whole = hashlib.sha256()
    for part in parts:
        content = _to_bytes(part)
        whole.update(len(content).to_bytes(4) + content)
    return whole.hexdigest()


def csrf_token(session_token: str) -> str:
    """Token that a page sends with each change: it takes the session's secret to make it."""
    return hmac.new(_to_bytes(session_token), b"opensuction csrf", hashlib.sha256).hexdigest()


def is_csrf_token(session_token: str, shown: str) -> bool:
    """True for the CSRF token that `csrf_token` makes of a session's secret."""
    return hmac.compare_digest(_to_bytes(csrf_token(session_token)), _to_bytes(shown))


def _to_bytes(text: str) -> bytes:
    return text[:LONGEST].encode("utf-8", "surrogatepass")


class Session(NamedTuple):
    """Somebody who has signed in, as the account is at this moment."""

    account: str
    role: Role
    is_administrator: bool
    must_change_password: bool
    """Nothing else is allowed before."""
    ends_at: datetime
    """If nothing more is asked."""
    rights: frozenset[Right]
    digest: str
    """Of what the person shows."""

    @property
    def shown(self) -> str:
        """As messages name it."""
        return self.account


class AccessToken(NamedTuple):
    """Another program, which may read something."""

    id: str
    label: str
    rights: frozenset[Right]
    """All of them read only."""
    expires_at: datetime

    @property
    def shown(self) -> str:
        """As messages name it."""
        return f"the token '{self.label}'"


def find(site: AccountStore, token: str, goes_on: bool = True) -> Session:
    """Session of a token. It goes on from now.

    goes_on: false where nobody asks for anything, and an open stream only looks whether it still
    holds.

    Raises NotSignedInError where it is unknown or over, or the account was deactivated.
    """
    now = site.now()
    digest = digest_of(token)
    with site.reading() as rows:
        session, bearer = _read(rows, digest, now)
    if not goes_on:
        return session
    if sign_in_rule.is_worth_writing(bearer, now):
        with suppress(RecordsError), site.changing() as change:  # nobody is sent away for that
            known = change.rows.find_bearer(digest, "session")
            if known is not None:
                change.rows.put_bearer(known._replace(seen_at=now))
    return session._replace(ends_at=min(bearer.expires_at, now + sign_in_rule.IDLE))


def check_csrf(token: str, shown: str) -> None:
    """Raises NotAllowedError where what a page shows is not that of its session."""
    if not is_csrf_token(token, shown):
        raise NotAllowedError("the request does not come from the page that was signed in")


def require(holder: Session | AccessToken | None, wanted: Right, reason: str | None = None) -> None:
    """Raises an error where somebody may not do this; None: nobody signed in.

    reason: why it is done, for a right that needs one.
    """
    if wanted not in right.ANYBODY:
        if holder is None:
            raise NotSignedInError("sign in first")
        is_new = isinstance(holder, Session) and holder.must_change_password
        if is_new and wanted not in right.MUST_CHANGE:
            raise NotAllowedError("change the one-time password first")
        if wanted not in holder.rights:
            raise NotAllowedError(f"{holder.shown} may not: {RIGHTS[wanted].sentence}")
    if RIGHTS[wanted].needs_reason:
        check_reason(reason)


def check_reason(reason: str | None) -> None:
    """Raises InputError where there is none, or it has invisible characters."""
    if reason is None or not reason.strip():
        raise InputError("say why: a reason is put on record")
    entry.check_reason("the reason", reason)


def _read(rows: AccountRows, digest: str, now: datetime) -> tuple[Session, Bearer]:
    bearer = rows.find_bearer(digest, "session")
    if bearer is None or bearer.account is None or sign_in_rule.has_ended(bearer, now):
        raise NotSignedInError("the session is over; sign in again")
    state, credential = rows.find_state(bearer.account), rows.find_credential(bearer.account)
    if state is None or not state.is_active or credential is None:
        raise NotSignedInError("the account was deactivated")
    return of(state, credential, bearer), bearer


def of(state: AccountState, credential: Credential, bearer: Bearer) -> Session:
    """The session of an account."""
    role = Role(state.role)
    rights = right.rights_of(role, state.is_administrator)
    return Session(
        account=state.account,
        role=role,
        is_administrator=state.is_administrator,
        must_change_password=credential.is_one_time,
        ends_at=sign_in_rule.ends_at(bearer),
        rights=rights & right.MUST_CHANGE if credential.is_one_time else rights,
        digest=bearer.digest,
    )
