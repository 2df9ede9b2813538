"""``run``, ``serve`` and ``ask`` as their users meet them: processes, a twin, the clock."""

import json
import os
import re
import signal
import stat
import time
from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest

from opensuction.accounts.accounts import Accounts
from opensuction.console import console_process
from opensuction.ipc.liveness import Heartbeat, Process, holder
from opensuction.ipc.ring import RingReader
from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import Phase
from opensuction.machine.twin.twin_process import PLAYS
from opensuction.records.records import Records
from opensuction.runtime import machine_folder
from opensuction.runtime.loop import ROW_COLUMNS
from tests.cli import command
from tests.cli.command import begun, opensuction, wait_for
from tests.console.served import free_port
from tests.runtime.machine_room import wait

pytestmark = pytest.mark.real_time

NEONATE = ("--patient", "neonate")
SIGN_S = 0.5
"""A sign of life is no older."""

BEGUN: list[command.Process] = []
"""What a test that failed may have left."""


@pytest.fixture
def name() -> Iterator[str]:
    """A machine's name of its own; whatever runs under it is gone afterwards."""
    made = f"t{os.getpid()}-{time.monotonic_ns() % 10**9}"
    yield made
    while BEGUN:
        with BEGUN.pop() as process:
            process.kill()
    folder = machine_folder.make(made)
    for lock in (
        machine_folder.SUPERVISES,
        machine_folder.CONSOLES,
        machine_folder.RECORDS,
        machine_folder.CONTROLS,
        PLAYS,
    ):
        pid = holder(folder / lock)
        if pid is not None:
            os.kill(pid, signal.SIGKILL)
    for file in folder.iterdir():
        file.unlink()
    folder.rmdir()


def phase_of(name: str) -> Phase | None:
    try:
        newest = RingReader(machine_folder.find(name) / machine_folder.RING).snapshot()
    except InputError:
        return None
    return None if newest is None else Phase(int(newest[1][ROW_COLUMNS.index("outputs.phase")]))


def is_kept(name: str) -> bool:
    """A recorder works: a cycle that begins before that has no recording of its own."""
    signs = Heartbeat(machine_folder.find(name))
    both = (Process.RECORDER, Process.KEEPING)
    return all(signs.is_expected(one) and signs.age_s(one) < SIGN_S for one in both)


def is_gone(name: str) -> bool:
    locks = (
        machine_folder.SUPERVISES,
        machine_folder.CONSOLES,
        machine_folder.RECORDS,
        machine_folder.CONTROLS,
        PLAYS,
    )
    return not any(holder(machine_folder.find(name) / lock) for lock in locks)


def test_a_cycle_is_run_recorded_replayed_and_on_record(name: str, tmp_path: Path) -> None:
    ran = opensuction(
        *("run", *NEONATE, "--name", name, "--json", "--database", "ward.db", "--out", "kept"),
        cwd=tmp_path,
    )
    data = json.loads(ran.stdout)
    assert "  Inserting\n" in ran.stderr
    assert is_gone(name)
    assert not list(machine_folder.find(name).iterdir())
    cycle = data["cycles"][0]
    # On a machine that is busy with other things a cycle may be broken off, and then says so.
    assert (ran.returncode, data["reason"] is None) == (
        (0, True) if cycle["outcome"] == "completed" else (1, False)
    )
    assert data["ticks"] > 5000
    assert data["in_silico"] is True
    assert data["scheduler"] in ("fifo", "other")
    recording = tmp_path / "kept" / cycle["recording"]
    replayed = opensuction("replay", str(recording), "--json", cwd=tmp_path)
    assert json.loads(replayed.stdout)["identical"] is True
    audited = opensuction("audit", "--database", "ward.db", cwd=tmp_path)
    assert audited.returncode == 0, audited.stdout
    with Records.open(str(tmp_path / "ward.db")) as records:
        did = {one.what for one in records.history.list_actions(name, 50)}
        assert {"start", "oxygen_skipped"} & did == {"start"}  # nobody asks a neonate's for oxygen
        assert {"control-started", "recorder-started", "controller-ended"} <= did


def serve(*arguments: str, cwd: Path, umask: int = 0o022) -> command.Process:
    """Begin to serve. umask: of who does."""
    before = os.umask(umask)
    try:
        BEGUN.append(begun("serve", *arguments, cwd=cwd))
        return BEGUN[-1]
    finally:
        os.umask(before)


