"""Supervision of the processes: one that hangs is replaced, one that cannot start is reported."""

import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from opensuction.ipc.liveness import Heartbeat, Process, holder
from opensuction.ipc.ring import RingReader
from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import RESTING
from opensuction.machine.twin.twin_process import SHOWN
from opensuction.runtime import launch
from opensuction.runtime.machine_folder import CONFIGURATION, CONSOLE, CONTROLS, RECORDS
from opensuction.runtime.supervisor import HUNG_S, Supervisor, SupervisorNotice
from tests.runtime.machine_room import INSIDE_MM, Room, running, wait
from tests.runtime.test_disk import LARGEST_BYTES

pytestmark = pytest.mark.real_time

STARTS_S = 20.0
"""Longest start of a process, compiled already, on a computer that is busy."""


@pytest.fixture
def room() -> Iterator[Room]:
    with running(begins=False) as made:
        yield made


def look(supervisor: Supervisor, seconds: float, wanted: str) -> SupervisorNotice:
    """Let it look until it has done something."""
    ends_s = time.monotonic() + seconds
    while time.monotonic() < ends_s:
        for notice in supervisor.look():
            if notice.what == wanted:
                return notice
        time.sleep(0.02)
    raise AssertionError(f"no {wanted} within {seconds:g} s")


@pytest.mark.sweep
def test_what_stands_still_is_replaced_and_the_catheter_comes_out(
    room: Room, tmp_path: Path
) -> None:
    with Supervisor(room.folder, tmp_path) as supervisor:
        told: list[str] = []
        supervisor.begin(lambda notice: told.append(notice.what))
        assert told == ["control-started", "recorder-started"]
        room.reopen()
        signs = Heartbeat(room.folder)
        both = (Process.RECORDER, Process.KEEPING)
        assert wait(lambda: all(signs.signs(one).starting_s is None for one in both))
        with pytest.raises(InputError, match=f"a supervisor runs already: process {os.getpid()}"):
            # Of another process: a lock of one's own is no hindrance.
            _in_another_process(room.folder, tmp_path)
        room.reach(lambda: room.truth("truth.tip_mm") > INSIDE_MM, supervisor.look)
        recorder, control = holder(room.folder / RECORDS), holder(room.folder / CONTROLS)
        assert recorder is not None
        assert control is not None
        os.kill(recorder, signal.SIGSTOP)
        look(supervisor, 5.0, "recorder-restarted")
        os.kill(control, signal.SIGSTOP)
        look(supervisor, 5.0, "control-restarted")
        assert wait(lambda: supervisor.look() == [] and supervisor.control.works(), 60.0)
        room.reopen()
        assert wait(lambda: supervisor.look() == [] and room.phase() in RESTING)
        assert room.is_out()
        assert RingReader(room.folder / SHOWN).newest() > 0
        assert supervisor.end()
    assert holder(room.folder / RECORDS) is holder(room.folder / CONTROLS) is None


@pytest.mark.parametrize(
    "lock",
    [
        pytest.param(CONTROLS, marks=pytest.mark.sweep),
        pytest.param(RECORDS, marks=pytest.mark.soak),
    ],
)
def test_what_hangs_when_a_supervisor_begins_is_replaced(
    room: Room, tmp_path: Path, lock: str
) -> None:
    """The one before was killed; meanwhile what it looked after was stopped, the tip inside."""
    first = launch.spawn(room.folder, launch.SUPERVISOR, str(tmp_path))
    signs = Heartbeat(room.folder)
    assert wait(lambda: signs.age_s(Process.KEEPING) < 0.5 and signs.age_s(Process.CONTROL) < 0.5)
    room.reopen()
    room.reach(lambda: room.truth("truth.tip_mm") > INSIDE_MM)
    first.kill()
    first.wait()
    hung = holder(room.folder / lock)
    assert hung is not None
    os.kill(hung, signal.SIGSTOP)
    told: list[str] = []
    with Supervisor(room.folder, tmp_path) as second:
        begun_s = time.monotonic()
        second.begin(lambda notice: told.append(notice.what))
        took_s = time.monotonic() - begun_s
        title = "control" if lock == CONTROLS else "recorder"
        assert {f"{title}-found", f"{title}-restarted"} <= set(told)
        assert took_s < HUNG_S + STARTS_S
        assert holder(room.folder / lock) not in (None, hung)
        room.reopen()
        assert wait(lambda: second.look() == [] and room.phase() in RESTING)
        assert room.is_out()
        assert second.end()


