"""The recorder as a process: ``python -m opensuction.runtime.recorder_process DIR OUT``.

It reads what the control loop publishes in DIR, writes recordings to OUT and puts on record what
happened. How far everything is kept it notes in DIR: another one that begins after its death goes
on there, and takes first what a controller that died has left. While something is not kept a sign
of life is missing, so that the controller raises the alarm.
"""

import contextlib
import math
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from opensuction.controller import configuration
from opensuction.controller.loop_tick import AT_REST
from opensuction.host import this_computer
from opensuction.host.host import NS_PER_S, Host, Steps, after
from opensuction.ipc.liveness import Heartbeat, Process, ProcessLock
from opensuction.ipc.ring import (
    COLUMNS,
    EventReader,
    FollowedRing,
    Place,
    ProcessEvent,
    Read,
    ReadCheckpoint,
)
from opensuction.kernel import arithmetic_fingerprint, private_file
from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import NOT_A_DEVICE
from opensuction.machine import port
from opensuction.recording.cycle_file.frame import NOTICE, Heading
from opensuction.records.records import Records
from opensuction.runtime import machine_folder, recording_part
from opensuction.runtime.database_writer import Context, DatabaseWriter, OpenRecords
from opensuction.runtime.flushed import Flushed
from opensuction.runtime.journal import Journal
from opensuction.runtime.loop import ROW_COLUMNS
from opensuction.runtime.machine_folder import (
    CONFIGURATION,
    CONTROLS,
    EVENTS,
    EVENTS_BEFORE,
    FLUSHED,
    MARK,
    RECORDS,
    RING,
    RING_BEFORE,
    WATCH_EVENTS,
)
from opensuction.runtime.nonvolatile_memory import NonvolatileMemory
from opensuction.runtime.recorder import Recorder
from opensuction.runtime.recorder_source import Source

EVERY_S = 0.05
"""How often it looks: well before the ring of 10 s comes round."""
REFUSED_S = 0.1
"""How often where the disk refuses: all rows that it has not taken are read again each time."""
SYNCS_S = 1.0
"""How long after it was waited for the disk is waited for again while a recording goes on; up to
twice as long where it is slow."""
QUIET_S = 0.5
"""Without rows for longer than this the controller may be another one by now."""
ROOM_S = 6.0
"""How long a controller that died waits for room on the disk: the ring of the next one has more."""
PATIENCE_S = 5.0
"""How long an end waits for a database that is away."""
_TICK = ROW_COLUMNS.index("inputs.tick")


class Keeping(NamedTuple):
    """Database writer, and the notes of how far it and the recorder have come."""

    writer: DatabaseWriter
    mark: ReadCheckpoint
    flushed: Flushed
    memory: NonvolatileMemory