def check_private(name: str, made_in: Path) -> None:
    """What a machine has written is its user's alone."""
    folder = machine_folder.find(name)
    assert wait((folder / console_process.LOG_FILE).exists, 60.0)
    for one in (folder.parent, folder, *folder.iterdir(), *made_in.rglob("*")):
        wanted = 0o700 if one.is_dir() else 0o600
        assert (str(one), oct(stat.S_IMODE(one.lstat().st_mode))) == (str(one), oct(wanted))


@pytest.mark.soak
def test_what_a_machine_writes_is_its_user_s_alone_whatever_the_umask(
    name: str, tmp_path: Path
) -> None:
    """As where everybody may read what somebody writes, below."""
    served = serve(
        *(*NEONATE, "--name", name, "--database", "records/ward.db"),
        *("--out", "runs/kept", "--port", str(free_port())),
        cwd=tmp_path,
        umask=0o077,
    )
    assert wait(lambda: phase_of(name) == Phase.PARKED, 240.0)
    assert wait(lambda: is_kept(name), 60.0)
    assert ask(name, "oxygen-skipped", tmp_path)["verdict"] == "pressed"
    assert ask(name, "start", tmp_path)["verdict"] == "pressed"
    assert wait(lambda: list((tmp_path / "runs" / "kept").glob("*.mcap")) != [], 60.0)
    check_private(name, tmp_path)
    served.send_signal(signal.SIGTERM)
    served.communicate(timeout=120.0)
    assert served.returncode == 0


def test_people_ask_a_machine_that_serves_and_a_second_one_is_refused(
    name: str, tmp_path: Path
) -> None:
    port = str(free_port())
    database = tmp_path / "records" / "ward.db"
    served = serve(
        *(*NEONATE, "--name", name, "--database", "records/ward.db"),
        *("--out", "runs/kept", "--port", port),
        cwd=tmp_path,
        umask=0o000,
    )
    assert wait(lambda: phase_of(name) == Phase.PARKED, 240.0)
    assert wait(lambda: is_kept(name), 60.0)
    second = opensuction(
        *("serve", *NEONATE, "--name", name, "--out", "other", "--port", port), cwd=tmp_path
    )
    assert (second.returncode, second.stdout) == (2, "")
    assert second.stderr.splitlines()[-1].startswith(
        f"opensuction: the machine '{name}' is run by another opensuction (process "
    )
    assert ask(name, "oxygen-skipped", tmp_path)["verdict"] == "pressed"
    assert ask(name, "start", tmp_path)["verdict"] == "pressed"
    assert wait(lambda: phase_of(name) == Phase.INSERTING)
    told = opensuction("ask", "abort", "--name", name, "--who", "nurse Kim", cwd=tmp_path)
    assert told.returncode == 0
    assert told.stdout.startswith("abort: the button went down; the machine is ")
    assert wait(lambda: phase_of(name) == Phase.HALTED)
    url = f"http://127.0.0.1:{port}"
    assert wait(lambda: holder(machine_folder.find(name) / machine_folder.CONSOLES) is not None)
    assert wait(lambda: state_of(url).get("phase") == "halted", 60.0)
    machine = httpx.get(f"{url}/api/v1/machine").json()
    assert (machine["serial"], machine["patient"]["age"]) == (name, "neonate")
    assert machine["anatomy"]["carina_mm"] > 0.0
    asked = {"ask": "abort", "key": "stop-0001"}
    pressed = httpx.post(f"{url}/api/v1/requests", json=asked, headers={"Origin": url})
    assert pressed.json()["verdict"] == "pressed"
    assert list((tmp_path / "runs" / "kept").glob("*.mcap")) != []
    check_private(name, tmp_path)
    # The password may still be being made: nobody hurries a whole walk through in a second.
    said = wait_for(f"Console: {url}/", served.stderr)
    served.send_signal(signal.SIGTERM)
    said += served.communicate(timeout=60.0)[1]
    assert served.returncode == 0, said
    password = re.search(r"sign in as admin with the one-time password (\S+),", said)
    assert password is not None
    with Records.open(str(database)) as records:
        signed_in = Accounts(records.database).sign_in("admin", password[1], "127.0.0.1")
    assert signed_in.session.must_change_password
    assert is_gone(name)
    with Records.open(str(database)) as records:
        assert records.history.list_cycles(name)[0].outcome == "aborted"
        acts = records.history.list_actions(name, 50)
        assert ("nurse Kim", "abort") in [(one.done_by, one.what) for one in acts]


