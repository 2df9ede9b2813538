"""A console as it is served: the real application, real records, people of each role, a machine."""

import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from fastapi import FastAPI
from starlette.testclient import TestClient, WebSocketTestSession

from opensuction.accounts.accounts import Accounts
from opensuction.accounts.sign_in import SignedIn
from opensuction.console.access import (
    CSRF_HEADER,
    ConsoleContext,
    ListeningAddress,
    device_cookie,
    session_cookie,
)
from opensuction.console.app import create_app
from opensuction.console.guard.limits import USUAL, Limits
from opensuction.console.live.hub import Hub
from opensuction.records.records import Records
from opensuction.runtime import machine_folder
from tests.accounts.example import CHEAP, PASSWORDS, ROLES, employ, enter
from tests.console.written_machine import WrittenMachine

HOST, PORT = "127.0.0.1", 8080
PEOPLE = {role: name for name, role in ROLES.items()} | {"administrator": "admin"}
"""Who has which role: ``clinician``, ``engineer``, ``observer``, ``administrator``."""


class Served(NamedTuple):
    """The parts of it."""

    app: FastAPI
    site: ConsoleContext
    machine: WrittenMachine
    signed_in: dict[str, SignedIn]
    """By role."""

    @property
    def host(self) -> str:
        """As a request says it."""
        return f"{self.site.origin.host}:{self.site.origin.port}"

    @property
    def url(self) -> str:
        """Where it believes to be."""
        return f"http://{self.host}"

    def headers(self, role: str | None) -> dict[str, str]:
        """What a page sends along that somebody of this role has signed in to."""
        found = {"Origin": self.url}
        if role is not None:
            found[CSRF_HEADER] = self.signed_in[role].csrf_token
        return found

    def cookies(self, role: str | None) -> dict[str, str]:
        """What a browser shows where somebody of this role has signed in; None: nobody."""
        if role is None:
            return {}
        found = self.signed_in[role]
        return {
            self.session_cookie: found.session_token,
            self.device_cookie: found.device_token,
        }

    @property
    def session_cookie(self) -> str:
        """Name of the cookie that holds a session."""
        return session_cookie(self.site.folder, self.host)

    @property
    def device_cookie(self) -> str:
        """Name of the one by which a browser is known."""
        return device_cookie(self.site.folder, self.host)

    def client(self, role: str | None = None, port: int = 50000) -> TestClient:
        """The application without a network, as somebody of this role; None: nobody.

        port: by which it tells one connection from another.
        An error within is an answer, as it is for a browser. Used as a context it has its lifespan.
        """
        return TestClient(
            self.app,
            self.url,
            raise_server_exceptions=False,
            headers=self.headers(role),
            cookies=self.cookies(role),
            client=(HOST, port),
        )

    @contextmanager
    def listen(self, client: TestClient, path: str) -> Iterator[WebSocketTestSession]:
        """A socket of the interface, such as ``/live``; client: within its context."""
        address = f"{self.url}/api/v1{path}".replace("http", "ws", 1)
        with client.websocket_connect(address) as socket:
            yield socket

    @staticmethod
    def password(role: str) -> str:
        """Of the person of this role."""
        return PASSWORDS[PEOPLE[role]]


def employ_all(accounts: Accounts) -> dict[str, SignedIn]:
    """An administrator and somebody of each role, signed in."""
    made = accounts.first_start()
    assert made is not None
    admin = enter(accounts, "admin", made.one_time_password)
    session = accounts.find_session(admin.session_token)
    others = {role: employ(accounts, session, name) for name, role in ROLES.items()}
    return {**others, "administrator": admin}


class Employed(NamedTuple):
    """A database in which everybody has signed in just now."""

    database: bytes
    signed_in: dict[str, SignedIn]
    at_s: float


_EMPLOYED: list[Employed] = []
LASTS_S = 300.0
"""For so long it may be copied; a session that is not used ends after half an hour."""


def find_employed() -> Employed:
    """One that is at most `LASTS_S` old: to copy it takes a fifth of what it takes to make."""
    if not _EMPLOYED or time.monotonic() > _EMPLOYED[-1].at_s + LASTS_S:
        with TemporaryDirectory() as folder:
            file = Path(folder) / "records.db"
            with Records.open(str(file)) as records:
                signed_in = employ_all(Accounts(records.database, hasher=CHEAP))
            _EMPLOYED[:] = [Employed(file.read_bytes(), signed_in, time.monotonic())]
    return _EMPLOYED[-1]


def make_site(
    folder: Path, records: Records, accounts: Accounts, port: int = PORT
) -> ConsoleContext:
    """The site of a machine that is played in a folder."""
    recordings = folder / "recordings"
    recordings.mkdir(exist_ok=True)
    return ConsoleContext(
        folder=folder,
        records=records,
        accounts=accounts,
        hub=Hub(folder),
        recordings=recordings,
        about=lambda: machine_folder.read(folder),
        origin=ListeningAddress(HOST, port),
    )


@contextmanager
def served(
    folder: Path, port: int = PORT, limits: Limits = USUAL, name: str = "room"
) -> Iterator[Served]:
    """A console with a machine that is parked, in a folder of the test's own. name: its."""
    room = folder / name
    room.mkdir()
    database = folder / "records.db"
    employed = find_employed()
    database.write_bytes(employed.database)
    with Records.open(str(database)) as records, WrittenMachine(room, str(database)) as machine:
        accounts = Accounts(records.database, hasher=CHEAP)
        site = make_site(room, records, accounts, port)
        yield Served(create_app(site, limits), site, machine, dict(employed.signed_in))


def free_port() -> int:
    """One that nobody listens at now."""
    with socket.socket() as found:
        found.bind((HOST, 0))
        return int(found.getsockname()[1])
