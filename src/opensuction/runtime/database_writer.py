"""Puts entries on record, in a thread of its own: a database may be slow, or away for a while.

What could not be stored is tried again, in order, until it is. Whoever hands entries over sees how
far they are stored, and keeps what comes after.
"""

from collections import deque
from collections.abc import Callable, Iterable
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import NamedTuple

from opensuction import __version__
from opensuction.host.host import NS_PER_S, Files, Host, Steps, Work, after
from opensuction.host.this_computer import THIS_COMPUTER
from opensuction.kernel.errors import InputError
from opensuction.records.database.failure import RecordsError
from opensuction.records.entry import Alarm, CycleEnd, CycleStart, Machine, Outcome
from opensuction.records.records import Records
from opensuction.runtime import flushed
from opensuction.runtime.flushed import Flushed
from opensuction.runtime.journal import SUPERVISOR, Begun, Entry
from opensuction.runtime.machine_folder import About

SHOWN_S, LOOKS_S = 1.0, 0.02
"""Of an entry that is lost people are told for so long; how often it is looked whether the last one
is over."""
AGAIN_S = 0.1
"""Between two tries, however much is handed over meanwhile; nobody is told of a database that is
away for a moment."""
UNSEEN = CycleEnd(Outcome.INTERRUPTED, "nobody recorded how it ended")

Task = Callable[[Records], None]
OpenRecords = Callable[[str | None], Records]
"""Opens the database of this address, as `Records.open_for_machine` does."""


class Context(NamedTuple):
    """Machine and settings that an entry belongs to."""

    about: About
    settings_hash: str


class _Reach:
    """A row until which everything was handed over, which moves on until it is its turn.

    A machine hands one over 20 times a second, for as long as a database may be away.
    """

    def __init__(self, followed: int, row: int, reached: Callable[[int, int], None]) -> None:
        self._followed, self._row, self._reached = followed, row, reached
        self._is_taken = False

    def move(self, followed: int, row: int) -> bool:
        """Reach to this row; false where that may come too late, or for another controller.

        Called where this is the last that was handed over: the row is right however late it is
        taken.
        """
        if followed != self._followed:
            return False
        self._row = row
        return not self._is_taken

    def __call__(self, _: Records) -> None:
        self._is_taken = True  # first: a row that comes from now on is handed over anew
        self._reached(self._followed, self._row)


