"""A recording from standard input, kept in a file while it is read: tables are read twice."""

import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from opensuction.kernel.errors import InputError
from opensuction.recording.bound import LARGEST_TEXT_BYTES, megabytes
from opensuction.recording.table import KINDS

DASH = Path("-")
"""How a person asks for it."""
NAME = "standard input"
"""How messages and results call it."""
PIECE_BYTES = 1 << 20


def _copy(stream: BinaryIO, path: Path) -> None:
    """All of a stream into a file. Raises InputError for more than a recording may have."""
    size_bytes = 0
    try:
        with path.open("wb") as file:
            while piece := stream.read(PIECE_BYTES):
                size_bytes += len(piece)
                if size_bytes > LARGEST_TEXT_BYTES:
                    raise InputError(
                        f"{NAME}: more than {megabytes(LARGEST_TEXT_BYTES)} MB, above the limit; "
                        "keep only the columns and the cycles that matter"
                    )
                file.write(piece)
    except OSError as error:
        raise OSError(error.errno, error.strerror, NAME) from None


@contextmanager
def spool() -> Iterator[Path]:
    """A file with all that standard input holds; refusals in here call it by `NAME`.

    Raises InputError where nothing can come. An error of the disk is raised as it is.
    """
    stream = None if sys.stdin is None else sys.stdin.buffer
    if stream is None or stream.isatty():
        raise InputError(f"{NAME}: nothing is piped in; give the path of {KINDS}, or pipe one in")
    with tempfile.TemporaryDirectory(prefix="opensuction-") as folder:
        path = Path(folder) / NAME
        _copy(stream, path)
        try:
            yield path
        except InputError as refused:
            raise InputError(str(refused).replace(str(path), NAME)) from None
