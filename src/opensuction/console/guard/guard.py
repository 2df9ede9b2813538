"""The first check of every request: it must be of this host and origin, and within the limits.

A request from another host or origin, too large, too slow or too frequent is refused with a
problem, and logged without anything secret. Every answer, also after a failure inside, gets the
headers of `header`.

Headers of every answer: what a browser may do with it. Source: [OWASP-Headers].
"""

import asyncio
import logging
import math
import time
from collections import Counter
from collections.abc import AsyncIterator, Callable, Iterable
from contextlib import asynccontextmanager
from http.cookies import CookieError, SimpleCookie

from starlette.datastructures import Headers
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from opensuction.console.guard import body, origin, problem
from opensuction.console.guard.limits import PREFIX, PRESSES, Limits, Rates
from opensuction.console.guard.problem import Problem
from opensuction.console.guard.turn import Turns
from opensuction.settings.wording import one_line

CSP = "; ".join(
    (
        "default-src 'none'",
        "script-src 'self'",
        "style-src 'self'",
        "connect-src 'self'",
        "img-src 'self' data:",
        "font-src 'self'",
        "media-src 'self'",
        "worker-src 'self'",
        "frame-src 'self'",
        "base-uri 'none'",
        "form-action 'none'",
        "frame-ancestors 'none'",
    )
)
"""Only what lies here, nothing inline. A route whose page needs another one says so itself."""
SECURITY = {
    "content-security-policy": CSP,
    "x-content-type-options": "nosniff",
    "x-frame-options": "DENY",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "cross-origin-embedder-policy": "require-corp",
    "permissions-policy": "camera=(), microphone=(), geolocation=(), payment=(), usb=()",
    "x-permitted-cross-domain-policies": "none",
}
TLS = {"strict-transport-security": "max-age=31536000"}
NO_STORE, NO_CACHE = "no-store", "no-cache"

Raw = list[tuple[bytes, bytes]]


def complete(given: Iterable[tuple[bytes, bytes]], is_interface: bool, has_tls: bool) -> Raw:
    """The headers of an answer with those that are missing; what a route has set stays.

    is_interface: what it says holds now and for this person, and is kept nowhere.
    """
    found = list(given)
    names = {name.lower() for name, _ in found}
    wanted = {**SECURITY, "cache-control": NO_STORE if is_interface else NO_CACHE}
    if has_tls:
        wanted |= TLS
    for name, value in wanted.items():
        if name.encode() not in names:
            found.append((name.encode(), value.encode()))
    return found


LOG = logging.getLogger("opensuction.console")
FAILED = "this did not work; the log of the console says why. To stop the machine goes on working"
LONGEST_PATH = 200
REFUSED = 1008
"""Code of a socket that is closed for what it asked."""
FAILS, TOO_OFTEN = 500, 429
MADE_S = "made_s"
"""Of a request's state: when its connection was made, monotonic; without it is an old one."""
SCHEMES = {"http": "http", "https": "https", "ws": "http", "wss": "https"}


