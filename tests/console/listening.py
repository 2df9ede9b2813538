"""A console that listens at a real port, in a thread of this process."""

import asyncio
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from ssl import SSLContext

from fastapi import FastAPI

from opensuction.console.console_process import Server, make_server
from opensuction.console.guard.limits import USUAL, Limits
from opensuction.session.running import console_settings
from tests.console.served import HOST, Served, free_port, served

ENDS_S = 10.0


@contextmanager
def listening(folder: Path, limits: Limits = USUAL, name: str = "room") -> Iterator[Served]:
    """The same at a free port of this computer, for browsers: `Served.url`."""
    with (
        served(folder, free_port(), limits, name) as made,
        listening_app(made.app, made.site.origin.port),
    ):
        yield made


@contextmanager
def listening_app(app: FastAPI, port: int, context: SSLContext | None = None) -> Iterator[Server]:
    """An application that listens, in a thread. context: by HTTPS.

    Whoever connects before it has started waits in the socket's queue.
    """
    with console_settings.listen(HOST, port) as listening:
        server = make_server(app, context)
        thread = threading.Thread(target=_run, args=(server, listening), daemon=True)
        thread.start()
        try:
            yield server
        finally:
            server.should_exit = True
            thread.join(ENDS_S)


def _run(server: Server, listening: socket.socket) -> None:
    asyncio.run(server.serve(sockets=[listening]))
