"""From what the control loop publishes to what is put on record: cycles, alarms, acts of people.

Each entry has a key that the same rows give again, so that a recorder that begins anew may say
twice what it had said.
"""

from collections.abc import Iterable, Iterator
from datetime import UTC, datetime
from typing import NamedTuple

import numpy as np

from opensuction.controller.loop_tick import AT_REST
from opensuction.ipc.ring import ProcessEvent
from opensuction.kernel.interface import STOP
from opensuction.kernel.record import Array
from opensuction.kernel.vocabulary import CYCLE, Phase, name_of
from opensuction.procedure.cycle.transition import Event as Transition
from opensuction.records.entry import Action, Alarm, CycleEnd, Outcome
from opensuction.runtime.loop import ROW_COLUMNS, is_steady, seen_in, told
from opensuction.runtime.recording_part import name_of as name_of_file
from opensuction.safety import condition_mask
from opensuction.safety.condition import Condition
from opensuction.safety.handling import Priority

MACHINE, SUPERVISOR = "opensuction", "opensuction supervisor"
"""Who acts where no person does."""
NOBODY = "unknown"
ANYBODY = "anybody"
"""Begins who asks where nobody has signed in; what follows is from where."""
QUIET_S = 10.0
"""Of the stops that such a one asks for the first is put on record, and another after so long:
whoever may press it for ever is not to fill the database."""
NS_PER_S = 1e9
_TIME, _LEFT, _TICK, _PHASE, _CAUSE, _TRIPS, _PRESENT, _LATCHED, _HEAD = (
    ROW_COLUMNS.index(name)
    for name in (
        "loop.time_s",
        "loop.left_rest",
        "inputs.tick",
        "outputs.phase",
        "outputs.cause",
        "outputs.verdict.trips",
        "outputs.signals.present",
        "outputs.signals.latched",
        "inputs.readings.head_mm",
    )
)
_FOLLOWED = (_LEFT, _PHASE, _TRIPS, _PRESENT, _LATCHED)


class Entry(NamedTuple):
    """One thing that is put on record."""

    key: str
    at: datetime
    what: "Begun | CycleEnd | Alarm | Action"


class Begun(NamedTuple):
    """A cycle has begun."""

    who: str
    recording: str
    """Name of its file, or of its first part."""


class ControllerRun(NamedTuple):
    """The controller that is followed."""

    name: str
    began_utc_ns: int
    """Of the monotonic clock's zero."""


def in_words(text: str, most: int = 64) -> str:
    """A text as a name on record: printable, with something in it."""
    kept = "".join(one if one.isprintable() else " " for one in text).strip()
    return kept[:most].strip() or NOBODY


