"""The console as a process: ``python -m opensuction.console.console_process DIR``.

In DIR lies what it is set to (`session.running.console_settings`). It gives a sign of life as long
as it answers; when it dies the controller goes on, tells people, and another one is started.
"""

import asyncio
import gc
import logging
import signal
import socket
import sys
import threading
import time
from collections.abc import Callable
from io import TextIOWrapper
from logging.handlers import RotatingFileHandler
from pathlib import Path

from opensuction.accounts.accounts import Accounts
from opensuction.console.app import create_app
from opensuction.console.guard.throttle import Throttle
from opensuction.console.live.hub import Hub
from opensuction.console.server import Server, make_server
from opensuction.console.site import ConsoleContext, ListeningAddress
from opensuction.ipc.heartbeat import Heartbeat, Process
from opensuction.ipc.process_lock import ProcessLock
from opensuction.kernel import private_file
from opensuction.kernel.errors import InputError
from opensuction.records.database.failure import RecordsError
from opensuction.records.records import Records
from opensuction.runtime import machine_identity
from opensuction.runtime.paths import CONSOLES
from opensuction.session.running import console_settings
from opensuction.session.running.console_settings import ConsoleSettings

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
        about=lambda: machine_identity.read(folder),
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
    except InputError as problem:
        sys.exit(f"opensuction: {problem}")
