"""Events of a simulated run for its recording."""

from collections.abc import Iterator

import numpy as np

from opensuction.kernel.name import name_of
from opensuction.kernel.phase import Phase
from opensuction.kernel.requests import Requests
from opensuction.procedure.cycle.transition import Event as Transition
from opensuction.recording.cycle_file.event import RecordedEvent
from opensuction.safety import condition_mask
from opensuction.safety.alarm.alarm_log import AlarmEvent
from opensuction.safety.alarm.alarm_state import NOTHING
from opensuction.safety.condition import Condition
from opensuction.simulation import alarm_record, annunciation
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.injection.injection import InjectedRun
from opensuction.simulation.input_log import InputSpan
from opensuction.simulation.trace import Columns

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
    for entry in alarm_record.log(columns).entries:
        at = round((entry.time_s - first_s) / DT_S)
        name = "audio" if entry.condition == NOTHING else name_of(Condition(entry.condition))
        if entry.event != AlarmEvent.STARTED:  # of the log itself
            yield at, RecordedEvent(0, "alarm", name, name_of(entry.event))


def _told(columns: Columns) -> Iterator[tuple[int, RecordedEvent]]:
    first_s = float(columns["time_s"][0])
    for one in annunciation.told(columns):
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
