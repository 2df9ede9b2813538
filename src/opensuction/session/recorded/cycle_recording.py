"""A simulated run as the recording that a machine would have left.

The inputs are those of the run; so are the outputs that its trace has. The state after each tick
comes from the controller, fed once more with these inputs by the call that the real-time loop uses:
a trace with some 200 columns more would cost every run of the simulation.

Events of a simulated run for its recording.
"""

from collections.abc import Iterator
from io import BytesIO
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from opensuction import __version__
from opensuction.controller import configuration
from opensuction.controller.configuration import Configuration
from opensuction.controller.real_time_call import INPUT_COLUMNS, OUTPUT_COLUMNS, RealTimeCall
from opensuction.controller.record import State
from opensuction.kernel import arithmetic_fingerprint
from opensuction.kernel.codegen import plain_row
from opensuction.kernel.interface import Commands, Requests
from opensuction.kernel.vocabulary import Phase, name_of
from opensuction.procedure.cycle.transition import Event as Transition
from opensuction.recording.cycle_file import row_schema
from opensuction.recording.cycle_file.frame import NOTICE, Heading
from opensuction.recording.cycle_file.row_schema import (
    INPUT_PART,
    OUTPUT_PART,
    STATE_PART,
    TICKS,
    RecordedEvent,
    SchemaColumn,
)
from opensuction.recording.cycle_file.writer import RecordingWriter
from opensuction.safety import condition_mask
from opensuction.safety.alarm.alarm_log import AlarmEvent
from opensuction.safety.alarm.alarm_state import NOTHING
from opensuction.safety.condition import Condition
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation import outcome
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.injection.injection import InjectedRun
from opensuction.simulation.trace import Columns, InputSpan
from opensuction.twin.machine.fail_safe import Annunciator
from opensuction.twin.machine.machine import Truth

WHO = "simulated person"
"""Nobody presses a button of the twin but the program."""


def _phases(columns: Columns, silent: set[int]) -> Iterator[tuple[int, RecordedEvent]]:
    """silent: rows from which on no controller ran."""
    phase = columns["phase"]
    for at in (0, *(np.flatnonzero(np.diff(phase)) + 1)):
        cause = int(columns["cause"][at])
        after = f"after {name_of(Transition(cause))}" if cause >= 0 and at not in silent else ""
        yield int(at), RecordedEvent(0, "phase", name_of(Phase(int(phase[at]))), after)


def _trips(columns: Columns) -> Iterator[tuple[int, RecordedEvent]]:
    masks = columns["verdict.trips"].astype(np.int64)
    before = np.concatenate(([0], masks[:-1]))
    for at in np.flatnonzero(masks & ~before):
        for number in condition_mask.decode(int(masks[at] & ~before[at])):
            yield int(at), RecordedEvent(0, "trip", name_of(Condition(number)))


def _alarms(columns: Columns) -> Iterator[tuple[int, RecordedEvent]]:
    first_s = float(columns["time_s"][0])
    for entry in outcome.log(columns).entries:
        at = round((entry.time_s - first_s) / DT_S)
        name = "audio" if entry.condition == NOTHING else name_of(Condition(entry.condition))
        if entry.event != AlarmEvent.STARTED:  # of the log itself
            yield at, RecordedEvent(0, "alarm", name, name_of(entry.event))


def _told(columns: Columns) -> Iterator[tuple[int, RecordedEvent]]:
    first_s = float(columns["time_s"][0])
    for one in outcome.told(columns):
        at = round((one.at_s - first_s) / DT_S)
        yield at, RecordedEvent(0, "told", name_of(one.condition), "at the bedside", who=one.by)


def _requests(span: InputSpan) -> Iterator[tuple[int, RecordedEvent]]:
    if span.set_by:
        yield span.first, RecordedEvent(0, "start", span.set_by)
    if not span.runs:
        yield span.first, RecordedEvent(0, "gap", "controller-stopped", f"for {span.ticks} ticks")
    for name in Requests._fields:
        if getattr(span.requests, name):
            key = f"{name}-{span.tick}"
            yield span.first, RecordedEvent(0, "request", name.replace("_", "-"), who=WHO, key=key)


def _faults(ran: InjectedRun) -> Iterator[tuple[int, RecordedEvent]]:
    for one in ran.faults:
        if np.isfinite(one.at_s):
            strength = f"strength {one.injection.strength:g}"
            name = one.injection.fault.title
            yield max(round(one.at_s / DT_S), 0), RecordedEvent(0, "fault", name, strength)


def events(ran: InjectedRun) -> list[tuple[int, RecordedEvent]]:
    """Events in the order of time, each with the row of the trace that it belongs to."""
    columns, silent = ran.columns, {span.first for span in ran.spans if not span.runs}
    found = [*_faults(ran), *_phases(columns, silent), *_trips(columns)]
    found += [*_alarms(columns), *_told(columns)]
    for span in ran.spans:
        found += _requests(span)
    first = ran.spans[0].tick
    placed = [(at, event._replace(tick=first + at)) for at, event in found]
    return sorted(placed, key=lambda one: one[0])


Table = NDArray[np.float64]

TWIN = "/twin"
"""Topic of what really happened, which no machine knows of itself."""
TWIN_COLUMNS = (
    SchemaColumn("phase", int),
    *row_schema.prefixed("truth", Truth),
    *row_schema.prefixed("annunciator", Annunciator),
    *row_schema.prefixed("obeyed", Commands),
)
_TRACED = {f"obeyed.{name}": f"commands.{name}" for name in Commands._fields}
"""Columns of the trace that have another name here."""
CHUNK_ROWS = 1000
"""Rows of a chunk: nothing is lost by larger ones in a file that is written at once."""
BLOCK_ROWS = 250
"""Rows that are made at once: they fit into a processor's second cache."""
TWIN_EVERY = 10
"""Of the trace's rows: 100 Hz are enough to see it, and a tenth of the file."""
TICK_NS = round(DT_S * 1e9)


