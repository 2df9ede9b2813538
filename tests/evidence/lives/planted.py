"""Faults that a programmer could make in the processes of a machine, each planted by itself.

Each takes the place of something that is right, for as long as a test holds it there.
"""

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import pytest

from opensuction.controller import loop_tick
from opensuction.evidence.lives import simulated_computer
from opensuction.evidence.lives.simulated_process import SimulatedLocks
from opensuction.host.host import Clock, Host, Steps
from opensuction.ipc.deadline_scheduler import DeadlineScheduler
from opensuction.ipc.liveness import Heartbeat, Signs
from opensuction.ipc.mailbox import Mailbox
from opensuction.ipc.ring import EventWriter, Place, ReadCheckpoint
from opensuction.kernel.interface import NO_REQUESTS
from opensuction.machine.twin.twin_process import Listener
from opensuction.recording.cycle_file.writer import RecordingWriter
from opensuction.records.records import Records
from opensuction.records.trail.chain import Trail
from opensuction.runtime import control_process, controller_memory, loop, supervisor
from opensuction.runtime.database_writer import DatabaseWriter
from opensuction.runtime.flushed import Flushed
from opensuction.runtime.journal import Journal
from opensuction.runtime.loop import ControlLoop
from opensuction.runtime.recorder import Recorder
from opensuction.runtime.recorder_process import RecorderService
from opensuction.runtime.recorder_source import Source
from opensuction.runtime.supervisor import SupervisedProcess
from opensuction.simulation.machine_side import GREETED
from opensuction.twin.machine import fail_safe

Patch = pytest.MonkeyPatch
Plant = Callable[[Patch], None]


class PlantedFault(NamedTuple):
    """A fault of the software."""

    name: str
    what: str
    """Mistake in one line."""
    plant: Plant


def _nothing(*_: object, **__: object) -> None:
    return None


def _leave_out(owner: type, name: str) -> Plant:
    """Have a method do nothing."""
    return lambda patch: patch.setattr(owner, name, _nothing)


def _replace(owner: object, name: str, value: object) -> Plant:
    return lambda patch: patch.setattr(owner, name, value)


def _tick_by_tick(patch: Patch) -> None:
    """Have each tick done by its own process: a stretch does not call what is planted there."""
    patch.setattr(simulated_computer, "PairedStretches", lambda _: None)


def _release(is_always: bool) -> Plant:
    """Have a controller say always, or never, that drives shall obey it again."""

    def plant(patch: Patch) -> None:
        hear = ControlLoop._hear

        def hear_and_release(self: ControlLoop) -> object:
            heard = hear(self)
            self.memory.counts[loop_tick.RELEASED] = self.tick if is_always else loop_tick.NEVER
            return heard

        patch.setattr(ControlLoop, "_hear", hear_and_release)
        _tick_by_tick(patch)

    return plant


def _hang_long(patch: Patch) -> None:
    begin = SupervisedProcess.__init__

    def begin_patient(self: SupervisedProcess, *args: Any, **named: Any) -> None:
        begin(self, *args, **named)
        self._hung_s *= 10.0

    patch.setattr(SupervisedProcess, "__init__", begin_patient)


def _restart_once(patch: Patch) -> None:
    look = SupervisedProcess.look

    def look_once(self: SupervisedProcess) -> tuple[str, str] | None:
        return look(self) if len(self._tried) < 2 or self.is_alive() else None

    patch.setattr(SupervisedProcess, "look", look_once)


def _find_nobody(patch: Patch) -> None:
    def begin(self: SupervisedProcess) -> str:
        self._start()
        return f"{self.title}-started"

    patch.setattr(SupervisedProcess, "begin", begin)


def _end_no_hung(patch: Patch) -> None:
    patch.setattr(SupervisedProcess, "_end_when_hung", lambda _: None)


class _WallClock(NamedTuple):
    """A clock whose durations are the wall's."""

    clock: Clock

    def monotonic_ns(self) -> int:
        return self.clock.wall_ns()


def _beat_by_the_wall(patch: Patch) -> None:
    begin = Heartbeat.__init__

    def begin_by_the_wall(self: Heartbeat, folder: Any, host: Host) -> None:
        begin(self, folder, host)
        self._clock = _WallClock(host.clock)  # type: ignore[assignment]

    patch.setattr(Heartbeat, "__init__", begin_by_the_wall)


def _pace_by_the_wall(patch: Patch) -> None:
    tick = control_process._tick

    def tick_by_the_wall(own: ControlLoop, pace: Any, host: Host) -> Steps[None]:
        begin, began_ns = pace.begin, host.clock.wall_ns() - host.clock.monotonic_ns()
        pace.begin = lambda _: begin(host.clock.wall_ns() - began_ns)
        return tick(own, pace, host)

    patch.setattr(control_process, "_tick", tick_by_the_wall)


