"""From the work of a command to its folder, its JSON object or summary, and its exit status.

The folder of one run: reserved by making it, written aside, put in place when whole.
"""

import contextlib
import errno
import json
import os
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from datetime import UTC, datetime
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from opensuction.cli import entry
from opensuction.cli.interruption import Stopped, postpone
from opensuction.kernel import private_file
from opensuction.kernel.errors import InputError
from opensuction.result.plain import Json

if TYPE_CHECKING:
    from rich.console import Console

    from opensuction.cli.progress import ProgressTeller


RUNS = Path("runs")
"""Where runs go when no folder is named."""
TAKEN = (errno.ENOTEMPTY, errno.EEXIST, errno.ENOTDIR)
"""Why a folder takes no other's place: that one holds something, or is no folder."""


def check(folder: Path, force: bool) -> None:
    """Refuse a folder that cannot be written or that holds something; raises InputError."""
    if folder.exists() and not folder.is_dir():
        raise InputError(f"--out {folder}: this is a file; name a folder")
    for parent in folder.parents:
        if parent.exists() and not parent.is_dir():
            raise InputError(f"--out {folder}: {parent} is a file; name a folder")
    if folder.is_dir() and any(folder.iterdir()) and not force:
        raise InputError(
            f"--out {folder}: the folder is not empty; name another one or add --force"
        )


@contextmanager
def reserve(out: Path | None, name: int | str, private: bool = False) -> Iterator[Path]:
    """The named folder, or ``runs/<time>-<name>`` in UTC; a cycle's name is its seed.

    It is made at once, so that no other command chooses it; what was made here and is empty goes
    again on any exception. private: for recordings, which are written as things happen: the folder
    is this user's alone, one that is there keeps its rights, and several machines may share it.
    Raises InputError where it cannot be written, and where another command writes into it.
    """
    made = [one for one in (out or RUNS / "one").parents if not one.exists()]
    try:
        with postpone():
            folder, is_new = _make_own(name, private) if out is None else _make(out, private)
            if is_new:
                made.insert(0, folder)
        with contextlib.nullcontext() if private else _lock(folder):
            yield folder
    except BaseException:
        with postpone():
            for one in made:
                with contextlib.suppress(OSError):  # it holds something
                    one.rmdir()
        raise


def _make_own(name: int | str, private: bool) -> tuple[Path, bool]:
    """A folder of this run alone, under `RUNS`."""
    base = RUNS / f"{datetime.now(tz=UTC):%Y%m%dT%H%M%SZ}-{name}"
    numbered = (base if k == 1 else base.with_name(f"{base.name}-{k}") for k in count(1))
    return next(made for made in (_make(folder, private) for folder in numbered) if made[1])


def _make(folder: Path, private: bool) -> tuple[Path, bool]:
    """Make a folder, and those above it; returns it and whether it is new.

    Raises InputError where it cannot be written.
    """
    check(folder, force=True)
    try:
        is_new = _make_new(folder, private)
        if not is_new and not folder.is_dir():
            raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR))
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise _unwritable(folder, error) from None
    return folder, is_new


def _make_new(folder: Path, private: bool) -> bool:
    """Make a folder; returns False where something of its name is there. Raises OSError."""
    while True:
        if private:
            private_file.make_folder(folder.parent)
        else:
            folder.parent.mkdir(parents=True, exist_ok=True)
        try:
            private_file.make_new_folder(folder) if private else folder.mkdir()
        except FileExistsError:
            return False
        except FileNotFoundError:
            if folder.parent.is_dir():
                raise
            continue  # another command that failed has just removed the folder above it
        return True


@contextmanager
def _lock(folder: Path) -> Iterator[None]:
    """No other command writes into a folder in here; the lock goes with the process that has it.

    Raises InputError where one does. A file system without locks has none.
    """
    handle = None
    try:
        if sys.platform != "win32":
            import fcntl

            with contextlib.suppress(OSError):
                handle = os.open(folder, os.O_RDONLY)
                try:
                    fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
                except BlockingIOError:
                    raise InputError(
                        f"--out {folder}: another command writes into it; name another folder, or "
                        "wait until it has ended"
                    ) from None
        yield
    finally:
        if handle is not None:
            os.close(handle)


def _unwritable(folder: Path, error: OSError) -> InputError:
    return InputError(
        f"--out {folder}: cannot be written ({(error.strerror or str(error)).lower()}); "
        "name a folder you may write to"
    )


def _is_fixed(folder: Path) -> bool:
    """True for a folder that cannot be replaced: a mount point, or the current one."""
    return folder.is_mount() or folder == Path.cwd()


def _make_staging(folder: Path) -> Path:
    """A folder beside one whose links are followed, or in it where it has to stay."""
    try:
        beside = folder if _is_fixed(folder) else folder.parent
        return Path(tempfile.mkdtemp(prefix=f".{folder.name}-", dir=beside))
    except OSError as error:
        raise _unwritable(folder, error) from None


def _put_in_place(staging: Path, folder: Path, force: bool) -> None:
    """Let what was staged take the place of a folder, or move it there file by file.

    Raises InputError where something is in the way by now; the results are kept beside it then.
    """
    private_file.share(staging)
    if staging.parent != folder:
        try:
            staging.replace(folder)
        except OSError as error:
            if error.errno not in TAKEN:
                raise
        else:
            return
    if obstacle := _find_obstacle(staging, folder, force):
        raise InputError(
            f"--out {folder}: {obstacle}; nothing in it was changed, the results are in "
            f"{_keep(staging, folder)}"
        )
    for file in staging.iterdir():
        file.replace(folder / file.name)
    staging.rmdir()


