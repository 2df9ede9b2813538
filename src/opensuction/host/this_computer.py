"""This computer as a host: the system's clocks, locks, processes, sockets, files and threads."""

import contextlib
import ctypes
import errno
import fcntl
import gc
import os
import secrets
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from io import FileIO
from pathlib import Path

from opensuction.host.host import (
    NS_PER_S,
    Allowed,
    Child,
    File,
    Host,
    Inbox,
    Lock,
    Outbox,
    Steps,
    Work,
    finish,
)
from opensuction.kernel import private_file
from opensuction.kernel.errors import InputError

TIMER_ABSTIME = 1
MCL_CURRENT_AND_FUTURE = 1 | 2
PRIORITY = 50
"""Of the real-time class: above everything that is not, below the kernel's own threads."""
_QUESTION = "hhqqi4x"
"""The system's ``struct flock``: kind, from where, start, length, process."""


class _Timespec(ctypes.Structure):
    _fields_ = (("tv_sec", ctypes.c_long), ("tv_nsec", ctypes.c_long))


_libc = ctypes.CDLL(None, use_errno=True)


class _Clock:
    """See `host.Clock`."""

    monotonic_ns = staticmethod(time.monotonic_ns)
    wall_ns = staticmethod(time.time_ns)

    def sleep_until(self, due_ns: int) -> None:
        if due_ns <= time.monotonic_ns():
            return
        until = _Timespec(*divmod(due_ns, NS_PER_S))
        at = ctypes.byref(until)
        # A signal ends the sleep early: sleep on, the handler has run.
        while _libc.clock_nanosleep(time.CLOCK_MONOTONIC, TIMER_ABSTIME, at, None) == errno.EINTR:
            pass


class _Locks:
    """See `host.Locks`."""

    def take(self, path: Path) -> Lock | None:
        file = private_file.append(path)
        try:
            fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            file.close()
            return None
        return file

    def take_file(self, path: Path) -> Lock | None:
        file = private_file.append(path)
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            file.close()
            return None
        return file

    def holder(self, path: Path) -> int | None:
        try:
            with path.open("r+b") as file:
                asked = struct.pack(_QUESTION, fcntl.F_WRLCK, os.SEEK_SET, 0, 0, 0)
                kind, _, _, _, process = struct.unpack(
                    _QUESTION, fcntl.fcntl(file, fcntl.F_GETLK, asked)
                )
        except OSError:
            return None
        return None if kind == fcntl.F_UNLCK else int(process)


class _Processes:
    """See `host.Processes`."""

    def spawn(self, module: str, arguments: Sequence[str], log: Path) -> Child:
        with private_file.append(log) as said:
            return subprocess.Popen(
                [sys.executable, "-m", module, *arguments],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=said,
                start_new_session=True,
            )

    def signal(self, pid: int, number: int) -> None:
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, number)


class _Inbox:
    """See `host.Inbox`."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        try:
            self._socket.setblocking(False)
            private_file.bind(self._socket.bind, path)
        except OSError:
            self._socket.close()
            raise

    def receive(self, most: int) -> bytes | None:
        try:
            return self._socket.recv(most)
        except BlockingIOError:
            return None

    def close(self) -> None:
        self._socket.close()
        self._path.unlink(missing_ok=True)


class _Outbox:
    """See `host.Outbox`."""

    def __init__(self, patience_s: float) -> None:
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.settimeout(patience_s)

    def send(self, path: Path, data: bytes) -> None:
        self._socket.sendto(data, str(path))

    def close(self) -> None:
        self._socket.close()


class _Datagrams:
    """See `host.Datagrams`."""

    def listen(self, path: Path) -> Inbox:
        return _Inbox(path)

    def sender(self, patience_s: float) -> Outbox:
        return _Outbox(patience_s)


class _Files:
    """See `host.Files`."""

    def create(self, path: Path) -> File:
        return FileIO(path, "xb", opener=private_file.opener)

    def write(self, path: Path, content: str) -> None:
        private_file.write(path, content, syncs=True)
        self.sync(path)

    def sync(self, path: Path) -> None:
        for one in (path, path.parent):
            handle = os.open(one, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
            try:
                os.fsync(handle)
            finally:
                os.close(handle)


class _Thread:
    """A `host.Worker` in a thread of its own."""

    def __init__(self, work: Work) -> None:
        self._work, self._is_there, self._is_woken = work, threading.Condition(), False
        self._thread = threading.Thread(target=self._do, daemon=True)
        self._thread.start()

    def wake(self) -> None:
        with self._is_there:
            self._is_woken = True
            self._is_there.notify()

    @property
    def has_ended(self) -> bool:
        return not self._thread.is_alive()

    def _do(self) -> None:
        for due_ns in self._work:
            wait_s = None if due_ns is None else (due_ns - time.monotonic_ns()) / NS_PER_S
            with self._is_there:
                if not self._is_woken:
                    self._is_there.wait(None if wait_s is None else max(wait_s, 0.0))
                self._is_woken = False


@contextmanager
def hardened() -> Iterator[Allowed]:
    """Locked memory and real-time priority for a loop, with the collector of garbage at rest.

    Everything must have been built by then: what a loop leaves behind afterwards is freed by its
    references alone, which its memory staying flat is the proof of.

    Only the loop itself has the priority: to lock memory takes some .2 s, and an interpreter with
    machine code takes as long to end. At the priority of other machines' loops it would keep them
    standing meanwhile.
    """
    gc.collect()
    gc.freeze()
    gc.disable()
    locked = _libc.mlockall(MCL_CURRENT_AND_FUTURE) == 0
    not_locked = os.strerror(ctypes.get_errno())
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    scheduler, refusals = "fifo", []
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    except (PermissionError, OSError) as error:
        scheduler = "other"
        refusals.append(
            f"no real-time priority ({os.strerror(error.errno or 0)}): other work on this machine "
            "makes ticks late"
        )
    if not locked:
        refusals.append(
            f"memory is not locked ({not_locked}): a page that was put away makes a tick late"
        )
    try:
        yield Allowed(scheduler, locked, tuple(refusals))
    finally:
        if scheduler == "fifo":
            os.sched_setscheduler(0, *before)


def _say(line: str) -> None:
    sys.stderr.write(f"opensuction: {line}\n")
    sys.stderr.flush()


THIS_COMPUTER = Host(
    clock=_Clock(),
    locks=_Locks(),
    processes=_Processes(),
    datagrams=_Datagrams(),
    files=_Files(),
    token=secrets.token_bytes,
    begin_worker=_Thread,
    hardened=hardened,
    say=_say,
    terminations=lambda: 0,
)
"""For whoever is told to end in another way than by a signal."""


def run(steps: Callable[[Host], Steps[None]]) -> None:
    """Run a process on this computer until its steps end: all that its main does.

    A signal to end is counted for it. What it cannot do is said in one line, and ends it.
    """
    endings: list[int] = []
    signal.signal(signal.SIGTERM, lambda number, _: endings.append(number))
    try:
        finish(
            steps(THIS_COMPUTER._replace(terminations=lambda: len(endings))), THIS_COMPUTER.clock
        )
    except InputError as problem:
        sys.exit(f"opensuction: {problem}")
