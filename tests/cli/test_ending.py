"""However a command is ended, it ends in one line and leaves nothing half-written."""

import contextlib
import io
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import IO, NoReturn
from unittest import mock

import pytest

from opensuction.cli import delivery, interruption
from opensuction.cli.command import run
from opensuction.cli.interruption import Stopped
from opensuction.runtime import supervisor
from opensuction.session.running import run as running
from tests.cli.command import (
    PROGRAM,
    begun,
    largest_file,
    opensuction_process,
    run_main,
    unrecorded,
    wait_for,
)
from tests.evidence.safety_case.hazard_example import FAULT, ROW

CYCLE = ("cycle", "--machine", "bench", "--compensation", "none")


@pytest.mark.parametrize(
    ("number", "status", "word"),
    [
        pytest.param(signal.SIGINT, 130, "interrupted", marks=pytest.mark.soak),
        pytest.param(signal.SIGHUP, 129, "terminal closed", marks=pytest.mark.soak),
    ],
)
def test_a_signal_ends_a_running_cycle_at_once(
    number: signal.Signals, status: int, word: str, tmp_path: Path
) -> None:
    with begun(*CYCLE, "--pace", "1", cwd=tmp_path) as process:
        wait_for("Checking", process.stdout)  # the cycle is under way
        process.send_signal(number)
        _, words = process.communicate(timeout=20)  # by itself it would take 30 s more
    assert process.returncode == status
    assert words.splitlines()[-1] == f"opensuction: {word}; nothing was written"
    assert "Traceback" not in words
    assert list(tmp_path.iterdir()) == []


def test_a_signal_ends_a_compilation(tmp_path: Path) -> None:
    (tmp_path / "work").mkdir()
    environment = {"OPENSUCTION_CACHE_DIR": str(tmp_path / "cache")}
    with begun(*CYCLE, cwd=tmp_path / "work", environment=environment) as process:
        wait_for("Compiling", process.stderr)
        process.send_signal(signal.SIGTERM)
        _, words = process.communicate(timeout=20)  # ends when all its processes have gone
    assert process.returncode == 143
    assert words.splitlines()[-1] == "opensuction: terminated; nothing was written"
    assert list((tmp_path / "work").iterdir()) == []


def test_a_signal_ends_a_recording_s_reading(tmp_path: Path) -> None:
    # Large, so that reading it is still under way when the signal arrives.
    rows = "".join(f"{i},{i % 977},{i % 977}.5\n" for i in range(100_000, 115_000))
    (tmp_path / "long.csv").write_text(f"time_s,head_mm,tip_mm\n{100 * rows}")
    columns = ("--input", "head_mm", "--output", "tip_mm")
    with begun("identify", "long.csv", *columns, cwd=tmp_path) as process:
        wait_for("Identifying", process.stderr)
        process.send_signal(signal.SIGINT)
        _, words = process.communicate(timeout=20)
    assert process.returncode == 130
    assert words.splitlines() == ["opensuction: interrupted; nothing was written"]
    assert [path.name for path in tmp_path.iterdir()] == ["long.csv"]


@pytest.mark.sweep
def test_a_signal_ends_the_processes_of_a_safety_case(tmp_path: Path) -> None:
    # Every run breaks its bound and says so: the first here, the second by another process.
    table = ROW.replace("safe_ms = 10000", "safe_ms = 1") + FAULT
    (tmp_path / "mine.toml").write_text(table)
    arguments = ("safety-case", "--table", "mine.toml", "--seeds", "100", "--out", "s")
    with begun(*arguments, cwd=tmp_path) as process:
        wait_for("seed 1", process.stderr)
        wait_for("broken: ", process.stderr)
        process.send_signal(signal.SIGTERM)
        _, words = process.communicate(timeout=20)  # ends when all its processes have gone
    assert process.returncode == 143
    assert words.splitlines()[-1] == "opensuction: terminated; nothing was written"
    assert [path.name for path in tmp_path.iterdir()] == ["mine.toml"]


WHILE_COMPUTING = """
import os, signal, threading
from opensuction.cli import interruption
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
choice = CycleChoice(RigChoice("bench"), compensation="none")
prepared = cycle_run.prepare(resolution.resolve(choice))
cycle_run.play(prepared, lambda _: None)
heard = 0
for k in range(TRIALS):
    sender = threading.Timer(0.042 * k / TRIALS, os.kill, (os.getpid(), signal.SIGTERM))
    try:
        with interruption.hear():
            sender.start()
            while True:
                cycle_run.play(prepared, lambda _: None)
    except interruption.Stopped:
        heard += 1
print(heard)
"""
"""Most signals come while compiled code runs, and are heard as it makes records for Python."""


@pytest.mark.parametrize("trials", [15, pytest.param(60, marks=pytest.mark.soak)])
def test_a_signal_within_compiled_code_is_heard_and_breaks_nothing(
    trials: int, tmp_path: Path
) -> None:
    done = subprocess.run(
        [sys.executable, "-c", WHILE_COMPUTING.replace("TRIALS", str(trials))],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert (done.returncode, done.stdout) == (0, f"{trials}\n"), done.stderr


def test_a_signal_that_is_ignored_stays_so() -> None:
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with interruption.hear():
            assert signal.getsignal(signal.SIGHUP) == signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, before)