class DatabaseWriter:
    """Stores entries in their order."""

    def __init__(
        self,
        database: str | None,
        host: Host = THIS_COMPUTER,
        open_records: OpenRecords = Records.open_for_machine,
    ) -> None:
        """database: see `Records.open_for_machine`; None: the default one."""
        self._database, self._host, self._open = database, host, open_records
        self._records: Records | None = None
        self._cycle: str | None = None
        """The machine's cycle that has not ended."""
        self._noted: Machine | None = None
        """The machine that was seen to be on record last."""
        self._tasks: deque[Task] = deque()
        self._is_wanted = True
        self.stored = 0
        """Rows up to this one are on record, of the controller that is followed."""
        self._followed = 0
        """How many were followed before it."""
        self._caught_up = 0
        """All is on record of those before this one."""
        self.lost = ""
        """Why entries are not stored; empty where they are."""
        self._worker = host.begin_worker(self._work())

    def put(self, entry: Entry, context: Context) -> None:
        """Store an entry some time soon."""
        self._hand(lambda records: self._store(records, entry, context))

    def bind(self, names: Iterable[str], notes: Flushed, machine: Machine) -> None:
        """Put on record what these recordings hold, by their notes, and drop the notes.

        The disk has each by then, or people were told that it may not.
        """
        for name in names:
            self._hand(partial(_sync, name=name, notes=notes, files=self._host.files))
            self._hand(partial(_bind, name=name, notes=notes, machine=machine))

    def sync(self, path: Path) -> None:
        """Have the disk keep a file as it is now, beside what is stored."""
        self._hand(lambda _: _sync_file(path, self._host.files))

    @property
    def is_idle(self) -> bool:
        """True once everything that was handed over is stored."""
        return not self._tasks

    def follow(self, row: int) -> None:
        """Another controller is followed from now on; what it did until this row is on record."""
        self._followed += 1
        self.stored = row
        followed = self._followed
        self._hand(lambda _: self._caught_up_with(followed))

    @property
    def has_caught_up(self) -> bool:
        """True once the controllers before the one that is followed are wholly on record."""
        return self._caught_up == self._followed

    def _caught_up_with(self, followed: int) -> None:
        self._caught_up = followed

    def reach(self, row: int) -> None:
        """Everything until this row has been handed over."""
        last = self._last()
        if last is None:
            self.stored = row
        elif not (isinstance(last, _Reach) and last.move(self._followed, row)):
            self._hand(_Reach(self._followed, row, self._reached))

    def _reached(self, followed: int, row: int) -> None:
        """Everything until this row is on record; of a controller before nobody asks any more."""
        if followed == self._followed:
            self.stored = row

    def adopt(
        self,
        machine: str,
        recording: str | None,
        comes: Callable[[str | None], bool],
        unseen: tuple[Entry, Context] | None = None,
    ) -> None:
        """Take up the machine's cycle that has no end.

        recording: of the cycle that goes on. comes: whether a recording is of one whose beginning
        will be handed over again, for a recorder that died had stored it and not yet said so. Any
        other is ended: nobody saw how. unseen: the beginning of the one that goes on, where nobody
        may have put it on record.
        """

        def take_up(records: Records) -> None:
            self._adopt(records, machine, recording, comes)
            if self._cycle is None and unseen is not None:
                self._store(records, *unseen)

        self._hand(take_up)

    def close(self, patience_s: float) -> Steps[bool]:
        """Store what is left; true where it could be within this time."""
        self._is_wanted = False
        self._worker.wake()
        clock = self._host.clock
        ends_ns = after(clock, patience_s)
        while not self._worker.has_ended and clock.monotonic_ns() < ends_ns:
            yield after(clock, LOOKS_S)
        return not self._tasks

    def _last(self) -> Task | None:
        """The last that is left to do; None where nothing is."""
        try:
            return self._tasks[-1]
        except IndexError:
            return None

    def _hand(self, task: Task) -> None:
        self._tasks.append(task)
        self._worker.wake()

    def _work(self) -> Work:
        """Store what is handed over, until nothing more is wanted and nothing is left."""
        while self._tasks or self._is_wanted:
            if not self._tasks:
                yield None
            elif self._try(self._tasks[0]):
                if self.lost:
                    yield from self._show_loss()
                self._tasks.popleft()
                self.lost = ""
            else:
                yield from self._wait_to_try_again()
        if self._records is not None:
            self._records.close()

    def _show_loss(self) -> Work:
        """Leave time to see that an entry is lost."""
        clock = self._host.clock
        ends_ns = after(clock, SHOWN_S)
        while clock.monotonic_ns() < ends_ns:
            yield ends_ns

    def _wait_to_try_again(self) -> Work:
        """Whoever hands something over wakes the work; only an end has it try at once."""
        clock, was_wanted = self._host.clock, self._is_wanted
        ends_ns = after(clock, AGAIN_S)
        while clock.monotonic_ns() < ends_ns and self._is_wanted == was_wanted:
            yield ends_ns

    def _try(self, task: Task) -> bool:
        """Run a task; true where nothing of it is left to do. `lost` says so where it is lost."""
        try:
            if self._records is None:
                self._records = self._open(self._database)
            task(self._records)
            self.lost = ""
        except RecordsError as error:
            self._noted = None  # it may be another database by the next time
            self.lost = str(error)
            return False
        except NotSyncedError as error:
            # What a disk refused once it may call synced the next time without having it. The
            # hash goes on record all the same: an audit finds what is missing.
            self.lost = str(error)
            self._host.say(self.lost)
        except InputError as error:
            # What the records do not take today they will not take tomorrow.
            self._noted = None
            self._host.say(f"not put on record: {error}")
            self.lost = ""
        except Exception as error:
            self.lost = f"{type(error).__name__}: {error}"
            self._host.say(f"not put on record: {self.lost}")
        return True

    def _store(self, records: Records, entry: Entry, context: Context) -> None:
        what, key, at = entry.what, entry.key, entry.at
        machine = context.about.machine
        if isinstance(what, Begun):
            # A recorder that died may have put it on record, and have heard more of who asked.
            begun = _find_begun(records, machine.serial, what.recording)
            self._cycle = begun or records.begin_cycle(_start_of(what, context), key, at)
        elif isinstance(what, CycleEnd):
            if self._cycle is not None:
                self._end(records, self._cycle, entry)
        elif isinstance(what, Alarm):
            records.add_alarm(machine, what, self._cycle, key, at)
        else:
            if machine != self._noted:
                records.note_machine(machine)
                self._noted = machine
            # What a supervisor did is said again by a recorder that begins anew, maybe later.
            cycle = None if what.done_by == SUPERVISOR else self._cycle
            own = what._replace(machine=machine.serial, cycle_id=cycle)
            records.act(own, key, at)

    def _end(self, records: Records, cycle: str, entry: Entry) -> None:
        """End a cycle; one that has ended already is the machine's no longer, either."""
        assert isinstance(entry.what, CycleEnd)
        try:
            records.end_cycle(cycle, entry.what, entry.key, entry.at)
        except RecordsError:
            raise
        except InputError:
            self._cycle = None
            raise
        self._cycle = None

    def _adopt(
        self,
        records: Records,
        machine: str,
        recording: str | None,
        comes: Callable[[str | None], bool],
    ) -> None:
        """See `adopt`."""
        for one in records.unfinished_cycles():
            if one.machine != machine or comes(one.recording):
                continue
            if recording is not None and one.recording == recording:
                self._cycle = one.id
            else:
                now = datetime.fromtimestamp(self._host.clock.wall_ns() / NS_PER_S, tz=UTC)
                records.end_cycle(one.id, UNSEEN, at=now)


