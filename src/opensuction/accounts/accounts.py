"""Operations on people's accounts, as a console or a command calls them.

Tokens for other programs: they read what they were given for, for a time, and change nothing.
"""

from collections.abc import Iterable
from datetime import timedelta
from typing import NamedTuple
from uuid import uuid4

from opensuction.accounts import directory, session, sign_in
from opensuction.accounts.directory import Account, NewPassword
from opensuction.accounts.rule import right, sign_in_rule
from opensuction.accounts.rule.right import Right
from opensuction.accounts.session import AccessToken, Session
from opensuction.accounts.sign_in import SignedIn
from opensuction.accounts.site import AccountStore, NotSignedInError, PasswordHasher
from opensuction.kernel.errors import InputError
from opensuction.records import account_rows, entry
from opensuction.records.account_rows import Bearer
from opensuction.records.database import utc_time
from opensuction.records.database.database import Database
from opensuction.records.records import Clock
from opensuction.settings.wording import show, unknown

PREFIX = "opensuction_"
"""So that a token that got into a public place is found by those who search for such."""


class NewToken(NamedTuple):
    """Shown once; nobody can find it out again."""

    token: str
    access: AccessToken


def issue(
    site: AccountStore, by: Session | None, label: str, scope: Iterable[str], life: timedelta
) -> NewToken:
    """Make a token. scope: what it may read, of `right.READ_ONLY`; none of it changes anything.

    Raises InputError for a scope or a life that cannot be, NotAllowedError.
    """
    entry.check_name("the label", label)
    rights = frozenset(map(_to_right, scope))
    if not rights:
        raise InputError(f"say what it may read: {', '.join(sorted(right.READ_ONLY))}")
    if not sign_in_rule.SHORTEST_TOKEN <= life <= sign_in_rule.LONGEST_TOKEN:
        raise InputError("a token holds for a minute at least and 366 days at most")
    token = f"{PREFIX}{session.make()}"
    with site.changing() as change:
        done_by = directory.check_right(change, by, Right.MANAGE_TOKENS)
        made = account_rows.AccessToken(
            str(uuid4()), label, ",".join(sorted(rights)), change.now + life
        )
        detail = f"{label}: {made.scope}, until {made.expires_at:%Y-%m-%d %H:%M} UTC"
        done = change.note(done_by, "issue-token", detail)
        account_rows.store_token(change.request, done, made)
        change.rows.put_bearer(
            Bearer(
                digest=session.digest_of(token),
                kind="token",
                account=None,
                token_id=made.id,
                made_at=change.now,
                seen_at=change.now,
                expires_at=made.expires_at,
            )
        )
    return NewToken(token, _to_access(made))


def find(site: AccountStore, token: str) -> AccessToken:
    """Access that a token gives. Raises NotSignedInError where it is unknown, revoked or over."""
    now = site.now()
    with site.reading() as rows:
        bearer = rows.find_bearer(session.digest_of(token), "token")
        known = None if bearer is None else rows.find_token(bearer.token_id or "")
    if known is None or now >= known.expires_at:
        raise NotSignedInError("the token is unknown, revoked or over")
    return _to_access(known)


def revoke(site: AccountStore, by: Session | None, token_id: str) -> None:
    """End a token. Raises InputError for one that is not there."""
    entry.check_name("the token's id", token_id)
    with site.changing() as change:
        done_by = directory.check_right(change, by, Right.MANAGE_TOKENS)
        known = change.rows.find_token(token_id)
        if known is None or not change.rows.drop_token(token_id):
            raise InputError(f"no token {show(token_id)} holds")
        change.note(done_by, "revoke-token", f"{known.label} ({token_id})")


def list_tokens(site: AccountStore) -> list[AccessToken]:
    """Tokens that hold, by their labels."""
    now = site.now()
    with site.reading() as rows:
        return [_to_access(one) for one in rows.list_tokens() if now < one.expires_at]


def _to_access(row: account_rows.AccessToken) -> AccessToken:
    rights = frozenset(map(Right, row.scope.split(",")))
    return AccessToken(row.id, row.label, rights & right.READ_ONLY, row.expires_at)


def _to_right(name: str) -> Right:
    if name not in right.READ_ONLY:
        raise InputError(unknown(f"scope {show(str(name))}", str(name), sorted(right.READ_ONLY)))
    return Right(name)


class Accounts:
    """The accounts of one database; may be used by several threads, and by several programs.

    What each call raises is said where it is carried out; all of it is one plain line: errors of
    `refusal` for a person who may not, InputError for what cannot be, RecordsError of the database.
    """

    def __init__(
        self,
        database: Database,
        clock: Clock = utc_time.now,
        hasher: PasswordHasher | None = None,
    ) -> None:
        """Of a database that is up to date (`Records.open`)."""
        self._site = AccountStore(database, clock, hasher or PasswordHasher())

    def first_start(self) -> NewPassword | None:
        """Make an administrator where there is no account (`directory.first_start`)."""
        return directory.first_start(self._site)

    def sign_in(self, name: str, password: str, origin: str, device: str | None = None) -> SignedIn:
        """Sign somebody in (`sign_in.sign_in`)."""
        return sign_in.sign_in(self._site, name, password, origin, device)

    def sign_out(self, token: str) -> None:
        """End a session; one that is over already is no error."""
        sign_in.sign_out(self._site, token)

    def find_session(self, token: str) -> Session:
        """Session of a token, as of now, for a request that changes nothing."""
        return session.find(self._site, token)

    def check_session(self, token: str) -> Session:
        """As `find_session`, where nobody asks for anything: it does not go on for that."""
        return session.find(self._site, token, goes_on=False)

    def find_session_for_change(self, token: str, csrf: str | None) -> Session:
        """As `find_session`, for a request that changes something. csrf: what the page shows."""
        session.check_csrf(token, csrf or "")
        return session.find(self._site, token)

    def change_password(self, token: str, present: str, wanted: str) -> Session:
        """Change one's own password; all other sessions of the account end."""
        return sign_in.change_password(self._site, token, present, wanted)

    def list_accounts(self) -> list[Account]:
        """All accounts, by their names."""
        return directory.list_accounts(self._site)

    def add(
        self, by: Session | None, name: str, role: str, is_administrator: bool = False
    ) -> NewPassword:
        """Make an account. by: the administrator; None: a command on the machine itself."""
        return directory.add(self._site, by, name, role, is_administrator)

    def change_role(
        self, by: Session | None, name: str, role: str, is_administrator: bool, reason: str
    ) -> None:
        """Change what an account may do, from its next request on."""
        directory.change_role(self._site, by, name, role, is_administrator, reason)

    def deactivate(self, by: Session | None, name: str, reason: str) -> None:
        """Nobody signs in as this account any more; its sessions end."""
        directory.deactivate(self._site, by, name, reason)

    def reset_password(self, by: Session | None, name: str) -> NewPassword:
        """Make a one-time password; an account that was deactivated is there again."""
        return directory.reset_password(self._site, by, name)

    def issue_token(
        self, by: Session | None, label: str, scope: Iterable[str], life: timedelta
    ) -> NewToken:
        """Make a token for another program, which only reads."""
        return issue(self._site, by, label, scope, life)

    def find_token(self, token: str) -> AccessToken:
        """Access that a token gives; see `access_token.find`."""
        return find(self._site, token)

    def revoke_token(self, by: Session | None, token_id: str) -> None:
        """End a token."""
        revoke(self._site, by, token_id)

    def list_tokens(self) -> list[AccessToken]:
        """Tokens that hold, by their labels."""
        return list_tokens(self._site)
