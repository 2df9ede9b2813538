"""Signing in and out, and one's own password. The session is a cookie that no script reads."""

from datetime import datetime
from typing import Annotated

from fastapi import APIRouter, Depends, Request, Response
from pydantic import BaseModel, ConfigDict, Field

from opensuction.accounts import secret
from opensuction.accounts.refusal import NotSignedInError, WrongPasswordError
from opensuction.accounts.rule import lifetime, right
from opensuction.accounts.rule.password import LONGEST_TYPED
from opensuction.accounts.rule.right import Right
from opensuction.accounts.session import Session
from opensuction.console import access
from opensuction.console.access import Here, OutOfTurn, may_change
from opensuction.console.guard.problem import FieldError, Problem, documented
from opensuction.console.site import ConsoleContext, device_cookie, session_cookie
from opensuction.kernel.errors import InputError

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
    return _describe(holder, secret.csrf_token(token))


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
    lasts_s = lifetime.ABSOLUTE.total_seconds()
    _set_cookie(response, site, session_cookie(site.folder, host), found.session_token, lasts_s)
    lasts_s = lifetime.DEVICE.total_seconds()
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
    return _describe(holder, secret.csrf_token(token))
