"""Files and folders of this user alone, whatever the umask.

No link is followed where they are made or emptied. They are those of machines, their recordings
and their records; what a person has written into a folder of their own has the rights that their
umask leaves (`share`).
"""

import errno
import os
import stat
from collections.abc import Callable, Collection
from contextlib import suppress
from pathlib import Path
from typing import BinaryIO

FOLDER_MODE, FILE_MODE = 0o700, 0o600
OTHERS = 0o077
"""Umask that leaves nobody else a right, for a process whose files are all of this kind."""
_RIGHTS = 0o777
"""Of owner, group and others; a folder may inherit more bits from the one above it."""
_ENTER = 0o111


def opener(path: str, flags: int) -> int:
    """Open for `open` and `io.FileIO`. A file that is there keeps its rights.

    Raises OSError for a link.
    """
    flags |= os.O_NOFOLLOW | os.O_CLOEXEC
    if not flags & os.O_CREAT:
        return os.open(path, flags)
    try:
        handle = os.open(path, flags | os.O_EXCL, FILE_MODE)
    except FileExistsError:
        if flags & os.O_EXCL:
            raise
        return os.open(path, flags & ~os.O_CREAT)
    os.fchmod(handle, FILE_MODE)
    return handle


def append(path: Path) -> BinaryIO:
    """A file to read and to write after its end, made where there is none. Raises OSError."""
    return open(path, "a+b", opener=opener)


def create(path: Path) -> BinaryIO:
    """A new file to write and to read; what was there before goes. Raises OSError."""
    path.unlink(missing_ok=True)
    return open(path, "x+b", opener=opener)


def write(path: Path, content: str | bytes, *, syncs: bool = False) -> None:
    """Write a file whole or not at all; text as UTF-8. Raises OSError.

    syncs: the disk has the content before the file takes the place of the one before.
    """
    new = path.with_name(f"{path.name}.{os.getpid()}.new")
    try:
        with create(new) as file:
            file.write(content.encode() if isinstance(content, str) else content)
            if syncs:
                file.flush()
                os.fsync(file.fileno())
        new.replace(path)
    except BaseException:
        with suppress(OSError):
            new.unlink(missing_ok=True)
        raise


def bind(bind_to: Callable[[str], None], path: Path) -> None:
    """Bind a socket to a path; what was there before goes. bind_to: of the socket. Raises OSError.

    To be called before there are other threads: the umask is the whole process's.
    """
    path.unlink(missing_ok=True)
    before = os.umask(_RIGHTS ^ FILE_MODE)
    try:
        bind_to(str(path))
    finally:
        os.umask(before)


def make_folder(path: Path) -> None:
    """Make a folder, and those above it that are not there. One that is there stays as it is.

    Raises OSError.
    """
    if path.is_dir():
        return
    make_folder(path.parent)
    try:
        make_new_folder(path)
    except FileExistsError:
        if not path.is_dir():
            raise


def make_new_folder(path: Path) -> None:
    """Make a folder that is not there. Raises OSError, FileExistsError where something is."""
    path.mkdir(FOLDER_MODE)
    _set_mode(path)


def is_own_folder(path: Path) -> bool:
    """True for a folder, no link, that belongs to this user and that nobody else may enter."""
    try:
        status = path.lstat()
    except OSError:
        return False
    is_own = stat.S_ISDIR(status.st_mode) and status.st_uid == os.geteuid()
    return is_own and status.st_mode & _RIGHTS == FOLDER_MODE


def share(path: Path) -> None:
    """Give a file or folder that was made for this user alone what the umask leaves others."""
    os.umask(before := os.umask(OTHERS))
    full = _RIGHTS if path.is_dir() else _RIGHTS & ~_ENTER
    path.chmod(full & ~before)


def empty_folder(path: Path, kept: Collection[str] = ()) -> None:
    """Remove the files and links in a folder of this user but those of some names.

    Raises OSError, for a link, too.
    """
    handle = _open_folder(path)
    try:
        for name in os.listdir(handle):  # noqa: PTH208 - of a handle, which no link can replace
            if name not in kept:
                os.unlink(name, dir_fd=handle)
    finally:
        os.close(handle)


def _set_mode(path: Path) -> None:
    """Of a folder that was just made: the umask may have taken rights of its owner."""
    if path.lstat().st_mode & _RIGHTS == FOLDER_MODE:
        return
    # It cannot be opened before its owner may read it.
    path.chmod(FOLDER_MODE, follow_symlinks=False)


def _open_folder(path: Path) -> int:
    handle = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC)
    if os.fstat(handle).st_uid != os.geteuid():
        os.close(handle)
        raise PermissionError(errno.EPERM, "it belongs to another user", str(path))
    return handle
