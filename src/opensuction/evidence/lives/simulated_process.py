"""A process of a simulated computer, and what the computer hands it: see `host.Host`.

The computer lets go of locks and inboxes when their process ends, however it ends.
"""

import errno
import signal
from collections import deque
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Protocol

from opensuction.host.host import Child, File, Inbox, Lock, Outbox, Steps, Work

ROOM = 10
"""Datagrams that wait at a path, as with the system's sockets."""
KILLED = -signal.SIGKILL
_ENDINGS = {0: "ended", KILLED: "was killed"}


class System(Protocol):
    """The computer, as far as its processes know it."""

    now_ns: int
    wall_offset_ns: int
    running: "Activity | None"
    """Whose step is being done."""
    locks: "dict[Path, SimulatedLock]"
    """Those that are held, by their paths."""
    inboxes: "dict[Path, SimulatedInbox]"
    """Those that somebody listens at, by their paths."""

    def tell(self, what: str) -> None:
        """Tell that a process began or ended."""

    def holder(self, path: Path) -> int | None:
        """See `host.Locks.holder`."""

    def spawn(self, module: str, arguments: Sequence[str], log: Path) -> Child:
        """See `host.Processes.spawn`."""

    def signal(self, pid: int, number: int) -> None:
        """See `host.Processes.signal`."""

    def deliver(self, inbox: "SimulatedInbox", data: bytes) -> None:
        """Bring a datagram to an inbox."""

    def schedule(self, activity: "Activity", due_ns: int) -> None:
        """Have an activity go on at an instant."""


class ProcessDiedError(BaseException):
    """A process has died in the middle of a step: nobody in it may catch this."""


class Activity:
    """The steps of a process, or of a worker of it."""

    def __init__(self, process: "SimulatedProcess", work: Steps[None] | Work) -> None:
        self.process, self.work = process, work
        self.due_ns: int | None = None
        """When it is called next; None: not before it is woken."""
        self.number = 0
        """Of the entry in the queue that counts; others have been overtaken."""
        self.has_ended = False
        self.busy_until_ns = 0
        """Until then it waits for the disk."""


class SimulatedProcess:
    """See `host.Child`."""

    def __init__(self, computer: "System", pid: int, module: str, log: Path) -> None:
        self.computer, self.module, self.log, self._pid = computer, module, log, pid
        self.terminations = 0
        self.status: int | None = None
        self.error: Exception | None = None
        """That it ended by; with it stays what it had open, as long as the computer is there."""
        self.frozen_until_ns = 0
        self.busy_until_ns = 0
        self.activities: list[Activity] = []
        self.locks: list[SimulatedLock] = []
        self.inboxes: list[SimulatedInbox] = []
        self.files: list[File] = []
        """Those that it has made; some may be closed."""
        self.fate: Callable[[], None] | None = None
        """Ends it as soon as it asks something of the disk or the database."""

    @property
    def pid(self) -> int:
        """See `host.Child.pid`."""
        return self._pid

    def poll(self) -> int | None:
        """See `host.Child.poll`."""
        return self.status

    def send_signal(self, sig: int) -> None:
        """See `host.Child.send_signal`."""
        self.computer.signal(self.pid, sig)

    def terminate(self) -> None:
        """See `host.Child.terminate`."""
        self.send_signal(signal.SIGTERM)

    def kill(self) -> None:
        """See `host.Child.kill`."""
        self.send_signal(signal.SIGKILL)

    def wait(self, timeout: float | None = None) -> int:  # noqa: ARG002
        """See `host.Child.wait`."""
        if self.status is None:
            raise RuntimeError("a simulated process is not waited for: look again later")
        return self.status

    def say(self, line: str) -> None:
        """Add a line to its log."""
        with self.log.open("a", encoding="utf-8") as file:
            file.write(f"opensuction: {line}\n")

    def end(self, status: int) -> None:
        """It does nothing more, and the system takes back what it holds for it."""
        self.status = status
        self.computer.tell(f"{self.module.rpartition('.')[2]} {_ENDINGS.get(status, 'failed')}")
        for lock in tuple(self.locks):
            lock.close()
        for inbox in tuple(self.inboxes):
            inbox.abandon()
        self.close_files()

    def meet_fate(self) -> None:
        """Die, where it is to die now. Raises ProcessDiedError then."""
        fate, self.fate = self.fate, None
        if fate is not None:
            fate()
            raise ProcessDiedError

    def close_files(self) -> None:
        """Close what it has open, as the system does when it ends: nothing more is written."""
        for file in self.files:
            file.close()


