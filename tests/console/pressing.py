"""People who press one thing after another at a console that listens, the first one held back."""

import json
import socket
import threading
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any

import httpx
import pytest

from opensuction.console.guard import body
from tests.console.served import HOST, Served

LONG_S = 60.0
"""Longer than anything here takes, on a computer however busy."""
REQUESTS = "/requests"


class Held:
    """Where the first request of somebody waits inside: as at a database that is slow."""

    def __init__(self) -> None:
        self.has_come, self.may_go = threading.Event(), threading.Event()
        self.fails = False
        self._is_taken = threading.Lock()

    def wait(self) -> None:
        """Hold whoever comes first; all others pass."""
        if self._is_taken.acquire(blocking=False):
            self.has_come.set()
            assert self.may_go.wait(LONG_S)
            if self.fails:
                raise RuntimeError("the database is gone")


class Pressing:
    """Several people, each request by a connection of its own."""

    def __init__(self, console: Served, arrived: threading.Semaphore) -> None:
        self.console, self.held = console, Held()
        self._arrived = arrived
        self._threads = ThreadPoolExecutor(16)
        self._count = 0

    def send(
        self, role: str | None, path: str, sent: dict[str, Any], method: str = "POST"
    ) -> Future[httpx.Response]:
        """Ask, and return once the console has the whole request; the answer comes later."""
        answer = self._threads.submit(
            httpx.request,
            method,
            f"{self.console.url}/api/v1{path}",
            json=sent,
            headers=self.console.headers(role),
            cookies=self.console.cookies(role),
            timeout=LONG_S,
        )
        assert self._arrived.acquire(timeout=LONG_S)
        return answer

    def press(self, role: str | None, ask: str) -> Future[httpx.Response]:
        """Press a button."""
        return self.send(role, REQUESTS, self.button(ask))

    def button(self, ask: str) -> dict[str, str]:
        """What a page sends for a button, with a key of its own."""
        self._count += 1
        return {"ask": ask, "key": f"key-{self._count:06}"}

    def hold(self, role: str, path: str, sent: dict[str, Any], method: str = "POST") -> Any:
        """Ask, and return once the request waits inside."""
        answer = self.send(role, path, sent, method)
        assert self.held.has_come.wait(LONG_S)
        return answer

    def let_others_be_faster(self) -> None:
        """Return once whatever was free to reach the machine before this has done so.

        Somebody else's button, pressed later, is answered: it goes the same way, and takes as long.
        """
        assert self.press("engineer", "reset").result(LONG_S).status_code == 200

    @contextmanager
    def line(
        self, role: str | None, sent: dict[str, Any], shown: int | None = None
    ) -> Iterator[Any]:
        """A connection by which somebody sends a button; what it sends is closed with it.

        shown: so many bytes of the body are sent; None: all of it.
        """
        whole = self.bytes_of(sent)
        cookies = "; ".join(f"{name}={value}" for name, value in self.console.cookies(role).items())
        head = "".join(
            f"{name}: {value}\r\n"
            for name, value in {
                "Host": f"{HOST}:{self.console.site.origin.port}",
                "Cookie": cookies,
                "Content-Type": "application/json",
                "Content-Length": str(len(whole)),
                **self.console.headers(role),
            }.items()
        )
        with socket.create_connection((HOST, self.console.site.origin.port), LONG_S) as made:
            made.sendall(f"POST /api/v1{REQUESTS} HTTP/1.1\r\n{head}\r\n".encode() + whole[:shown])
            yield made

    @staticmethod
    def bytes_of(sent: dict[str, Any]) -> bytes:
        """A body as `line` sends it."""
        return json.dumps(sent).encode()

    @property
    def pressed(self) -> list[str]:
        """What the clinician, or nobody who signed in, has pressed, as it came to the machine."""
        return [ask for ask, who in self.console.machine.pressed if who != "bert"]

    def end(self) -> None:
        """Nothing is held any more, and everybody has an answer."""
        self.held.may_go.set()
        self._threads.shutdown()


@contextmanager
def pressing(console: Served, monkeypatch: pytest.MonkeyPatch) -> Iterator[Pressing]:
    """The clinician's first request, whatever it asks for, waits inside until it may go on."""
    arrived = threading.Semaphore(0)
    find, again = console.site.accounts.find_session, body.again
    slow = console.signed_in["clinician"].session_token

    def find_slowly(token: str) -> Any:
        if token == slow:
            people.held.wait()
        return find(token)

    def note(*given: Any) -> Any:
        arrived.release()
        return again(*given)

    people = Pressing(console, arrived)
    monkeypatch.setattr(console.site.accounts, "find_session", find_slowly)
    monkeypatch.setattr(body, "again", note)
    try:
        yield people
    finally:
        people.end()
