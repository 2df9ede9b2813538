"""Alarms and other notices shown to people in a cycle, from every source, the most urgent first.

Alarms come from the controller. Drives and power supply reach the annunciator without it: a run in
which the controller could not announce anything is not a run without alarms.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

from opensuction.report.summary import Summary, is_inside, number, rows, text
from opensuction.report.wording import quantity

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


def name_of(entry: Mapping[str, Any], key: str) -> str:
    """The name of a condition, with hyphens."""
    return (text(entry, key) or "?").replace("_", "-")


def _notice(summary: Summary, entry: Summary, name: str, by: str, is_shown: bool) -> Notice:
    sentence = text(entry, "sentence") or name.replace("-", " ")
    remedy = text(entry, "remedy") or ""
    if is_inside(summary) and name in WORDS_INSIDE:
        sentence, remedy = WORDS_INSIDE[name]
    started_s = number(entry, "started_s") if "started_s" in entry else number(entry, "at_s")
    return Notice(
        condition=name,
        priority=text(entry, "priority") or "",
        sentence=sentence,
        remedy=remedy,
        started_s=started_s,
        ended_s=number(entry, "ended_s"),
        latched=entry.get("latched") is True,
        by=by,
        is_shown=is_shown,
    )


def notices(summary: Summary) -> list[Notice]:
    """Everything that was raised, each condition once, the most urgent first."""
    told = rows(summary, "told")
    names_told = {name_of(entry, "what") for entry in told}
    knows = summary.get("told") is not None
    found = []
    for entry in rows(summary, "alarms"):
        name = name_of(entry, "condition")
        found.append(_notice(summary, entry, name, CONTROLLER, not knows or name in names_told))
    raised = {notice.condition for notice in found}
    for entry in told:
        name = name_of(entry, "what")
        if name not in raised:
            raised.add(name)
            by = text(entry, "by") or CONTROLLER
            found.append(_notice(summary, entry, name, by, is_shown=True))
    return sorted(found, key=_urgency)


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
