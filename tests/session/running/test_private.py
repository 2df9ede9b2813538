"""Privacy of a machine's folder: for its user alone, and never written through a link."""

import os
import stat
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, cast

import pytest

from opensuction.console.console_process import LOG_FILE, PrivateLog
from opensuction.controller.configuration import Configuration
from opensuction.ipc import liveness
from opensuction.ipc.liveness import Heartbeat, ProcessLock
from opensuction.ipc.mailbox import Mailbox
from opensuction.ipc.ring import EventWriter, ReadCheckpoint
from opensuction.kernel.errors import InputError
from opensuction.machine.port import BACKEND
from opensuction.machine.twin import twin_machine
from opensuction.machine.twin.twin_process import BEGUN
from opensuction.runtime import launch, machine_folder
from opensuction.session.running import basis, console_settings
from opensuction.session.running.console_settings import ConsoleSettings
from opensuction.twin.plant import PlantState
from tests.controller.bedside import hurried
from tests.runtime.identity import ABOUT
from tests.session.running.test_basis import at_bed

LOOP = hurried(2.0)[0]
CHOSEN = Configuration(LOOP.controller, LOOP.heads_mm)
CONSOLE = ConsoleSettings("127.0.0.1", 8080, "postgresql://anna:secret@server/records", "runs")


def begin_twin(folder: Path) -> None:
    loop, state = hurried(2.0)
    twin_machine.prepare(
        folder, twin_machine.side_of(loop, seed=1), PlantState(state.machine, state.bedside)
    )


def listen(folder: Path) -> None:
    """As a controller that dies: the sockets stay in the folder."""
    for own in Mailbox(folder / machine_folder.ASK)._inboxes:
        cast(Any, own)._socket.close()


WRITERS: dict[str, Callable[[Path], object]] = {
    machine_folder.ABOUT: lambda folder: machine_folder.write(folder, ABOUT),
    machine_folder.BASIS: lambda folder: basis.write(folder, at_bed()),
    machine_folder.CONFIGURATION: lambda folder: launch.configure(folder, CHOSEN),
    machine_folder.CONSOLE: lambda folder: console_settings.write(folder, CONSOLE),
    machine_folder.MARK: lambda folder: ReadCheckpoint(folder / machine_folder.MARK),
    machine_folder.CONTROLS: lambda folder: ProcessLock(
        folder / machine_folder.CONTROLS, ""
    ).close(),
    machine_folder.EVENTS: lambda folder: EventWriter(folder / machine_folder.EVENTS).close(),
    machine_folder.EVENTS + ".lock": lambda folder: EventWriter(
        folder / machine_folder.EVENTS
    ).close(),
    machine_folder.EVENTS + ".new": lambda folder: EventWriter(
        folder / machine_folder.EVENTS
    ).close(),
    machine_folder.ASK: listen,
    liveness.FILE: Heartbeat,
    BEGUN: begin_twin,
    BACKEND: begin_twin,
    LOG_FILE: lambda folder: PrivateLog(folder / LOG_FILE).close(),
}
"""What makes the file of a name in a machine's folder."""


@pytest.mark.parametrize("umask", [0o000, 0o077], ids=oct)
@pytest.mark.parametrize("name", WRITERS)
def test_each_file_is_its_user_s_alone_whatever_the_umask(
    tmp_path: Path, name: str, umask: int
) -> None:
    before = os.umask(umask)
    try:
        WRITERS[name](tmp_path)
    finally:
        os.umask(before)
    made = {one.name: stat.S_IMODE(one.lstat().st_mode) for one in tmp_path.iterdir()}
    assert made
    assert set(made.values()) == {0o600}, made


@pytest.mark.parametrize("name", WRITERS)
def test_no_file_is_written_through_a_link_in_its_place(tmp_path: Path, name: str) -> None:
    folder, theirs = tmp_path / "machine", tmp_path / "theirs"
    folder.mkdir()
    theirs.write_text("theirs")
    (folder / name).symlink_to(theirs)
    with suppress(OSError, InputError):  # refused, or the link itself was replaced
        WRITERS[name](folder)
    assert theirs.read_text() == "theirs"


def test_a_recorder_s_folder_is_the_user_s_alone(tmp_path: Path) -> None:
    from opensuction.cli import delivery

    before = os.umask(0)
    try:
        with delivery.reserve(tmp_path / "runs" / "kept", "twin", private=True):
            pass
    finally:
        os.umask(before)
    for folder in (tmp_path / "runs", tmp_path / "runs" / "kept"):
        assert stat.S_IMODE(folder.stat().st_mode) == 0o700