def _find_obstacle(staging: Path, folder: Path, force: bool) -> str | None:
    """Obstacle to moving files into a folder; None where there is none."""
    if not folder.is_dir():
        return "a file has taken its place meanwhile"
    if not force and any(one != staging for one in folder.iterdir()):
        return "something was written into the folder meanwhile"
    for file in staging.iterdir():
        if (folder / file.name).is_dir():
            return f"its {file.name} is a folder, and a file is to go there"
    return None


def _keep(staging: Path, folder: Path) -> Path:
    """Let staged results keep a folder of their own; returns it."""
    for number in count(2):
        kept = staging.with_name(f"{folder.name}-{number}")
        with contextlib.suppress(FileExistsError):
            kept.mkdir()
            return staging.replace(kept)
    raise AssertionError


def write(staging: Path, files: Mapping[str, str | bytes]) -> None:
    """Write files, by name; raises OSError with the file's name where the disk does not take it.

    A letter that UTF-8 does not have, as half a letter of a file's name, becomes its escape.
    """
    for name, content in files.items():
        file = staging / name
        if isinstance(content, str):
            content = content.encode("utf-8", "backslashreplace")  # noqa: PLW2901
        try:
            file.write_bytes(content)
        except OSError as error:
            # An error while writing has no name: it is about a file that was opened before.
            raise OSError(error.errno, error.strerror, name) from None


@contextmanager
def stage(folder: Path, force: bool) -> Iterator[Path]:
    """A folder to write into; it becomes ``folder`` at the end, or vanishes on any exception.

    With ``force`` the files of a folder that is not empty are replaced one by one; others in it
    stay. Raises InputError where the folder cannot be written or holds something, before anything
    is computed; and at the end where something came in between, with the results kept beside it.
    """
    check(folder, force)
    staging, placed, final = None, False, folder.resolve()
    try:
        with postpone():
            staging = _make_staging(final)
        yield staging
        with postpone():
            _put_in_place(staging, final, force)
            placed = True
    except BaseException as ending:
        if placed:
            ending.add_note(f"the results are in {folder}")
        with postpone():
            if staging is not None:
                shutil.rmtree(staging, ignore_errors=True)
        raise


class OutputChoice(NamedTuple):
    """Options for the place and form of the results."""

    out: Path | None = None
    force: bool = False
    as_json: bool = False


class CommandResult(NamedTuple):
    """Results of a command."""

    data: Json
    """The one object of ``--json``."""
    files: Mapping[str, str | bytes]
    """By their names in the folder."""
    summarise: "Callable[[Console, Path], None]"
    """Prints it for a person; takes the folder that the files are in."""
    is_good: bool = True
    """Whether the exit status is 0."""
    stale: tuple[str, ...] = ()
    """Files that an earlier run may have left in the folder and that would now tell a lie."""


def to_text(data: Json) -> str:
    """A JSON object as its file holds it."""
    return json.dumps(data, indent=2) + "\n"


def show(as_json: bool, data: Json, summarise: "Callable[..., None]") -> None:
    """Print the one object of ``--json``, or the summary for a person."""
    from opensuction.cli.progress import PlainConsole

    try:
        if as_json:
            print(json.dumps(data))  # noqa: T201 - the result
        else:
            summarise(PlainConsole())
        if sys.stdout is not None:
            sys.stdout.flush()
    except BrokenPipeError:
        raise
    except OSError as error:
        raise OSError(error.errno, error.strerror, "stdout") from None


def deliver(
    output: OutputChoice,
    name: int | str,
    work: "Callable[[ProgressTeller, Path], CommandResult]",
    doing: str | None = None,
    writes: bool = False,
) -> int:
    """Carry out the work of a command; returns the exit status.

    name: of the folder where none was named. work: takes the folder in which its files will be.
    writes: it writes large files itself, and takes a folder that becomes that one.
    doing: said while all of the work is done in the background; None: the work waits by itself.
    Raises InputError for a folder that cannot be written and for what the work refuses.
    """
    from opensuction.cli.progress import ProgressTeller

    progress = ProgressTeller()
    with (
        reserve(output.out, name) as folder,
        stage(folder, output.force) as staging,
    ):
        place = staging if writes else folder
        if doing is None:
            done = work(progress, place)
        else:
            done = progress.wait(lambda: work(progress, place), doing)
        write(staging, done.files)
    for stale in done.stale:
        (folder / stale).unlink(missing_ok=True)
    try:
        show(output.as_json, done.data, lambda console: done.summarise(console, folder))
    except (OSError, Stopped) as ending:
        ending.add_note(f"the results are in {folder}")
        raise
    return entry.DONE if done.is_good else entry.FAILED


def delivering(
    name: str, doing: str, work: "Callable[[Any, ProgressTeller, Path], CommandResult]"
) -> Callable[[Any], int]:
    """Function that carries a command out in the background and delivers its results.

    work: takes the command's options first; their field ``results`` says where to deliver.
    """
    return lambda options: deliver(
        options.results, name, lambda progress, folder: work(options, progress, folder), doing
    )
