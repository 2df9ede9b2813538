"""The accounts of a site: made, changed, ended; always by somebody who may, and with an entry."""

from datetime import datetime
from typing import NamedTuple

from opensuction.accounts import session, sign_in
from opensuction.accounts.rule import right, sign_in_rule
from opensuction.accounts.rule.right import RIGHTS, Right, Role
from opensuction.accounts.session import Session, check_reason
from opensuction.accounts.site import AccountChange, AccountStore, NotAllowedError
from opensuction.kernel.errors import InputError
from opensuction.records.account_rows import AccountState, Credential, store_state
from opensuction.settings.wording import show, unknown

FIRST = "admin"
"""The account of the first start."""
KEEPER = "command-line"
"""Whoever may write the database anyway: a command on the machine itself."""


class Account(NamedTuple):
    """An account, as a list shows it."""

    name: str
    role: Role
    is_administrator: bool
    is_active: bool
    has_one_time_password: bool
    """Nobody has chosen a password of their own for it since one was made."""
    password_set_at: datetime | None


class NewPassword(NamedTuple):
    """Shown once, to be told to the person; nobody can find it out again."""

    account: str
    one_time_password: str
    expires_at: datetime


def first_start(site: AccountStore) -> NewPassword | None:
    """Make an administrator where there is no account; None: there is one.

    While its password has never been changed, each start makes another one: the one that was shown
    before may be lost.
    """
    with site.reading() as rows:
        if not _is_first(rows.list_states(), rows.find_credential(FIRST)):
            return None
    made = session.make_one_time_password()
    password_hash = site.hasher.make(made)
    with site.changing() as change:
        states = change.rows.list_states()
        if not _is_first(states, change.rows.find_credential(FIRST)):
            return None  # another program was faster
        if not states:
            done = change.note(KEEPER, "add-account", f"{FIRST}: the first administrator")
            state = AccountState(FIRST, Role.OBSERVER, True, True)
            store_state(change.request, done, state)
        else:
            change.note(KEEPER, "reset-password", f"{FIRST}: never signed in, started again")
        return _give_password(change, FIRST, made, password_hash)


def _is_first(states: list[AccountState], credential: Credential | None) -> bool:
    if not states:
        return True
    return len(states) == 1 and credential is not None and credential.is_one_time


def list_accounts(site: AccountStore) -> list[Account]:
    """All accounts, by their names, those that were deactivated, too."""
    with site.reading() as rows:
        return [
            Account(
                name=state.account,
                role=Role(state.role),
                is_administrator=state.is_administrator,
                is_active=state.is_active,
                has_one_time_password=credential is not None and credential.is_one_time,
                password_set_at=None if credential is None else credential.set_at,
            )
            for state in rows.list_states()
            for credential in (rows.find_credential(state.account),)
        ]


def add(
    site: AccountStore, by: Session | None, name: str, role: str, is_administrator: bool = False
) -> NewPassword:
    """Make an account. by: the administrator; None: a command on the machine itself.

    Raises InputError for a name that cannot be or is taken, NotAllowedError.
    """
    sign_in_rule.check(name)
    wanted = _to_role(role)
    made = session.make_one_time_password()
    password_hash = site.hasher.make(made)
    with site.changing() as change:
        done_by = _check_may(change, by)
        if change.rows.find_state(name) is not None:
            raise InputError(f"there is an account '{name}' already")
        state = AccountState(name, wanted, is_administrator, True)
        if not _has_administrator(change, state):
            raise InputError("there is no administrator yet: the first account must be one")
        done = change.note(done_by, "add-account", f"{name}: {_describe(wanted, is_administrator)}")
        store_state(change.request, done, state)
        return _give_password(change, name, made, password_hash)