class Journal:
    """Follows one controller, row by row."""

    def __init__(self, run: ControllerRun, before: Array | None, goes_on: float = AT_REST) -> None:
        """before: the row before the first, where there is one.

        goes_on: when the machine left its rest, of what goes on there and has been put on record.
        """
        self._run = run
        self._known = 0 if before is None else seen_in(before).told
        self._left_rest = goes_on if before is None else float(before[_LEFT])
        self._on_record = goes_on != AT_REST
        self._who, self._why, self._trips = NOBODY, "", 0
        self._stops: dict[str, datetime] = {}
        """When the last stop of nobody who signed in was put on record, by from where."""
        self._drawn_out = before is None
        """What began with the first row is a way out."""
        self._last = before

    @property
    def is_in_cycle(self) -> bool:
        """True while a cycle is on record that has not ended."""
        return self._on_record

    def find_begun(self, row: Array | None) -> Entry | None:
        """The beginning of the cycle that a row is of, for one that nobody saw begin."""
        if row is None or Phase(int(row[_PHASE])) not in CYCLE:
            return None
        return self._begin(row, NOBODY)

    def miss(self, first: Array, ticks: int) -> Entry:
        """Entry on rows that are missing. first: the one behind them."""
        detail = f"{ticks} ticks: what happened in them is not on record"
        return self._entry("missed", first, Action(MACHINE, "rows-missed", detail))

    def leave_out(self, ticks: int) -> Entry:
        """Entry on rows that were followed, the last one among them or before, and not kept."""
        assert self._last is not None
        detail = f"{ticks} ticks: no recording holds them, for the disk took none"
        return self._entry("unrecorded", self._last, Action(MACHINE, "rows-unrecorded", detail))

    def follow(self, rows: Array, happened: Iterable[ProcessEvent]) -> Iterator[Entry]:
        """The entries of rows, in order, and of what was told until then."""
        for event in happened:
            yield from self._hear(event)
        if not len(rows):
            return
        self._last = rows[-1]
        if is_steady(rows, _FOLLOWED):
            yield from self._look(rows[0], seen_in(rows[0]).told)
            return
        masks = told(rows)
        changed = np.flatnonzero(
            (np.diff(rows[:, _LEFT], prepend=self._left_rest) != 0)
            | (np.diff(rows[:, _PHASE], prepend=-1.0) != 0)
            | (masks != np.concatenate(([self._known], masks[:-1])))
            | (np.diff(rows[:, _TRIPS], prepend=-1.0) != 0)
        )
        for at in changed:
            yield from self._look(rows[at], int(masks[at]))

    def end(self) -> Iterator[Entry]:
        """The entries of a controller that writes no more: a cycle that goes on is broken off."""
        if self._last is None or not self._on_record:
            return
        self._on_record = False
        phase, head_mm = Phase(int(self._last[_PHASE])), float(self._last[_HEAD])
        detail = f"the controller died while {name_of(phase)}, the head at {head_mm:.1f} mm"
        yield self._entry("end", self._last, CycleEnd(Outcome.INTERRUPTED, detail))

    def _entry(self, kind: str, row: Array, what: Begun | CycleEnd | Alarm | Action) -> Entry:
        tick = int(row[_TICK])
        return Entry(f"{self._run.name}-{tick}-{kind}", self._at(row[_TIME] * NS_PER_S), what)

    def _begin(self, row: Array, who: str) -> Entry:
        left_rest = float(row[_LEFT])
        return self._entry("begin", row, Begun(who, name_of_file(self._run.name, left_rest)))

    def _at(self, monotonic_ns: float) -> datetime:
        return datetime.fromtimestamp((self._run.began_utc_ns + monotonic_ns) / NS_PER_S, tz=UTC)

    def _look(self, row: Array, mask: int) -> Iterator[Entry]:
        """Entries on the news in a row."""
        phase, left_rest = Phase(int(row[_PHASE])), float(row[_LEFT])
        self._trips |= int(row[_TRIPS])
        if left_rest != self._left_rest and self._left_rest != AT_REST:
            yield from self._rest(row, phase)
        self._left_rest = left_rest
        if phase in CYCLE and not self._on_record:
            self._on_record, self._why, self._trips = True, "", 0
            yield self._begin(row, self._who)
        if phase == Phase.ABORTING and row[_CAUSE] >= 0:
            self._why = name_of(Transition(int(row[_CAUSE])))
        for number in condition_mask.decode(mask & ~self._known):
            condition = Condition(number)
            priority = Priority(condition.row.handling.priority)
            alarm = Alarm(condition.name, priority.name.lower(), condition.row.sentence)
            yield self._entry(f"alarm-{number}", row, alarm)
        self._known = mask

    def _rest(self, row: Array, phase: Phase) -> Iterator[Entry]:
        """Entries on all that ends as the machine comes to rest."""
        if self._on_record:
            self._on_record = False
            yield self._entry("end", row, self._outcome(phase))
        elif self._drawn_out and self._left_rest <= 1.0:
            detail = f"drawn out by itself after the start; now {name_of(phase)}"
            yield self._entry("drawn-out", row, Action(MACHINE, "drawn-out", detail))

    def _outcome(self, phase: Phase) -> CycleEnd:
        if phase == Phase.PARKED:
            return CycleEnd(Outcome.COMPLETED, inside_at_end=False)
        trips = [name_of(one) for one in condition_mask.decode_trips(self._trips)]
        return CycleEnd(Outcome.ABORTED, ", ".join(filter(None, (self._why, *trips))))

    def _is_repeated(self, ask: str, who: str, at: datetime) -> bool:
        """True for a stop, by nobody who signed in, that was put on record a moment ago."""
        if ask != STOP or not who.startswith(ANYBODY):
            return False
        last = self._stops.get(who)
        if last is not None and (at - last).total_seconds() < QUIET_S:
            return True
        self._stops = {
            name: when
            for name, when in self._stops.items()
            if (at - when).total_seconds() < QUIET_S
        }
        self._stops[who] = at
        return False

    def _hear(self, event: ProcessEvent) -> Iterator[Entry]:
        """Entries on an event that a process told."""
        fields = event.fields
        kind, verdict = str(fields["kind"]), str(fields.get("verdict", ""))
        at = self._at(float(fields.get("time_ns", 0)))
        key = f"{self._run.name}-event-{event.number}"
        if kind == "request" and verdict != "malformed":
            ask, who = in_words(str(fields["ask"])), in_words(str(fields["who"]))
            if ask == "start" and verdict == "pressed":
                self._who = who
            if not self._is_repeated(ask, who, at):
                yield Entry(key, at, Action(who, ask, verdict))
        elif kind == "watch":
            what, detail = in_words(str(fields["what"])), str(fields["detail"])
            yield Entry(str(fields["key"]), at, Action(SUPERVISOR, what, detail))
        elif kind in ("began", "ended"):
            ask = "controller-" + ("restarted" if fields.get("recovered") == "yes" else kind)
            told = [str(fields[name]) for name in ("scheduler", "refusals") if fields.get(name)]
            if fields.get("lacks"):
                told.append(f"the machine lacks: {fields['lacks']}")
            detail = "; ".join(told)
            yield Entry(key, at, Action(MACHINE, ask, detail))
