"""Jobs on recordings: reports, replays and figures, one of a kind at a time, with results kept.

Cache of results from recordings, in a folder beside them: each is computed once.

It is a folder of files and no table: the records are append-only and audited, and hold what
happened; these results can be computed again. Deleting the folder costs time, and nothing else. A
file is named by its recording and by a key of that recording's size and time and of this software,
so that no outdated result is ever shown.

File of a cycle's recording: its name on record, looked up in the recordings' folder alone.
"""

import contextlib
import hashlib
import json
import logging
import re
import stat
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from opensuction import __version__
from opensuction.console.guard.problem import Problem
from opensuction.console.history.work_process import FIGURES, LIMITS_S, REPLAY, REPORT
from opensuction.kernel import private_file

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,120}\.mcap")
"""Of what a recorder writes. What a record says otherwise is no file of this folder."""
MOST_PARTS = 1000


class RecordingFile(NamedTuple):
    """A recording: its file, and further parts where a recorder died."""

    name: str
    parts: tuple[Path, ...]
    size: int
    """Bytes of all parts."""
    changed_ns: int
    """When the last of them was written to, or put in its place."""


def _is_file(path: Path) -> bool:
    """True for a plain file; a link could lead out of the folder."""
    try:
        return stat.S_ISREG(path.lstat().st_mode)
    except OSError:
        return False


def find(folder: Path, name: str | None) -> RecordingFile | None:
    """The recording of this name; None where there is none here.

    name: as it is on record; it never comes from whoever asks.
    """
    if name is None or not NAME.fullmatch(name) or ".." in name:
        return None
    first = folder / name
    if not _is_file(first):
        return None
    parts = [first]
    for number in range(2, MOST_PARTS):
        part = folder / f"{first.stem}-{number}.mcap"
        if not _is_file(part):
            break
        parts.append(part)
    facts = [part.stat() for part in parts]
    return RecordingFile(
        name,
        tuple(parts),
        sum(one.st_size for one in facts),
        max(max(one.st_mtime_ns, one.st_ctime_ns) for one in facts),
    )


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


LOG = logging.getLogger("opensuction.console")
MODULE = "opensuction.console.history.work_process"
REPORT_KIND, REPLAY_KIND, FIGURE_KIND = "report.html", "replay.json", "figure.json"
WAIT_S = 30.0
"""How long somebody waits for a report while another one is made."""
AT_ONCE = 20
"""Recordings whose figures one process works out: it loads what it needs only once."""
MOST_FIGURES = 20_000
"""That are remembered."""
FAILED = "it could not be worked out; the console's log says why"


def _work(what: str, files: Sequence[RecordingFile]) -> Iterator[dict[str, Any]]:
    """The answers about these recordings, as they come. Ends early where the process does."""
    process = subprocess.Popen(
        [sys.executable, "-m", MODULE],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,
    )
    assert process.stdin is not None
    assert process.stdout is not None
    timer = threading.Timer(LIMITS_S[what], process.kill)
    timer.daemon = True
    timer.start()
    try:
        asked = {"what": what, "recordings": [[str(part) for part in one.parts] for one in files]}
        process.stdin.write(json.dumps(asked).encode() + b"\n")
        process.stdin.flush()
        for line in process.stdout:
            yield json.loads(line)
    except OSError as error:
        LOG.warning("%s of a recording: %s", what, error)
    finally:
        timer.cancel()
        process.kill()
        _, said = process.communicate()
        if process.returncode not in (0, -9) and said:
            LOG.warning("%s of a recording: %s", what, said.decode(errors="replace")[-2000:])


def _do(what: str, file: RecordingFile) -> dict[str, Any]:
    """The answer about one recording."""
    for answer in _work(what, [file]):
        return answer
    return {"refused": FAILED}


