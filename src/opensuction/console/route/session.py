"""Signing in and out, and one's own password. The session is a cookie that no script reads.

People's accounts, tokens of other programs, and the table of who may do what.
"""

from datetime import datetime, timedelta
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Path, Request, Response
from pydantic import BaseModel, ConfigDict, Field

from opensuction.accounts.accounts import Accounts
from opensuction.accounts.directory import Account, NewPassword
from opensuction.accounts.rule import right, sign_in_rule
from opensuction.accounts.rule.password import LONGEST_TYPED
from opensuction.accounts.rule.right import Right, Role
from opensuction.accounts.session import AccessToken, Session, csrf_token
from opensuction.accounts.site import NotSignedInError, WrongPasswordError
from opensuction.console import access
from opensuction.console.access import (
    ConsoleContext,
    Here,
    Holder,
    OutOfTurn,
    check_reason,
    device_cookie,
    may,
    may_change,
    session_cookie,
)
from opensuction.console.guard.problem import FieldError, Problem, documented
from opensuction.kernel.errors import InputError

accounts_router = APIRouter(tags=["Accounts"])
LONGEST_TOKEN_S = round(sign_in_rule.LONGEST_TOKEN.total_seconds())
SHORTEST_TOKEN_S = round(sign_in_rule.SHORTEST_TOKEN.total_seconds())

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


@accounts_router.get("/rights")
def read_rights() -> list[dict[str, Any]]:
    """List the rights with the roles that have them: the table that this interface obeys."""
    return [dict(one) for one in right.list_plain()]


@accounts_router.get("/accounts", responses=documented(401, 403, 503))
def list_accounts(site: Here, _: SeesAccounts) -> list[AccountBody]:
    """All accounts, those that were deactivated too."""
    return [_account(one) for one in site.accounts.list_accounts()]


@accounts_router.post("/accounts", status_code=201, responses=documented(401, 403, 409, 503))
def add_account(site: Here, by: ByAccounts, wanted: NewAccount) -> NewPasswordBody:
    """Make an account, with a password for its first sign-in."""
    try:
        made = site.accounts.add(by, wanted.name, wanted.role, wanted.is_administrator)
    except InputError as error:
        raise _of_field(error, "name") from None
    return _password(made)


@accounts_router.put("/accounts/{name}", responses=documented(401, 403, 404, 409, 503))
def change_account(site: Here, by: ByAccounts, name: Name, wanted: ChangedAccount) -> AccountBody:
    """Change what an account may do, from its next request on."""
    _find(site.accounts, name)
    reason = check_reason(wanted.reason)
    site.accounts.change_role(by, name, wanted.role, wanted.is_administrator, reason)
    return _account(_find(site.accounts, name))


@accounts_router.post("/accounts/{name}/password", responses=documented(401, 403, 404, 409, 503))
def reset_password(site: Here, by: ByAccounts, name: Name) -> NewPasswordBody:
    """Make a one-time password; an account that was deactivated is there again."""
    _find(site.accounts, name)
    return _password(site.accounts.reset_password(by, name))


@accounts_router.delete(
    "/accounts/{name}", status_code=204, responses=documented(401, 403, 404, 409, 503)
)
def deactivate(site: Here, by: ByAccounts, name: Name, given: Given) -> None:
    """Nobody signs in as this account any more; what it did stays on record."""
    _find(site.accounts, name)
    site.accounts.deactivate(by, name, check_reason(given.reason))


@accounts_router.get("/tokens", responses=documented(401, 403, 503))
def list_tokens(site: Here, _: SeesTokens) -> list[TokenBody]:
    """Tokens of other programs that hold."""
    return [TokenBody(**_token(one)) for one in site.accounts.list_tokens()]


@accounts_router.post("/tokens", status_code=201, responses=documented(401, 403, 409, 503))
def issue_token(site: Here, by: ByTokens, wanted: NewTokenRequest) -> NewTokenBody:
    """Make a token, which only reads."""
    life = timedelta(seconds=wanted.lasts_s)
    made = site.accounts.issue_token(by, wanted.label, wanted.scope, life)
    return NewTokenBody(**_token(made.access), token=made.token)


@accounts_router.delete(
    "/tokens/{token_id}", status_code=204, responses=documented(401, 403, 404, 409, 503)
)
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


router = APIRouter(tags=["Session"])
Password = Annotated[str, Field(max_length=LONGEST_TYPED)]


