"""``opensuction`` for many command lines in turn: each call has a process forked from a warm one.

Half of what a short command costs is its start. Here one process imports the program, performs one
cycle so that the machine code is loaded, and then forks for each call; the fork takes on what a
process of its own would have had from the caller: arguments, folder, environment, streams. The
program that stands for ``opensuction`` in a folder of ``PATH`` only hands these over and ends as
the fork did.
"""

import atexit
import contextlib
import gc
import marshal
import os
import signal
import socket
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import NoReturn

from opensuction.cli import app

ROOT = Path(__file__).resolve().parents[2]
"""From where this module is found."""
CALLER = """\
#!{python} -IS
import marshal, os, sys
from socket import AF_UNIX, send_fds, socket

link = socket(AF_UNIX)
link.connect({address!r})
call = marshal.dumps((sys.argv[1:], os.getcwd(), dict(os.environ)))
send_fds(link, [len(call).to_bytes(4)], [0, 1, 2])
link.sendall(call)
status = int(link.recv(8) or b"70")  # what it waits for ended without a word
if status < 0:
    os.kill(os.getpid(), -status)
sys.exit(status)
"""
"""What runs as ``opensuction``: nothing is imported that Python does not bring."""


WARM_UP = ("cycle", "cycle --protocol paper --fault valve-jammed@suctioning")
"""What the process did before: the machine code of most commands is loaded then."""


@contextlib.contextmanager
def folder_of(scratch: Path) -> Iterator[Path]:
    """Folder for ``PATH`` with ``opensuction`` in it, as long as this lasts.

    scratch: where it is made; its path must be short enough for a socket.
    """
    address, program = scratch / "calls", scratch / "opensuction"
    program.write_text(CALLER.format(python=sys.executable, address=str(address)))
    program.chmod(0o755)
    command = [sys.executable, "-m", __name__, str(address)]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        try:
            assert process.stdout.readline() == b"ready\n"
            yield scratch
        finally:
            process.terminate()


class _Forks:
    """Calls that are being carried out, each by a process whose end its caller is told."""

    def __init__(self) -> None:
        self._callers: dict[int, socket.socket] = {}
        signal.signal(signal.SIGCHLD, lambda *_: self.answer())

    def add(self, pid: int, caller: socket.socket) -> None:
        self._callers[pid] = caller
        self.answer()  # it may have ended before it was noted

    def answer(self) -> None:
        """Tell the callers of processes that have ended with which status; negative: a signal."""
        for pid in tuple(self._callers):
            ended, status = os.waitpid(pid, os.WNOHANG)
            if ended:
                with self._callers.pop(pid) as caller, contextlib.suppress(BrokenPipeError):
                    caller.sendall(str(os.waitstatus_to_exitcode(status)).encode())


def _next_call(address: str) -> socket.socket:
    """Wait for calls; returns in the process that is to carry out one."""
    forks = _Forks()
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(address)
        listener.listen()
        print("ready", flush=True)  # noqa: T201
        while True:
            caller, _ = listener.accept()
            pid = os.fork()
            if pid == 0:
                signal.signal(signal.SIGCHLD, signal.SIG_DFL)
                return caller
            forks.add(pid, caller)


def _take_over(caller: socket.socket) -> None:
    """Make the caller's arguments, folder, environment and streams those of this process."""
    with caller:
        size, streams, _, _ = socket.recv_fds(caller, 4, 3)
        with caller.makefile("rb") as rest:
            arguments, folder, environment = marshal.loads(rest.read(int.from_bytes(size)))
    for mine, given in enumerate(streams):
        os.dup2(given, mine)
        os.close(given)
    # As Python opens them; those from before the fork may know a file of another kind.
    sys.stdin, sys.stdout = os.fdopen(0), os.fdopen(1, "w")
    sys.stderr = os.fdopen(2, "w", 1, errors="backslashreplace")
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    sys.argv = ["opensuction", *arguments]


def _carry_out() -> int:
    """Do what ``sys.argv`` says; the status with which ``opensuction`` would end."""
    try:
        app.main()
    except SystemExit as leaving:
        status = leaving.code
    except BaseException:
        sys.excepthook(*sys.exc_info())
        status = 1
    assert isinstance(status, int)
    return status


def _warm_up() -> None:
    """Carry out some commands, of which nothing is left but what they loaded."""
    with (
        tempfile.TemporaryDirectory() as folder,
        contextlib.chdir(folder),
        Path(os.devnull).open("w") as nowhere,
        contextlib.redirect_stdout(nowhere),
        contextlib.redirect_stderr(nowhere),
    ):
        import_module("scipy.signal")
        for number, line in enumerate(WARM_UP):
            sys.argv = ["opensuction", *line.split(), "--out", f"runs/{number}"]
            _carry_out()
    gc.collect()
    gc.freeze()  # what a fork does not touch it need not copy
    assert threading.active_count() == 1, "a fork has no thread but its own"


def main() -> NoReturn:
    """Carry out calls until this process is ended."""
    address = sys.argv[1]
    _warm_up()
    _take_over(_next_call(address))
    status = _carry_out()
    # The end of an interpreter, but for the objects: all of them would be copied to be let go.
    threading._shutdown()  # type: ignore[attr-defined]
    atexit._run_exitfuncs()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)


if __name__ == "__main__":
    main()
