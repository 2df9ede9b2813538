"""Folders of results: existing files are never overwritten unasked."""

import os
import signal
from collections.abc import Callable
from contextlib import ExitStack
from datetime import datetime
from pathlib import Path
from types import SimpleNamespace

import pytest

from opensuction.cli import delivery, interruption
from opensuction.cli.delivery import CommandResult, OutputChoice
from opensuction.kernel import private_file
from opensuction.kernel.errors import InputError


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The current folder is empty, and all that happens does in one second."""
    instant = SimpleNamespace(now=lambda tz: datetime(2026, 1, 2, 3, 4, 5, tzinfo=tz))
    monkeypatch.setattr(delivery, "datetime", instant)
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")


def content(folder: Path) -> dict[str, str]:
    return {file.name: file.read_text() for file in folder.iterdir()}


def deliver(
    out: Path | None, text: str, during: Callable[[], object] = lambda: None, force: bool = False
) -> int:
    """A command that writes this text, and what happens while it works."""

    def work(*_: object) -> CommandResult:
        during()
        return CommandResult({}, {"result.txt": text}, lambda *_: None)

    return delivery.deliver(OutputChoice(out, force, as_json=True), "cycle", work)


@pytest.mark.parametrize("force", [False, True])
@pytest.mark.parametrize("below", ["", "sub", "sub/deeper"])
def test_a_file_in_the_way_is_named_and_kept(tmp_path: Path, below: str, force: bool) -> None:
    file = tmp_path / "kept"
    file.write_text("mine")
    with pytest.raises(InputError, match="is a file; name a folder") as refused:
        delivery.check(file / below, force)
    assert str(file) in str(refused.value)
    assert file.read_text() == "mine"


def test_what_a_folder_holds_is_replaced_only_with_force(tmp_path: Path) -> None:
    (tmp_path / "report.html").write_text("older")
    with pytest.raises(InputError, match="is not empty; name another one or add --force"):
        delivery.check(tmp_path, force=False)
    delivery.check(tmp_path, force=True)
    delivery.check(tmp_path / "new", force=False)
    assert (tmp_path / "report.html").read_text() == "older"


def test_commands_of_the_same_second_have_a_folder_each() -> None:
    def third() -> None:
        deliver(None, "3")

    def second() -> None:
        deliver(None, "2", third)

    assert deliver(None, "1", second) == 0
    first = "20260102T030405Z-cycle"
    assert {one.name: content(one) for one in delivery.RUNS.iterdir()} == {
        first: {"result.txt": "1"},
        f"{first}-2": {"result.txt": "2"},
        f"{first}-3": {"result.txt": "3"},
    }


@pytest.mark.parametrize("private", [False, True])
def test_a_folder_is_there_as_soon_as_it_is_chosen(private: bool) -> None:
    with ExitStack() as stack:
        folders = [stack.enter_context(delivery.reserve(None, "twin", private)) for _ in range(4)]
        assert [one.name for one in folders] == [
            f"20260102T030405Z-twin{end}" for end in ("", "-2", "-3", "-4")
        ]
        assert all(one.is_dir() for one in folders)


@pytest.mark.parametrize("force", [False, True])
@pytest.mark.parametrize("exists", [False, True])
def test_a_second_command_in_the_same_folder_is_refused_before_it_works(
    force: bool, exists: bool
) -> None:
    out = Path("new") / "below"
    if exists:
        out.mkdir(parents=True)
    refused = []

    def second() -> None:
        with pytest.raises(InputError, match="another command writes into it; name another") as it:
            deliver(out, "2", lambda: pytest.fail("it worked"), force)
        refused.append(str(it.value))

    assert deliver(out, "1", second) == 0
    assert refused[0].startswith(f"--out {out}: ")
    assert content(out) == {"result.txt": "1"}
    with pytest.raises(InputError, match="not empty"):
        deliver(out, "2")
    assert deliver(out, "3", force=True) == 0  # the first one has let go of it
    assert content(out) == {"result.txt": "3"}


@pytest.mark.parametrize("out", [None, Path("new"), Path("new/below/deep")], ids=str)
@pytest.mark.parametrize("failure", [InputError("bad"), interruption.Stopped(2), OSError(28, "")])
def test_what_fails_leaves_no_folder(out: Path | None, failure: BaseException) -> None:
    def fail() -> None:
        assert any(Path().iterdir())
        raise failure

    with pytest.raises(type(failure)):
        deliver(out, "1", fail)
    assert list(Path().iterdir()) == []


@pytest.mark.parametrize("out", [None, Path("new/below")], ids=str)
def test_a_machine_that_does_not_begin_leaves_no_folder(out: Path | None) -> None:
    def fail() -> None:
        with delivery.reserve(out, "twin", private=True) as folder:
            assert folder.stat().st_mode & 0o777 == 0o700
            raise InputError("bad")

    with pytest.raises(InputError, match="bad"):
        fail()
    assert list(Path().iterdir()) == []


def test_machines_may_record_into_one_folder() -> None:
    with (
        delivery.reserve(Path("given"), "a", private=True) as first,
        delivery.reserve(Path("given"), "b", private=True) as second,
    ):
        assert first == second == Path("given")


@pytest.mark.parametrize("out", [None, Path("given")], ids=str)
def test_what_fails_leaves_the_folders_of_others(out: Path | None) -> None:
    Path("given").mkdir()

    def fail() -> None:
        (out or delivery.RUNS).joinpath("theirs.txt").write_text("theirs")
        raise InputError("bad")

    with pytest.raises(InputError, match="bad"):
        deliver(out, "1", fail)
    assert content(out or delivery.RUNS) == {"theirs.txt": "theirs"}
    assert Path("given").is_dir()


@pytest.mark.parametrize("out", [None, Path("given"), Path("link"), Path()], ids=str)
def test_a_folder_that_filled_meanwhile_is_refused_and_the_results_are_kept(
    out: Path | None,
) -> None:
    if out is not None:
        Path("given").mkdir()
        Path("link").symlink_to("given")
    if out == Path():
        Path("link").unlink()
        Path("given").rmdir()

    def fill() -> None:
        folder = next(Path("runs").glob("*-cycle")) if out is None else out
        assert folder.is_dir()
        (folder / "result.txt").write_text("theirs")

    with pytest.raises(InputError, match="was written into the folder meanwhile") as refused:
        deliver(out, "mine", fill)
    kept = Path(str(refused.value).rpartition(" are in ")[2])
    assert content(kept) == {"result.txt": "mine"}
    theirs = next(Path("runs").glob("*-cycle")) if out is None else out
    assert (theirs / "result.txt").read_text() == "theirs"
    assert not list(Path().rglob(".*"))


def test_what_was_kept_is_not_replaced_either() -> None:
    Path("given-2").mkdir()
    with pytest.raises(InputError, match=r"the results are in .*given-3$"):
        deliver(Path("given"), "mine", lambda: Path("given/theirs.txt").write_text("theirs"))
    assert content(Path("given-3")) == {"result.txt": "mine"}
    assert not list(Path("given-2").iterdir())


def test_a_file_in_the_folder_s_place_is_kept_with_the_results() -> None:
    def swap() -> None:
        Path("given").rmdir()
        Path("given").write_text("theirs")

    with pytest.raises(InputError, match="a file has taken its place meanwhile"):
        deliver(Path("given"), "mine", swap)
    assert Path("given").read_text() == "theirs"
    assert content(Path("given-2")) == {"result.txt": "mine"}


def test_a_folder_where_a_file_is_to_go_loses_nothing() -> None:
    Path("given/result.txt").mkdir(parents=True)
    with pytest.raises(InputError, match=r"its result\.txt is a folder, and a file is to go there"):
        deliver(Path("given"), "mine", force=True)
    assert Path("given/result.txt").is_dir()
    assert content(Path("given-2")) == {"result.txt": "mine"}


@pytest.mark.parametrize("out", [Path("link"), Path(), Path.cwd], ids=["link", "dot", "current"])
def test_a_folder_that_has_to_stay_is_written_into(out: Path | Callable[[], Path]) -> None:
    """A link is none to it, and a shell is not left in a folder that is no more."""
    folder = out() if callable(out) else out
    if folder == Path("link"):
        Path("given").mkdir()
        folder.symlink_to("given")
    before = folder.stat().st_ino if folder != Path("link") else None
    assert deliver(folder, "mine") == 0
    assert content(folder) == {"result.txt": "mine"}
    assert before in (None, folder.stat().st_ino)
    assert Path("link").is_symlink() == (folder == Path("link"))


def test_where_a_disk_is_mounted_files_go_into_its_folder(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """No folder beside it is on the same disk, and none can take its place."""
    Path("disk").mkdir()
    before = Path("disk").stat().st_ino
    monkeypatch.setattr(Path, "is_mount", lambda path: path.name == "disk")
    seen: list[str] = []
    assert deliver(Path("disk"), "mine", lambda: seen.extend(map(str, Path().iterdir()))) == 0
    assert seen == ["disk"]
    assert (content(Path("disk")), Path("disk").stat().st_ino) == ({"result.txt": "mine"}, before)


def test_a_signal_while_results_are_put_in_place_says_where_they_are(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    share = private_file.share

    def interrupt(folder: Path) -> None:
        os.kill(os.getpid(), signal.SIGTERM)
        share(folder)

    monkeypatch.setattr(private_file, "share", interrupt)
    with interruption.hear(), pytest.raises(interruption.Stopped) as stopped:
        deliver(Path("given"), "mine")
    assert stopped.value.__notes__ == ["the results are in given"]
    assert content(Path("given")) == {"result.txt": "mine"}


def test_letters_that_utf_8_lacks_are_written_as_escapes(tmp_path: Path) -> None:
    delivery.write(tmp_path, {"a.txt": "n\udcff µ\n", "b.bin": b"\xff"})
    assert (tmp_path / "a.txt").read_text(encoding="utf-8") == "n\\udcff µ\n"
    assert (tmp_path / "b.bin").read_bytes() == b"\xff"
