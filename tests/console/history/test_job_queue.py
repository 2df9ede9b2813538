"""Work on recordings: at the lowest priority, one at a time, within a time, never for nobody."""

import json
import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from opensuction.console.guard.problem import Problem
from opensuction.console.history import job_queue
from opensuction.console.history.job_queue import JobQueue, RecordingFile
from opensuction.console.history.work_process import LIMITS_S, NICEST, REPLAY
from tests.console.history.past import RECORDING

SECONDS = 60.0


def put(folder: Path, *names: str) -> list[RecordingFile]:
    """Files that are no recordings."""
    found = []
    for name in names:
        (folder / name).write_bytes(b"no recording")
        file = job_queue.find(folder, name)
        assert file is not None
        found.append(file)
    return found


def begun(path: Path) -> subprocess.Popen[bytes]:
    """The process, with so much to say that it waits for whoever reads it."""
    process = subprocess.Popen(
        [sys.executable, "-m", job_queue.MODULE], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    assert process.stdin is not None
    asked = {"what": REPLAY, "recordings": [[str(path)]] * 5000}
    process.stdin.write(json.dumps(asked).encode() + b"\n")
    process.stdin.flush()
    return process


def test_the_work_has_the_lowest_priority_and_ends_with_who_asked(tmp_path: Path) -> None:
    process = begun(tmp_path / "a.mcap")
    assert process.stdout is not None
    assert process.stdin is not None
    assert b"no such file" in process.stdout.readline()
    assert os.getpriority(os.PRIO_PROCESS, process.pid) == NICEST
    assert process.poll() is None
    process.stdin.close()  # as where the console has died
    assert process.wait(SECONDS) == 1
    process.stdout.close()


def test_what_takes_too_long_is_ended_and_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (file,) = put(tmp_path, RECORDING)
    monkeypatch.setitem(LIMITS_S, REPLAY, 0)
    working = JobQueue(tmp_path)
    working.replay(file)
    ended = threading.Event()
    while working.verdict(file)["state"] == "running":
        ended.wait(0.02)
    assert working.verdict(file) == {
        "state": "failed",
        "verdict": None,
        "failure": job_queue.FAILED,
    }


def test_one_replay_at_a_time_and_the_same_one_is_joined(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first, second = put(tmp_path, "a.mcap", "b.mcap")
    goes_on, asked = threading.Event(), list[str]()

    def work(_: str, files: list[RecordingFile]) -> Iterator[dict[str, Any]]:
        asked.append(files[0].name)
        goes_on.wait(SECONDS)
        yield {"refused": f"{files[0].parts[0]}: is no MCAP file"}

    monkeypatch.setattr(job_queue, "_work", work)
    working = JobQueue(tmp_path)
    assert working.replay(first)["state"] == "running"
    assert working.replay(first)["state"] == "running"
    with pytest.raises(Problem) as refused:
        working.replay(second)
    assert refused.value.status == 409
    assert working.verdict(second)["state"] == "none"
    goes_on.set()
    pause = threading.Event()
    while working.verdict(first)["state"] == "running":
        pause.wait(0.01)
    assert asked == ["a.mcap"]
    assert working.verdict(first)["failure"] == "a.mcap: is no MCAP file", "no folder is told"
    assert working.replay(second)["state"] == "running"


def test_a_folder_that_cannot_be_written_costs_only_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (file,) = put(tmp_path, "a.mcap")
    (tmp_path / ".history").write_text("a file where a folder should be")
    pages = iter(("one", "two"))
    monkeypatch.setattr(job_queue, "_work", lambda *_: iter([{"html": next(pages)}]))
    working = JobQueue(tmp_path)
    assert working.report(file) == b"one"
    assert working.report(file) == b"two"
