"""The control loop's rows in blocks, and the events in them, read once for all clients.

A control process may end and another one begin; then its ring is another file, and is followed.
"""

from pathlib import Path
from typing import NamedTuple

from opensuction.console.signals.channel import Block
from opensuction.controller import configuration
from opensuction.ipc.ring import EventReader, FollowedRing, ProcessEvent, RingReader
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array
from opensuction.kernel.vocabulary import name_of
from opensuction.runtime import loop
from opensuction.runtime.loop import CONFIGURED, ROW_COLUMNS, Seen
from opensuction.runtime.machine_folder import CONFIGURATION, EVENTS, RING
from opensuction.safety.condition import Condition

NS_PER_S = 1e9
AT_ONCE = 1000
"""Rows of a block, at most."""
_TIME = ROW_COLUMNS.index("loop.time_s")
_CONDITIONS = {
    name_of(one): (one.row.sentence, name_of(one.row.handling.priority)) for one in Condition
}


class SourceFacts(NamedTuple):
    """Facts about a control process."""

    source: int
    """It is the so manieth since the console began, from 1 on."""
    run: str
    version: str
    settings: str
    """Hash of what the controller goes by."""
    period_s: float
    utc_offset_s: float
    """UTC of the monotonic clock's zero, since 1970."""


class Occurrence(NamedTuple):
    """Something that happened, for a mark."""

    source: int
    tick: int
    time_s: float
    kind: str
    """``phase``, ``trip``, ``alarm``, ``request``, or what the loop says of itself."""
    name: str
    detail: str
    sentence: str = ""
    """Of an alarm or a trip: what is wrong."""
    priority: str = ""
    """Of an alarm or a trip: ``low``, ``medium`` or ``high``."""


class Found(NamedTuple):
    """Rows and events since the last call."""

    facts: SourceFacts | None
    """Of another control process than before; None: still the same."""
    blocks: tuple[Block, ...]
    occurrences: tuple[Occurrence, ...]


NOTHING = Found(None, (), ())


def marks(block: Block, seen: Seen) -> tuple[list[Occurrence], Seen]:
    """Phases, trips and alarms that change within rows. seen: in the row before the first."""
    found = []
    for at, one in loop.find(block.rows, seen):
        time_s = float(block.rows[at, _TIME])
        words = _CONDITIONS.get(one.name, ("", "")) if one.kind in ("alarm", "trip") else ("", "")
        found.append(
            Occurrence(block.source, one.tick, time_s, one.kind, one.name, one.detail, *words)
        )
    return found, loop.seen_in(block.rows[-1])


def _facts(reader: RingReader, source: int) -> SourceFacts:
    told = reader.facts.told
    return SourceFacts(
        source,
        told["run"],
        told["version"],
        told["settings"],
        int(told["period_ns"]) / NS_PER_S,
        int(told["began_utc_ns"]) / NS_PER_S,
    )


