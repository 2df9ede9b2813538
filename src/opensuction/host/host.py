"""Port of a machine's processes to the computer that they run on.

Clocks, sleep, locks, other processes, datagrams and chance are handed to each process as one
record. So the same code runs on a computer (`this_computer`) and in one that is simulated.

A process is a generator of `Steps`: it does what is due, and yields when it is to be called next.
Whatever lies between two yields is one step, which waits for nobody.
"""

from collections.abc import Callable, Generator, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import NamedTuple, Protocol, TypeVar

NS_PER_S = 1_000_000_000

Result = TypeVar("Result")
Steps = Generator[int, None, Result]
"""Yields when it is to be called next, by the monotonic clock, ns; one that is over: at once."""
Work = Generator[int | None, None, None]
"""Likewise of a worker; None: not before it is woken."""


class Clock(Protocol):
    """Clocks of a computer."""

    def monotonic_ns(self) -> int:
        """Time that never goes back nor jumps, ns; its zero means nothing."""

    def wall_ns(self) -> int:
        """UTC since 1970, ns; it jumps where somebody sets it."""

    def sleep_until(self, due_ns: int) -> None:
        """Sleep until an instant of the monotonic clock; at once where it is over."""


class Lock(Protocol):
    """A lock that is held until it is closed, or its process ends."""

    def close(self) -> None:
        """Let another one have it."""


class Locks(Protocol):
    """Locks by the path of a file. The system lets go of a process's when it ends."""

    def take(self, path: Path) -> Lock | None:
        """Take the lock of a task for this process; None where another process has it.

        Raises OSError where the file cannot be.
        """

    def take_file(self, path: Path) -> Lock | None:
        """Take the lock of a file; None where anybody has it, this process included.

        Raises OSError where the file cannot be.
        """

    def holder(self, path: Path) -> int | None:
        """Number of the process that has the lock of a task; None where nobody has it.

        Not for the process that has it itself: to look lets go of it.
        """


class Child(Protocol):
    """A process that was started."""

    @property
    def pid(self) -> int:
        """Its number."""

    def poll(self) -> int | None:
        """Its exit status; None while it runs."""

    def send_signal(self, sig: int) -> None:
        """Send it a signal."""

    def terminate(self) -> None:
        """Tell it to end."""

    def kill(self) -> None:
        """Have the system end it at once."""

    def wait(self, timeout: float | None = None) -> int:
        """Wait until it has ended; its exit status. timeout: in s; None: for ever."""


class Processes(Protocol):
    """The computer's processes."""

    def spawn(self, module: str, arguments: Sequence[str], log: Path) -> Child:
        """Start a module as a process that belongs to no terminal and no parent.

        log: what it says is added to this file.
        """

    def signal(self, pid: int, number: int) -> None:
        """Send a signal; to a process that has ended: nothing happens."""


class Inbox(Protocol):
    """Datagrams that come to a path."""

    def receive(self, most: int) -> bytes | None:
        """The next one, cut at so many bytes; None where there is none. Never waits."""

    def close(self) -> None:
        """Take no more."""


class Outbox(Protocol):
    """Sends datagrams."""

    def send(self, path: Path, data: bytes) -> None:
        """Send one. Raises OSError where nobody listens, or has no room within the patience."""

    def close(self) -> None:
        """Send no more."""


class Datagrams(Protocol):
    """Datagrams between processes of one user."""

    def listen(self, path: Path) -> Inbox:
        """Listen at a path that only this user may send to; what was there before goes.

        Raises OSError where that cannot be.
        """

    def sender(self, patience_s: float) -> Outbox:
        """Send from here. patience_s: longest wait for room; 0: none."""


class File(Protocol):
    """A file that is written, as `io.FileIO`."""

    @property
    def closed(self) -> bool:
        """True once it was closed."""

    def write(self, data: memoryview, /) -> int:
        """Hand bytes to the system; how many it took. Raises OSError where it takes none."""

    def seek(self, place: int, /) -> int:
        """Go on at this place."""

    def truncate(self) -> int:
        """Cut it off here. Raises OSError."""

    def close(self) -> None:
        """Write no more."""


class Files(Protocol):
    """Files on a disk. What was written outlives its process; a loss of power, what was synced."""

    def create(self, path: Path) -> File:
        """A new file of this user alone. Raises OSError, FileExistsError where there is one."""

    def write(self, path: Path, content: str) -> None:
        """Write a file of this user alone, and wait until the disk has it.

        After a loss of power it is as it was before, or holds all of the content. Raises OSError.
        """

    def sync(self, path: Path) -> None:
        """Wait until the disk has a file as it is now, and its name.

        Raises OSError where the disk refuses; what of the file it has then, nobody knows.
        """


class Worker(Protocol):
    """Work that a process does beside its steps, which it may keep waiting."""

    def wake(self) -> None:
        """Have it go on now."""

    @property
    def has_ended(self) -> bool:
        """True once its work is at its end."""


class Allowed(NamedTuple):
    """Real-time rights that the kernel has granted."""

    scheduler: str
    """``fifo`` at a priority, or ``other``: then whoever else wants the core gets its share."""
    memory_locked: bool
    """No page of it has to be fetched from a disk."""
    refusals: tuple[str, ...]
    """What it has not, each in a sentence."""


class Host(NamedTuple):
    """The computer, as one process of it is handed it."""

    clock: Clock
    locks: Locks
    processes: Processes
    datagrams: Datagrams
    files: Files
    token: Callable[[int], bytes]
    """So many random bytes that nobody can guess."""
    begin_worker: Callable[[Work], Worker]
    """Have work done beside this process's steps."""
    hardened: Callable[[], AbstractContextManager[Allowed]]
    """Locked memory and real-time priority for a loop."""
    say: Callable[[str], None]
    """Write a line where whoever looks after this process finds it: its log."""
    terminations: Callable[[], int]
    """How often this process was told to end."""


def finish(steps: Steps[Result], clock: Clock) -> Result:
    """Do steps to their end, and sleep in between; what they return."""
    while True:
        try:
            due_ns = next(steps)
        except StopIteration as end:
            result: Result = end.value
            return result
        clock.sleep_until(due_ns)


def after(clock: Clock, seconds: float) -> int:
    """The instant so many seconds from now, by the monotonic clock, ns."""
    return clock.monotonic_ns() + round(seconds * NS_PER_S)