class Clock(NamedTuple):
    """Clock of a run's rows."""

    began_ns: int
    """UTC of the first row, in nanoseconds since 1970."""

    def times_ns(self, some: slice) -> NDArray[np.uint64]:
        """Of these rows."""
        rows = np.arange(some.start, some.stop, some.step)
        return (self.began_ns + rows * TICK_NS).astype(np.uint64)


def heading(prepared: Prepared, began_ns: int) -> Heading:
    """Heading of the recording of a run."""
    chosen = Configuration(prepared.loop.controller, prepared.loop.heads_mm)
    choice, equipment = prepared.resolved.choice, prepared.resolved.equipment
    return Heading(
        software_version=__version__,
        settings=configuration.to_json(chosen),
        settings_hash=configuration.hash_of(chosen),
        fingerprint=arithmetic_fingerprint.fingerprint(),
        began_ns=began_ns,
        about={
            "machine": str(equipment.machine_name),
            "patient": str(equipment.patient_name or "none"),
            "protocol": str(prepared.resolved.protocol_name),
            "approach": choice.approach,
            "compensation": str(choice.compensation),
            "seed": str(equipment.seed),
            "faults": ", ".join(choice.faults) or "none",
            "notice": NOTICE,
        },
    )


def _inputs(columns: Columns, span: InputSpan, some: slice) -> Table:
    """Rows of inputs. some: rows of the trace, within the span."""
    rows = np.zeros((some.stop - some.start, len(INPUT_COLUMNS)))
    number = span.tick + np.arange(some.start, some.stop) - span.first
    for i, name in enumerate(INPUT_COLUMNS):
        if name in columns:
            rows[:, i] = columns[name][some]
        elif name.startswith("requests.") and some.start == span.first:
            rows[0, i] = getattr(span.requests, name.removeprefix("requests."))
    rows[:, INPUT_COLUMNS.index("tick")] = number
    rows[:, INPUT_COLUMNS.index("dt_s")] = DT_S
    rows[:, INPUT_COLUMNS.index("host.overrun")] = number < span.late_until_tick
    return rows


class _Recorder:
    """Writes a run, block by block."""

    def __init__(self, prepared: Prepared, ran: InjectedRun, file: RecordingWriter) -> None:
        self._loop, self._ran, self._file = prepared.loop, ran, file
        self._clock = Clock(file.began_ns)
        self._call: RealTimeCall | None = None
        self._events = iter(events(ran))
        self._next = next(self._events, None)

    def write(self) -> None:
        """All of it."""
        for span in self._ran.spans:
            if span.state is not None:
                self._start(span, span.state)
            for first in range(span.first, span.end, BLOCK_ROWS):
                some = slice(first, min(first + BLOCK_ROWS, span.end))
                self._tell(some.stop)
                if span.runs:
                    self._file.add_rows(TICKS, self._times(some), self._ticks(span, some))
                seen = slice(-(-some.start // TWIN_EVERY) * TWIN_EVERY, some.stop, TWIN_EVERY)
                self._file.add_rows(TWIN, self._times(seen), self._twin(seen))

    def _times(self, some: slice) -> NDArray[np.uint64]:
        return self._clock.times_ns(some)

    def _start(self, span: InputSpan, state: State) -> None:
        """Set the controller's state, and say so."""
        if self._call is None:
            self._call = RealTimeCall(self._loop.controller, self._loop.heads_mm, state)
        else:
            self._call.state = state
        numbers = np.concatenate(([span.tick], plain_row.pack(State, state)))
        at = slice(span.first, span.first + 1)
        self._file.add_rows(row_schema.STARTS, self._times(at), numbers[np.newaxis])

    def _tell(self, end: int) -> None:
        """Write the events before a row."""
        while self._next is not None and self._next[0] < end:
            at, event = self._next
            self._file.add_event(self._clock.began_ns + at * TICK_NS, event)
            self._next = next(self._events, None)

    def _ticks(self, span: InputSpan, some: slice) -> Table:
        """Rows of ticks."""
        inputs = _inputs(self._ran.columns, span, some)
        outputs = np.empty((len(inputs), len(OUTPUT_COLUMNS)))
        states = np.empty((len(inputs), STATE_PART.stop - STATE_PART.start))
        assert self._call is not None  # a run begins with a state
        self._call.run(inputs, outputs, states)
        for i, name in enumerate(OUTPUT_COLUMNS):
            if name in self._ran.sent:  # as it was in the run
                outputs[:, i] = self._ran.sent[name][some]
        rows = np.empty((len(inputs), len(row_schema.TICK_COLUMNS)))
        rows[:, INPUT_PART], rows[:, OUTPUT_PART], rows[:, STATE_PART] = inputs, outputs, states
        return rows

    def _twin(self, some: slice) -> Table:
        """Rows of what really happened."""
        columns = self._ran.columns
        names = [_TRACED.get(one.name, one.name) for one in TWIN_COLUMNS]
        return np.column_stack([columns[name][some] for name in names])


def record(prepared: Prepared, ran: InjectedRun, began_ns: int) -> bytes:
    """The recording of a run, as its file holds it.

    prepared: the cycle as it began. began_ns: UTC of its first row, in nanoseconds since 1970.
    """
    tables = {**row_schema.TABLES, TWIN: TWIN_COLUMNS}
    file = BytesIO()
    with RecordingWriter(file, heading(prepared, began_ns), tables, CHUNK_ROWS) as writer:
        _Recorder(prepared, ran, writer).write()
    return file.getvalue()
