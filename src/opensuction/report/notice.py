"""Alarms and other notices shown to people in a cycle, from every source, the most urgent first.

Alarms come from the controller. Drives and power supply reach the annunciator without it: a run in
which the controller could not announce anything is not a run without alarms.
"""

from collections.abc import Iterable
from typing import NamedTuple

from opensuction.report.wording import quantity
from opensuction.result.cycle_result import AlarmRecord, Announcement, CycleResult

CONTROLLER = "controller"

PRIORITIES = ("low", "medium", "high")
"""Rising."""

PATIENT_FIRST = (
    "circuit-disconnected",
    "spo2-low",
    "heart-rate-low",
    "airway-pressure-unsafe",
    "lung-volume-lost",
)
"""Of one priority these come first, in this order: about the patient, the most specific first."""
CAUSES = ("circuit-disconnected",)
"""Named beside a broken bound in the first line: what a person can mend at once."""
CONSEQUENCES = (
    "watchdog-fired",
    "message-late",
    "recovery-needed",
    "check-failed",
    "automation-stopped",
)
"""Of one priority these come last, in this order: they say that something else is wrong."""

WORDS_INSIDE: dict[str, tuple[str, str]] = {
    "reserve-energy-used": (
        "mains power is gone, and the catheter was not drawn out",
        "Draw the catheter out by hand. Restore mains power.",
    ),
    "withdrawal-unseen": (
        "the catheter was to be drawn out, and nothing shows that it moved",
        "Look at the patient. Draw the catheter out by hand. Check the encoder's cable.",
    ),
    "watchdog-fired": (
        "the drives' watchdog has stopped the machine",
        "Draw the catheter out by hand. Restart the controller.",
    ),
    "recovery-needed": (
        "the machine was put to work with the catheter not at its park position",
        "Draw the catheter out by hand.",
    ),
}
"""Sentence and remedy of conditions whose own words say or hope that the catheter comes out, for a
run at whose end it is still in."""


class Notice(NamedTuple):
    """Something that people were told."""

    condition: str
    """Name as in the JSON."""
    priority: str
    """``low``, ``medium`` or ``high``; empty where it is not known."""
    sentence: str
    remedy: str
    """May be empty."""
    started_s: float | None
    ended_s: float | None
    """None where it was still shown at the end."""
    latched: bool
    by: str
    """``controller``, ``drives`` or ``power``."""
    is_shown: bool
    """Whether the annunciator showed it, as far as that is known."""


def span(notice: Notice) -> str:
    """From when to when it was shown."""
    begin = "?" if notice.started_s is None else quantity(notice.started_s, "s")
    ended_s = notice.ended_s
    return f"from {begin} on" if ended_s is None else f"{begin} to {quantity(ended_s, 's')}"


def notices(result: CycleResult) -> list[Notice]:
    """Everything that was raised in a cycle, the most urgent first."""
    found = gather(result.alarms, result.told)
    return [_inside(notice) for notice in found] if result.is_inside else found


def gather(alarms: Iterable[AlarmRecord], told: Iterable[Announcement] | None) -> list[Notice]:
    """Everything that was raised, the most urgent first; the annunciator adds what no alarm has.

    alarms: of the controller. told: what the annunciator showed; None where that is not known.
    """
    shown = {one.what for one in told or ()}
    found = [_of_controller(alarm, told is None or alarm.condition in shown) for alarm in alarms]
    raised = {notice.condition for notice in found}
    for one in told or ():
        if one.what not in raised:
            raised.add(one.what)
            found.append(_of_annunciator(one))
    return sorted(found, key=_urgency)


def _of_controller(alarm: AlarmRecord, is_shown: bool) -> Notice:
    return Notice(
        condition=alarm.condition,
        priority=alarm.priority,
        sentence=alarm.sentence,
        remedy=alarm.remedy,
        started_s=alarm.started_s,
        ended_s=alarm.ended_s,
        latched=alarm.latched,
        by=CONTROLLER,
        is_shown=is_shown,
    )


def _of_annunciator(one: Announcement) -> Notice:
    return Notice(
        condition=one.what,
        priority=one.priority,
        sentence=one.sentence,
        remedy=one.remedy,
        started_s=one.at_s,
        ended_s=None,
        latched=False,
        by=one.by,
        is_shown=True,
    )


def _inside(notice: Notice) -> Notice:
    """The notice of a run at whose end the catheter is still in."""
    sentence, remedy = WORDS_INSIDE.get(notice.condition, (notice.sentence, notice.remedy))
    return notice._replace(sentence=sentence, remedy=remedy)


def _urgency(notice: Notice) -> tuple[int, int, int, float]:
    """Sorts before another where it is smaller."""
    known = notice.priority in PRIORITIES
    priority = PRIORITIES.index(notice.priority) if known else len(PRIORITIES)
    kind, place = 1, 0
    if notice.condition in PATIENT_FIRST:
        kind, place = 0, PATIENT_FIRST.index(notice.condition)
    elif notice.condition in CONSEQUENCES:
        kind, place = 2, CONSEQUENCES.index(notice.condition)
    started_s = float("inf") if notice.started_s is None else notice.started_s
    return -priority, kind, place, started_s
