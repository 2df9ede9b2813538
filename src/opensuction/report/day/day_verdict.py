"""Verdict of a day of cycles in one line: the most urgent finding of all its cycles."""

from typing import NamedTuple

from opensuction.report.wording import capitalise
from opensuction.result.day_result import DayCycleResult, DayResult

KINDS = ("bad", "notice", "good")
"""Verdicts of a cycle, the most urgent first."""


class DayVerdict(NamedTuple):
    """The first line of a day."""

    text: str
    kind: str
    """One of `KINDS`."""
    lead: str


def kind_of(cycle: DayCycleResult) -> str:
    """Verdict of a cycle: its report's; where it has none, by how it ended."""
    if cycle.news is not None:
        return cycle.news.verdict
    return "good" if cycle.is_good else "bad"


def headline_of(cycle: DayCycleResult) -> str:
    """First line about a cycle, for a person."""
    return cycle.outcome.capitalize() if cycle.news is None else cycle.news.headline


def _urgency(cycle: DayCycleResult) -> tuple[bool, bool, int]:
    """Sorts before another where it is smaller."""
    return not cycle.inside_at_end, not cycle.harm, KINDS.index(kind_of(cycle))


def verdict(day: DayResult) -> DayVerdict:
    """The first line of a day, which has at least one cycle."""
    cycles, repeat, refusal = day.cycles, day.repeat, day.refusal
    done = sum(cycle.is_completed for cycle in cycles)
    count = f"{done} of {repeat} cycles completed"
    worst = min(cycles, key=_urgency)
    kind = kind_of(worst)
    if refusal is not None and kind != "bad":
        return DayVerdict("A further cycle was refused", "bad", f"{capitalise(refusal)}. {count}.")
    if kind == "good":
        return DayVerdict(count, "good" if done == repeat else "bad", "")
    said = f"Cycle {worst.number}: {headline_of(worst)}"
    if kind == "notice" and done == repeat:
        amber = [cycle for cycle in cycles if kind_of(cycle) == "notice"]
        number = "one" if len(amber) == 1 else str(len(amber))
        return DayVerdict(f"{count}, {number} to look at", "notice", f"{said}.")
    others = [cycle for cycle in cycles if cycle is not worst and kind_of(cycle) != "good"]
    more = ""
    if others:
        numbers = ", ".join(str(cycle.number) for cycle in others)
        more = f" Look at {'cycles' if len(others) > 1 else 'cycle'} {numbers} too."
    if kind == "notice" and done != repeat:
        kind = "bad"
    return DayVerdict(said, kind, f"{count}.{more}")