class SimulatedLock:
    """A lock that a process holds."""

    def __init__(self, process: SimulatedProcess, path: Path) -> None:
        self.process, self.path = process, path
        process.locks.append(self)
        process.computer.locks[path] = self

    def close(self) -> None:
        """See `host.Lock.close`."""
        if self in self.process.locks:
            self.process.locks.remove(self)
            del self.process.computer.locks[self.path]


class SimulatedLocks:
    """See `host.Locks`."""

    def __init__(self, process: SimulatedProcess) -> None:
        self._process = process

    def take(self, path: Path) -> Lock | None:
        """See `host.Locks.take`."""
        return self.take_file(path)

    def take_file(self, path: Path) -> Lock | None:
        """See `host.Locks.take_file`."""
        if not path.parent.is_dir():
            raise FileNotFoundError(errno.ENOENT, "No such file or directory", str(path))
        if path in self._process.computer.locks:
            return None
        return SimulatedLock(self._process, path)

    def holder(self, path: Path) -> int | None:
        """See `host.Locks.holder`."""
        return self._process.computer.holder(path)


class SimulatedInbox:
    """See `host.Inbox`."""

    def __init__(self, process: SimulatedProcess, path: Path) -> None:
        if not path.parent.is_dir():
            raise FileNotFoundError(errno.ENOENT, "No such file or directory", str(path))
        self._process, self._path = process, path
        self.waiting: deque[bytes] = deque()
        process.inboxes.append(self)
        process.computer.inboxes[path] = self

    def receive(self, most: int) -> bytes | None:
        """See `host.Inbox.receive`."""
        return self.waiting.popleft()[:most] if self.waiting else None

    def close(self) -> None:
        """See `host.Inbox.close`."""
        self.abandon()

    def abandon(self) -> None:
        """Nobody listens any more."""
        if self in self._process.inboxes:
            self._process.inboxes.remove(self)
        if self._process.computer.inboxes.get(self._path) is self:
            del self._process.computer.inboxes[self._path]


class SimulatedOutbox:
    """See `host.Outbox`."""

    def __init__(self, computer: "System") -> None:
        self._computer = computer

    def send(self, path: Path, data: bytes) -> None:
        """See `host.Outbox.send`."""
        inbox = self._computer.inboxes.get(path)
        if inbox is None:
            raise ConnectionRefusedError(errno.ECONNREFUSED, "Connection refused")
        if len(inbox.waiting) >= ROOM:
            raise TimeoutError(errno.EAGAIN, "timed out")
        self._computer.deliver(inbox, data)

    def close(self) -> None:
        """See `host.Outbox.close`."""


class SimulatedClock:
    """See `host.Clock`."""

    def __init__(self, computer: "System") -> None:
        self._computer = computer

    def monotonic_ns(self) -> int:
        """See `host.Clock.monotonic_ns`."""
        return self._computer.now_ns

    def wall_ns(self) -> int:
        """See `host.Clock.wall_ns`."""
        return self._computer.now_ns + self._computer.wall_offset_ns

    def sleep_until(self, due_ns: int) -> None:
        """See `host.Clock.sleep_until`."""
        raise RuntimeError(f"a step of a simulated process sleeps until {due_ns} ns")


class SimulatedDatagrams:
    """See `host.Datagrams`."""

    def __init__(self, process: SimulatedProcess) -> None:
        self._process = process

    def listen(self, path: Path) -> Inbox:
        """See `host.Datagrams.listen`."""
        return SimulatedInbox(self._process, path)

    def sender(self, patience_s: float) -> Outbox:  # noqa: ARG002
        """See `host.Datagrams.sender`."""
        return SimulatedOutbox(self._process.computer)


class SimulatedProcesses:
    """See `host.Processes`."""

    def __init__(self, computer: "System") -> None:
        self._computer = computer

    def spawn(self, module: str, arguments: Sequence[str], log: Path) -> Child:
        """See `host.Processes.spawn`."""
        return self._computer.spawn(module, arguments, log)

    def signal(self, pid: int, number: int) -> None:
        """See `host.Processes.signal`."""
        self._computer.signal(pid, number)


class SimulatedWorker:
    """See `host.Worker`."""

    def __init__(self, computer: "System", activity: Activity) -> None:
        self._computer, self._activity = computer, activity

    def wake(self) -> None:
        """See `host.Worker.wake`."""
        self._computer.schedule(self._activity, self._computer.now_ns)

    @property
    def has_ended(self) -> bool:
        """See `host.Worker.has_ended`."""
        return self._activity.has_ended