class SignalSource:
    """Follows one machine."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._ring = FollowedRing(folder / RING, lambda columns: columns == ROW_COLUMNS)
        self._event_ring = FollowedRing(folder / EVENTS, lambda _: True)
        self._events: EventReader | None = None
        self._seen = loop.NOTHING
        self._tip = (1.0, 0.0)
        self.facts: SourceFacts | None = None
        """Of the control process that is followed; None before there was one."""
        self._found = 0

    @property
    def next(self) -> int:
        """Number of the row that is read next."""
        return 1 if self._ring.reader is None else self._ring.reader.next

    def skip(self) -> None:
        """Leave out what nobody has asked for so far: go on with the newest."""
        self._look()
        if self._ring.reader is not None:
            newest = self._ring.reader.snapshot()
            self._ring.reader.next = self._ring.reader.newest() + 1
            if newest is not None:
                self._seen = loop.seen_in(newest[1])
        if self._events is not None:
            self._events.read()

    def read(self) -> Found:
        """Rows and events since the last call."""
        before = self._ring.reader
        rest = () if before is None else self._read(before)
        facts = self._look()
        if facts is None or self._ring.reader is None:
            return Found(None, *self._with_events(rest))
        if before is not None:
            # Of the one before: what it wrote between the last look and its end.
            rest = (*rest, *self._read(before, facts.source - 1))
        old = tuple(one for block in rest for one in self._marks(block))
        self._seen = loop.NOTHING
        blocks, occurrences = self._with_events(self._read(self._ring.reader))
        return Found(facts, (*rest, *blocks), (*old, *occurrences))

    def before(self, first: int) -> "PastRows | None":
        """Reads rows again that have been, from a number on; None where there are none."""
        if self._ring.reader is None or self.facts is None:
            return None
        return PastRows(self._folder, self, max(first, 1))

    def block(self, rows: Array, missed: int, source: int | None = None) -> Block:
        """Rows with what is needed to read them."""
        assert self.facts is not None
        return Block(source or self.facts.source, rows, missed, self.facts.period_s, *self._tip)

    def _look(self) -> SourceFacts | None:
        """Facts about a new control process; None: still the same."""
        if self._event_ring.look() and self._event_ring.reader is not None:
            self._events = EventReader(self._event_ring.reader)
        if not self._ring.look() or self._ring.reader is None:
            return None
        self._found += 1
        self.facts = _facts(self._ring.reader, self._found)
        self._read_tip()
        return self.facts

    def _read_tip(self) -> None:
        """Read the tip's gain and offset to the head from the controller's configuration."""
        try:
            text = (self._folder / CONFIGURATION).read_text(encoding="utf-8")
            tip = configuration.from_json(text).settings.limits.tip
        except (OSError, UnicodeDecodeError, InputError):
            return
        self._tip = (tip.gain, tip.offset_mm)

    def _read(self, reader: RingReader, source: int | None = None) -> tuple[Block, ...]:
        """All that a ring has by now, in blocks."""
        blocks = []
        for _ in range(reader.facts.slots // AT_ONCE + 1):
            found = reader.read(AT_ONCE)
            if len(found.rows):
                blocks.append(self.block(found.rows, found.missed, source))
            if len(found.rows) < AT_ONCE:
                break
        return tuple(blocks)

    def _marks(self, block: Block) -> list[Occurrence]:
        found, self._seen = marks(block, self._seen)
        return found

    def _with_events(
        self, blocks: tuple[Block, ...]
    ) -> tuple[tuple[Block, ...], tuple[Occurrence, ...]]:
        found = [one for block in blocks for one in self._marks(block)]
        told = [] if self._events is None else self._events.read()[0]
        if any(one.fields["kind"] == CONFIGURED for one in told):
            self._read_tip()
        found.extend(map(self._of_happening, told))
        return blocks, tuple(found)

    def _of_happening(self, happening: ProcessEvent) -> Occurrence:
        """Event of the control process, without the person who asked: that is for the records."""
        one = loop.of_happening(happening)
        time_s = int(happening.fields.get("time_ns", 0)) / NS_PER_S
        return Occurrence(self._found, one.tick, time_s, one.kind, one.name, one.detail)


class PastRows:
    """Rows that have been, once more, up to where the source is."""

    def __init__(self, folder: Path, source: SignalSource, first: int) -> None:
        self._reader = RingReader(folder / RING)
        self._reader.next = first
        self._source = source
        self._run = source.facts
        self._seen = loop.NOTHING

    @property
    def is_over(self) -> bool:
        """True once it is level with the source, or that has gone on to another process."""
        return self._reader.next >= self._source.next or self._source.facts is not self._run

    def read(self) -> Found | None:
        """The next of them; None once it is over."""
        if self.is_over:
            return None
        wanted = self._source.next - self._reader.next
        found = self._reader.read(min(wanted, AT_ONCE // 2))
        if not len(found.rows):
            return None
        block = self._source.block(found.rows, found.missed)
        happened, self._seen = marks(block, self._seen)
        return Found(None, (block,), tuple(happened))