def test_the_folder_is_put_in_place_whole_before_a_signal_is_heard(tmp_path: Path) -> None:
    done = []

    def place() -> None:
        with interruption.postpone():
            os.kill(os.getpid(), signal.SIGTERM)
            done.append("whole")
        done.append("after the signal")

    def break_off(folder: Path) -> None:
        with delivery.stage(folder, force=False) as staging:
            delivery.write(staging, {"half.txt": "half"})
            os.kill(os.getpid(), signal.SIGTERM)

    with interruption.hear():
        with pytest.raises(Stopped):
            place()
        with pytest.raises(Stopped):
            break_off(tmp_path / "out")
    assert done == ["whole"]
    assert list(tmp_path.iterdir()) == []
    assert signal.getsignal(signal.SIGTERM) == signal.SIG_DFL


@pytest.mark.parametrize(
    ("recorded", "left"), [(True, "the recordings are in out"), (False, "nothing was recorded")]
)
def test_a_machine_that_ends_says_whether_there_are_recordings(
    recorded: bool, left: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop(*_: object) -> NoReturn:
        if recorded:
            (tmp_path / "out" / "1.mcap").touch()
        raise Stopped(signal.SIGTERM)

    (tmp_path / "out").mkdir()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(supervisor, "Supervisor", lambda *_: contextlib.nullcontext())
    monkeypatch.setattr(running, "supervise", stop)
    with pytest.raises(Stopped) as stopped:
        run.supervise(mock.Mock(), Path("out"), None, mock.Mock())
    assert stopped.value.__notes__ == [left]


@pytest.mark.parametrize(
    ("arguments", "left"),
    [
        (("--help",), "nothing was written"),
        ((*CYCLE, "--no-recording", "--json", "--out", "run"), "the results are in run"),
    ],
)
def test_a_closed_pipe_is_one_line(arguments: tuple[str, ...], left: str, tmp_path: Path) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    done = subprocess.run(
        [*PROGRAM, *arguments],
        cwd=tmp_path,
        stdout=writer,
        stderr=subprocess.PIPE,
        text=True,
        timeout=300,
        check=False,
    )
    os.close(writer)
    assert done.returncode == 141
    assert done.stderr.splitlines()[-1] == f"opensuction: nobody reads the output any more; {left}"
    assert "Traceback" not in done.stderr
    names = [path.name for path in tmp_path.iterdir()]
    assert names == (["run"] if "run" in left else [])


@pytest.fixture
def closed() -> Iterator[IO[str]]:
    """A pipe that nobody reads any more."""
    reader, writer = os.pipe()
    os.close(reader)
    stream = os.fdopen(writer, "w")
    yield stream
    with contextlib.suppress(BrokenPipeError):
        stream.close()


def test_a_pipe_that_is_closed_before_the_live_view_leaves_nothing(
    closed: IO[str], tmp_path: Path
) -> None:
    words = io.StringIO()
    status = run_main(*CYCLE, "--out", "run", cwd=tmp_path, stdout=closed, stderr=words)
    assert status == 141
    line = words.getvalue().splitlines()[-1]
    assert line == "opensuction: nobody reads the output any more; nothing was written"
    assert list(tmp_path.iterdir()) == []


def test_closed_progress_ends_the_command_without_a_word(closed: IO[str], tmp_path: Path) -> None:
    output = io.StringIO()
    arguments = (*CYCLE, "--json", "--out", "run")
    status = run_main(*arguments, cwd=tmp_path, stdout=output, stderr=closed)
    assert (status, output.getvalue()) == (141, "")
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_cannot_be_written_is_one_line_and_changes_nothing(tmp_path: Path) -> None:
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "cycle.json").write_text("of an earlier run")
    with largest_file(50_000):  # the report has more
        done = unrecorded(*CYCLE, "--json", "--out", "run", "--force", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (74, "")
    line = done.stderr.splitlines()[-1]
    assert line == "opensuction: report.html: file too large; nothing was written"
    (file,) = (tmp_path / "run").iterdir()
    assert file.read_text() == "of an earlier run"
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full on this system")
def test_a_full_disk_behind_stdout_is_one_line(tmp_path: Path) -> None:
    arguments, words = (*CYCLE, "--json", "--out", "run"), io.StringIO()
    # As it is closed, what is left of the output has no room either.
    with contextlib.suppress(OSError), Path("/dev/full").open("w") as full:
        status = run_main(*arguments, cwd=tmp_path, stdout=full, stderr=words)
    assert status == 74
    line = words.getvalue().splitlines()[-1]
    assert line == "opensuction: stdout: no space left on device; the results are in run"
    assert sorted(file.name for file in (tmp_path / "run").iterdir()) == [
        "cycle.json",
        "recording.mcap",
        "report.html",
    ]


def test_a_process_of_its_own_says_the_same_as_one_within(tmp_path: Path) -> None:
    ran = opensuction_process("--version", cwd=tmp_path)
    assert (ran.returncode, ran.stderr) == (0, "")
    assert ran.stdout.startswith("opensuction ")
