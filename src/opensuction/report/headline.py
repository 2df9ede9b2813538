"""Headline of a cycle: the most urgent finding in one line, and the line below it.

In this order: the catheter is still inside; a bound for the patient was broken; the most urgent
alarm; completed with alarms; completed.
"""

from typing import NamedTuple

from opensuction.report import contradicting_alarms, ending, figures, harm
from opensuction.report.figure import FigureVerdict, attention, needs_look
from opensuction.report.notice import CAUSES, Notice, notices
from opensuction.report.summary import Summary, is_completed, is_inside, is_recorded, number
from opensuction.report.wording import capitalise, depth_words, quantity, stopped

NAMED = 2
"""So many figures are named in the first line; the line below it has all."""
UNNOTICED = "The machine would say that all is well."
"""Of a run in which nothing noticed an injected fault."""


class Headline(NamedTuple):
    """The first line of a report."""

    text: str
    verdict: FigureVerdict
    """``GOOD``, ``NOTICE`` or ``BAD``."""
    lead: str
    """What to do, and how the cycle ended."""
    look: str
    """Which figures need a look; may be empty."""


def headline(summary: Summary) -> Headline:
    """The first line of a cycle, and the line below it."""
    for said in (_inside, _harm, _alarm):
        found = said(summary)
        if found is not None:
            return found
    if not is_completed(summary):
        lead = stopped(capitalise(ending.reason(summary)))
        return Headline(ending.ended(summary), FigureVerdict.BAD, lead, _look(summary))
    return _completed(summary)


def _completed(summary: Summary) -> Headline:
    """A cycle that ran to its end without an alarm."""
    amber = [figure for figure in figures.figures(summary) if needs_look(figure)]
    values = [f"{figure.name.lower()} {figure.value}, {figure.remark}" for figure in amber]
    lead = stopped(capitalise("; ".join(values))) if values else ""
    unnoticed = ending.unnoticed(summary)
    if unnoticed:
        text = f"Completed, and nothing noticed the fault {' or '.join(unnoticed)}"
        return Headline(text, FigureVerdict.NOTICE, UNNOTICED, lead)
    if amber:
        named = ", ".join(attention(figure) for figure in amber[:NAMED])
        more = f" and {len(amber) - NAMED} more" if len(amber) > NAMED else ""
        text = f"Completed, look at {named}{more}"
        return Headline(text, FigureVerdict.NOTICE, lead, "")
    good = "Every figure is within the limit that was set for it."
    if is_recorded(summary):
        good = "Every figure that the machine knows is within the limit that was set for it."
    return Headline("Completed", FigureVerdict.GOOD, good, _planned(summary))


def _join(*parts: str) -> str:
    return " ".join(part for part in parts if part)


def _look(summary: Summary) -> str:
    """Which figures need a look."""
    names = [
        attention(figure)
        for figure in figures.figures(summary)
        if needs_look(figure)
        and figure.name != contradicting_alarms.AT_END  # the first line says it
    ]
    return f"Look at: {', '.join(names)}." if names else ""


def _planned(summary: Summary) -> str:
    """Which figures are outside a recommendation by design."""
    found = [figure for figure in figures.figures(summary) if figure.is_planned]
    return " ".join(f"{figure.name}: {figure.remark}." for figure in found)


def _ending(summary: Summary) -> str:
    """How the cycle ended, and why where the most urgent alarm does not say it."""
    first = next((notice.sentence for notice in notices(summary)), "")
    ended = stopped(ending.ended(summary))
    if is_completed(summary):
        return ended
    reason = ending.reason(summary)
    return ended if reason == first else f"{ended} {stopped(capitalise(reason))}"


def _told(summary: Summary) -> str:
    """The most urgent alarm in a sentence, or that there was none."""
    raised = notices(summary)
    if not raised:
        return "Nobody was told: no alarm was raised."
    return f"{_priority(raised[0])}: {stopped(raised[0].sentence)}"


def _priority(notice: Notice) -> str:
    return f"{notice.priority} alarm".strip().capitalize()


def _inside(summary: Summary) -> Headline | None:
    if not is_inside(summary):
        return None
    where = depth_words(number(summary, "tip", "end_mm") or 0.0)
    text = f"CATHETER IS STILL IN THE AIRWAY, {where}: draw it out by the handle"
    if is_recorded(summary):
        text = f"CATHETER STILL IN THE AIRWAY AS THE RECORDING ENDS, {where}, by estimate"
    lead = _join(_told(summary), _ending(summary))
    return Headline(text, FigureVerdict.BAD, lead, _look(summary))


def _harm(summary: Summary) -> Headline | None:
    broken = [(harm.sentence(summary, *found), found[1]) for found in harm.broken(summary)]
    if not broken:
        return None
    (sentence, words), rest = broken[0], broken[1:]
    causes = [notice.sentence for notice in notices(summary) if notice.condition in CAUSES]
    text = f"PATIENT AT RISK: {'; '.join([sentence, *causes])}"
    more = _join(*(stopped(f"Also: {also}") for also, _ in rest))
    lead = _join(words.remedy, more, _told(summary), _ending(summary))
    return Headline(text, FigureVerdict.BAD, lead, _look(summary))


def _alarm(summary: Summary) -> Headline | None:
    raised = notices(summary)
    if not raised:
        return None
    first = raised[0]
    over = "" if first.ended_s is None else f", over since {quantity(first.ended_s, 's')}"
    text = f"{_priority(first)}{over}: {first.sentence}"
    is_high = first.priority == "high"
    if is_completed(summary) and not is_high:
        text = f"Completed with alarms: {first.sentence}"
    ended = _ending(summary)
    if is_completed(summary):
        ended = "Completed with alarms." if is_high else ""
    is_bad = is_high or not is_completed(summary)
    return Headline(
        text,
        FigureVerdict.BAD if is_bad else FigureVerdict.NOTICE,
        _join(first.remedy, ended),
        _look(summary),
    )
