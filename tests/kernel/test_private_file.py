"""Rights that are set and not inherited, and links that are not followed."""

import os
import socket
import stat
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from opensuction.kernel import private_file

UMASKS = pytest.mark.parametrize("umask", [0o000, 0o022, 0o077, 0o277], ids=oct)


@contextmanager
def under(umask: int) -> Iterator[None]:
    """Whatever the person's shell is set to."""
    before = os.umask(umask)
    try:
        yield
    finally:
        os.umask(before)


def rights(path: Path) -> int:
    return stat.S_IMODE(path.lstat().st_mode)


def listen(path: Path) -> None:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as own:
        private_file.bind(own.bind, path)


MAKERS: dict[str, Callable[[Path], object]] = {
    "append": lambda path: private_file.append(path).close(),
    "create": lambda path: private_file.create(path).close(),
    "write": lambda path: private_file.write(path, "new"),
    "bind": listen,
}
"""All ways to make a file."""


@UMASKS
@pytest.mark.parametrize("maker", MAKERS)
def test_a_file_is_its_user_s_alone_whatever_the_umask(
    tmp_path: Path, umask: int, maker: str
) -> None:
    with under(umask):
        MAKERS[maker](tmp_path / "made")
    assert rights(tmp_path / "made") == 0o600
    assert [one.name for one in tmp_path.iterdir()] == ["made"], "nothing is left beside it"


@UMASKS
def test_a_folder_and_those_above_it_are_their_user_s_alone(tmp_path: Path, umask: int) -> None:
    (tmp_path / "shared").mkdir()
    (tmp_path / "shared").chmod(0o755)
    with under(umask):
        private_file.make_folder(tmp_path / "shared" / "runs" / "kept")
    assert rights(tmp_path / "shared" / "runs") == rights(tmp_path / "shared/runs/kept") == 0o700
    assert rights(tmp_path / "shared") == 0o755, "what was there stays as it was"
    assert private_file.is_own_folder(tmp_path / "shared" / "runs" / "kept")
    assert not private_file.is_own_folder(tmp_path / "shared")


@pytest.mark.parametrize("maker", MAKERS)
@pytest.mark.parametrize("dangles", [False, True])
def test_nothing_is_written_through_a_link(tmp_path: Path, maker: str, dangles: bool) -> None:
    target, planted = tmp_path / "target", tmp_path / "planted"
    if not dangles:
        target.write_text("theirs")
    planted.symlink_to(target)
    try:
        MAKERS[maker](planted)
    except OSError:
        assert planted.is_symlink(), "refused"
    else:
        assert rights(planted) == 0o600
        assert not planted.is_symlink(), "the link itself was replaced"
    assert target.exists() is not dangles
    assert dangles or target.read_text() == "theirs"


def test_a_file_that_is_there_keeps_its_rights_and_its_content(tmp_path: Path) -> None:
    """Such as a database that its administrator shares with a group."""
    file = tmp_path / "records.db-lock"
    file.write_text("a")
    file.chmod(0o660)
    with private_file.append(file) as again:
        again.write(b"b")
    assert (file.read_text(), rights(file)) == ("ab", 0o660)


def test_a_folder_that_is_a_link_is_no_own_folder_and_is_not_emptied(tmp_path: Path) -> None:
    theirs, planted = tmp_path / "theirs", tmp_path / "planted"
    private_file.make_folder(theirs)
    (theirs / "file").touch()
    planted.symlink_to(theirs)
    assert not private_file.is_own_folder(planted)
    with pytest.raises(OSError, match="planted"):
        private_file.empty_folder(planted)
    assert (theirs / "file").exists()


def test_links_in_a_folder_are_removed_and_not_what_they_lead_to(tmp_path: Path) -> None:
    own, theirs = tmp_path / "own", tmp_path / "theirs"
    private_file.make_folder(own)
    private_file.make_folder(theirs)
    (theirs / "file").touch()
    (own / "link").symlink_to(theirs)
    (own / "file").touch()
    private_file.empty_folder(own)
    assert (list(own.iterdir()), list(theirs.iterdir())) == ([], [theirs / "file"])


@pytest.mark.parametrize(
    ("umask", "folder", "file"), [(0o022, 0o755, 0o644), (0o077, 0o700, 0o600)]
)
def test_what_a_person_asked_for_has_the_rights_that_their_umask_leaves(
    tmp_path: Path, umask: int, folder: int, file: int
) -> None:
    private_file.make_folder(tmp_path / "result")
    private_file.write(tmp_path / "report.html", "")
    with under(umask):
        private_file.share(tmp_path / "result")
        private_file.share(tmp_path / "report.html")
        assert os.umask(umask) == umask, "it was only looked at"
    assert (rights(tmp_path / "result"), rights(tmp_path / "report.html")) == (folder, file)