def _in_another_process(folder: Path, out: Path) -> None:
    process = launch.spawn(folder, launch.SUPERVISOR, str(out))
    assert process.wait(60.0) == 1
    raise InputError(launch.last_words(folder, launch.SUPERVISOR))


def test_who_has_begun_it_hears_at_each_look_who_does_not_work_yet(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / CONSOLE).write_text("{}")
    spawned = [sys.executable, "-c", "import time; time.sleep(600.0)"]
    monkeypatch.setattr(launch, "spawn", lambda *_, **__: subprocess.Popen(spawned))
    signs, heard = Heartbeat(tmp_path), list[tuple[str, ...]]()
    first = {
        ("control", "recorder", "console"): Process.CONSOLE,
        ("control", "recorder"): Process.CONTROL,
        ("recorder",): Process.RECORDER,
    }

    def hear(starting: tuple[str, ...]) -> None:
        heard.append(starting)
        signs.beat(first[starting])

    with Supervisor(tmp_path, tmp_path) as supervisor:
        supervisor.begin(meanwhile=hear)
        waited = [signs.signs(one).starting_s is not None for one in Process]
        assert supervisor.end()
    assert heard == list(first)
    assert [one for one, is_so in zip(Process, waited, strict=True) if is_so] == [
        Process.RECORDER,
        Process.KEEPING,
    ]


@pytest.mark.sweep
def test_a_recorder_that_cannot_keep_anything_is_told_with_its_reason(
    room: Room, tmp_path: Path
) -> None:
    """A disk that is full: nobody has died, and what is seen now will be missing."""
    with Supervisor(room.folder, tmp_path) as supervisor:
        supervisor.begin()
        room.reopen()
        recorder = holder(room.folder / RECORDS)
        assert recorder is not None
        resource.prlimit(recorder, resource.RLIMIT_FSIZE, (LARGEST_BYTES, resource.RLIM_INFINITY))
        room.begin_cycle(supervisor.look)
        notice = look(supervisor, 30.0, "recorder-keeps-nothing")
        assert notice.detail.startswith("not kept: "), notice.detail
        resource.prlimit(
            recorder, resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY)
        )
        look(supervisor, 5.0, "recorder-keeps")
        assert wait(lambda: supervisor.look() == [] and room.phase() in RESTING)
        assert supervisor.end()


def test_a_controller_that_cannot_begin_is_said_and_nothing_is_left(
    room: Room, tmp_path: Path
) -> None:
    (room.folder / CONFIGURATION).write_text("{}")
    with Supervisor(room.folder, tmp_path) as supervisor:
        with pytest.raises(InputError, match="the control does not run: controller settings"):
            supervisor.begin()
        assert holder(room.folder / RECORDS) is holder(room.folder / CONTROLS) is None


@pytest.mark.sweep
def test_one_that_dies_again_and_again_is_given_up(room: Room, tmp_path: Path) -> None:
    with Supervisor(room.folder, tmp_path) as supervisor:
        supervisor.begin()
        (room.folder / CONFIGURATION).write_text("{}")
        pid = holder(room.folder / CONTROLS)
        assert pid is not None
        os.kill(pid, signal.SIGKILL)
        notice = look(supervisor, 60.0, "control-given-up")
        assert "controller settings" in notice.detail
        supervisor.end()
