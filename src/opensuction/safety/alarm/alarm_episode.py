"""Alarms from beginning to end, read from the log: what a person is told afterwards."""

from typing import NamedTuple

from opensuction.safety.alarm.alarm_log import AlarmEvent, Entry, Log
from opensuction.safety.condition import row_of
from opensuction.safety.priority import Priority

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