def _lose_nobody(patch: Patch) -> None:
    def is_lost(signs: Signs, known_deaths: int, running_s: float) -> bool:  # noqa: ARG001
        return False

    patch.setattr(loop, "is_lost", is_lost)


def _count_no_missed_tick(patch: Patch) -> None:
    begin = DeadlineScheduler.begin

    def begin_anew(self: DeadlineScheduler, now_ns: int) -> int:
        begin(self, now_ns)
        return 0

    patch.setattr(DeadlineScheduler, "begin", begin_anew)
    _tick_by_tick(patch)


def _hear_no_stop(patch: Patch) -> None:
    receive = Mailbox.receive

    def receive_others(self: Mailbox) -> object:
        pressed, answers = receive(self)
        return pressed._replace(abort=False) if pressed is not NO_REQUESTS else pressed, answers

    patch.setattr(Mailbox, "receive", receive_others)


def _answer_nobody(patch: Patch) -> None:
    write = EventWriter.write

    def write_others(self: EventWriter, kind: str, tick: int, **fields: str) -> None:
        if kind != "request":
            write(self, kind, tick, **fields)

    patch.setattr(EventWriter, "write", write_others)


def _drop_waiting(patch: Patch) -> None:
    receive = Mailbox.receive

    def receive_new(self: Mailbox) -> object:
        self._waiting.clear()
        return receive(self)

    patch.setattr(Mailbox, "receive", receive_new)


def _hear_always(patch: Patch) -> None:
    hear = Listener.hear

    def hear_something(self: Listener) -> bool:
        hear(self)
        return bool(self.heard.counts[GREETED])

    patch.setattr(Listener, "hear", hear_something)
    _tick_by_tick(patch)


def _wait_long(patch: Patch) -> None:
    of = fail_safe.of

    def of_patient(*args: Any) -> Any:
        watchdog = of(*args)
        return watchdog._replace(silence_s=100.0 * watchdog.silence_s)

    patch.setattr(fail_safe, "of", of_patient)


def _write_full_chunks_only(patch: Patch) -> None:
    flush = RecordingWriter.flush

    def flush_full(self: RecordingWriter) -> None:
        if self._pending_rows >= self._chunk_rows:
            flush(self)

    patch.setattr(RecordingWriter, "flush", flush_full)


def _reach_ahead(patch: Patch) -> None:
    def reach(self: DatabaseWriter, row: int) -> None:
        self.stored = row

    patch.setattr(DatabaseWriter, "reach", reach)


def _count_pending(patch: Patch) -> None:
    def kept(self: Recorder) -> int:
        return self._number - sum(map(len, self._before))

    patch.setattr(Recorder, "kept", property(kept))


def _drop_edges(patch: Patch) -> None:
    read = Source.read

    def read_less(self: Source) -> Any:
        found, happened = read(self)
        rows = found.rows[:-1] if len(found.rows) > 30 else found.rows
        return found._replace(rows=rows), happened

    patch.setattr(Source, "read", read_less)


def _close_at_once(patch: Patch) -> None:
    def close(self: DatabaseWriter, patience_s: float) -> Steps[bool]:  # noqa: ARG001
        self._is_wanted = False
        yield from ()
        return not self._tasks

    patch.setattr(DatabaseWriter, "close", close)


def _store_no_entry(patch: Patch) -> None:
    store = Trail.store

    def store_others(self: Trail, table: Any, row: Any) -> None:
        if table.name == "alarm":
            self._connection.execute(table.insert().values(row))
        else:
            store(self, table, row)

    patch.setattr(Trail, "store", store_others)


def _remember_no_key(patch: Patch) -> None:
    store = Records._store

    def store_anew(self: Records, kind: str, said: Any, _: str | None, *rest: Any) -> str:
        return store(self, kind, said, None, *rest)

    patch.setattr(Records, "_store", store_anew)


def _forget_the_state(patch: Patch) -> None:
    patch.setattr(controller_memory, "read_before", _nothing)


def _forget_the_phase(patch: Patch) -> None:
    read = controller_memory.read_before

    def read_parked(*args: Any) -> Any:
        before = read(*args)
        return None if before is None else before._replace(phase=0)

    patch.setattr(controller_memory, "read_before", read_parked)


def _go_on_behind(patch: Patch) -> None:
    place = ReadCheckpoint.set

    def place_ahead(self: ReadCheckpoint, run: str, at: Place) -> None:
        place(self, run, Place(at.row + 100 * (at.row > 0), at.event))

    patch.setattr(ReadCheckpoint, "set", place_ahead)


def _tell_no_alarm(patch: Patch) -> None:
    look = Journal._look

    def look_on(self: Journal, row: Any, mask: int) -> Iterator[Any]:
        self._known = mask
        yield from look(self, row, mask)

    patch.setattr(Journal, "_look", look_on)


def _follow_the_dead(patch: Patch) -> None:
    patch.setattr(Source, "is_replaced", lambda _: False)


