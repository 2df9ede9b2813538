"""The disk of a simulated computer, and the database on it: full, failing, slow or away for a time.

Files and database are real ones. What the disk refuses is refused as the system and SQLite do it:
before anything of it is written, in the middle of it, or after all of it.
"""

import errno
import os
import random
import tempfile
from collections.abc import Callable
from functools import cache
from io import FileIO
from pathlib import Path

from opensuction.evidence.lives.life_fault import Kind
from opensuction.evidence.lives.simulated_process import SimulatedProcess, System
from opensuction.host.host import NS_PER_S, File
from opensuction.kernel import private_file
from opensuction.records.database import database, failure
from opensuction.records.database.database import Refusals
from opensuction.records.records import Records

LEFT_BYTES = 100_000
"""Room on a disk as it is called full, at most: a chunk or two."""
STALLS = 0.05
"""Share of the writes for which a slow disk keeps its process waiting."""
STALL_S = (0.1, 3.0)
STORED = 0.5
"""Share of the commits that fail and have been stored all the same."""


@cache
def _new_records() -> bytes:
    """A database as `Records.open` makes it."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "records.db"
        Records.open(str(file)).close()
        return file.read_bytes()


class SimulatedDisk:
    """State of the disk and of the database; each fault lasts until an instant of the clock."""

    def __init__(self, computer: System, seed: int) -> None:
        self._computer = computer
        self._chance = random.Random(f"disk {seed}")
        self.full_until_ns = self.failing_until_ns = self.slow_until_ns = self.away_until_ns = 0
        self._room = self._stalled_until_ns = 0
        self.synced: dict[Path, int] = {}
        """Bytes that the disk has of each file."""

    @property
    def refuses(self) -> bool:
        """True while disk or database refuse to keep something."""
        until_ns = max(self.full_until_ns, self.failing_until_ns, self.away_until_ns)
        return self._computer.now_ns < until_ns

    @property
    def unsound_until_ns(self) -> int:
        """Instant until which it refuses something, or keeps somebody waiting."""
        lasts_ns = max(self.full_until_ns, self.failing_until_ns, self.away_until_ns)
        return max(lasts_ns, self.slow_until_ns, self._stalled_until_ns)

    def strike(self, kind: Kind, until_ns: int) -> None:
        """Give disk or database a fault until then."""
        match kind:
            case Kind.DISK_FULL:
                self.fill(until_ns)
            case Kind.DISK_FAILING:
                self.failing_until_ns = max(self.failing_until_ns, until_ns)
            case Kind.DISK_SLOW:
                self.slow_until_ns = max(self.slow_until_ns, until_ns)
            case Kind.DATABASE:
                self.away_until_ns = max(self.away_until_ns, until_ns)

    def fill(self, until_ns: int) -> None:
        """Have it full until then: writes that need room are refused."""
        self.full_until_ns = max(self.full_until_ns, until_ns)
        self._room = self._chance.randrange(LEFT_BYTES)

    def take(self, wanted: int) -> int:
        """Take room for a write, as far as there is some. Raises OSError where there is none."""
        if self._computer.now_ns >= self.full_until_ns:
            return wanted
        if not self._room:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        taken = min(wanted, self._room)
        self._room -= taken
        return taken

    def give_back(self, size_bytes: int) -> None:
        """Take back the room of what was cut off."""
        self._room += size_bytes

    def stall_thread(self) -> None:
        """Keep whoever syncs waiting where the disk is slow, and no other thread of its process."""
        running, now_ns = self._computer.running, self._computer.now_ns
        if running is not None and now_ns < self.slow_until_ns:
            running.busy_until_ns = self._stalled_until_ns = now_ns + self._draw_stall_ns()

    def _draw_stall_ns(self) -> int:
        return round(self._chance.uniform(*STALL_S) * NS_PER_S)

    def stall(self, process: SimulatedProcess, share: float) -> None:
        """Keep a process waiting where the disk is slow, for a share of what it asks."""
        now_ns = self._computer.now_ns
        if now_ns < self.slow_until_ns and self._chance.random() < share:
            busy_ns = max(process.busy_until_ns, now_ns)
            process.busy_until_ns = busy_ns + self._draw_stall_ns()

    def sync(self, path: Path) -> None:
        """See `host.Files.sync`."""
        if self._computer.now_ns < self.failing_until_ns:
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        self.synced[path] = path.stat().st_size

    def write(self, path: Path, content: bytes) -> None:
        """See `host.Files.write`: one that cannot be synced may have been written all the same."""
        if self._computer.now_ns < self.full_until_ns:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        if self._computer.now_ns >= self.failing_until_ns or self._chance.random() < STORED:
            private_file.write(path, content)
        self.sync(path)

    def lose_power(self, folder: Path) -> None:
        """Cut what is in a folder's files to what was synced, and maybe some of what came after.

        A file that was never synced may be gone with its name.
        """
        for path in sorted(folder.iterdir()):
            size, kept = path.stat().st_size, self.synced.get(path)
            if kept is None and self._chance.random() < STORED:
                path.unlink()
            elif (kept or 0) < size:
                left = self._chance.randint(kept or 0, size)
                os.truncate(path, left)
                self.synced[path] = left

    def open_records(self, url: str | None) -> Records:
        """The records as a machine opens them, on this disk. Raises RecordsError."""
        if self._refuse_begin() != database.OK:
            raise failure.refused(database.parse(url).shown, failure.LOCKED)
        file = database.parse(url).file
        if file is not None and not file.exists():
            with private_file.create(file) as made:
                made.write(_new_records())
        records = Records.open_for_machine(url)
        refusals = Refusals(
            self._refuse_begin, self._refuse_commit, self._is_stored, self._meet_fate_at_commit
        )
        database.interpose(records.database, refusals)
        return records

    def _meet_fate_at_commit(self, store: Callable[[], object]) -> None:
        """Have whoever is to die do so as a commit begins, or once it is stored."""
        running = self._computer.running
        if running is None or running.process.fate is None:
            return
        if self.is_done(running.process):
            store()
        running.process.meet_fate()

    def draw_part(self, process: SimulatedProcess, size_bytes: int) -> int:
        """Bytes of a write that are there where its process may die in it."""
        return size_bytes if process.fate is None else self._chance.randint(0, size_bytes)

    def is_done(self, process: SimulatedProcess) -> bool:
        """True where what a process asks is done, though it may die now."""
        return process.fate is None or self._chance.random() < STORED

    def _refuse_begin(self) -> int:
        return database.BUSY if self._computer.now_ns < self.away_until_ns else database.OK

    def _refuse_commit(self) -> int:
        if self._computer.now_ns < self.full_until_ns:
            return database.NO_ROOM
        if self._computer.now_ns < self.failing_until_ns:
            return database.DISK_ERROR
        return database.OK

    def _is_stored(self) -> bool:
        """Of a commit that could not be synced nobody knows whether it is stored."""
        is_failing = self._refuse_commit() == database.DISK_ERROR
        return is_failing and self._chance.random() < STORED


class SimulatedFile(FileIO):
    """See `host.File`."""

    def __init__(self, disk: SimulatedDisk, process: SimulatedProcess, path: Path) -> None:
        super().__init__(path, "xb", opener=private_file.opener)
        self._disk, self._process = disk, process

    def write(self, data: memoryview, /) -> int:  # type: ignore[override]
        """See `host.File.write`."""
        self._disk.stall(self._process, STALLS)
        taken = self._disk.take(len(data))
        part = self._disk.draw_part(self._process, taken)
        written = super().write(data[:part])
        self._disk.give_back(taken - part)
        self._process.meet_fate()
        return written

    def truncate(self, size: int | None = None, /) -> int:
        """See `host.File.truncate`."""
        if not self._disk.is_done(self._process):
            self._process.meet_fate()
        before = os.fstat(self.fileno()).st_size
        left = super().truncate(size)
        self._disk.give_back(before - left)
        self._process.meet_fate()
        return left


class SimulatedFiles:
    """See `host.Files`."""

    def __init__(self, disk: SimulatedDisk, process: SimulatedProcess) -> None:
        self.disk, self._process = disk, process

    def create(self, path: Path) -> File:
        """See `host.Files.create`."""
        if not self.disk.is_done(self._process):
            self._process.meet_fate()
        made = SimulatedFile(self.disk, self._process, path)
        self._process.files.append(made)
        self.disk.synced.pop(path, None)
        self._process.meet_fate()
        return made

    def write(self, path: Path, content: str) -> None:
        """See `host.Files.write`: only the thread waits that asks for it."""
        self.disk.stall_thread()
        if self.disk.is_done(self._process):
            self.disk.write(path, content.encode())
        self._process.meet_fate()

    def sync(self, path: Path) -> None:
        """See `host.Files.sync`: only the thread waits that asks for it."""
        self.disk.stall_thread()
        if self.disk.is_done(self._process):
            self.disk.sync(path)
        self._process.meet_fate()
