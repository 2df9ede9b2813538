"""A machine in real time with its console: processes, as `opensuction serve` has them."""

import subprocess
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from opensuction.accounts.accounts import Accounts
from opensuction.accounts.sign_in import SignedIn
from opensuction.console.access import session_cookie
from opensuction.host.host import Child
from opensuction.records.records import Records
from opensuction.runtime import launch
from opensuction.session.running import console_settings
from opensuction.session.running.console_settings import ConsoleSettings
from tests.accounts.example import CHEAP
from tests.console.served import HOST, employ_all, free_port
from tests.runtime.machine_room import running, wait
from tests.runtime.room import Room

CONSOLE = "opensuction.console.console_process"
STARTS_S = 120.0


class ConsoleMachine(NamedTuple):
    """The parts of it."""

    room: Room
    console: "Child"
    port: int
    signed_in: dict[str, SignedIn]

    @property
    def url(self) -> str:
        return f"http://{HOST}:{self.port}"

    def cookie(self, role: str) -> str:
        """As a header has it."""
        return f"{self.cookie_name}={self.signed_in[role].session_token}"

    @property
    def cookie_name(self) -> str:
        """Of a session."""
        return session_cookie(self.room.folder, f"{HOST}:{self.port}")

    def browser_cookies(self, role: str) -> list[dict[str, str]]:
        """As Playwright takes them."""
        token = self.signed_in[role].session_token
        return [{"name": self.cookie_name, "value": token, "url": self.url}]


def _answers(url: str) -> bool:
    try:
        with urllib.request.urlopen(f"{url}/", timeout=2.0) as answer:
            return bool(answer.status == 200)
    except (urllib.error.URLError, OSError):
        return False


@contextmanager
def console_machine() -> Iterator[ConsoleMachine]:
    """Twin, controller and console; people of each role have signed in."""
    with running() as room:
        database = str(room.folder / "records.db")
        with Records.open(database) as records:
            people = employ_all(Accounts(records.database, hasher=CHEAP))
        port = free_port()
        out = room.folder / "recordings"
        out.mkdir()
        settings = ConsoleSettings(HOST, port, database, str(out))
        console_settings.write(room.folder, settings)
        console = launch.spawn(room.folder, CONSOLE)
        made = ConsoleMachine(room, console, port, people)
        try:
            assert wait(lambda: _answers(made.url), STARTS_S), launch.last_words(
                room.folder, CONSOLE
            )
            yield made
        finally:
            console.terminate()
            try:
                console.wait(10.0)
            except subprocess.TimeoutExpired:
                console.kill()
                console.wait()


def cpu_s(pid: int) -> float:
    """Processor time that a process has taken, of all its threads."""
    text = Path(f"/proc/{pid}/stat").read_text(encoding="ascii")
    fields = text.rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / 100.0


def sleep_until(instant_s: float) -> None:
    """Monotonic."""
    time.sleep(max(instant_s - time.monotonic(), 0.0))