def change_role(
    site: AccountStore,
    by: Session | None,
    name: str,
    role: str,
    is_administrator: bool,
    reason: str,
) -> None:
    """Change what an account may do; it holds from the next request on.

    Raises InputError for an account that is not there, or where no administrator would be left.
    """
    wanted = _to_role(role)
    check_reason(reason)
    with site.changing() as change:
        done_by = _check_may(change, by)
        before = _find(change, name)
        after = before._replace(role=wanted, is_administrator=is_administrator)
        if after == before:
            return
        _check_administrators(change, after)
        was = _describe(Role(before.role), before.is_administrator)
        detail = f"{name}: {_describe(wanted, is_administrator)}, was {was}: {reason}"
        store_state(change.request, change.note(done_by, "change-role", detail), after)


def deactivate(site: AccountStore, by: Session | None, name: str, reason: str) -> None:
    """Nobody signs in as this account any more; its sessions end. What it did stays on record."""
    check_reason(reason)
    with site.changing() as change:
        done_by = _check_may(change, by)
        before = _find(change, name)
        after = before._replace(is_active=False)
        if after == before:
            return
        _check_administrators(change, after)
        done = change.note(done_by, "deactivate-account", f"{name}: {reason}")
        store_state(change.request, done, after)
        change.rows.drop_credential(name)
        change.rows.drop_bearers(name)


def reset_password(site: AccountStore, by: Session | None, name: str) -> NewPassword:
    """Make a one-time password; sessions end, waits too. An account that was ended is there again.

    Raises InputError for an account that is not there.
    """
    made = session.make_one_time_password()
    password_hash = site.hasher.make(made)
    with site.changing() as change:
        done_by = _check_may(change, by)
        state = _find(change, name)
        what = "reset-password" if state.is_active else "activate-account"
        done = change.note(done_by, what, name)
        if not state.is_active:
            store_state(change.request, done, state._replace(is_active=True))
        return _give_password(change, name, made, password_hash)


def _give_password(change: AccountChange, name: str, made: str, password_hash: str) -> NewPassword:
    expires_at = change.now + sign_in_rule.ONE_TIME
    change.rows.put_credential(Credential(name, password_hash, True, change.now, expires_at))
    change.rows.drop_bearers(name)
    change.rows.put_attempt(sign_in.of_account(name).key, None)
    return NewPassword(name, made, expires_at)


def check_right(change: AccountChange, by: Session | None, wanted: Right) -> str:
    """Account that makes a change, for the record. Raises NotAllowedError without the right."""
    if by is None:
        return KEEPER
    state = change.rows.find_state(by.account)
    bearer = change.rows.find_bearer(by.digest, "session")
    if (
        state is None
        or not state.is_active
        or bearer is None
        or by.must_change_password
        or wanted not in right.rights_of(Role(state.role), state.is_administrator)
    ):
        raise NotAllowedError(f"{by.account} may not: {RIGHTS[wanted].sentence}")
    return state.account


def _check_may(change: AccountChange, by: Session | None) -> str:
    return check_right(change, by, Right.MANAGE_ACCOUNTS)


def _find(change: AccountChange, name: str) -> AccountState:
    state = change.rows.find_state(name) if sign_in_rule.can_be(name) else None
    if state is None:
        names = [one.account for one in change.rows.list_states()]
        raise InputError(unknown(f"account {show(name)}", name, names))
    return state


def _has_administrator(change: AccountChange, after: AccountState) -> bool:
    """True if an active administrator is left after this change of an account."""
    states = [one for one in change.rows.list_states() if one.account != after.account]
    return any(one.is_active and one.is_administrator for one in (*states, after))


def _check_administrators(change: AccountChange, after: AccountState) -> None:
    if not _has_administrator(change, after):
        raise InputError(f"'{after.account}' is the last administrator: make another one first")


def _to_role(role: str) -> Role:
    try:
        return Role(role)
    except ValueError:
        raise InputError(unknown(f"role {show(role)}", role, list(Role))) from None


def _describe(role: Role, is_administrator: bool) -> str:
    return f"{role} and administrator" if is_administrator else str(role)
