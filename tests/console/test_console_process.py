"""The console as a process beside a machine that runs: it may die, and nothing else notices."""

import json
import os
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from unittest import mock

import httpx
import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from opensuction.accounts.accounts import Accounts
from opensuction.ipc.liveness import Heartbeat, Process, holder
from opensuction.kernel.vocabulary import CYCLE, Phase
from opensuction.records.records import Records
from opensuction.runtime import launch, supervisor
from opensuction.runtime.machine_folder import CONSOLES, CONTROLS
from opensuction.runtime.supervisor import Supervisor, SupervisorNotice
from opensuction.safety.condition import Condition
from opensuction.session.running import console_settings
from opensuction.session.running.console_settings import ConsoleSettings
from tests.accounts.example import CHEAP
from tests.console.served import HOST, free_port
from tests.runtime.machine_room import LOCKSTEP, running, wait
from tests.runtime.room import INSIDE_MM, Room

pytestmark = pytest.mark.real_time

CONTROL = "lockstep"
"""Name that the supervisor gives to the controller of a machine in step."""


class Served:
    """A machine that runs, with its console."""

    def __init__(self, room: Room, out: Path) -> None:
        self.room, self.port = room, free_port()
        database = str(room.folder / "records.db")
        console_settings.write(room.folder, ConsoleSettings(HOST, self.port, database, str(out)))
        with Records.open(database) as records:
            Accounts(records.database, hasher=CHEAP).first_start()
        self.url = f"http://{HOST}:{self.port}"
        self.supervisor = Supervisor(room.folder, out)
        self.told: list[SupervisorNotice] = []
        self.supervisor.begin(self.told.append)
        room.reopen()

    def look(self) -> list[SupervisorNotice]:
        done = self.supervisor.look()
        self.told += done
        return done

    def wait(self, name: str, seconds: float = 60.0) -> SupervisorNotice:
        """Until the supervisor has done this."""
        before = len(self.told)
        assert wait(
            lambda: any(one.what == name for one in (self.look(), self.told[before:])[1]), seconds
        )
        return next(one for one in self.told[before:] if one.what == name)

    def pid(self) -> int:
        found = holder(self.room.folder / CONSOLES)
        assert found is not None
        return found

    def process(self) -> int:
        """The same, as soon as it was started."""
        console = self.supervisor.console
        assert console is not None
        assert console.pid is not None
        return console.pid

    def state(self) -> dict[str, object]:
        return dict(httpx.get(f"{self.url}/api/v1/state", timeout=10.0).json())

    def ask(self, button: str) -> httpx.Response:
        body = {"ask": button, "key": f"key-{time.monotonic_ns()}"}
        headers = {"Origin": self.url}
        return httpx.post(f"{self.url}/api/v1/requests", json=body, headers=headers, timeout=10.0)

    def is_there(self) -> bool:
        try:
            return bool(self.state()["connected"])
        except httpx.HTTPError:
            return False

    def works(self) -> bool:
        self.look()
        console = self.supervisor.console
        return console is not None and console.works()


@contextmanager
def serving(out: Path) -> Iterator[Served]:
    """In step: how a machine keeps time is not the point."""
    with running(begins=False, in_step=True) as room:
        with mock.patch.object(launch, "CONTROL", LOCKSTEP):
            made = Served(room, out)
        try:
            yield made
        finally:
            made.supervisor.end()
            made.supervisor.__exit__()


@pytest.mark.sweep
def test_one_that_dies_again_and_again_is_given_up_and_the_machine_goes_on(tmp_path: Path) -> None:
    with serving(tmp_path / "kept") as served:
        assert [one.what for one in served.told] == [
            f"{CONTROL}-started",
            "recorder-started",
            "console-started",
        ]
        control = holder(served.room.folder / CONTROLS)
        for _ in range(supervisor.TRIES - 1):
            os.kill(served.process(), signal.SIGKILL)
            served.wait("console-restarted")
        os.kill(served.process(), signal.SIGKILL)
        notice = served.wait("console-given-up")
        assert "5 died within 60 s" in notice.detail
        assert holder(served.room.folder / CONTROLS) == control
        assert served.room.phase() == Phase.PARKED
        assert wait(
            lambda: bool(
                int(served.room.now("outputs.signals.present")) >> int(Condition.CONSOLE_LOST) & 1
            ),
            30.0,
        )


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """Its supervisor replaces what a test has killed."""
    with serving(tmp_path_factory.mktemp("machine") / "kept") as made:
        yield made