@pytest.mark.soak
def test_a_machine_lost_with_the_tip_inside_is_told_and_the_next_one_waits_for_a_person(
    name: str, tmp_path: Path
) -> None:
    """Its twin dies, and the patient with it: nobody can bring that catheter out.

    `session/running/test_predecessor.py` asks the same of what a machine leaves, without processes.
    """
    options = (*NEONATE, "--name", name, "--database", "ward.db", "--out", "kept")
    served = serve(*options, "--port", str(free_port()), cwd=tmp_path)
    assert wait(lambda: phase_of(name) == Phase.PARKED, 240.0)
    assert wait(lambda: is_kept(name), 60.0)
    assert ask(name, "oxygen-skipped", tmp_path)["verdict"] == "pressed"
    assert ask(name, "start", tmp_path)["verdict"] == "pressed"
    assert wait(lambda: phase_of(name) == Phase.SUCTIONING, 60.0)
    twin = holder(machine_folder.find(name) / PLAYS)
    assert twin is not None
    os.kill(twin, signal.SIGKILL)
    served.send_signal(signal.SIGTERM)
    said = served.communicate(timeout=180.0)[1]
    assert served.returncode == 1, said
    assert "did not answer any more, and the catheter's tip was last inside" in said
    assert "ended in order" not in said
    assert is_gone(name)

    served = serve(*options, "--port", str(free_port()), cwd=tmp_path)
    # It is at home and knows where the other one was.
    assert wait(lambda: phase_of(name) == Phase.HALTED, 240.0)
    url = wait_for("Console: ", served.stderr)
    assert "another patient with it: that of the earlier run is gone" in url
    assert "last inside: look at the patient" in url
    state = state_of(re.search(r"Console: (\S+?)/?[ ,\n]", url)[1])  # type: ignore[index]
    assert state["phase"] == "halted"
    assert state["alarms"] != []
    assert float(str(state["rest_left_s"])) > 60.0
    assert ask(name, "start", tmp_path)["verdict"] == "pressed"
    assert phase_of(name) == Phase.HALTED
    served.send_signal(signal.SIGTERM)
    said = served.communicate(timeout=120.0)[1]
    assert served.returncode == 0, said
    assert "ended in order" in said


def state_of(url: str) -> dict[str, object]:
    try:
        return dict(httpx.get(f"{url}/api/v1/state", timeout=10.0).json())
    except httpx.HTTPError:
        return {}


def ask(name: str, button: str, folder: Path) -> dict[str, str]:
    ran = opensuction("ask", button, "--name", name, "--json", cwd=folder)
    assert ran.stderr == ""
    return dict(json.loads(ran.stdout))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("ask", "start", "--name", "nobodys"), "no machine 'nobodys' runs here"),
        (("ask", "jump"), "unknown request 'jump'; known: start, "),
        (("ask", "start", "--name", "../x"), "a machine's name is 1 to 32 letters"),
        (("run", "--patient", "nobody"), "nobody"),
        (("serve", "--port", "0"), "--port 0: a port is 1 to 65535"),
        (("serve", "--port", "x"), "--port"),
        (("serve", "--host", "0.0.0.0"), "needs --certificate and --key"),
        (("serve", "--certificate", "c.pem"), "--certificate and --key go together"),
        (("serve", "--certificate", "c.pem", "--key", "k.pem"), "c.pem: cannot be read"),
        (("run", "--every", "0"), "--every"),
        (("run", "--database", "/proc/x.db"), "/proc/x.db"),
        (("run", "--out", "/proc/x"), "--out /proc/x: cannot be written"),
    ],
)
def test_bad_input_is_one_line(arguments: tuple[str, ...], words: str, tmp_path: Path) -> None:
    ran = opensuction(*arguments, cwd=tmp_path)
    assert (ran.returncode, ran.stdout) == (2, "")
    assert words in ran.stderr
    assert len(ran.stderr.splitlines()) == 1
    assert not list(tmp_path.iterdir())
