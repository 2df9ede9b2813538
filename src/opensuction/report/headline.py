"""What a person must know first of a cycle, in one line, and the line below it.

In this order: the catheter is still inside; a bound for the patient was broken; the most urgent
alarm; completed with alarms; completed.
"""

from typing import NamedTuple

from opensuction.report import ending, figures, harm, witness
from opensuction.report.figure import FigureVerdict, attention, needs_look
from opensuction.report.notice import Notice, notices
from opensuction.report.summary import Summary, is_completed, is_inside, number
from opensuction.report.wording import capitalise, depth_words, quantity, stopped


class Headline(NamedTuple):
    """The first line of a report."""

    text: str
    verdict: FigureVerdict
    """``GOOD``, ``NOTICE`` or ``BAD``."""
    lead: str
    """What to do, how the cycle ended, and which figures need a look."""


def headline(summary: Summary) -> Headline:
    """The first line of a cycle, and the line below it."""
    for said in (_inside, _harm, _alarm):
        found = said(summary)
        if found is not None:
            return found
    if not is_completed(summary):
        lead = _join(stopped(capitalise(ending.reason(summary))), _look(summary))
        return Headline(ending.ended(summary), FigureVerdict.BAD, lead)
    amber = [figure for figure in figures.figures(summary) if needs_look(figure)]
    values = [f"{figure.name.lower()} {figure.value}, {figure.remark}" for figure in amber]
    lead = stopped(capitalise("; ".join(values))) if values else ""
    unnoticed = ending.unnoticed(summary)
    if unnoticed:
        text = f"Completed, and nothing noticed the fault {' or '.join(unnoticed)}"
        return Headline(text, FigureVerdict.NOTICE, lead)
    if amber:
        text = f"Completed, with {'a figure' if len(amber) == 1 else 'figures'} to look at"
        return Headline(text, FigureVerdict.NOTICE, lead)
    good = _join("Every figure that has a limit is within it.", _planned(summary))
    return Headline("Completed", FigureVerdict.GOOD, good)


def _join(*parts: str) -> str:
    return " ".join(part for part in parts if part)


def _look(summary: Summary) -> str:
    """Which figures need a look."""
    names = [
        attention(figure)
        for figure in figures.figures(summary)
        if needs_look(figure) and figure.name != witness.AT_END  # the first line says it
    ]
    return f"Look at: {', '.join(names)}." if names else ""


def _planned(summary: Summary) -> str:
    """Which figures are outside a recommendation by design."""
    found = [figure for figure in figures.figures(summary) if figure.is_planned]
    return " ".join(f"{figure.name}: {figure.remark}." for figure in found)


def _ending(summary: Summary, first: str = "") -> str:
    """How the cycle ended and why, unless the first line has said why. first: its sentence."""
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
    if not is_completed(summary) and raised[0].sentence == ending.reason(summary):
        return f"That is a {raised[0].priority} alarm."
    return f"{_priority(raised[0])}: {stopped(raised[0].sentence)}"


def _priority(notice: Notice) -> str:
    return f"{notice.priority} alarm".strip().capitalize()


def _inside(summary: Summary) -> Headline | None:
    if not is_inside(summary):
        return None
    where = depth_words(number(summary, "tip", "end_mm") or 0.0)
    text = f"CATHETER IS STILL IN THE AIRWAY, {where}: draw it out by the handle"
    lead = _join(_ending(summary), _told(summary), _look(summary))
    return Headline(text, FigureVerdict.BAD, lead)


def _harm(summary: Summary) -> Headline | None:
    listed = figures.figures(summary)
    broken = harm.broken(summary)
    if not broken:
        return None
    first, rest = broken[0], broken[1:]
    text = f"PATIENT AT RISK: {harm.sentence(first, listed)}"
    more = "".join(stopped(f" Also: {harm.sentence(words, listed)}") for words in rest).strip()
    lead = _join(first.remedy, more, _ending(summary), _told(summary), _look(summary))
    return Headline(text, FigureVerdict.BAD, lead)


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
    ending = _ending(summary, first.sentence)
    if is_completed(summary):
        ending = "Completed with alarms." if is_high else ""
    is_bad = is_high or not is_completed(summary)
    return Headline(
        text,
        FigureVerdict.BAD if is_bad else FigureVerdict.NOTICE,
        _join(first.remedy, ending, _look(summary)),
    )
