"""The alarm log: what was signalled when, and what people did about it.

Made outside the compiled step from the signals of successive ticks. A log is a value: noting gives
a new one. It is bounded; what it had to let go of is counted. It goes to storage as plain data and
comes back from it, so that it survives the loss of power.

Alarms from beginning to end, read from the log: what a person is told afterwards.
"""

from collections.abc import Mapping
from enum import IntEnum
from typing import Any, NamedTuple

from opensuction.kernel.errors import InputError
from opensuction.safety.alarm.alarm_state import NOTHING, SILENT, Signals
from opensuction.safety.condition import row_of
from opensuction.safety.condition_mask import decode
from opensuction.safety.handling import Priority

VERSION = 1
"""Of the stored form."""


class AlarmEvent(IntEnum):
    """Event of an alarm, in the order within one tick. Never renumber."""

    STARTED = 0
    """Power-up: whatever was signalled before is no longer known."""
    ENDED = 1
    """The condition is over, and so is its alarm."""
    LATCHED = 2
    """The condition is over; its alarm waits for a reset."""
    RESET = 3
    """A person cleared what was latched."""
    RAISED = 4
    """The condition is present, also once more."""
    ESCALATED = 5
    ACKNOWLEDGED = 6
    PAUSED = 7
    """A person silenced everything for a while."""
    PAUSE_ENDED = 8


class Entry(NamedTuple):
    """One line of the log."""

    time_s: float
    """As the caller counts it; across power-ups the caller must keep counting."""
    condition: int
    """`NOTHING` where the event belongs to no single condition."""
    event: AlarmEvent


class Log(NamedTuple):
    """Entries, oldest first, and the signals that were seen last."""

    capacity: int
    entries: tuple[Entry, ...]
    lost: int
    """How many older entries had to go."""
    time_s: float
    """Of the last tick that was looked at."""
    last: Signals


def start(capacity: int, time_s: float) -> Log:
    """Log at the first power-up.

    capacity: how many entries are kept, at least 1; raises InputError for fewer.
    """
    if capacity < 1:
        raise InputError(f"the alarm log's capacity is {capacity} entries; it must be at least 1")
    entries = (Entry(time_s, NOTHING, AlarmEvent.STARTED),)
    return Log(capacity, entries, 0, time_s, SILENT)


def _append(log: Log, time_s: float, new: list[Entry], last: Signals) -> Log:
    entries = (*log.entries, *new)
    excess = max(len(entries) - log.capacity, 0)
    return Log(log.capacity, entries[excess:], log.lost + excess, time_s, last)


def restart(log: Log, time_s: float) -> Log:
    """A log that came back from storage, at the next power-up."""
    _require_order(log, time_s)
    return _append(log, time_s, [Entry(time_s, NOTHING, AlarmEvent.STARTED)], SILENT)


def _require_order(log: Log, time_s: float) -> None:
    if not time_s >= log.time_s:
        raise ValueError(f"the alarm log has reached {log.time_s} s and cannot go on at {time_s} s")


def _events(before: Signals, after: Signals) -> dict[AlarmEvent, int]:
    """Mask of the conditions to which each event happened, in the order of `AlarmEvent`."""
    ended = before.present & ~after.present
    raised = after.present & ~before.present
    return {
        AlarmEvent.ENDED: ended & ~after.latched,
        AlarmEvent.LATCHED: ended & after.latched,
        AlarmEvent.RESET: before.latched & ~after.latched & ~after.present,
        AlarmEvent.RAISED: raised,
        AlarmEvent.ESCALATED: after.escalated & ~before.escalated,
        AlarmEvent.ACKNOWLEDGED: after.acknowledged & ~before.acknowledged,
    }


