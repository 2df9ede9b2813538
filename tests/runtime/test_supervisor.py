"""Supervision of the processes: one that hangs is replaced, one that cannot start is reported."""

import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from opensuction.host.host import Child
from opensuction.ipc.liveness import Heartbeat, Process
from opensuction.ipc.ring import RingReader
from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import RESTING
from opensuction.machine.twin.twin_process import SHOWN
from opensuction.runtime import launch
from opensuction.runtime.machine_folder import CONFIGURATION, CONSOLE, CONTROLS, RECORDS
from opensuction.runtime.supervisor import HUNG_S, Supervisor, SupervisorNotice
from tests.runtime.room import INSIDE_MM, Room
from tests.runtime.simulated_room import OUTSIDE, SimulatedRoom, full_disk, simulated
from tests.runtime.test_disk import LARGEST_BYTES

STARTS_S = 2.0
"""Longest start of a process on a simulated computer, and its first sign of life."""


@pytest.fixture
def room() -> Iterator[SimulatedRoom]:
    with simulated(begins=False) as made:
        yield made


def look(room: Room, supervisor: Supervisor, seconds: float, wanted: str) -> SupervisorNotice:
    """Let it look until it has done something."""
    told: list[SupervisorNotice] = []

    def is_done() -> bool:
        told.extend(supervisor.look())
        return any(one.what == wanted for one in told)

    assert room.wait(is_done, seconds), f"no {wanted} within {seconds:g} s"
    return next(one for one in told if one.what == wanted)


def test_what_stands_still_is_replaced_and_the_catheter_comes_out(
    room: Room, tmp_path: Path
) -> None:
    with Supervisor(room.folder, tmp_path, host=room.host) as supervisor:
        told: list[str] = []
        supervisor.begin(lambda notice: told.append(notice.what))
        assert told == ["control-started", "recorder-started"]
        room.reopen()
        signs = Heartbeat(room.folder, room.host)
        both = (Process.RECORDER, Process.KEEPING)
        assert room.wait(lambda: all(signs.signs(one).starting_s is None for one in both))
        with pytest.raises(InputError, match=f"a supervisor runs already: process {room.pid}"):
            # Of another process: a lock of one's own is no hindrance.
            _in_another_process(room, tmp_path)
        room.reach(lambda: room.truth("truth.tip_mm") > INSIDE_MM, supervisor.look)
        recorder, control = room.holder(RECORDS), room.holder(CONTROLS)
        assert recorder is not None
        assert control is not None
        room.signal(recorder, signal.SIGSTOP)
        look(room, supervisor, 5.0, "recorder-restarted")
        room.signal(control, signal.SIGSTOP)
        look(room, supervisor, 5.0, "control-restarted")
        assert room.wait(lambda: supervisor.look() == [] and supervisor.control.works(), 60.0)
        room.reopen()
        assert room.wait(lambda: supervisor.look() == [] and room.phase() in RESTING)
        assert room.is_out()
        assert RingReader(room.folder / SHOWN).newest() > 0
        assert supervisor.end()
    assert room.holder(RECORDS) is room.holder(CONTROLS) is None


@pytest.mark.parametrize(
    "lock",
    [CONTROLS, RECORDS],
)
def test_what_hangs_when_a_supervisor_begins_is_replaced(
    room: SimulatedRoom, tmp_path: Path, lock: str
) -> None:
    """The one before was killed; meanwhile what it looked after was stopped, the tip inside."""
    first = launch.spawn(room.folder, launch.SUPERVISOR, str(tmp_path), host=room.host)
    signs = Heartbeat(room.folder, room.host)
    assert room.wait(
        lambda: signs.age_s(Process.KEEPING) < 0.5 and signs.age_s(Process.CONTROL) < 0.5
    )
    room.reopen()
    room.reach(lambda: room.truth("truth.tip_mm") > INSIDE_MM)
    first.kill()
    first.wait()
    hung = room.holder(lock)
    assert hung is not None
    room.signal(hung, signal.SIGSTOP)
    told: list[str] = []
    with Supervisor(room.folder, tmp_path, host=room.host) as second:
        begun_s = room.now_s()
        second.begin(lambda notice: told.append(notice.what))
        took_s = room.now_s() - begun_s
        title = "control" if lock == CONTROLS else "recorder"
        assert {f"{title}-found", f"{title}-restarted"} <= set(told)
        assert took_s < HUNG_S + STARTS_S
        assert room.holder(lock) not in (None, hung)
        room.reopen()
        assert room.wait(lambda: second.look() == [] and room.phase() in RESTING)
        assert room.is_out()
        assert second.end()


