"""A console at a machine that runs, controller and twin in step, and its people."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from starlette.testclient import TestClient

from opensuction.accounts.accounts import Accounts
from opensuction.console.access import ConsoleContext
from opensuction.console.app import create_app
from opensuction.console.guard.limits import UNHURRIED
from opensuction.control.compensation import CompensationKind
from opensuction.records.records import Records
from opensuction.runtime import machine_folder
from opensuction.session.running import basis
from tests.accounts.example import CHEAP
from tests.console.served import PORT, Served, employ_all, make_site
from tests.runtime.machine_room import running, wait
from tests.runtime.room import Room
from tests.session.running.test_basis import at_bed

PATIENT = "neonate"


class Bed(NamedTuple):
    """The parts of it."""

    room: Room
    served: Served

    @property
    def site(self) -> ConsoleContext:
        return self.served.site

    def client(self, role: str | None) -> TestClient:
        return self.served.client(role)

    def get(self, path: str, role: str | None = "clinician") -> Any:
        answer = self.client(role).get(f"/api/v1{path}")
        assert answer.status_code == 200, answer.text
        return answer.json()

    def settle(self) -> None:
        """Until it is parked."""
        self.room.park()

    def actions(self) -> list[tuple[str, str, str]]:
        """What is on record of what people did, the newest first."""
        found = self.site.records.history.list_actions(limit=100)
        return [(one.done_by, one.what, one.detail) for one in found]


def prepare(folder: Path) -> None:
    """What `session.running.machine` leaves beside the settings of `machine_room`'s machine."""
    basis.write(folder, at_bed(PATIENT, CompensationKind.EXACT_INVERSE))


@contextmanager
def bed(folder: Path, port: int = PORT) -> Iterator[Bed]:
    """A machine that is parked, with a console before it; a busy computer does not halt it."""
    with running(in_step=True) as room:
        told = machine_folder.read(room.folder)
        database = str(folder / "records.db")
        machine_folder.write(room.folder, told._replace(database=database))
        prepare(room.folder)
        with Records.open(database) as records:
            accounts = Accounts(records.database, hasher=CHEAP)
            site = make_site(room.folder, records, accounts, port)
            served = Served(create_app(site, UNHURRIED), site, None, employ_all(accounts))  # type: ignore[arg-type]
            yield Bed(room, served)


def until(holds: Callable[[], bool], seconds: float = 30.0) -> None:
    assert wait(holds, seconds)
