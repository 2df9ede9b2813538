"""Authentication of a request, and the check of its rights, as dependencies of the routes.

Routes take them by ``Depends``. Those that read the database are plain functions, so that they run
in a thread.

Parts of a console that its routes use: machine folder, records, accounts, hub, address.
"""

import os
import re
from collections import OrderedDict
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, NamedTuple

from fastapi import Depends, Request
from starlette.requests import HTTPConnection

from opensuction.accounts import session
from opensuction.accounts.accounts import Accounts
from opensuction.accounts.rule import right
from opensuction.accounts.rule.right import RIGHTS, Right
from opensuction.accounts.session import AccessToken, Session
from opensuction.accounts.site import NotAllowedError, NotSignedInError
from opensuction.console.guard.problem import FieldError, Problem
from opensuction.console.guard.turn import Turn
from opensuction.console.live.hub import Hub
from opensuction.kernel.errors import InputError
from opensuction.records.records import Records
from opensuction.runtime.machine_folder import About

PORT = re.compile(r":(\d{1,5})$", re.ASCII)
"""At the end of a Host header; none where it is the usual one."""


class ListeningAddress(NamedTuple):
    """Address on which the console listens."""

    host: str
    port: int
    has_tls: bool = False


class ConsoleContext(NamedTuple):
    """All that the routes go by."""

    folder: Path
    """The machine's (`runtime.machine_folder`)."""
    records: Records
    accounts: Accounts
    hub: Hub
    recordings: Path
    about: Callable[[], About]
    """Whose machine it is, as of now. Raises InputError."""
    origin: ListeningAddress


def session_cookie(folder: Path, host: str | None) -> str:
    """Name of the cookie that holds a session. folder: the machine's. host: as a request says it.

    A browser sends the cookies of a name to each port of it: machines beside each other, also of
    several users, have their own. So have two of the same name on two computers, whose ports are
    forwarded to one: they differ by the port that the browser asks at.
    """
    return f"opensuction_session_{_place(folder, host)}"


def device_cookie(folder: Path, host: str | None) -> str:
    """Name of the cookie by which a browser is known where somebody has signed in before."""
    return f"opensuction_device_{_place(folder, host)}"


def _place(folder: Path, host: str | None) -> str:
    port = PORT.search(host or "")
    own = f"{os.geteuid()}_{folder.name}"
    return own if port is None else f"{own}_{port[1]}"


CSRF_HEADER = "X-CSRF-Token"
UNATTENDED_HEADER = "X-Unattended"
"""A page looks by itself, again and again: a session does not go on for that."""
UNATTENDED = "unattended"
"""The same in an address: a page gives its sockets no header."""
BEARER = "bearer"
NAMES_KEPT = 1000
GIVEN_LATER = "in the body"
"""Stands for a reason that the route itself looks at (`check_reason`)."""

Holder = Session | AccessToken | None
"""Who asks; None: nobody who signed in."""


async def find_site(connection: HTTPConnection) -> ConsoleContext:
    """Context that the application was made with.

    Asynchronous, so that it needs no thread: a stop must not wait for one when all of them wait for
    a database that hangs.
    """
    found: ConsoleContext = connection.app.state.site
    return found


Here = Annotated[ConsoleContext, Depends(find_site)]
"""The site, as a parameter of a route."""


def find_turn(request: Request) -> Turn:
    """The place of a request that changes something among others of its session."""
    found: Turn = request.state.turn
    return found


async def wait_turn(request: Request) -> None:
    """Wait until what the same session has asked for before is done. Raises Problem."""
    await find_turn(request).wait(request.receive)


async def leave_turn(request: Request) -> None:
    """Wait for nothing, and have nothing wait: for what changes nothing that a button acts on."""
    find_turn(request).leave()


InTurn = Annotated[None, Depends(wait_turn)]
OutOfTurn = Annotated[None, Depends(leave_turn)]


def session_token(connection: HTTPConnection) -> str | None:
    """Session token in the browser's cookie; None where nobody has signed in."""
    site: ConsoleContext = connection.app.state.site
    name = session_cookie(site.folder, connection.headers.get("host"))
    return connection.cookies.get(name) or None


def _bearer_token(connection: HTTPConnection) -> str | None:
    kind, _, token = connection.headers.get("authorization", "").partition(" ")
    return token.strip() if kind.lower() == BEARER else None