def _in_another_process(room: Room, out: Path) -> None:
    process = launch.spawn(room.folder, launch.SUPERVISOR, str(out), host=room.host)
    assert room.ended(process, 60.0) == 1
    raise InputError(launch.last_words(room.folder, launch.SUPERVISOR))


def test_who_has_begun_it_hears_at_each_look_who_does_not_work_yet(
    room: SimulatedRoom, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / CONSOLE).write_text("{}")

    def spawn(folder: Path, module: str, *_: str, **__: object) -> Child:
        return room.computer.spawn(OUTSIDE, (), launch.log_of(folder, module))

    monkeypatch.setattr(launch, "spawn", spawn)
    signs, heard = Heartbeat(tmp_path, room.host), list[tuple[str, ...]]()
    first = {
        ("control", "recorder", "console"): Process.CONSOLE,
        ("control", "recorder"): Process.CONTROL,
        ("recorder",): Process.RECORDER,
    }

    def hear(starting: tuple[str, ...]) -> None:
        heard.append(starting)
        signs.beat(first[starting])

    with Supervisor(tmp_path, tmp_path, host=room.host) as supervisor:
        supervisor.begin(meanwhile=hear)
        waited = [signs.signs(one).starting_s is not None for one in Process]
        assert supervisor.end()
    # The first sign of life comes at the instant of the start, and counts at the next look.
    assert heard == [next(iter(first)), *first]
    assert [one for one, is_so in zip(Process, waited, strict=True) if is_so] == [
        Process.RECORDER,
        Process.KEEPING,
    ]


def test_a_recorder_that_cannot_keep_anything_is_told_with_its_reason(
    room: SimulatedRoom, tmp_path: Path
) -> None:
    """A disk that is full: nobody has died, and what is seen now will be missing."""
    with Supervisor(room.folder, tmp_path, host=room.host) as supervisor:
        supervisor.begin()
        room.reopen()
        recorder = room.holder(RECORDS)
        assert recorder is not None
        with full_disk(LARGEST_BYTES):
            room.begin_cycle(supervisor.look)
            notice = look(room, supervisor, 30.0, "recorder-keeps-nothing")
            assert notice.detail.startswith("not kept: "), notice.detail
        look(room, supervisor, 5.0, "recorder-keeps")
        assert room.wait(lambda: supervisor.look() == [] and room.phase() in RESTING)
        assert supervisor.end()


def test_a_controller_that_cannot_begin_is_said_and_nothing_is_left(
    room: SimulatedRoom, tmp_path: Path
) -> None:
    (room.folder / CONFIGURATION).write_text("{}")
    with Supervisor(room.folder, tmp_path, host=room.host) as supervisor:
        with pytest.raises(InputError, match="the control does not run: controller settings"):
            supervisor.begin()
        assert room.holder(RECORDS) is room.holder(CONTROLS) is None


def test_one_that_dies_again_and_again_is_given_up(room: SimulatedRoom, tmp_path: Path) -> None:
    with Supervisor(room.folder, tmp_path, host=room.host) as supervisor:
        supervisor.begin()
        (room.folder / CONFIGURATION).write_text("{}")
        pid = room.holder(CONTROLS)
        assert pid is not None
        room.signal(pid, signal.SIGKILL)
        notice = look(room, supervisor, 60.0, "control-given-up")
        assert "controller settings" in notice.detail
        supervisor.end()
