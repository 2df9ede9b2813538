"""Events of a recording, derived from rows of the control loop."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from opensuction.ipc.event_ring import ProcessEvent
from opensuction.kernel.name import name_of
from opensuction.kernel.phase import Phase
from opensuction.kernel.record import Array
from opensuction.procedure.cycle.transition import Event as Transition
from opensuction.recording.cycle_file.event import RecordedEvent
from opensuction.runtime.loop import ROW_COLUMNS
from opensuction.safety import condition_mask
from opensuction.safety.condition import Condition

_TICK, _PHASE, _CAUSE, _TRIPS, _PRESENT, _LATCHED = (
    ROW_COLUMNS.index(name)
    for name in (
        "inputs.tick",
        "outputs.phase",
        "outputs.cause",
        "outputs.verdict.trips",
        "outputs.signals.present",
        "outputs.signals.latched",
    )
)


class Seen(NamedTuple):
    """State in the row before, to find changes by."""

    phase: int
    trips: int
    told: int
    """Conditions that people are told."""


NOTHING = Seen(-1, 0, 0)


def told(rows: Array) -> "np.ndarray[tuple[int], np.dtype[np.int64]]":
    """Conditions that people shall be told, in each row."""
    return rows[:, _PRESENT].astype(np.int64) | rows[:, _LATCHED].astype(np.int64)


def seen_in(row: Array) -> Seen:
    """State in a row."""
    return Seen(int(row[_PHASE]), int(row[_TRIPS]), int(told(row[np.newaxis])[0]))


def find(rows: Array, before: Seen) -> Iterator[tuple[int, RecordedEvent]]:
    """Events with the index of their row. before: of the row before the first."""
    watched = np.stack((rows[:, _PHASE], rows[:, _TRIPS], told(rows)))
    changes = np.diff(watched, axis=1, prepend=np.array(before, float)[:, np.newaxis]).any(axis=0)
    for at in np.flatnonzero(changes):
        row = rows[at]
        tick, now = int(row[_TICK]), seen_in(row)
        if now.phase != before.phase:
            cause = int(row[_CAUSE])
            detail = f"after {name_of(Transition(cause))}" if cause >= 0 else ""
            yield int(at), RecordedEvent(tick, "phase", name_of(Phase(now.phase)), detail)
        for number in condition_mask.decode(now.trips & ~before.trips):
            yield int(at), RecordedEvent(tick, "trip", name_of(Condition(number)))
        for number in condition_mask.decode(now.told ^ before.told):
            detail = "raised" if now.told >> number & 1 else "ended"
            yield int(at), RecordedEvent(tick, "alarm", name_of(Condition(number)), detail)
        before = now


def of_happening(happening: ProcessEvent) -> RecordedEvent:
    """Recorded event of one that the loop has told."""
    fields = happening.fields
    return RecordedEvent(
        int(fields.get("tick", 0)),
        str(fields["kind"]),
        str(fields.get("ask", fields.get("what", fields["kind"]))),
        str(fields.get("verdict", fields.get("detail", ""))),
        str(fields.get("who", "")),
        str(fields.get("key", "")),
    )