class ControllerSession:
    """Recording and records of all that one controller publishes."""

    def __init__(
        self, folder: Path, out: Path, source: Source, keeping: Keeping, host: Host
    ) -> None:
        self._folder, self._source, self._clock = folder, source, host.clock
        self._syncs_ns = self._syncing_since_ns = 0
        """When the disk is waited for next, and since when it is; 0: it is not."""
        self._writer, mark, self._flushed, self._memory = keeping
        self._mark, writer = mark, self._writer
        run = source.run.name
        self._place = mark.find(run) or Place(0, 0)
        left = source.begin(self._place)
        self._recorder = Recorder(
            out, run, self._describe, left.state, self._place.row, self._flushed, host
        )
        goes_on = None if left.goes_on == AT_REST else recording_part.name_of(run, left.goes_on)
        writer.follow(self._place.row)
        # Where rows are missing nobody knows what comes again.
        last = -1.0 if left.before is None else float(left.before[_TICK])
        last = math.inf if left.state is None else last
        self._journal = Journal(source.run, left.before, left.goes_on)
        unseen = self._journal.find_begun(left.behind)
        writer.adopt(
            self._about.machine.serial,
            goes_on,
            lambda name: recording_part.is_after(name, run, last),
            None if unseen is None else (unseen, self._context),
        )
        self._followed = self._place.row
        self._unrecorded = 0
        """Rows that were followed and that the disk never took; nothing on record tells of them."""

    @property
    def lost(self) -> str:
        """Reason why something is not kept; empty where all is."""
        return self._recorder.lost or self._writer.lost or self._memory.lost

    @property
    def is_refused(self) -> bool:
        """True while the disk does not take the rows."""
        return bool(self._recorder.lost)

    def _describe(self) -> Heading:
        """Heading of the recordings of this controller."""
        text = (self._folder / CONFIGURATION).read_text(encoding="utf-8")
        chosen = configuration.from_json(text)
        self._rule = chosen.settings.service.passes
        self._about, self._about_of = (
            machine_folder.read(self._folder),
            machine_folder.identity(self._folder),
        )
        self._context = Context(self._about, configuration.hash_of(chosen))
        return Heading(
            software_version=self._source.version,
            settings=configuration.to_json(chosen),
            settings_hash=self._context.settings_hash,
            fingerprint=arithmetic_fingerprint.fingerprint(),
            began_ns=self._source.run.began_utc_ns,
            about=_heading(self._source.told) | self._about.heading,
        )

    def _ask_whose(self) -> None:
        """Read the machine's identity again: a catheter is changed without other settings."""
        found = machine_folder.identity(self._folder)
        if found not in (self._about_of, machine_folder.NOWHERE):
            self._about_of, self._about = found, machine_folder.read(self._folder)
            self._context = self._context._replace(about=self._about)

    def take(self, found: Read, happened: list[ProcessEvent]) -> None:
        """Record the rows and events that the controller has published."""
        self._ask_whose()
        if len(found.rows):
            self._memory.take(found.rows[-1], self._rule)
        self._recorder.take(found, happened)
        self._sync()
        kept = self._recorder.kept
        last = found.first + len(found.rows) - 1
        if self._recorder.lost:
            self._source.go_back(kept)
        # Rows that are given again have been followed before.
        new = found.rows[max(self._followed - found.first + 1, 0) :]
        missed = found.first - 1 - self._followed
        if missed > 0 and len(new):
            self._writer.put(self._journal.miss(new[0], missed), self._context)
        for entry in self._journal.follow(new, happened):
            self._writer.put(entry, self._context)
        self._unrecorded += found.missed - max(missed, 0)
        if not self._recorder.lost:
            self._tell_unrecorded()
        self._bind()
        self._followed = max(self._followed, last)
        self._writer.reach(kept)
        event = self._source.event if self._writer.is_idle else self._place.event
        self._place = Place(min(kept, self._writer.stored), event)
        # Until then another recorder goes on with the controller before, or tells what is missing.
        if self._writer.has_caught_up and not self._unrecorded:
            self._mark.set(self._source.run.name, self._place)

    def _sync(self) -> None:
        """Have the disk keep what was recorded, now and then: a loss of power takes the rest.

        One that is slow is asked less often: it has enough to do with what is written. Not seldom,
        for it may be slow once.
        """
        now_ns = self._clock.monotonic_ns()
        if not (self._recorder.is_recording and self._writer.is_idle):
            return
        if self._syncing_since_ns:
            took_ns, self._syncing_since_ns = now_ns - self._syncing_since_ns, 0
            rest_ns = round(SYNCS_S * NS_PER_S)
            self._syncs_ns = now_ns + rest_ns + min(took_ns, rest_ns)
        if now_ns >= self._syncs_ns:
            assert self._recorder.path is not None
            self._syncing_since_ns = now_ns
            self._writer.sync(self._recorder.path)

    def _tell_unrecorded(self) -> None:
        """Put on record how many rows the disk never took."""
        ticks, self._unrecorded = self._unrecorded, 0
        if ticks > 0:
            self._writer.put(self._journal.leave_out(ticks), self._context)

    def _bind(self) -> None:
        """After the cycles that the recordings are of: what they hold."""
        self._writer.bind(self._recorder.take_ended(), self._flushed, self._about.machine)

    def end(self, died: bool) -> None:
        """No more comes. died: its writer is dead."""
        kept = self._recorder.kept
        self._recorder.close()
        if self._recorder.lost:
            self._unrecorded += self._followed - kept
        self._tell_unrecorded()
        if died:
            for entry in self._journal.end():
                self._writer.put(entry, self._context)
        self._bind()


def _heading(ring: Mapping[str, str]) -> dict[str, str]:
    """Entries of a recording on the machine that it was made on. ring: what its ring tells."""
    try:
        machine = port.read_description(ring)
    except InputError as error:  # of any machine everything is kept
        return {"disclaimer": NOT_A_DEVICE, "lacks": str(error)}
    told = {"notice": NOTICE} if machine.in_silico else {"disclaimer": NOT_A_DEVICE}
    lacking = machine.capabilities.lacking
    return {**told, "lacks": ", ".join(lacking)} if lacking else told