def _take_no_lock(patch: Patch) -> None:
    class Free:
        def close(self) -> None:
            """There is none."""

    def take(self: Any, path: Any) -> Any:
        return self.take_file(path) or Free()

    patch.setattr(SimulatedLocks, "take", take)


PLANTED = (
    PlantedFault(
        "replaces-nobody",
        "a supervisor replaces nobody",
        _leave_out(SupervisedProcess, "look"),
    ),
    PlantedFault(
        "one-try",
        "a supervisor gives up after the first death",
        _replace(supervisor, "TRIES", 1),
    ),
    PlantedFault("restarts-once", "a supervisor replaces a process once only", _restart_once),
    PlantedFault("finds-nobody", "a supervisor starts what runs already", _find_nobody),
    PlantedFault(
        "control-hung-soon",
        "a controller counts as hung after .02 s, a fifth of its beat",
        _replace(supervisor, "CONTROL_HUNG_S", 0.02),
    ),
    PlantedFault("hung-late", "a process counts as hung after ten times as long", _hang_long),
    PlantedFault("hung-never", "a process that hangs is not ended", _end_no_hung),
    PlantedFault("beats-by-the-wall", "signs of life go by the wall clock", _beat_by_the_wall),
    PlantedFault("paces-by-the-wall", "ticks go by the wall clock", _pace_by_the_wall),
    PlantedFault(
        "missed-late",
        "a controller misses another process after 5 s instead of .5 s",
        _replace(loop, "MISSED_S", 5.0),
    ),
    PlantedFault("misses-nobody", "a controller tells of nobody who is lost", _lose_nobody),
    PlantedFault(
        "uncounted-ticks",
        "ticks that were missed are not counted",
        _count_no_missed_tick,
    ),
    PlantedFault("forgets", "a controller knows nothing of the one before", _forget_the_state),
    PlantedFault(
        "forgets-the-phase",
        "a controller believes that the one before died at rest",
        _forget_the_phase,
    ),
    PlantedFault(
        "never-released",
        "a controller never has the drives obey it again",
        _release(is_always=False),
    ),
    PlantedFault(
        "always-released",
        "drives that act alone obey again whoever speaks",
        _release(is_always=True),
    ),
    PlantedFault("hears-no-stop", "a STOP is answered and not obeyed", _hear_no_stop),
    PlantedFault("answers-nobody", "nobody is told what became of a request", _answer_nobody),
    PlantedFault(
        "refuses-nothing",
        "old, late and repeated requests are carried out",
        _replace(Mailbox, "_refuse_button", lambda *_: ""),
    ),
    PlantedFault(
        "adopts-nothing",
        "a recorder does not take up the cycle that goes on",
        _leave_out(DatabaseWriter, "adopt"),
    ),
    PlantedFault(
        "leaves-the-dead",
        "a recorder does not finish what a dead controller left",
        _replace(RecorderService, "_finish_before", lambda *_: iter(())),
    ),
    PlantedFault(
        "follows-the-dead", "a recorder does not notice another controller", _follow_the_dead
    ),
    PlantedFault("reaches-ahead", "what waits for the database counts as stored", _reach_ahead),
    PlantedFault("no-mark", "it is not noted how far was read", _leave_out(ReadCheckpoint, "set")),
    PlantedFault("marks-ahead", "more is noted as read than was kept", _go_on_behind),
    PlantedFault("counts-pending", "rows count as kept before they are written", _count_pending),
    PlantedFault(
        "writes-twice",
        "rows that a recorder wrote before it died are written again",
        _replace(Recorder, "_leave_out_written", lambda _, rows: rows),
    ),
    PlantedFault("drops-edges", "the last row of a large piece is dropped", _drop_edges),
    PlantedFault(
        "no-flush",
        "what is left is not written as a recording ends",
        _write_full_chunks_only,
    ),
    PlantedFault("no-notes", "how far recordings go is not noted", _leave_out(Flushed, "_write")),
    PlantedFault("closes-at-once", "a recorder ends with entries not stored", _close_at_once),
    PlantedFault("unchained", "alarms are stored without an entry in the trail", _store_no_entry),
    PlantedFault("no-keys", "what is said twice is put on record twice", _remember_no_key),
    PlantedFault("no-alarms", "alarms are not put on record", _tell_no_alarm),
    PlantedFault("drops-waiting", "a press that has to wait a tick is dropped", _drop_waiting),
    PlantedFault("hears-always", "the drives' watchdog never fires", _hear_always),
    PlantedFault("waits-long", "the drives wait 2 s instead of .02 s", _wait_long),
    PlantedFault(
        "no-end", "a controller's death ends no cycle", _replace(Journal, "end", lambda _: ())
    ),
    PlantedFault(
        "no-footer",
        "recordings are closed without their end",
        _leave_out(RecordingWriter, "_finish"),
    ),
    PlantedFault("no-lock", "two of the same may work at once", _take_no_lock),
)
"""Each fault with its name."""
