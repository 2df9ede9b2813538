"""Cache of results from recordings, in a folder beside them: each is computed once.

It is a folder of files and no table: the records are append-only and audited, and hold what
happened; these results can be computed again. Deleting the folder costs time, and nothing else. A
file is named by its recording and by a key of that recording's size and time and of this software,
so that no outdated result is ever shown.
"""

import contextlib
import hashlib
from pathlib import Path

from opensuction import __version__
from opensuction.console.history.recording_file import RecordingFile
from opensuction.kernel import private_file

FOLDER = ".history"
FORMAT = 3
"""Of what is kept; the next number makes everything be worked out anew."""


def _stem(file: RecordingFile) -> str:
    key = f"{FORMAT} {__version__} {file.size} {file.changed_ns} {len(file.parts)}"
    return f"{file.name}.{hashlib.sha256(key.encode()).hexdigest()[:16]}"


class ResultCache:
    """The folder, made when something is kept first."""

    def __init__(self, recordings: Path) -> None:
        self._folder = recordings / FOLDER

    def find(self, file: RecordingFile, kind: str) -> bytes | None:
        """Kept result of a recording. kind: ``report.html``, ``replay.json``, ``figure.json``."""
        if not private_file.is_own_folder(self._folder):
            return None
        try:
            return (self._folder / f"{_stem(file)}.{kind}").read_bytes()
        except OSError:
            return None

    def keep(self, file: RecordingFile, kind: str, data: bytes) -> None:
        """Keep it, whole or not at all; a disk that cannot take it costs time later, no more."""
        path = self._folder / f"{_stem(file)}.{kind}"
        with contextlib.suppress(OSError):
            private_file.make_folder(self._folder)
            if not private_file.is_own_folder(self._folder):
                return
            for old in self._folder.glob(f"{file.name}.*.{kind}"):
                old.unlink(missing_ok=True)
            private_file.write(path, data)
