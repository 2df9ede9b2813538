"""The console as a process: ``python -m opensuction.console.console_process DIR``.

In DIR lies what it is set to (`session.running.console_settings`). It gives a sign of life as long
as it answers; when it dies the controller goes on, tells people, and another one is started.

The console's network server: it closes connections that send too little for too long.

A server that waits for the rest of a request as long as somebody likes can be kept busy by one who
sends a letter a minute.

A log that nobody can flood: so many lines, then one that says how many were left out.
"""

import asyncio
import gc
import logging
import signal
import socket
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from io import TextIOWrapper
from logging.handlers import RotatingFileHandler
from pathlib import Path
from ssl import SSLContext

import uvicorn
from starlette.types import ASGIApp
from uvicorn.protocols.http.h11_impl import H11Protocol, RequestResponseCycle
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from opensuction.accounts.accounts import Accounts
from opensuction.console.access import ConsoleContext, ListeningAddress
from opensuction.console.app import create_app
from opensuction.console.guard import problem
from opensuction.console.guard.guard import MADE_S
from opensuction.console.guard.limits import Buckets
from opensuction.console.guard.origin import is_loopback
from opensuction.console.guard.problem import MEDIA_TYPE, Problem
from opensuction.console.live.hub import Hub
from opensuction.ipc.liveness import Heartbeat, Process, ProcessLock
from opensuction.kernel import private_file
from opensuction.kernel.errors import InputError
from opensuction.records.database.failure import RecordsError
from opensuction.records.records import Records
from opensuction.runtime import machine_folder
from opensuction.runtime.machine_folder import CONSOLES
from opensuction.session.running import console_settings
from opensuction.session.running.console_settings import ConsoleSettings

RATE_HZ, MOST = 5.0, 100.0


class Throttle(logging.Filter):
    """Of a handler."""

    def __init__(self, buckets: Buckets | None = None) -> None:
        super().__init__()
        self._buckets = buckets or Buckets(RATE_HZ, MOST)
        self._left_out = 0
        self._lock = threading.Lock()

    def filter(self, record: logging.LogRecord) -> bool:
        """See `logging.Filter`."""
        with self._lock:
            if self._buckets.take("line"):
                self._left_out += 1
                return False
            if self._left_out:
                record.msg = f"{record.getMessage()} ({self._left_out} lines before it left out)"
                record.args = ()
                self._left_out = 0
            return True


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
        self._made_s = self._heard_s = self.loop.time()
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
            max(others, key=HastyProtocol._expendable).transport.abort()
        self._wait()

    def _is_of(self, peer: str) -> bool:
        """Tell whether it is an open connection of this address."""
        is_open = not self.transport.is_closing()
        return is_open and self.client is not None and self.client[0] == peer

    def _expendable(self) -> tuple[int, float]:
        """Rank of a connection, the highest loses least.

        First those that have never asked and wait, then those that wait for a body, the oldest of
        each; then those that have nothing to say now, of them who has asked most. Last those that
        are being answered, of them the one that has waited longest: it has been heard, and loses an
        answer at most, where a new one that was refused might be a stop that nobody hears.
        """
        now_s = self.loop.time()
        age_s = now_s - self._made_s
        if self._is_waiting():
            cycle: RequestResponseCycle | None = self.cycle  # None before the first request
            return (3, age_s) if cycle is None else (1, self._heard)
        return (2, age_s) if self.cycle.more_body else (0, now_s - self._heard_s)

    def data_received(self, data: bytes) -> None:
        """See `asyncio.Protocol`."""
        super().data_received(data)
        self._heard += 1
        self._heard_s = self.loop.time()
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


LOG = logging.getLogger("opensuction.console")
LOG_FILE, LOG_BYTES = "console.log", 1_000_000
"""In the machine's folder, which lies in memory: no more than twice this."""
BEATS_S = 0.1
STUCK_S = 2.0
"""An event loop that has done nothing for longer than this answers nobody: no sign of life."""
AGAIN_S = 1.0
"""Between two tries to open the records."""
SWITCHES_S = 0.001
"""Longest turn of a thread while another waits: a stop is not to wait longer for what computes."""


