"""People's accounts, tokens of other programs, and the table of who may do what."""

from datetime import datetime, timedelta
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Path
from pydantic import BaseModel, ConfigDict, Field

from opensuction.accounts.accounts import Accounts
from opensuction.accounts.directory import Account, NewPassword
from opensuction.accounts.rule import lifetime, right
from opensuction.accounts.rule.right import Right, Role
from opensuction.accounts.session import AccessToken, Session
from opensuction.console.access import Here, Holder, check_reason, may, may_change
from opensuction.console.guard.problem import FieldError, Problem, documented
from opensuction.kernel.errors import InputError

router = APIRouter(tags=["Accounts"])
LONGEST_TOKEN_S = round(lifetime.LONGEST_TOKEN.total_seconds())
SHORTEST_TOKEN_S = round(lifetime.SHORTEST_TOKEN.total_seconds())

Name = Annotated[str, Path(max_length=64, description="Of an account.")]
ByAccounts = Annotated[Session, Depends(may_change(Right.MANAGE_ACCOUNTS))]
ByTokens = Annotated[Session, Depends(may_change(Right.MANAGE_TOKENS))]
SeesAccounts = Annotated[Holder, Depends(may(Right.MANAGE_ACCOUNTS))]
SeesTokens = Annotated[Holder, Depends(may(Right.MANAGE_TOKENS))]
Reason = Annotated[str, Field(min_length=1, max_length=500)]


class _Body(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)


class NewAccount(_Body):
    """An account that is wanted."""

    name: Annotated[str, Field(max_length=64)]
    role: Annotated[Role, Field(strict=False)]
    is_administrator: bool = False


class ChangedAccount(_Body):
    """Rights that an account shall have, and the reason."""

    role: Annotated[Role, Field(strict=False)]
    is_administrator: bool
    reason: Reason


class Given(_Body):
    """Reason for an action."""

    reason: Reason


class AccountBody(BaseModel):
    """An account."""

    name: str
    role: str
    is_administrator: bool
    is_active: bool
    has_one_time_password: bool
    password_set_at: datetime | None


class NewPasswordBody(BaseModel):
    """A password that is shown this once."""

    account: str
    one_time_password: str
    expires_at: datetime


class NewTokenRequest(_Body):
    """A token that is wanted."""

    label: Annotated[str, Field(min_length=1, max_length=64)]
    scope: Annotated[
        list[Annotated[str, Field(max_length=64)]],
        Field(min_length=1, max_length=16, description=f"Of: {', '.join(sorted(right.READ_ONLY))}"),
    ]
    lasts_s: Annotated[int, Field(ge=SHORTEST_TOKEN_S, le=LONGEST_TOKEN_S)]


class TokenBody(BaseModel):
    """A token, without what it is."""

    id: str
    label: str
    scope: list[str]
    expires_at: datetime


class NewTokenBody(TokenBody):
    """A token that is shown this once."""

    token: str


@router.get("/rights")
def read_rights() -> list[dict[str, Any]]:
    """List the rights with the roles that have them: the table that this interface obeys."""
    return [dict(one) for one in right.list_plain()]


@router.get("/accounts", responses=documented(401, 403, 503))
def list_accounts(site: Here, _: SeesAccounts) -> list[AccountBody]:
    """All accounts, those that were deactivated too."""
    return [_account(one) for one in site.accounts.list_accounts()]


@router.post("/accounts", status_code=201, responses=documented(401, 403, 409, 503))
def add_account(site: Here, by: ByAccounts, wanted: NewAccount) -> NewPasswordBody:
    """Make an account, with a password for its first sign-in."""
    try:
        made = site.accounts.add(by, wanted.name, wanted.role, wanted.is_administrator)
    except InputError as error:
        raise _of_field(error, "name") from None
    return _password(made)


@router.put("/accounts/{name}", responses=documented(401, 403, 404, 409, 503))
def change_account(site: Here, by: ByAccounts, name: Name, wanted: ChangedAccount) -> AccountBody:
    """Change what an account may do, from its next request on."""
    _find(site.accounts, name)
    reason = check_reason(wanted.reason)
    site.accounts.change_role(by, name, wanted.role, wanted.is_administrator, reason)
    return _account(_find(site.accounts, name))


@router.post("/accounts/{name}/password", responses=documented(401, 403, 404, 409, 503))
def reset_password(site: Here, by: ByAccounts, name: Name) -> NewPasswordBody:
    """Make a one-time password; an account that was deactivated is there again."""
    _find(site.accounts, name)
    return _password(site.accounts.reset_password(by, name))


@router.delete("/accounts/{name}", status_code=204, responses=documented(401, 403, 404, 409, 503))
def deactivate(site: Here, by: ByAccounts, name: Name, given: Given) -> None:
    """Nobody signs in as this account any more; what it did stays on record."""
    _find(site.accounts, name)
    site.accounts.deactivate(by, name, check_reason(given.reason))


@router.get("/tokens", responses=documented(401, 403, 503))
def list_tokens(site: Here, _: SeesTokens) -> list[TokenBody]:
    """Tokens of other programs that hold."""
    return [TokenBody(**_token(one)) for one in site.accounts.list_tokens()]


@router.post("/tokens", status_code=201, responses=documented(401, 403, 409, 503))
def issue_token(site: Here, by: ByTokens, wanted: NewTokenRequest) -> NewTokenBody:
    """Make a token, which only reads."""
    life = timedelta(seconds=wanted.lasts_s)
    made = site.accounts.issue_token(by, wanted.label, wanted.scope, life)
    return NewTokenBody(**_token(made.access), token=made.token)


@router.delete("/tokens/{token_id}", status_code=204, responses=documented(401, 403, 404, 409, 503))
def revoke_token(site: Here, by: ByTokens, token_id: Annotated[str, Path(max_length=64)]) -> None:
    """End a token."""
    if all(one.id != token_id for one in site.accounts.list_tokens()):
        raise Problem(404, "no such token holds")
    site.accounts.revoke_token(by, token_id)


def _find(accounts: Accounts, name: str) -> Account:
    for one in accounts.list_accounts():
        if one.name == name:
            return one
    raise Problem(404, "there is no such account")


def _of_field(error: InputError, field: str) -> InputError | Problem:
    """A refusal that is about what was typed, beside its field."""
    if type(error) is not InputError:
        return error
    return Problem(422, str(error), [FieldError(field, str(error))])


def _account(one: Account) -> AccountBody:
    return AccountBody(**one._asdict())


def _password(made: NewPassword) -> NewPasswordBody:
    return NewPasswordBody(**made._asdict())


def _token(one: AccessToken) -> dict[str, Any]:
    return {
        "id": one.id,
        "label": one.label,
        "scope": sorted(map(str, one.rights)),
        "expires_at": one.expires_at,
    }
