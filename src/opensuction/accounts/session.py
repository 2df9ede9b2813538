"""Sessions of people and access tokens of programs, and the check of their rights."""

from contextlib import suppress
from datetime import datetime
from typing import NamedTuple

from opensuction.accounts import secret
from opensuction.accounts.refusal import NotAllowedError, NotSignedInError
from opensuction.accounts.rule import lifetime, right
from opensuction.accounts.rule.right import RIGHTS, Right, Role
from opensuction.accounts.site import AccountStore
from opensuction.kernel.errors import InputError
from opensuction.records import entry_check
from opensuction.records.account_rows import AccountRows, AccountState, Bearer, Credential
from opensuction.records.database.failure import RecordsError


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
    digest = secret.digest(token)
    with site.reading() as rows:
        session, bearer = _read(rows, digest, now)
    if not goes_on:
        return session
    if lifetime.is_worth_writing(bearer, now):
        with suppress(RecordsError), site.changing() as change:  # nobody is sent away for that
            known = change.rows.find_bearer(digest, "session")
            if known is not None:
                change.rows.put_bearer(known._replace(seen_at=now))
    return session._replace(ends_at=min(bearer.expires_at, now + lifetime.IDLE))


def check_csrf(token: str, shown: str) -> None:
    """Raises NotAllowedError where what a page shows is not that of its session."""
    if not secret.is_csrf_token(token, shown):
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
    entry_check.check_reason("the reason", reason)


def _read(rows: AccountRows, digest: str, now: datetime) -> tuple[Session, Bearer]:
    bearer = rows.find_bearer(digest, "session")
    if bearer is None or bearer.account is None or lifetime.has_ended(bearer, now):
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
        ends_at=lifetime.ends_at(bearer),
        rights=rights & right.MUST_CHANGE if credential.is_one_time else rights,
        digest=bearer.digest,
    )