class JobQueue:
    """Of one folder of recordings. May be asked by several threads."""

    def __init__(self, recordings: Path) -> None:
        self._kept = ResultCache(recordings)
        self._quick, self._slow = threading.Lock(), threading.Lock()
        self._state = threading.Lock()
        self._replaying: str | None = None
        """Name of the recording that is played again now."""
        self._failed: dict[str, str] = {}
        """Why a recording could not be played again, by its name."""
        self._is_filling = False
        self._figures: dict[RecordingFile, dict[str, Any]] = {}
        """Those that were asked for: days of trends ask for thousands, again and again."""

    def report(self, file: RecordingFile) -> bytes:
        """The report's page. Raises Problem where it cannot be made, or not now."""
        found = self._kept.find(file, REPORT_KIND)
        if found is not None:
            return found
        if not self._quick.acquire(timeout=WAIT_S):
            raise Problem(
                503, "other reports are being made: try again", headers={"Retry-After": "10"}
            )
        try:
            answer = _do(REPORT, file)
        finally:
            self._quick.release()
        if "html" not in answer:
            raise Problem(422, _without_folder(answer["refused"], file))
        page: bytes = answer["html"].encode()
        self._kept.keep(file, REPORT_KIND, page)
        return page

    def verdict(self, file: RecordingFile) -> dict[str, Any]:
        """State of a replay, and its verdict where there is one."""
        found = self._kept.find(file, REPLAY_KIND)
        if found is not None:
            return {"state": "done", "verdict": json.loads(found), "failure": None}
        with self._state:
            if self._replaying == file.name:
                return {"state": "running", "verdict": None, "failure": None}
            failure = self._failed.get(file.name)
        state = "none" if failure is None else "failed"
        return {"state": state, "verdict": None, "failure": failure}

    def replay(self, file: RecordingFile) -> dict[str, Any]:
        """Have a recording played again, unless that was done; see `verdict`.

        Raises Problem while another one is.
        """
        known = self.verdict(file)
        if known["state"] in ("done", "running"):
            return known
        with self._state:
            if self._replaying is not None:
                raise Problem(
                    409,
                    "another recording is being played again: try once it is done",
                    headers={"Retry-After": "20"},
                )
            self._replaying = file.name
            self._failed.pop(file.name, None)
        threading.Thread(target=self._replay, args=(file,), daemon=True).start()
        return {"state": "running", "verdict": None, "failure": None}

    def _replay(self, file: RecordingFile) -> None:
        failure = FAILED
        try:
            with self._slow:
                answer = _do(REPLAY, file)
            if "refused" in answer:
                failure = _without_folder(answer["refused"], file)
            else:
                failure = ""
                self._kept.keep(file, REPLAY_KIND, json.dumps(answer).encode())
        finally:
            with self._state:
                self._replaying = None
                if failure:
                    self._failed[file.name] = failure

    def figures(self, file: RecordingFile) -> dict[str, Any] | None:
        """Figures of a recording; None: nobody has worked them out yet."""
        found = self._figures.get(file)
        if found is None:
            kept = self._kept.find(file, FIGURE_KIND)
            if kept is None:
                return None
            found = json.loads(kept)
            if len(self._figures) >= MOST_FIGURES:
                self._figures.clear()
            self._figures[file] = found
        return found

    def fill(
        self, files: Sequence[RecordingFile], refuse: Callable[[RecordingFile], str | None]
    ) -> None:
        """Have the figures of recordings worked out, unless that is going on.

        refuse: why a file is not what it should be, asked in the thread that works; None: it is.
        """
        with self._state:
            if self._is_filling or not files:
                return
            self._is_filling = True
        threading.Thread(target=self._fill, args=(list(files), refuse), daemon=True).start()

    def _fill(
        self, files: list[RecordingFile], refuse: Callable[[RecordingFile], str | None]
    ) -> None:
        try:
            for first in range(0, len(files), AT_ONCE):
                some = []
                for file in files[first : first + AT_ONCE]:
                    refused = refuse(file)
                    if refused is None:
                        some.append(file)
                    else:
                        answer = {"refused": refused}
                        self._kept.keep(file, FIGURE_KIND, json.dumps(answer).encode())
                with self._slow:
                    for file, answer in zip(some, _work(FIGURES, some), strict=False):
                        self._kept.keep(file, FIGURE_KIND, json.dumps(answer).encode())
        finally:
            with self._state:
                self._is_filling = False


def _without_folder(said: str, file: RecordingFile) -> str:
    """A message without where on this computer the recording lies."""
    return said.replace(f"{file.parts[0].parent}/", "")