class Names:
    """Accounts of recently seen session tokens, so that a stop need not wait for a database."""

    def __init__(self) -> None:
        self._known: OrderedDict[str, str] = OrderedDict()

    def keep(self, token: str, account: str) -> None:
        """Somebody was found."""
        digest = session.digest_of(token)
        self._known[digest] = account
        self._known.move_to_end(digest)
        while len(self._known) > NAMES_KEPT:
            self._known.popitem(last=False)

    def forget(self, token: str) -> None:
        """A session has ended."""
        self._known.pop(session.digest_of(token), None)

    def find(self, token: str) -> str | None:
        """Account of a session token; None for a token that was not seen."""
        return self._known.get(session.digest_of(token))


def find_name(connection: HTTPConnection) -> str | None:
    """The account of whoever asks, for the record alone: nothing is allowed by it."""
    token, names = session_token(connection), connection.app.state.names
    return None if token is None else names.find(token)


def find_session(site: ConsoleContext, connection: HTTPConnection, token: str) -> Session:
    """Session of a token. It goes on from now, unless a page asks by itself.

    Raises NotSignedInError for one that is over.
    """
    accounts = site.accounts
    is_unattended = UNATTENDED_HEADER in connection.headers or UNATTENDED in connection.query_params
    find = accounts.check_session if is_unattended else accounts.find_session
    try:
        holder = find(token)
    except NotSignedInError:
        connection.app.state.names.forget(token)
        raise
    connection.app.state.names.keep(token, holder.account)
    return holder


def find_holder(site: ConsoleContext, connection: HTTPConnection) -> Holder:
    """Holder of a request that changes nothing. Raises NotSignedInError for an ended session."""
    bearer = _bearer_token(connection)
    if bearer is not None:
        return site.accounts.find_token(bearer)
    token = session_token(connection)
    return None if token is None else find_session(site, connection, token)


def _require(holder: Holder, wanted: Right) -> None:
    reason = GIVEN_LATER if RIGHTS[wanted].needs_reason else None
    session.require(holder, wanted, reason)


def may(wanted: Right) -> Callable[[HTTPConnection, ConsoleContext], Holder]:
    """A dependency that lets through who may see something, and says who that is.

    What anybody may see asks no database, and nobody's name is known.
    """

    def find(connection: HTTPConnection, site: Here) -> Holder:
        if wanted in right.ANYBODY:
            return None
        holder = find_holder(site, connection)
        _require(holder, wanted)
        return holder

    return find


def may_change(wanted: Right) -> Callable[[HTTPConnection, ConsoleContext, None], Session]:
    """A dependency that lets through who may change something: signed in, from the page itself.

    In the session's turn: not before what was asked for before is done, and right and session are
    those of then. The reason, where the right needs one, is the route's to check (`check_reason`).
    """

    def find(connection: HTTPConnection, site: Here, _: InTurn) -> Session:
        return allow_change(site, connection, wanted)

    return find


def may_begin(wanted: Right) -> Callable[[HTTPConnection, ConsoleContext, None], Session]:
    """As `may_change`, out of turn: for work on records that changes nothing and takes long."""

    def find(connection: HTTPConnection, site: Here, _: OutOfTurn) -> Session:
        return allow_change(site, connection, wanted)

    return find


def allow_change(site: ConsoleContext, connection: HTTPConnection, wanted: Right) -> Session:
    """Session of a request for a change, if its holder may. Raises errors of `accounts.site`."""
    if _bearer_token(connection) is not None:
        raise NotAllowedError("a token of another program changes nothing")
    token = session_token(connection)
    if token is None:
        raise NotSignedInError("sign in first")
    shown = connection.headers.get(CSRF_HEADER)
    try:
        session.check_csrf(token, shown or "")
        holder = find_session(site, connection, token)
        _require(holder, wanted)
    except NotAllowedError as error:
        connection.app.state.refused.note(find_name(connection), str(wanted), str(error))
        raise
    return holder


def check_reason(reason: str | None) -> str:
    """The reason of a right that needs one; a problem of the field ``reason`` where it is none."""
    try:
        session.check_reason(reason)
    except InputError as refused:
        raise Problem(422, str(refused), [FieldError("reason", str(refused))]) from None
    return reason or ""
