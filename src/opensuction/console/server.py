"""The console's network server: it closes connections that send too little for too long.

A server that waits for the rest of a request as long as somebody likes can be kept busy by one who
sends a letter a minute.
"""

import asyncio
from collections.abc import Iterator
from contextlib import contextmanager
from ssl import SSLContext

import uvicorn
from starlette.types import ASGIApp
from uvicorn.protocols.http.h11_impl import H11Protocol, RequestResponseCycle
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from opensuction.console.guard import problem
from opensuction.console.guard.guard import MADE_S
from opensuction.console.guard.origin import is_loopback
from opensuction.console.guard.problem import MEDIA_TYPE, Problem

HEADERS_S = 10.0
"""Within this time a request has said all but its body."""
HEADERS_BYTES = 16_384
KEPT_S = 30
"""A connection on which nothing is asked any more is kept for so long."""
CONNECTIONS_HERE, CONNECTIONS_ELSEWHERE = 400, 64
"""Open at once, of this computer and of another address: a page takes up to eight."""
MESSAGE_BYTES = 4096
"""Of what a page says by a socket; it has nothing to say."""
PING_S = 10.0
"""A page that answers no ping for so long is gone."""
ENDS_S = 2
"""Within this time what is asked is answered when the console ends."""
NEEDED = (0, 0.0)
BAD_REQUEST = 400


class HastyProtocol(H11Protocol):
    """Waits for a whole request, but not for ever; and has not too many of the same address.

    One too many takes the place of the most expendable: a flood costs who makes it.
    """

    headers_s = HEADERS_S

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """See `asyncio.Protocol`."""
        super().connection_made(transport)
        self._timer: asyncio.TimerHandle | None = None
        self._heard = 0
        self._made_s = self.loop.time()
        # Each request's state is a copy of this.
        self.app_state = {**self.app_state, MADE_S: self._made_s}
        peer = self.client[0] if self.client else "unknown"
        others = [
            one
            for one in self.connections
            if isinstance(one, HastyProtocol) and one is not self and one._is_of(peer)
        ]
        most = CONNECTIONS_HERE if is_loopback(peer) else CONNECTIONS_ELSEWHERE
        if len(others) >= most:
            self.logger.warning("too many connections from %s", peer)
            # Or who opens many keeps everybody else of the same address or proxy out.
            gone = max(others, key=HastyProtocol._expendable)
            if gone._expendable() == NEEDED:
                gone = self
            gone.transport.abort()
            if gone is self:
                return
        self._wait()

    def _is_of(self, peer: str) -> bool:
        """Tell whether it is an open connection of this address."""
        is_open = not self.transport.is_closing()
        return is_open and self.client is not None and self.client[0] == peer

    def _expendable(self) -> tuple[int, float]:
        """Rank of a connection, the highest loses least; `NEEDED` where it is being answered.

        First those that have never asked and wait, then those that wait for a body, the oldest of
        each; then those that have nothing to say now, of them who has asked most.
        """
        age_s = self.loop.time() - self._made_s
        if self._is_waiting():
            cycle: RequestResponseCycle | None = self.cycle  # None before the first request
            return (3, age_s) if cycle is None else (1, self._heard)
        return (2, age_s) if self.cycle.more_body else NEEDED

    def data_received(self, data: bytes) -> None:
        """See `asyncio.Protocol`."""
        super().data_received(data)
        self._heard += 1
        if self._is_waiting():
            self._wait()
        else:
            self._wait_no_more()

    def connection_lost(self, exc: Exception | None) -> None:
        """See `asyncio.Protocol`."""
        self._wait_no_more()
        super().connection_lost(exc)

    def _is_waiting(self) -> bool:
        """True while a part of a request is there, and the rest is not."""
        if self.transport.is_closing() or self.transport.get_protocol() is not self:
            return False
        cycle: RequestResponseCycle | None = self.cycle  # before the first request there is none
        return cycle is None or cycle.response_complete

    def _wait(self) -> None:
        if self._timer is None:
            self._timer = self.loop.call_later(self.headers_s, self._give_up)

    def _wait_no_more(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _give_up(self) -> None:
        self._timer = None
        if self._is_waiting():
            self.transport.abort()

    def send_400_response(self, msg: str) -> None:  # noqa: ARG002 - not for who sent it
        """Answer input that is no HTTP request with a problem, as every refusal."""
        body = bytes(problem.answer(Problem(BAD_REQUEST, "this is no request of HTTP")).body)
        head = (
            "HTTP/1.1 400 Bad Request",
            f"Content-Type: {MEDIA_TYPE}",
            f"Content-Length: {len(body)}",
            "Cache-Control: no-store",
            "X-Content-Type-Options: nosniff",
            "Connection: close",
        )
        self.transport.write("\r\n".join((*head, "", "")).encode() + body)
        self.transport.close()


class PageProtocol(WebSocketsSansIOProtocol):
    """A page's socket, which may hang up in the same moment as the console ends."""

    def shutdown(self) -> None:
        """See `uvicorn.Server.shutdown`."""
        if self.transport.is_closing():
            # Goodbyes are exchanged already; another would be an error that ends the console.
            self.stop_keepalive()
        else:
            super().shutdown()


class Server(uvicorn.Server):
    """Ends when it is told to, by whoever runs it: signals are not its business."""

    @contextmanager
    def capture_signals(self) -> Iterator[None]:
        """See `uvicorn.Server`."""
        yield


def make_server(app: ASGIApp, context: SSLContext | None = None) -> Server:
    """Server of an application on sockets that listen already. context: speaks HTTPS."""
    config = uvicorn.Config(
        app,
        http=HastyProtocol,
        ws=PageProtocol,
        loop="asyncio",
        lifespan="on",
        log_config=None,
        access_log=False,
        proxy_headers=False,
        server_header=False,
        h11_max_incomplete_event_size=HEADERS_BYTES,
        timeout_keep_alive=KEPT_S,
        timeout_graceful_shutdown=ENDS_S,
        ws_max_size=MESSAGE_BYTES,
        ws_ping_interval=PING_S,
        ws_ping_timeout=PING_S,
        ws_per_message_deflate=False,
        ssl_context_factory=None if context is None else lambda *_: context,
    )
    return Server(config)
