"""Headline of a cycle: the most urgent finding in one line, and the line below it.

In this order: the catheter is still inside; a bound for the patient was broken; the most urgent
alarm; completed with alarms; completed.
"""

from typing import NamedTuple

from opensuction.report import ending, figures
from opensuction.report.figure import CycleFigure, FigureVerdict, attention, needs_look
from opensuction.report.notice import CAUSES, Notice, notices
from opensuction.report.wording import capitalise, depth_words, quantity, stopped
from opensuction.result.cycle_result import CycleResult

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


def headline(result: CycleResult) -> Headline:
    """The first line of a cycle, and the line below it."""
    for said in (_inside, _harm, _alarm):
        found = said(result)
        if found is not None:
            return found
    if not result.is_completed:
        lead = stopped(capitalise(ending.reason(result)))
        return Headline(ending.ended(result), FigureVerdict.BAD, lead, _look(result))
    return _completed(result)


def _completed(result: CycleResult) -> Headline:
    """A cycle that ran to its end without an alarm."""
    amber = [figure for figure in figures.figures(result) if needs_look(figure)]
    values = [f"{figure.name.lower()} {figure.value}, {figure.remark}" for figure in amber]
    lead = stopped(capitalise("; ".join(values))) if values else ""
    unnoticed = ending.unnoticed(result)
    if unnoticed:
        text = f"Completed, and nothing noticed the fault {' or '.join(unnoticed)}"
        return Headline(text, FigureVerdict.NOTICE, UNNOTICED, lead)
    if amber:
        named = ", ".join(attention(figure) for figure in amber[:NAMED])
        more = f" and {len(amber) - NAMED} more" if len(amber) > NAMED else ""
        text = f"Completed, look at {named}{more}"
        return Headline(text, FigureVerdict.NOTICE, lead, "")
    good = "Every figure is within the limit that was set for it."
    if result.is_recorded:
        good = "Every figure that the machine knows is within the limit that was set for it."
    return Headline("Completed", FigureVerdict.GOOD, good, _planned(result))


def _join(*parts: str) -> str:
    return " ".join(part for part in parts if part)


def _look(result: CycleResult) -> str:
    """List the figures that need a look."""
    names = [
        attention(figure)
        for figure in figures.figures(result)
        if needs_look(figure) and figure.name != CycleFigure.AT_END  # the first line says it
    ]
    return f"Look at: {', '.join(names)}." if names else ""


def _planned(result: CycleResult) -> str:
    """List the figures that are outside a recommendation by design."""
    found = [figure for figure in figures.figures(result) if figure.is_planned]
    return " ".join(f"{figure.name}: {figure.remark}." for figure in found)


def _ending(result: CycleResult) -> str:
    """Ending of the cycle, with its reason where the most urgent alarm does not say it."""
    first = next((notice.sentence for notice in notices(result)), "")
    ended = stopped(ending.ended(result))
    if result.is_completed:
        return ended
    reason = ending.reason(result)
    return ended if reason == first else f"{ended} {stopped(capitalise(reason))}"


def _told(result: CycleResult) -> str:
    """The most urgent alarm in a sentence, or that there was none."""
    raised = notices(result)
    if not raised:
        return "Nobody was told: no alarm was raised."
    return f"{_priority(raised[0])}: {stopped(raised[0].sentence)}"


def _priority(notice: Notice) -> str:
    return f"{notice.priority} alarm".strip().capitalize()


def _inside(result: CycleResult) -> Headline | None:
    if not result.is_inside:
        return None
    where = depth_words(result.tip.end_mm or 0.0)
    text = f"CATHETER IS STILL IN THE AIRWAY, {where}: draw it out by the handle"
    if result.is_recorded:
        text = f"CATHETER STILL IN THE AIRWAY AS THE RECORDING ENDS, {where}, by estimate"
    lead = _join(_told(result), _ending(result))
    return Headline(text, FigureVerdict.BAD, lead, _look(result))


def _harm(result: CycleResult) -> Headline | None:
    broken = [(ending.sentence(result, *found), found[1]) for found in ending.broken(result)]
    if not broken:
        return None
    (sentence, words), rest = broken[0], broken[1:]
    causes = [notice.sentence for notice in notices(result) if notice.condition in CAUSES]
    text = f"PATIENT AT RISK: {'; '.join([sentence, *causes])}"
    more = _join(*(stopped(f"Also: {also}") for also, _ in rest))
    lead = _join(words.remedy, more, _told(result), _ending(result))
    return Headline(text, FigureVerdict.BAD, lead, _look(result))


def _alarm(result: CycleResult) -> Headline | None:
    raised = notices(result)
    if not raised:
        return None
    first = raised[0]
    over = "" if first.ended_s is None else f", over since {quantity(first.ended_s, 's')}"
    text = f"{_priority(first)}{over}: {first.sentence}"
    is_high = first.priority == "high"
    if result.is_completed and not is_high:
        text = f"Completed with alarms: {first.sentence}"
    ended = _ending(result)
    if result.is_completed:
        ended = "Completed with alarms." if is_high else ""
    is_bad = is_high or not result.is_completed
    return Headline(
        text,
        FigureVerdict.BAD if is_bad else FigureVerdict.NOTICE,
        _join(first.remedy, ended),
        _look(result),
    )