class Guard:
    """Around the whole application."""

    def __init__(
        self,
        app: ASGIApp,
        limits: Limits,
        rates: Rates,
        hosts: frozenset[str] | None,
        cookie: Callable[[str | None], str],
    ) -> None:
        """hosts: see `origin.hosts_of`. cookie: name of the session's, by the Host."""
        self.app, self._limits, self._rates = app, limits, rates
        self._hosts, self._cookie = hosts, cookie
        self._turns = Turns(limits)
        self._often = asyncio.Semaphore(limits.more_at_once)
        self._sockets: Counter[str] = Counter()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """See ASGI."""
        if scope["type"] == "http":
            await self._serve(scope, receive, send)
        elif scope["type"] == "websocket":
            await self._serve_socket(scope, receive, send)
        else:
            await self.app(scope, receive, send)

    async def _serve(self, scope: Scope, receive: Receive, send: Send) -> None:
        begun_s = time.monotonic()
        is_interface = scope["path"].startswith(PREFIX)
        has_tls = scope["scheme"] == "https"
        status = 0

        async def answer(message: Message) -> None:
            nonlocal status
            if message["type"] == "http.response.start":
                status = message["status"]
                given = message.get("headers", ())
                message["headers"] = complete(given, is_interface, has_tls)
            await send(message)

        async def refuse(refused: Problem) -> None:
            await problem.answer(refused)(scope, receive, answer)

        try:
            headers = Headers(scope=scope)
            self._check(scope, headers)
            body.check_length(self._limits, headers.get("content-length"))
            await self._pass_on(scope, headers, receive, answer)
        except Problem as refused:
            if refused.status == TOO_OFTEN:
                # Told at once, who floods asks again at once, and the event loop only refuses.
                await asyncio.sleep(self._limits.refused_s)
            await refuse(refused)
        except body.GoneError:
            pass
        except Exception:
            LOG.exception("%s %s failed", scope["method"], _path(scope))
            if status == 0:
                await refuse(Problem(FAILS, FAILED))
            else:
                raise
        finally:
            _log(scope, status, begun_s)

    async def _pass_on(self, scope: Scope, headers: Headers, receive: Receive, send: Send) -> None:
        """Take the body, then ask the application; a change has its place before its body comes."""
        if scope["method"] in origin.SAFE:
            whole = await body.read(self._limits, receive)
            await self.app(scope, body.again(whole, receive), send)
            return
        with self._turns.take(self._session(headers)) as turn:
            scope.setdefault("state", {})["turn"] = turn
            whole = await body.read(self._limits, receive)
            body.check_keys(whole, is_press=scope["path"] == PRESSES)
            turn.arrive()
            # Not before: a press that is never ended would hold one of the few.
            async with self._place(scope):
                await self.app(scope, body.again(whole, receive), send)

    @asynccontextmanager
    async def _place(self, scope: Scope) -> AsyncIterator[None]:
        """Keep a place for a press; a connection that presses often waits for others that do."""
        peer, port = scope.get("client") or ("unknown", 0)
        age_s = time.monotonic() - scope.get("state", {}).get(MADE_S, -math.inf)
        if scope["path"] != PRESSES or self._rates.is_a_first_press(peer, port, age_s):
            yield
            return
        async with self._often:
            # Or the flood would have all of a core.
            await asyncio.sleep(self._limits.more_s)
            yield

    def _check(self, scope: Scope, headers: Headers) -> None:
        """Raises Problem for what goes no further."""
        peer = _peer(scope)
        method = scope.get("method", "GET")
        is_socket = scope["type"] == "websocket"
        if why := origin.refuse_host(self._hosts, headers.get("host")):
            raise Problem(421, why)
        is_guarded = is_socket or scope["path"].startswith(PREFIX)
        scheme = SCHEMES.get(str(scope["scheme"]), "http")
        # To stop is obeyed without one, and is known by its body: the route asks of other buttons.
        needs_origin = is_socket or (method not in origin.SAFE and scope["path"] != PRESSES)
        if is_guarded and (why := origin.refuse_origin(headers, scheme, needs_origin)):
            raise Problem(403, why)
        _, port = scope.get("client") or ("", 0)
        self._rates.check(method, scope["path"], peer, port, self._session(headers))

    def _session(self, headers: Headers) -> str | None:
        """Session token that the cookie shows; it is not verified here."""
        try:
            found = SimpleCookie(headers.get("cookie", "")).get(self._cookie(headers.get("host")))
        except CookieError:
            return None
        return None if found is None else found.value

    async def _serve_socket(self, scope: Scope, receive: Receive, send: Send) -> None:
        peer, begun_s = _peer(scope), time.monotonic()
        has_tls = scope["scheme"] == "wss"

        async def tell(message: Message) -> None:
            if message["type"] == "websocket.http.response.start":
                message["headers"] = complete(message.get("headers", ()), True, has_tls)
            await send(message)

        try:
            self._check(scope, Headers(scope=scope))
            self._check_sockets(peer)
        except Problem as refused:
            _log(scope, refused.status, begun_s)
            await _refuse_socket(problem.answer(refused), scope, receive, tell)
            return
        self._sockets[peer] += 1
        try:
            await self.app(scope, receive, tell)
        except Exception:
            LOG.exception("socket %s failed", _path(scope))
        finally:
            self._sockets[peer] -= 1
            if not self._sockets[peer]:
                del self._sockets[peer]

    def _check_sockets(self, peer: str) -> None:
        limits = self._limits
        most = limits.sockets_here if origin.is_loopback(peer) else limits.sockets_elsewhere
        if self._sockets.total() >= limits.sockets or self._sockets[peer] >= most:
            raise Problem(429, "too many pages listen already", headers={"Retry-After": "5"})


async def _refuse_socket(answer: Response, scope: Scope, receive: Receive, send: Send) -> None:
    if "websocket.http.response" not in scope.get("extensions", {}):
        await send({"type": "websocket.close", "code": REFUSED, "reason": ""})
        return

    async def translate(message: Message) -> None:
        await send({**message, "type": f"websocket.{message['type']}"})

    await answer({**scope, "type": "http", "method": "GET"}, receive, translate)


def _peer(scope: Scope) -> str:
    client = scope.get("client")
    return "unknown" if client is None else str(client[0])


def _path(scope: Scope) -> str:
    """As a log may have it: without what was asked in it."""
    return one_line(str(scope["path"]))[:LONGEST_PATH]


def _log(scope: Scope, status: int, begun_s: float) -> None:
    """A line for what was refused or failed; the rest only for who looks for it."""
    level = logging.WARNING if status >= 400 or status == 0 else logging.DEBUG
    if not LOG.isEnabledFor(level):
        return
    method = scope.get("method", "socket")
    what = f"{status} {method} {_path(scope)} from {_peer(scope)}"
    LOG.log(level, "%s (%.0f ms)", what, 1e3 * (time.monotonic() - begun_s))
