"""The folder of one run: written aside and renamed into place when whole."""

import shutil
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path

from opensuction.cli.interruption import postpone
from opensuction.kernel import private_file
from opensuction.kernel.errors import InputError

RUNS = Path("runs")
"""Where runs go when no folder is named."""


def choose(out: Path | None, name: int | str) -> Path:
    """The named folder, or ``runs/<time>-<name>`` in UTC; a cycle's name is its seed."""
    if out is not None:
        return out
    base = RUNS / f"{datetime.now(tz=UTC):%Y%m%dT%H%M%SZ}-{name}"
    folder, number = base, 2
    while folder.exists():
        folder, number = base.with_name(f"{base.name}-{number}"), number + 1
    return folder


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


def make(folder: Path) -> None:
    """Make a folder of recordings, which are written as things happen and for this user alone.

    One that is there keeps its rights. Raises InputError where it cannot be.
    """
    check(folder, force=True)
    try:
        private_file.make_folder(folder)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise _unwritable(folder, error) from None


def _unwritable(folder: Path, error: OSError) -> InputError:
    return InputError(
        f"--out {folder}: cannot be written ({(error.strerror or str(error)).lower()}); "
        "name a folder you may write to"
    )


def _staging(folder: Path) -> Path:
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        if folder.is_dir():
            # Renaming into it needs more than a writable parent.
            with tempfile.TemporaryFile(dir=folder):
                pass
        return Path(tempfile.mkdtemp(prefix=f".{folder.name}-", dir=folder.parent))
    except OSError as error:
        raise _unwritable(folder, error) from None


def _put_in_place(staging: Path, folder: Path) -> None:
    private_file.share(staging)
    if not folder.exists() or not any(folder.iterdir()):
        staging.replace(folder)
        return
    for file in staging.iterdir():
        file.replace(folder / file.name)
    staging.rmdir()


def write(staging: Path, files: Mapping[str, str | bytes]) -> None:
    """Write files, by name; raises OSError with the file's name where the disk does not take it."""
    for name, content in files.items():
        file = staging / name
        try:
            file.write_bytes(content if isinstance(content, bytes) else content.encode("utf-8"))
        except OSError as error:
            # An error while writing has no name: it is about a file that was opened before.
            raise OSError(error.errno, error.strerror, name) from None


@contextmanager
def stage(folder: Path, force: bool) -> Iterator[Path]:
    """A folder to write into; it becomes ``folder`` at the end, or vanishes on any exception.

    With ``force`` the files of a folder that is not empty are replaced one by one; others in it
    stay. Raises InputError where the folder cannot be written, before anything is computed.
    """
    check(folder, force)
    parents = [parent for parent in folder.parents if not parent.exists()]
    staging = None
    try:
        with postpone():
            staging = _staging(folder)
        yield staging
        with postpone():
            _put_in_place(staging, folder)
    except BaseException:
        with postpone():
            if staging is not None:
                shutil.rmtree(staging, ignore_errors=True)
            for parent in parents:
                if parent.is_dir() and not any(parent.iterdir()):
                    parent.rmdir()
        raise
