"""Runs the command line as a user would, in this process or in one of its own."""

import contextlib
import io
import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import IO, Any, NamedTuple
from unittest import mock

import pytest

from opensuction.cli import app
from opensuction.result.plain import Json
from tests.cli import result_schema

Process = subprocess.Popen[str]
PROGRAM = (sys.executable, "-m", "opensuction.cli.app")
HEARING = (
    sys.executable,
    "-c",
    "import signal\n"
    "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
    "signal.signal(signal.SIGHUP, signal.SIG_DFL)\n"
    "from opensuction.cli import app\n"
    "app.main()",
)
"""The same where whoever runs the tests ignores signals, as ``nohup`` and a job of a shell do."""


class Ran(NamedTuple):
    """What a command came to."""

    returncode: int
    stdout: str
    stderr: str


def opensuction(*arguments: str, cwd: Path) -> Ran:
    """Run ``opensuction`` with these arguments in a folder, in this process.

    What it prints with ``--json`` must be as the published schema has it.
    """
    stdout, stderr = io.StringIO(), io.StringIO()
    code = run_main(*arguments, cwd=cwd, stdout=stdout, stderr=stderr)
    if "--json" in arguments and stdout.getvalue():  # nothing of what was refused
        data = json.loads(stdout.getvalue())
        assert not result_schema.find_faults(name_object(arguments, data), data)
    return Ran(code, stdout.getvalue(), stderr.getvalue())


def run_main(*arguments: str, cwd: Path, stdout: IO[str], stderr: IO[str]) -> int:
    """The same with these streams; returns the status, also where a process would be left."""
    with (
        contextlib.chdir(cwd),
        contextlib.redirect_stdout(stdout),
        contextlib.redirect_stderr(stderr),
        mock.patch.object(sys, "argv", ["opensuction", *arguments]),
        mock.patch.object(os, "_exit", sys.exit),
        pytest.raises(SystemExit) as leaving,
    ):
        app.main()
    code = leaving.value.code
    assert isinstance(code, int)
    return code


@contextlib.contextmanager
def largest_file(size_bytes: int) -> Iterator[None]:
    """No file of this process grows beyond this, as on a disk that is full."""
    import resource  # not on every system

    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size_bytes, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def spread_here(
    function: Callable[[Any], Any],
    tasks: Sequence[Any],
    _: int,
    tell: Callable[[int, Any], None] = lambda *_: None,
    warn: object = None,  # noqa: ARG001 - no process dies
) -> list[Any]:
    """`worker_pool.spread` in this process, for tests whose subject is not the others."""
    answers = []
    for number, task in enumerate(tasks):
        answers.append(function(task))
        tell(number, answers[-1])
    return answers


def unrecorded(command: str, *arguments: str, cwd: Path) -> Ran:
    """The same without a recording: what nobody looks at takes half of a cycle's time."""
    return opensuction(command, "--no-recording", *arguments, cwd=cwd)


def name_object(arguments: tuple[str, ...], data: Json) -> str:
    """Name of the object that a command printed, in the published schema."""
    if "--play" in arguments:
        return f"{arguments[0]}-play"
    return "replay-several" if data.keys() == {"recordings"} else arguments[0]


def opensuction_process(
    *arguments: str, cwd: Path, environment: Mapping[str, str] | None = None
) -> Ran:
    """The same in a process of its own, whose streams, start and end are the subject."""
    done = subprocess.run(
        [*PROGRAM, *arguments],
        cwd=cwd,
        env={**os.environ, **(environment or {})},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    return Ran(done.returncode, done.stdout, done.stderr)


def begun(*arguments: str, cwd: Path, environment: Mapping[str, str] | None = None) -> Process:
    """The same, still running: wait for a line of it, then do to it what is tested."""
    return subprocess.Popen(
        [*HEARING, *arguments],
        cwd=cwd,
        env={**os.environ, **(environment or {})},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def wait_for(words: str, stream: IO[str] | None) -> str:
    """Read lines of a running command until one has these words; all that was read."""
    assert stream is not None
    said = ""
    for line in stream:
        said += line
        if words in line:
            return said
    raise AssertionError(f"no line with {words!r}")
