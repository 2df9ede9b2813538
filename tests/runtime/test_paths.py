"""The folder of a machine where others were there first, or left something in its place."""

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from opensuction.kernel import private_file
from opensuction.kernel.errors import InputError
from opensuction.runtime import machine_folder

NAME = "ward-3"
SOMEBODY = 65_534
"""Number of another user."""


@pytest.fixture
def memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where everybody may make folders."""
    (tmp_path / "shm").mkdir()
    monkeypatch.setattr(machine_folder, "MEMORY", tmp_path / "shm")
    return tmp_path / "shm"


@pytest.fixture
def usual(memory: Path) -> Path:
    return memory / f"opensuction-{os.geteuid()}"


def somebody_else_s(usual: Path) -> None:
    if os.geteuid() != 0:
        pytest.skip("only root can make a folder of another user")
    usual.mkdir(0o700)
    (usual / NAME).mkdir(0o700)
    (usual / NAME / machine_folder.EVENTS).write_text("theirs")
    os.chown(usual / NAME, SOMEBODY, SOMEBODY)
    os.chown(usual, SOMEBODY, SOMEBODY)


def open_to_all(usual: Path) -> None:
    (usual / NAME).mkdir(parents=True)
    (usual / NAME / machine_folder.EVENTS).write_text("theirs")
    usual.chmod(0o777)


def a_link(usual: Path) -> None:
    theirs = usual.parent.parent / "theirs"
    open_to_all(theirs)
    theirs.chmod(0o700)
    usual.symlink_to(theirs)


@pytest.mark.parametrize("squat", [somebody_else_s, open_to_all, a_link])
def test_a_folder_that_is_not_the_user_s_alone_is_passed_by(
    usual: Path, squat: Callable[[Path], None]
) -> None:
    squat(usual)
    assert machine_folder.find(NAME).parent != usual, "nothing is read of it, either"
    folder = machine_folder.make(NAME)
    assert folder.parent != usual
    assert folder.parent.name.startswith(f"{usual.name}-")
    assert private_file.is_own_folder(folder)
    assert private_file.is_own_folder(folder.parent)
    assert machine_folder.passed_by(folder).startswith(f"{usual} is not this user's alone")
    (folder / machine_folder.EVENTS).touch()
    machine_folder.clear(folder)
    assert (usual / NAME / machine_folder.EVENTS).read_text() == "theirs"
    # Every other command finds the same one, whatever is in its environment.
    assert machine_folder.find(NAME) == machine_folder.make(NAME) == folder
    assert machine_folder.make("another").parent == folder.parent


def test_a_machine_is_found_when_whoever_was_there_first_has_gone(usual: Path) -> None:
    usual.touch()
    folder = machine_folder.make(NAME)
    usual.unlink()
    machine_folder.make("before")
    assert machine_folder.find(NAME) == folder
    usual.mkdir(0o700)
    assert machine_folder.find(NAME) == folder
    assert machine_folder.make("later").parent == usual


def test_a_name_that_looks_like_the_user_s_own_is_not_trusted(memory: Path, usual: Path) -> None:
    usual.touch()
    open_to_all(memory / f"{usual.name}-0000000000000000")
    folder = machine_folder.make(NAME)
    assert folder.parent.name != f"{usual.name}-0000000000000000"
    assert machine_folder.find(NAME) == folder


def test_a_usual_folder_is_used_and_nothing_is_said(usual: Path) -> None:
    folder = machine_folder.make(NAME)
    assert folder == usual / NAME
    assert private_file.is_own_folder(usual)
    assert machine_folder.passed_by(folder) == ""


@pytest.mark.parametrize("umask", [0o000, 0o077])
def test_a_machine_s_folders_are_the_user_s_alone_whatever_the_umask(
    usual: Path, umask: int
) -> None:
    before = os.umask(umask)
    try:
        machine_folder.make(NAME)
    finally:
        os.umask(before)
    assert private_file.is_own_folder(usual)
    assert private_file.is_own_folder(usual / NAME)


def test_a_link_under_a_machine_s_name_is_refused_and_where_it_leads_stays(
    memory: Path, usual: Path
) -> None:
    theirs = memory / "theirs"
    theirs.mkdir()
    (theirs / "file").write_text("theirs")
    usual.mkdir(0o700)
    (usual / NAME).symlink_to(theirs)
    with pytest.raises(InputError, match=r"ward-3 is a link, or not this user's alone: remove it"):
        machine_folder.make(NAME)
    with pytest.raises(InputError, match="cannot be emptied"):
        machine_folder.clear(usual / NAME)
    assert (theirs / "file").read_text() == "theirs"