class Pulse:
    """Signs of life, in a thread of its own: a long computation in another one is no death."""

    def __init__(self, folder: Path, server: Server) -> None:
        self._heartbeat, self._server = Heartbeat(folder), server
        self._seen_s = time.monotonic()
        self._is_over = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True, name="pulse")

    async def keep(self) -> None:
        """Show that the event loop goes on."""
        self._thread.start()
        while True:
            self._seen_s = time.monotonic()
            await asyncio.sleep(BEATS_S)

    def end(self) -> None:
        """It ends as it should."""
        self._is_over.set()
        if self._thread.is_alive():
            self._thread.join()
        self._heartbeat.end(Process.CONSOLE)

    def _run(self) -> None:
        while not self._server.started:
            if self._is_over.wait(BEATS_S):
                return
        self._heartbeat.begin(Process.CONSOLE)
        while not self._is_over.wait(BEATS_S):
            if time.monotonic() - self._seen_s < STUCK_S:
                self._heartbeat.beat(Process.CONSOLE)


class PrivateLog(RotatingFileHandler):
    """A log that only this user may read: it holds addresses of people."""

    def _open(self) -> TextIOWrapper:
        return TextIOWrapper(private_file.append(Path(self.baseFilename)), "utf-8", self.errors)


def _log_to(folder: Path) -> None:
    """Log refusals and failures to a file of bounded size."""
    handler = PrivateLog(folder / LOG_FILE, maxBytes=LOG_BYTES, backupCount=1)
    handler.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(message)s"))
    handler.addFilter(Throttle())
    root = logging.getLogger()
    root.addHandler(handler)
    root.setLevel(logging.WARNING)


def _open_records(database: str | None, is_over: Callable[[], bool]) -> Records | None:
    """The records, as soon as they are there; None where the process shall end before."""
    said = ""
    while not is_over():
        try:
            return Records.open(database)
        except RecordsError as error:
            if str(error) != said:
                said = str(error)
                LOG.error("waiting for the records: %s", said)
            time.sleep(AGAIN_S)
    return None


def _site(folder: Path, settings: ConsoleSettings, records: Records) -> ConsoleContext:
    return ConsoleContext(
        folder=folder,
        records=records,
        accounts=Accounts(records.database),
        hub=Hub(folder),
        recordings=Path(settings.recordings),
        about=lambda: machine_folder.read(folder),
        origin=ListeningAddress(settings.host, settings.port, settings.has_tls),
    )


def serve(folder: Path) -> None:
    """Serve until the process is told to end. Raises InputError where it cannot begin."""
    ending: list[int] = []
    signal.signal(signal.SIGTERM, lambda number, _: ending.append(number))
    with ProcessLock(folder / CONSOLES, "a console runs"):
        settings = console_settings.read(folder)
        _log_to(folder)
        sys.setswitchinterval(SWITCHES_S)
        context = None
        if settings.certificate is not None and settings.key is not None:
            context = console_settings.make_context(Path(settings.certificate), Path(settings.key))
        with console_settings.listen(settings.host, settings.port) as listening:
            records = _open_records(settings.database, lambda: bool(ending))
            if records is None:
                return
            with records:
                server = make_server(create_app(_site(folder, settings, records)), context)
                # What was built until now stays: a whole collection of garbage that went through
                # it kept the event loop, and a stop, waiting for .3 s.
                gc.collect()
                gc.freeze()
                asyncio.run(_serve(folder, server, listening, ending))


async def _serve(folder: Path, server: Server, listening: socket.socket, ending: list[int]) -> None:
    def end() -> None:
        server.should_exit = True

    asyncio.get_running_loop().add_signal_handler(signal.SIGTERM, end)
    server.should_exit = bool(ending)
    pulse = Pulse(folder, server)
    beating = asyncio.create_task(pulse.keep())
    try:
        await server.serve(sockets=[listening])
    finally:
        beating.cancel()
        pulse.end()


if __name__ == "__main__":
    try:
        serve(Path(sys.argv[1]))
    except InputError as error:
        sys.exit(f"opensuction: {error}")
