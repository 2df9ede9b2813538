"""Tokens for other programs: they read what they were given for, for a time, and change nothing."""

from collections.abc import Iterable
from datetime import timedelta
from typing import NamedTuple
from uuid import uuid4

from opensuction.accounts import directory, secret
from opensuction.accounts.refusal import NotSignedInError
from opensuction.accounts.rule import lifetime, right
from opensuction.accounts.rule.right import Right
from opensuction.accounts.session import AccessToken, Session
from opensuction.accounts.site import AccountStore
from opensuction.kernel.errors import InputError
from opensuction.records import account_rows, entry_check
from opensuction.records.account_rows import Bearer
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
    entry_check.check_name("the label", label)
    rights = frozenset(map(_to_right, scope))
    if not rights:
        raise InputError(f"say what it may read: {', '.join(sorted(right.READ_ONLY))}")
    if not lifetime.SHORTEST_TOKEN <= life <= lifetime.LONGEST_TOKEN:
        raise InputError("a token holds for a minute at least and 366 days at most")
    token = f"{PREFIX}{secret.make()}"
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
                digest=secret.digest(token),
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
        bearer = rows.find_bearer(secret.digest(token), "token")
        known = None if bearer is None else rows.find_token(bearer.token_id or "")
    if known is None or now >= known.expires_at:
        raise NotSignedInError("the token is unknown, revoked or over")
    return _to_access(known)


def revoke(site: AccountStore, by: Session | None, token_id: str) -> None:
    """End a token. Raises InputError for one that is not there."""
    entry_check.check_name("the token's id", token_id)
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