@pytest.fixture
def served(shared: Served) -> Served:
    """The same, parked, with a console that shows it."""
    assert wait(lambda: shared.works() and shared.is_there(), 60.0)
    shared.room.reopen()
    shared.room.park(shared.look)
    return shared


@pytest.mark.sweep
def test_killed_in_a_cycle_nothing_but_the_page_is_gone_for_a_moment(served: Served) -> None:
    """The cycle ends as planned; people are told; another console is there; the page hears on."""
    room = served.room
    beats, before = Heartbeat(room.folder), len(served.told)
    headers = {"Origin": served.url}
    room.begin_cycle(served.look)
    with connect(f"ws://{HOST}:{served.port}/api/v1/live", additional_headers=headers) as page:
        shown: list[str] = []

        def hear() -> bool:
            served.look()
            shown.append(json.loads(page.recv(timeout=5.0))["phase"])
            return room.truth("truth.tip_mm") > INSIDE_MM or room.phase() == Phase.HALTED

        assert wait(hear, 60.0)
        assert "inserting" in shown, room.state()
        os.kill(served.pid(), signal.SIGKILL)
        with pytest.raises(ConnectionClosed):
            _hear_all(page)
    assert wait(lambda: (served.look(), room.phase() not in CYCLE)[1], 60.0)
    assert room.phase() == Phase.PARKED, "the cycle has ended as planned"
    assert room.is_out()
    assert "console-restarted" in [one.what for one in served.told[before:]]
    assert wait(served.works)
    assert beats.deaths(Process.CONSOLE) >= 1
    state = served.state()
    assert (state["connected"], state["phase"]) == (True, "parked")
    names = [one["name"] for one in state["alarms"]]  # type: ignore[attr-defined]
    assert (
        "console-lost" in names
        or not int(room.now("outputs.signals.present")) >> int(Condition.CONSOLE_LOST) & 1
    )
    assert served.ask("abort").json()["verdict"] == "pressed"


def _hear_all(page: object) -> None:
    while True:
        page.recv(timeout=5.0)  # type: ignore[attr-defined]


@pytest.mark.sweep
def test_the_console_shows_that_the_controller_died_and_then_the_one_that_came(
    served: Served,
) -> None:
    control = holder(served.room.folder / CONTROLS)
    assert control is not None
    os.kill(control, signal.SIGSTOP)
    # The supervisor does not look, so nobody replaces it yet.
    assert wait(lambda: served.state()["connected"] is False, 5.0)
    state = served.state()
    assert state["phase"] == "unknown"
    assert state["tip_mm"] is None
    answer = served.ask("abort")
    assert answer.status_code == 503
    assert answer.json()["detail"].startswith("NOBODY HEARS THE STOP")
    served.wait(f"{CONTROL}-restarted")
    assert wait(lambda: (served.look(), served.is_there())[1], 60.0)
    assert served.ask("abort").json()["verdict"] == "pressed"


@pytest.mark.sweep
def test_a_second_one_is_refused_in_one_line_and_the_first_told_to_end_is_missed_by_nobody(
    served: Served,
) -> None:
    second = launch.spawn(served.room.folder, launch.CONSOLE)
    assert second.wait(60.0) == 1
    words = launch.last_words(served.room.folder, launch.CONSOLE)
    assert words.startswith(f"a console runs already: process {served.pid()}")
    beats = Heartbeat(served.room.folder)
    pid = served.pid()
    os.kill(pid, signal.SIGTERM)
    assert wait(lambda: holder(served.room.folder / CONSOLES) != pid, 15.0)
    assert not beats.is_expected(Process.CONSOLE)
    assert beats.is_expected(Process.CONTROL)
