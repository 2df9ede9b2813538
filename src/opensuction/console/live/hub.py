"""The machine's newest row, as a state for all who look: worked out once, not once a page.

Nothing here waits: neither for the control loop, which does not know of it, nor for the records.

The state, `RATE_HZ` times a second, to every page that listens: worked out once for all.

A page that cannot follow misses states, and gets the newest when it can: nothing is queued for it.

Outcome of the last cycle on record, looked up when the machine has come to rest.

Reasons for the end of a cycle, in words for a person: the records hold names of events.
"""

import asyncio
import json
import logging
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from opensuction.console.live import state
from opensuction.console.live.state import Seen, State
from opensuction.controller import configuration
from opensuction.controller.configuration import Configuration
from opensuction.ipc.liveness import FILE, Heartbeat
from opensuction.ipc.ring import FollowedRing
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array
from opensuction.kernel.vocabulary import RESTING, name_of
from opensuction.machine import port
from opensuction.machine.port import Description
from opensuction.procedure.cycle.transition import Event
from opensuction.records.records import Records
from opensuction.runtime.loop import ROW_COLUMNS
from opensuction.runtime.machine_folder import CONFIGURATION, RING, About
from opensuction.safety.condition import Condition
from opensuction.session.cycle.cycle_summary import ABORT_SENTENCES

FRESH_S = 0.02
"""A state that is no older is given again."""
SILENT = Description(in_silico=True, capabilities=port.NOTHING)
"""Description of a machine that no controller has described yet."""
LOG = logging.getLogger("opensuction.console")


class SentState(NamedTuple):
    """A state, and the text that all pages are sent."""

    state: State
    text: str
    at_s: float