class Who(BaseModel):
    """Person who is signed in, with the rights."""

    name: str | None = Field(description="None: nobody is.")
    role: str | None = None
    is_administrator: bool = False
    must_change_password: Annotated[bool, Field(description="Nothing else is allowed before.")] = (
        False
    )
    rights: list[str]
    csrf: Annotated[
        str | None, Field(description="Sent along with each change as X-CSRF-Token.")
    ] = None
    expires_at: datetime | None = None


class SignIn(BaseModel):
    """A name and its password."""

    model_config = ConfigDict(extra="forbid", strict=True)

    name: Annotated[str, Field(max_length=128)]
    password: Password


class Passwords(BaseModel):
    """The present password and the one that is wanted."""

    model_config = ConfigDict(extra="forbid", strict=True)

    present: Password
    wanted: Password


def _describe(session: Session | None, csrf: str | None) -> Who:
    if session is None:
        return Who(name=None, rights=sorted(right.ANYBODY))
    return Who(
        name=session.account,
        role=session.role,
        is_administrator=session.is_administrator,
        must_change_password=session.must_change_password,
        rights=sorted(session.rights),
        csrf=csrf,
        expires_at=session.ends_at,
    )


def _set_cookie(
    response: Response, site: ConsoleContext, name: str, value: str, lasts_s: float
) -> None:
    response.set_cookie(
        name,
        value,
        max_age=round(lasts_s),
        path="/",
        secure=site.origin.has_tls,
        httponly=True,
        samesite="strict",
    )


def _drop_cookie(response: Response, site: ConsoleContext, host: str | None) -> None:
    response.delete_cookie(
        session_cookie(site.folder, host),
        path="/",
        secure=site.origin.has_tls,
        httponly=True,
        samesite="strict",
    )


@router.get("/session", responses=documented(503))
def read_session(request: Request, site: Here) -> Who:
    """Person who is signed in. A session that is over is nobody's.

    Its cookie stays: an answer that is slower than a sign-in would take the new one away.
    """
    token = access.session_token(request)
    if token is None:
        return _describe(None, None)
    try:
        holder = access.find_session(site, request, token)
    except NotSignedInError:
        return _describe(None, None)
    return _describe(holder, csrf_token(token))


@router.post("/session", responses=documented(401, 503))
def sign_in(request: Request, response: Response, site: Here, _: OutOfTurn, asked: SignIn) -> Who:
    """Sign in. What is wrong is not said; after several failures one must wait.

    Whoever comes waits for nothing that whoever sat here before has asked for.
    """
    origin = "unknown" if request.client is None else request.client.host
    host = request.headers.get("host")
    device = request.cookies.get(device_cookie(site.folder, host)) or None
    before = access.session_token(request)
    found = site.accounts.sign_in(asked.name, asked.password, origin, device)
    if before is not None:
        site.accounts.sign_out(before)  # whoever sat here before leaves nothing behind
        request.app.state.names.forget(before)
    request.app.state.names.keep(found.session_token, found.session.account)
    lasts_s = sign_in_rule.ABSOLUTE.total_seconds()
    _set_cookie(response, site, session_cookie(site.folder, host), found.session_token, lasts_s)
    lasts_s = sign_in_rule.KNOWN_DEVICE.total_seconds()
    _set_cookie(response, site, device_cookie(site.folder, host), found.device_token, lasts_s)
    return _describe(found.session, found.csrf_token)


@router.delete("/session", status_code=204, responses=documented(401, 403, 409, 503))
def sign_out(
    request: Request,
    response: Response,
    site: Here,
    _: Annotated[Session, Depends(may_change(Right.CHANGE_OWN_PASSWORD))],
) -> None:
    """Sign out; the session holds nowhere any more."""
    token = access.session_token(request)
    if token is not None:
        site.accounts.sign_out(token)
        request.app.state.names.forget(token)
    _drop_cookie(response, site, request.headers.get("host"))


@router.put("/session/password", responses=documented(401, 403, 409, 503))
def change_password(
    request: Request,
    site: Here,
    _: Annotated[Session, Depends(may_change(Right.CHANGE_OWN_PASSWORD))],
    asked: Passwords,
) -> Who:
    """Change one's own password; all other sessions of the account end."""
    token = access.session_token(request) or ""
    try:
        holder = site.accounts.change_password(token, asked.present, asked.wanted)
    except WrongPasswordError:
        problem = FieldError("present", "this is not the present password")
        raise Problem(403, "the present password is wrong", [problem]) from None
    except InputError as error:
        if type(error) is InputError:
            raise Problem(422, str(error), [FieldError("wanted", str(error))]) from None
        raise
    return _describe(holder, csrf_token(token))
