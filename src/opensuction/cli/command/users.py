"""``users``: people's accounts, for a site without a browser, or for who is locked out of one."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

from opensuction.cli import exit_status
from opensuction.cli.delivery import show
from opensuction.cli.entry import Command
from opensuction.kernel.errors import InputError
from opensuction.result.plain import Json

if TYPE_CHECKING:
    from rich.console import Console

    from opensuction.accounts.accounts import Accounts
    from opensuction.accounts.directory import NewPassword


class UsersOptions(NamedTuple):
    """What the command takes."""

    act: str = "list"
    account: str | None = None
    role: str | None = None
    administrator: bool = False
    reason: str | None = None
    database: str | None = None
    as_json: bool = False


def _list(_accounts: "Accounts", _name: str, _options: UsersOptions) -> Json:
    return {}


def _add(accounts: "Accounts", name: str, options: UsersOptions) -> Json:
    made = accounts.add(None, name, _need_role(options), options.administrator)
    return _to_json(made)


def _change_role(accounts: "Accounts", name: str, options: UsersOptions) -> Json:
    role, reason = _need_role(options), _need_reason(options)
    accounts.change_role(None, name, role, options.administrator, reason)
    return {}


def _deactivate(accounts: "Accounts", name: str, options: UsersOptions) -> Json:
    accounts.deactivate(None, name, _need_reason(options))
    return {}


def _reset_password(accounts: "Accounts", name: str, _options: UsersOptions) -> Json:
    return _to_json(accounts.reset_password(None, name))


ACTS: dict[str, Callable[["Accounts", str, UsersOptions], Json]] = {
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
    data = _carry_out(options)
    show(options.as_json, data, lambda console: _summarise(console, data))
    return exit_status.DONE


def _carry_out(options: UsersOptions) -> Json:
    from opensuction.accounts.accounts import Accounts
    from opensuction.records import audit
    from opensuction.records.records import Records

    if options.act != MAKES_FILE:
        audit.open_for_audit(options.database).close()  # a name misspelt makes no new file
    with Records.open(options.database) as records:
        accounts = Accounts(records.database)
        done = ACTS[options.act](accounts, options.account or "", options)
        return {
            "database": records.database.address.shown,
            "act": options.act,
            "account": options.account,
            "one_time_password": None,
            "expires_at": None,
            **done,
            "accounts": [
                {
                    "name": one.name,
                    "role": str(one.role),
                    "administrator": one.is_administrator,
                    "active": one.is_active,
                    "must_change_password": one.has_one_time_password,
                    "password_set_at": one.password_set_at and one.password_set_at.isoformat(),
                }
                for one in accounts.list_accounts()
            ],
        }


def _need_role(options: UsersOptions) -> str:
    if options.role is None:
        raise InputError("say what the person is here for: --role observer, clinician or engineer")
    return options.role


def _need_reason(options: UsersOptions) -> str:
    if options.reason is None:
        raise InputError("say why: --reason 'left the ward'; it is put on record")
    return options.reason


def _to_json(made: "NewPassword") -> Json:
    return {
        "one_time_password": made.one_time_password,
        "expires_at": made.expires_at.isoformat(),
    }


def _summarise(console: "Console", data: Json) -> None:
    if data["one_time_password"] is not None:
        console.print(
            f"{data['account']}: one-time password {data['one_time_password']}, shown this once, "
            f"until {data['expires_at'][:16].replace('T', ' ')} UTC",
            soft_wrap=True,
        )
        return
    if data["act"] != "list":
        (one,) = [one for one in data["accounts"] if one["name"] == data["account"]]
        console.print(_describe(one), soft_wrap=True)
        return
    for one in data["accounts"]:
        console.print(_describe(one), soft_wrap=True)
    if not data["accounts"]:
        console.print(f"{data['database']}: no accounts yet", soft_wrap=True)


def _describe(one: dict[str, Any]) -> str:
    notes = [one["role"]]
    if one["administrator"]:
        notes.append("administrator")
    if not one["active"]:
        notes.append("deactivated")
    if one["must_change_password"]:
        notes.append("has a one-time password")
    return f"{one['name']}: {', '.join(notes)}"


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