def note(log: Log, time_s: float, signals: Signals) -> Log:
    """The log after a tick; the same object's entries where nothing changed.

    Raises ValueError for a time before the last one.
    """
    _require_order(log, time_s)
    new = [
        Entry(time_s, condition, event)
        for event, conditions in _events(log.last, signals).items()
        for condition in decode(conditions)
    ]
    paused, was_paused = signals.pause_left_s > 0.0, log.last.pause_left_s > 0.0
    if paused != was_paused:
        new.append(Entry(time_s, NOTHING, AlarmEvent.PAUSED if paused else AlarmEvent.PAUSE_ENDED))
    return _append(log, time_s, new, signals)


def store(log: Log) -> dict[str, Any]:
    """The log as plain data, ready for JSON or a database."""
    return {
        "version": VERSION,
        "capacity": log.capacity,
        "lost": log.lost,
        "time_s": log.time_s,
        "entries": [[entry.time_s, entry.condition, entry.event.name] for entry in log.entries],
    }


def load(data: Mapping[str, Any]) -> Log:
    """A log from its stored form; call `restart` before noting anything in it.

    Raises InputError where the data is no log of this version, or out of order.
    """
    if data.get("version") != VERSION:
        raise InputError(
            f"the alarm log's version is {data.get('version')!r}; this software reads {VERSION}"
        )
    try:
        entries = tuple(
            Entry(float(time_s), int(condition), AlarmEvent[event])
            for time_s, condition, event in data["entries"]
        )
        log = Log(int(data["capacity"]), entries, int(data["lost"]), float(data["time_s"]), SILENT)
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"the alarm log cannot be read: {error!r}") from error
    times = [*(entry.time_s for entry in entries), log.time_s]
    if times != sorted(times):
        raise InputError("the alarm log's entries are out of order; it was changed or damaged")
    if log.lost < 0 or not len(entries) <= log.capacity:
        raise InputError(
            f"the alarm log holds {len(entries)} of {log.capacity} entries and has lost {log.lost};"
            " it was changed or damaged"
        )
    return log


CLOSING = (AlarmEvent.ENDED, AlarmEvent.RESET)
"""What ends an alarm."""


class Episode(NamedTuple):
    """One alarm: from when it was raised until it was over."""

    condition: int
    priority: Priority
    """The highest that it had."""
    started_s: float
    ended_s: float | None
    """When nothing of it was shown any more; None where the log ends before."""
    latched: bool
    """Its condition ended and it was shown on, until a person reset."""
    acknowledged_s: float | None
    """When a person first answered it; None where nobody did."""


def _begin(entry: Entry) -> Episode:
    return Episode(
        condition=entry.condition,
        priority=row_of(entry.condition).handling.priority,
        started_s=entry.time_s,
        ended_s=None,
        latched=False,
        acknowledged_s=None,
    )


def _continue(episode: Episode, entry: Entry) -> Episode:
    """An alarm after another entry about it."""
    if entry.event in CLOSING:
        return episode._replace(ended_s=entry.time_s)
    if entry.event == AlarmEvent.LATCHED:
        return episode._replace(latched=True)
    if entry.event == AlarmEvent.ESCALATED:
        return episode._replace(priority=Priority(min(episode.priority + 1, Priority.HIGH)))
    if entry.event == AlarmEvent.ACKNOWLEDGED and episode.acknowledged_s is None:
        return episode._replace(acknowledged_s=entry.time_s)
    return episode


def list_episodes(log: Log) -> tuple[Episode, ...]:
    """Every alarm of a log in the order in which they were raised.

    What holds again while it is still shown is the same alarm. A power-up ends what was shown: it
    is not known any more. An alarm whose beginning the log had to let go of is left out.
    """
    found: list[Episode] = []
    shown: dict[int, int] = {}
    for entry in log.entries:
        if entry.event == AlarmEvent.STARTED:
            for index in shown.values():
                found[index] = found[index]._replace(ended_s=entry.time_s)
            shown.clear()
        elif entry.event == AlarmEvent.RAISED and entry.condition not in shown:
            shown[entry.condition] = len(found)
            found.append(_begin(entry))
        elif entry.condition in shown:
            index = shown[entry.condition]
            found[index] = _continue(found[index], entry)
            if entry.event in CLOSING:
                del shown[entry.condition]
    return tuple(found)