class NotSyncedError(Exception):
    """The disk may not have a recording that was written."""


def _sync(_: Records, name: str, notes: Flushed, files: Files) -> None:
    note = notes.left().get(name)
    if note is not None:
        _sync_file(Path(note.folder) / name, files)


def _sync_file(path: Path, files: Files) -> None:
    try:
        files.sync(path)
    except FileNotFoundError:
        return  # an audit tells
    except OSError as error:
        problem = error.strerror or str(error)
        raise NotSyncedError(f"the disk may not have {path.name}: {problem}") from None


def _bind(records: Records, name: str, notes: Flushed, machine: Machine) -> None:
    note = notes.left().get(name)
    if note is None:
        return
    try:
        records.bind_recording(machine, flushed.bind(name, note))
    except RecordsError:
        raise  # it is tried again
    except InputError:
        notes.drop(name)
        raise
    notes.drop(name)


def _find_begun(records: Records, machine: str, recording: str) -> str | None:
    """The cycle of a recording that is on record and has not ended; None where there is none."""
    for one in records.unfinished_cycles():
        if one.machine == machine and one.recording == recording:
            return one.id
    return None


def _start_of(begun: Begun, context: Context) -> CycleStart:
    about = context.about
    return CycleStart(
        machine=about.machine,
        catheter=about.catheter,
        protocol=about.protocol,
        approach=about.approach,
        requested_by=begun.who,
        software=f"opensuction {__version__}",
        patient=about.patient,
        parameter_file=about.parameter_file,
        settings_sha256=context.settings_hash,
        recording=begun.recording,
    )
