"""``users``: people's accounts, for a site without a browser, or for who is locked out of one."""

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

from opensuction.cli import entry
from opensuction.cli.delivery import show
from opensuction.cli.entry import Command
from opensuction.kernel.errors import InputError
from opensuction.result.plain import to_json

if TYPE_CHECKING:
    from rich.console import Console

    from opensuction.accounts.accounts import Accounts
    from opensuction.accounts.directory import Account, NewPassword


class UsersOptions(NamedTuple):
    """Options of ``users``."""

    act: str = "list"
    account: str | None = None
    role: str | None = None
    administrator: bool = False
    reason: str | None = None
    database: str | None = None
    as_json: bool = False


class AccountEntry(NamedTuple):
    """Account, as the list has it."""

    name: str
    role: str
    administrator: bool
    active: bool
    must_change_password: bool
    """It has a one-time password."""
    password_set_at: str | None
    """UTC, in the form of ISO 8601; None: it has no password."""


class UsersResult(NamedTuple):
    """Result of an act on an account, and all accounts after it."""

    database: str
    act: str
    """Of `ACTS`."""
    account: str | None
    """None: the act was to list them."""
    one_time_password: str | None
    """None: the act made none."""
    expires_at: str | None
    """Of that password; UTC, in the form of ISO 8601."""
    accounts: tuple[AccountEntry, ...]
    """By their names."""


def _list(_accounts: "Accounts", _name: str, _options: UsersOptions) -> None:
    pass


def _add(accounts: "Accounts", name: str, options: UsersOptions) -> "NewPassword":
    return accounts.add(None, name, _need_role(options), options.administrator)


def _change_role(accounts: "Accounts", name: str, options: UsersOptions) -> None:
    role, reason = _need_role(options), _need_reason(options)
    accounts.change_role(None, name, role, options.administrator, reason)


def _deactivate(accounts: "Accounts", name: str, options: UsersOptions) -> None:
    accounts.deactivate(None, name, _need_reason(options))


def _reset_password(accounts: "Accounts", name: str, _options: UsersOptions) -> "NewPassword":
    return accounts.reset_password(None, name)


ACTS: dict[str, Callable[["Accounts", str, UsersOptions], "NewPassword | None"]] = {
    "list": _list,
    "add": _add,
    "role": _change_role,
    "deactivate": _deactivate,
    "reset-password": _reset_password,
}
MAKES_FILE = "add"
"""The one act for which a database is made where there is none."""


def run(options: UsersOptions) -> int:
    """Carry an act out; returns the exit status. Raises InputError for what cannot be."""
    from opensuction.settings import wording

    if options.act not in ACTS:
        raise InputError(wording.unknown(f"act {wording.show(options.act)}", options.act, ACTS))
    if options.act == "list" and options.account is not None:
        raise InputError("'users list' takes no name: it lists all accounts")
    if options.act != "list" and options.account is None:
        raise InputError(f"say whose account: opensuction users {options.act} NAME")
    found = _carry_out(options)
    show(options.as_json, to_json(found), lambda console: _summarise(console, found))
    return entry.DONE


def _carry_out(options: UsersOptions) -> UsersResult:
    from opensuction.accounts.accounts import Accounts
    from opensuction.records import audit
    from opensuction.records.records import Records

    if options.act != MAKES_FILE:
        audit.open_for_audit(options.database).close()  # a name misspelt makes no new file
    with Records.open(options.database) as records:
        accounts = Accounts(records.database)
        made = ACTS[options.act](accounts, options.account or "", options)
        return UsersResult(
            database=records.database.address.shown,
            act=options.act,
            account=options.account,
            one_time_password=None if made is None else made.one_time_password,
            expires_at=None if made is None else made.expires_at.isoformat(),
            accounts=tuple(_entry(one) for one in accounts.list_accounts()),
        )


def _entry(one: "Account") -> AccountEntry:
    return AccountEntry(
        name=one.name,
        role=str(one.role),
        administrator=one.is_administrator,
        active=one.is_active,
        must_change_password=one.has_one_time_password,
        password_set_at=None if one.password_set_at is None else one.password_set_at.isoformat(),
    )


def _need_role(options: UsersOptions) -> str:
    if options.role is None:
        raise InputError("say what the person is here for: --role observer, clinician or engineer")
    return options.role


def _need_reason(options: UsersOptions) -> str:
    if options.reason is None:
        raise InputError("say why: --reason 'left the ward'; it is put on record")
    return options.reason


def _summarise(console: "Console", found: UsersResult) -> None:
    if found.one_time_password is not None and found.expires_at is not None:
        console.print(
            f"{found.account}: one-time password {found.one_time_password}, shown this once, "
            f"until {found.expires_at[:16].replace('T', ' ')} UTC",
            soft_wrap=True,
        )
        return
    if found.act != "list":
        (one,) = [one for one in found.accounts if one.name == found.account]
        console.print(_describe(one), soft_wrap=True)
        return
    for one in found.accounts:
        console.print(_describe(one), soft_wrap=True)
    if not found.accounts:
        console.print(f"{found.database}: no accounts yet", soft_wrap=True)


def _describe(one: AccountEntry) -> str:
    notes = [one.role]
    if one.administrator:
        notes.append("administrator")
    if not one.active:
        notes.append("deactivated")
    if one.must_change_password:
        notes.append("has a one-time password")
    return f"{one.name}: {', '.join(notes)}"


COMMAND = Command(
    name="users",
    options=UsersOptions,
    run=run,
    sentence="People's accounts: list, add, change, deactivate, reset a password.",
    details="Accounts of a database of records, for a site without a browser, or where nobody can "
    "sign in. Whoever may write the database may do this; each act is on record as done by "
    "'command-line'. An account is never deleted: what was done in its name stays on record. A "
    "one-time password is shown once, holds for 24 hours, signs in once, and must be changed then: "
    "whoever leaves before needs another one (reset-password, which also lets an account that was "
    "deactivated in again). Roles: an observer looks, a clinician starts cycles, an engineer "
    "changes limits and calibration; an "
    "administrator manages accounts, whatever the role; the first account is one. Everybody may "
    "stop the machine, without any account.",
    examples="""\b
Examples:
  opensuction users                             all accounts
  opensuction users add eva --role engineer --administrator
  opensuction users add anna --role clinician   prints a one-time password
  opensuction users role anna --role engineer --reason 'new post'
  opensuction users deactivate anna --reason 'left the ward'
  opensuction users reset-password anna
  opensuction users --json | jq '.accounts[] | select(.active).name'

\b
Environment:
  OPENSUCTION_DATABASE  the database where --database names none
  PGPASSWORD            of a server; or use ~/.pgpass, not the command line""",
    ends="0 done",
)
