"""A machine's processes on a simulated computer: nothing waits, and each run comes again.

Whoever asks, looks and kills stands outside: while they wait the computer's time goes by.
"""

import resource
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from opensuction.evidence.lives.simulated_computer import SimulatedComputer
from opensuction.evidence.lives.simulated_machine import MEMORY, machine_processes
from opensuction.host.host import NS_PER_S, Host, Steps, after
from tests.runtime.room import Room

OUTSIDE = "outside"
IDLE_S = 0.1
HOUR_S = 3600.0


class _Clock:
    """A `host.Clock` of who is outside: the computer works while they sleep."""

    def __init__(self, computer: SimulatedComputer) -> None:
        self._computer = computer

    def monotonic_ns(self) -> int:
        return self._computer.now_ns

    def wall_ns(self) -> int:
        return self._computer.now_ns + self._computer.wall_offset_ns

    def sleep_until(self, due_ns: int) -> None:
        self._computer.run_until(due_ns)


class SimulatedRoom(Room):
    """A `Room` on a computer of its own."""

    looks_s = 0.02
    """Between two looks controller and twin tick in a stretch; nothing here is over sooner."""

    def __init__(self, folder: Path, seed: int = 1) -> None:
        self.computer = SimulatedComputer(
            seed,
            {
                **machine_processes(lambda: self.computer),
                OUTSIDE: lambda host, _: self._stand(host),
            },
        )
        self._hosts: list[Host] = []
        pid = self.computer.spawn(OUTSIDE, (), folder / "outside.log").pid
        outside = self._hosts[0]._replace(clock=_Clock(self.computer))
        super().__init__(folder, outside, pid)

    def _stand(self, host: Host) -> Steps[None]:
        """Have a process that does nothing by itself, until it is told to end."""
        self._hosts.append(host)

        def idle() -> Steps[None]:
            while not host.terminations():
                yield after(host.clock, IDLE_S)

        return idle()

    def set_clock(self, by_s: float) -> None:
        """Set the wall clock forward, or back."""
        self.computer.wall_offset_ns += round(by_s * NS_PER_S)

    def close(self) -> None:
        """End all, and let go of what they have open."""
        super().close()
        self.computer.close()
        assert self.computer.crashes == []


@contextmanager
def simulated(begins: bool = True, seed: int = 1) -> Iterator[SimulatedRoom]:
    """A machine in a folder of its own. begins: the controller, too."""
    folder = Path(tempfile.mkdtemp(dir=MEMORY if MEMORY.is_dir() else None))
    made = SimulatedRoom(folder, seed)
    try:
        if begins:
            made.begin()
        yield made
    finally:
        made.close()
        shutil.rmtree(folder)


@contextmanager
def full_disk(largest: int) -> Iterator[None]:
    """No file of this process, in which the simulated ones are, grows beyond so many bytes."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (largest, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
