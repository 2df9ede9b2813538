"""The rows of people's accounts: read and written, nothing decided.

What an account is stands on record, each state by the action that made it. Hashes of passwords,
what sessions, devices and programs show, and failed sign-ins have no entry in the trail, and go.
"""

from datetime import datetime
from typing import Any, NamedTuple

from sqlalchemy import Connection, Table, bindparam, delete, func, select

from opensuction.records.database import schema
from opensuction.records.database.statement import delete_by, insert_into, select_by
from opensuction.records.request import Request


class AccountState(NamedTuple):
    """State of an account."""

    account: str
    role: str
    is_administrator: bool
    is_active: bool


class Credential(NamedTuple):
    """Credential that a password is held against."""

    account: str
    password_hash: str
    is_one_time: bool
    """Must be changed before anything else."""
    set_at: datetime
    expires_at: datetime | None
    """Of a one-time password that has not signed in yet; None of all others."""


class Bearer(NamedTuple):
    """Holder of a secret with this SHA-256."""

    digest: str
    kind: str
    """Of `account_schema.BEARERS`."""
    account: str | None
    token_id: str | None
    made_at: datetime
    seen_at: datetime
    expires_at: datetime


class Attempt(NamedTuple):
    """Sign-ins that failed in a row."""

    failures: int
    last_at: datetime


class AccessToken(NamedTuple):
    """Token with which another program may read."""

    id: str
    label: str
    scope: str
    expires_at: datetime


_STATE, _BEARER = schema.account_state.c, schema.bearer.c
_LAST_STATE = select_by(schema.account_state, "account").order_by(_STATE.number.desc()).limit(1)
_DROP_ENDED = delete(schema.bearer).where(
    _BEARER.expires_at <= bindparam("now"), _BEARER.kind != "token"
)
_DROP_OLD_ATTEMPTS = delete(schema.attempt).where(schema.attempt.c.last_at < bindparam("before"))


class AccountRows:
    """The rows within one transaction."""

    def __init__(self, connection: Connection) -> None:
        """Of a transaction that reads, or of one that writes (`Request`)."""
        self._connection = connection

    def find_state(self, account: str) -> AccountState | None:
        """Present state of an account; None: there is none of that name."""
        row = self._connection.execute(_LAST_STATE, {"account": account}).one_or_none()
        return None if row is None else _to_state(row)

    def list_states(self) -> list[AccountState]:
        """Present state of every account, by its name."""
        table = schema.account_state
        last = (
            select(table.c.account, func.max(table.c.number).label("number"))
            .group_by(table.c.account)
            .subquery()
        )
        query = (
            select(table)
            .join(last, (table.c.account == last.c.account) & (table.c.number == last.c.number))
            .order_by(table.c.account)
        )
        return [_to_state(row) for row in self._connection.execute(query)]

    def find_credential(self, account: str) -> Credential | None:
        """Credential of an account."""
        row = self._find(schema.credential, account=account)
        if row is None:
            return None
        return Credential(
            row.account, row.password_hash, row.is_one_time, row.set_at, row.expires_at
        )

    def put_credential(self, credential: Credential) -> None:
        """Set it, in place of the one before."""
        self.drop_credential(credential.account)
        self._connection.execute(insert_into(schema.credential), credential._asdict())

    def drop_credential(self, account: str) -> None:
        """Nobody signs in with it any more."""
        self._drop(schema.credential, account=account)

    def find_bearer(self, digest: str, kind: str) -> Bearer | None:
        """Holder of a secret of this kind."""
        row = self._find(schema.bearer, digest=digest, kind=kind)
        if row is None:
            return None
        return Bearer(**{name: getattr(row, name) for name in Bearer._fields})

    def put_bearer(self, bearer: Bearer) -> None:
        """Know a bearer, in place of one with the same secret."""
        self.drop_bearer(bearer.digest)
        self._connection.execute(insert_into(schema.bearer), bearer._asdict())

    def drop_bearer(self, digest: str) -> None:
        """Forget a bearer."""
        self._drop(schema.bearer, digest=digest)

    def drop_bearers(self, account: str, kind: str | None = None, but: str = "") -> None:
        """Forget those of an account. kind: of this kind only. but: of this digest not."""
        table = schema.bearer
        statement = delete(table).where(table.c.account == account, table.c.digest != but)
        if kind is not None:
            statement = statement.where(table.c.kind == kind)
        self._connection.execute(statement)

    def drop_token(self, token_id: str) -> bool:
        """Forget what shows an access token; returns whether anything did."""
        table = schema.bearer
        done = self._connection.execute(delete(table).where(table.c.token_id == token_id))
        return done.rowcount > 0

    def drop_old(self, now: datetime, attempts_before: datetime) -> None:
        """Forget sessions and devices whose time is over, and failures of long ago.

        Tokens stay: a clock that was wrong for a moment must not end them.
        """
        self._connection.execute(_DROP_ENDED, {"now": now})
        self._connection.execute(_DROP_OLD_ATTEMPTS, {"before": attempts_before})

    def find_attempt(self, key: str) -> Attempt | None:
        """Sign-ins that failed in a row, by the hash of what is counted."""
        row = self._find(schema.attempt, key=key)
        return None if row is None else Attempt(row.failures, row.last_at)

    def put_attempt(self, key: str, attempt: Attempt | None) -> None:
        """Set them; None: none failed."""
        self._drop(schema.attempt, key=key)
        if attempt is not None:
            self._connection.execute(insert_into(schema.attempt), {"key": key, **attempt._asdict()})

    def find_token(self, token_id: str) -> AccessToken | None:
        """An access token by its id, whether it still holds or not."""
        row = self._find(schema.access_token, id=token_id)
        return None if row is None else AccessToken(row.id, row.label, row.scope, row.expires_at)

    def list_tokens(self) -> list[AccessToken]:
        """Access tokens that something still shows, by their labels."""
        token, bearer = schema.access_token, schema.bearer
        query = (
            select(token)
            .join(bearer, bearer.c.token_id == token.c.id)
            .order_by(token.c.label, token.c.id)
        )
        return [
            AccessToken(row.id, row.label, row.scope, row.expires_at)
            for row in self._connection.execute(query)
        ]

    def _find(self, table: Table, **keys: str) -> Any:
        return self._connection.execute(select_by(table, *keys), keys).one_or_none()

    def _drop(self, table: Table, **keys: str) -> None:
        self._connection.execute(delete_by(table, *keys), keys)


def store_state(request: Request, action_id: str, state: AccountState) -> None:
    """Put on record what an account is from an action on."""
    number = request.count_up(schema.account_state, schema.account_state.c.account == state.account)
    row = {"action_id": action_id, "number": number, **state._asdict()}
    request.trail.store(schema.account_state, row)


def store_token(request: Request, action_id: str, token: AccessToken) -> None:
    """Put an access token on record, without what shows it."""
    row = {"action_id": action_id, **token._asdict()}
    request.trail.store(schema.access_token, row)


def _to_state(row: Any) -> AccountState:
    return AccountState(row.account, row.role, row.is_administrator, row.is_active)