class RecorderService:
    """The recorder: a desk after the other."""

    def __init__(self, folder: Path, out: Path, host: Host, open_records: OpenRecords) -> None:
        self._folder, self._out, self._host = folder, out, host
        self._heartbeat, told = Heartbeat(folder, host), machine_folder.read(folder)
        self._writer = DatabaseWriter(told.database, host, open_records)
        self._keeping = Keeping(
            self._writer,
            ReadCheckpoint(folder / MARK),
            Flushed(folder / FLUSHED),
            NonvolatileMemory(None if told.memory is None else Path(told.memory), host),
        )
        # Before anything else is written: what a recorder that died had written is as it was.
        notes = self._keeping.flushed
        self._writer.bind(notes.left(), notes, told.machine)
        self._watch = FollowedRing(folder / WATCH_EVENTS, lambda columns: columns == COLUMNS)
        self._watched: EventReader | None = None
        self._said = ""
        """Why something was not kept, as it was said last."""
        self._finished = ""
        """The run of the controller that was followed to its end."""

    @property
    def _ending(self) -> bool:
        return self._host.terminations() > 0

    def steps(self) -> Steps[None]:
        """Record until the process is told to end."""
        self._heartbeat.begin(Process.RECORDER)
        # Or one that has never kept anything since is missed by nobody.
        self._heartbeat.beat(Process.KEEPING)
        while (source := (yield from self._wait())) is not None:
            yield from self._record(source)
            if self._ending:
                break
        if source is not None and source.is_replaced():
            # Another controller has begun, and it was not looked for yet.
            with contextlib.suppress(InputError, OSError):
                yield from self._record(self._find())
        if not (yield from self._keeping.memory.close(PATIENCE_S)):
            self._host.say(f"not kept: {self._keeping.memory.lost}")
        if not (yield from self._writer.close(PATIENCE_S)):
            self._host.say(f"not all was put on record: {self._writer.lost}")
        self._heartbeat.end(Process.RECORDER)
        self._heartbeat.end(Process.KEEPING)

    def _record(self, source: Source) -> Steps[None]:
        """Record all that one controller publishes."""
        yield from self._finish_before(source.run.name)
        desk = self._open(source)
        yield from self._follow(desk, source)
        desk.take(*source.drain())
        goes_on = self._ending and self._host.locks.holder(self._folder / CONTROLS) is not None
        desk.end(died=not goes_on or source.is_replaced())
        self._finished = source.run.name
        self._beat(desk.lost)

    def _find(self) -> Source:
        """The controller that there is. Raises InputError or OSError where there is none."""
        return Source(self._folder / RING, self._folder / EVENTS)

    def _open(self, source: Source) -> ControllerSession:
        return ControllerSession(self._folder, self._out, source, self._keeping, self._host)

    def _finish_before(self, run: str) -> Steps[None]:
        """Record the rest of a controller whose recorder died, too, maybe with nothing read yet.

        run: of the controller after it. Once a row of this one was read, all of it was taken.
        """
        if self._keeping.mark.find(run) is not None:
            return
        with contextlib.suppress(InputError, OSError):
            source = Source(self._folder / RING_BEFORE, self._folder / EVENTS_BEFORE)
            if source.run.name != self._finished:
                desk = self._open(source)
                desk.take(*source.drain())
                ends_ns = after(self._host.clock, ROOM_S)
                while (
                    desk.is_refused
                    and not self._ending
                    and self._host.clock.monotonic_ns() < ends_ns
                ):
                    self._beat(desk.lost)
                    yield after(self._host.clock, REFUSED_S)
                    desk.take(*source.drain())
                desk.end(died=True)

    def _wait(self) -> Steps[Source | None]:
        """The controller, once there is one; None where the process is told to end before."""
        while not self._ending:
            self._beat(self._writer.lost)
            try:
                return self._find()
            except (InputError, OSError):
                yield after(self._host.clock, EVERY_S)
        return None

    def _beat(self, lost: str) -> None:
        self._heartbeat.beat(Process.RECORDER)
        if not lost:
            self._heartbeat.beat(Process.KEEPING)
        elif lost != self._said:
            self._said = lost
            self._host.say(f"not kept: {lost}")

    def _hear_watch(self) -> list[ProcessEvent]:
        """Events of the supervisor since the last call, whichever supervisor there is."""
        if self._watch.look() and self._watch.reader is not None:
            self._watched = EventReader(self._watch.reader)
        return [] if self._watched is None else self._watched.read()[0]

    def _now_s(self) -> float:
        return self._host.clock.monotonic_ns() / NS_PER_S

    def _follow(self, desk: ControllerSession, source: Source) -> Steps[None]:
        """Record what one controller publishes, until it is replaced or the process shall end."""
        came_s = self._now_s()
        while not self._ending:
            found, happened = source.read()
            desk.take(found, [*happened, *self._hear_watch()])
            self._beat(desk.lost)
            # Whatever came while it was starting is taken: from now on its silence is a loss.
            self._heartbeat.work(Process.RECORDER)
            self._heartbeat.work(Process.KEEPING)
            now_s = self._now_s()
            if len(found.rows):
                came_s = now_s
            elif now_s - came_s > QUIET_S and source.is_replaced():
                return
            yield after(self._host.clock, REFUSED_S if desk.is_refused else EVERY_S)


def steps(
    host: Host, folder: Path, out: Path, open_records: OpenRecords = Records.open_for_machine
) -> Steps[None]:
    """Record until the process is told to end. Raises InputError where it cannot begin."""
    with ProcessLock(folder / RECORDS, "a recorder runs", host):
        try:
            private_file.make_folder(out)
        except OSError as error:
            raise InputError(f"no recordings can be kept in {out}: {error.strerror}") from None
        yield from RecorderService(folder, out, host, open_records).steps()


if __name__ == "__main__":
    _folder, _out = map(Path, sys.argv[1:])
    this_computer.run(lambda host: steps(host, _folder, _out))