class Hub:
    """Of one machine's folder. May be asked by several threads."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.last_cycle: State | None = None
        """What is on record of the last cycle; whoever looks there says it here."""
        self._ring = FollowedRing(folder / RING, lambda columns: columns == ROW_COLUMNS)
        self._lock = threading.RLock()
        self._heartbeat: Heartbeat | None = None
        self._beats = self._written = (0, 0)
        self._configuration: Configuration | None = None
        self._told: SentState | None = None
        self._said = ""

    def newest(self) -> tuple[int, Array] | None:
        """The newest row with its number; None where no controller has written any."""
        with self._lock:
            self._ring.look()
            reader = self._ring.reader
            return None if reader is None else reader.snapshot()

    def machine(self) -> Description:
        """The machine as its controller describes it; without a controller nothing is claimed.

        Raises InputError for what is no description.
        """
        with self._lock:
            self._ring.look()
            reader = self._ring.reader
            return SILENT if reader is None else port.read_description(reader.facts.told)

    def configuration(self) -> Configuration:
        """Present configuration of the controller. Raises InputError where there is none."""
        path = self.folder / CONFIGURATION
        with self._lock:
            written = _stamp(path)
            if self._configuration is None or written != self._written:
                try:
                    text = path.read_text(encoding="utf-8")
                except (OSError, UnicodeDecodeError) as error:
                    raise InputError(f"no machine is set up in {self.folder}: {error}") from None
                self._configuration, self._written = configuration.from_json(text), written
            return self._configuration

    def now(self) -> SentState:
        """Present state of the machine."""
        with self._lock:
            told = self._told
            if told is None or time.monotonic() - told.at_s > FRESH_S:
                told = self._told = self._tell()
            return told

    def state(self) -> State:
        """The same, without its text."""
        return self.now().state

    def _tell(self) -> SentState:
        try:
            found = state.tell(self._see(), self._look_at_beats(), self.last_cycle)
            text = json.dumps(found, allow_nan=False, separators=(",", ":"))
            self._said = ""
        except (InputError, ValueError, KeyError) as error:
            # Of what cannot be understood nothing is shown: it would look as if it were known.
            if self._said != str(error):
                self._said = str(error)
                LOG.error("the machine's state cannot be told: %s", error)
            found = state.tell(None, None, self.last_cycle)
            text = json.dumps(found, allow_nan=False, separators=(",", ":"))
        return SentState(found, text, time.monotonic())

    def _see(self) -> Seen | None:
        newest = self.newest()
        reader = self._ring.reader
        if newest is None or reader is None:
            return None
        number, values = newest
        return Seen(
            number=number,
            values=values,
            began_utc_ns=int(reader.facts.told["began_utc_ns"]),
            settings=self.configuration().settings,
            age_s=time.monotonic() - float(values[0]),
        )

    def _look_at_beats(self) -> Heartbeat | None:
        """The signs of life; the file is another one where the folder was cleared meanwhile."""
        beats = _stamp(self.folder / FILE)[:1]
        if beats == (0,):
            return None
        if self._heartbeat is None or beats != self._beats[:1]:
            self._heartbeat, self._beats = Heartbeat(self.folder), (beats[0], 0)
        return self._heartbeat


def _stamp(path: Path) -> tuple[int, int]:
    """Inode and modification time of a file; zeros where there is none."""
    try:
        found = path.stat()
    except OSError:
        return 0, 0
    return found.st_ino, found.st_mtime_ns


RATE_HZ = 20.0


class Broadcast:
    """Runs as long as anybody listens; within one event loop."""

    def __init__(self, hub: Hub) -> None:
        self._hub = hub
        self._next: asyncio.Future[str] | None = None
        self._task: asyncio.Task[None] | None = None
        self._listeners = 0

    def join(self) -> None:
        """One more listens."""
        self._listeners += 1
        if self._task is None or self._task.done():
            self._task = asyncio.get_running_loop().create_task(self._run())

    def leave(self) -> None:
        """One less."""
        self._listeners -= 1

    async def next(self) -> str:
        """The next state, as text."""
        if self._next is None or self._next.done():
            self._next = asyncio.get_running_loop().create_future()
        return await asyncio.shield(self._next)

    async def _run(self) -> None:
        loop = asyncio.get_running_loop()
        due_s = loop.time()
        while self._listeners > 0:
            waiting = self._next
            if waiting is not None and not waiting.done():
                waiting.set_result(self._hub.now().text)
            due_s = max(due_s + 1.0 / RATE_HZ, loop.time())
            await asyncio.sleep(due_s - loop.time())


CAUSES = {
    **ABORT_SENTENCES,
    Event.PHASE_OVERDUE: "a phase took longer than planned",
    Event.CHECK_FAILED: "the pre-use test failed",
}
"""Every event that breaks a cycle off, as a report says it; which phase and what failed are not on
record."""
_WORDS = {name_of(one): words for one, words in CAUSES.items()} | {
    name_of(one): one.row.sentence for one in Condition
}


def say(detail: str) -> str:
    """The detail of an outcome in words; what is no list of names stands for itself.

    >>> say("abort-requested")
    'a person asked for it'
    >>> say("tripped, catheter-jammed") == Condition.CATHETER_JAMMED.row.sentence
    True
    >>> say("nobody recorded how it ended")
    'nobody recorded how it ended'
    """
    names = [name for name in detail.split(", ") if name]
    if not names or any(name not in _WORDS for name in names):
        return detail
    # A limit that is named says more than that there was one.
    told = names[1:] if names[0] == name_of(Event.TRIPPED) and len(names) > 1 else names
    return "; ".join(_WORDS[name] for name in told)


LOOKS_S = 0.5
AGAIN = 20
"""In so many looks the records are asked anyway: they are written a little after the row."""
SOON = 4
"""Looks after a cycle in which its end may not be on record yet."""
REST = frozenset(name_of(phase) for phase in RESTING)


class LastCycle:
    """Looks in a thread of its own, for a database may be slow."""

    def __init__(self, hub: Hub, records: Records, about: Callable[[], About]) -> None:
        self._hub, self._records, self._about = hub, records, about
        self._is_over = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True, name="last cycle")
        self._count = 0

    def begin(self) -> None:
        """Look from now on."""
        self._thread.start()

    def end(self) -> None:
        """Look no more."""
        self._is_over.set()
        self._thread.join()

    def _run(self) -> None:
        while True:
            self.look()
            if self._is_over.wait(LOOKS_S):
                return

    def look(self) -> None:
        """Once, if it is time."""
        if self._hub.state()["phase"] not in REST:
            self._count = 0
            return
        if self._count < SOON or self._count % AGAIN == 0:
            try:
                self._hub.last_cycle = self._find()
            except InputError:
                self._hub.last_cycle = None  # not known is better than that of before
        self._count += 1

    def _find(self) -> dict[str, Any] | None:
        past = self._records.history.list_cycles(self._about().machine.serial, 1)
        if not past:
            return None
        one = past[0]
        return {
            "id": one.id,
            "number": one.number,
            "outcome": None if one.outcome is None else str(one.outcome),
            "detail": one.detail,
            "why": say(one.detail),
            "inside_at_end": one.inside_at_end,
            "requested_by": one.requested_by,
            "started_at": one.started_at.isoformat(),
            "ended_at": None if one.ended_at is None else one.ended_at.isoformat(),
        }
