"""Verdict of a day of cycles in one line: the most urgent finding of all its cycles."""

from collections.abc import Mapping
from typing import Any, NamedTuple

from opensuction.report.summary import Summary, harms, is_completed, rows, text, value
from opensuction.report.wording import capitalise

KINDS = ("bad", "notice", "good")
"""Verdicts of a cycle, the most urgent first."""


class DayVerdict(NamedTuple):
    """The first line of a day."""

    text: str
    kind: str
    """One of `KINDS`."""
    lead: str


def is_good(day: Mapping[str, Any] | None) -> bool:
    """Whether a script may go on: every cycle was completed, no bound was broken, nothing refused.

    day: the key ``day`` of the JSON; None where there was a single cycle.
    """
    if day is None:
        return True
    return value(day, "refusal") is None and all(_is_well(cycle) for cycle in rows(day, "cycles"))


def _is_well(cycle: Summary) -> bool:
    left_inside = value(cycle, "inside_at_end") is True
    return is_completed(cycle) and not left_inside and not harms(cycle)


def kind_of(cycle: Summary) -> str:
    """Verdict of a cycle: its report's; where it has none, by how it ended."""
    found = text(cycle, "verdict")
    if found in KINDS:
        return found
    return "good" if _is_well(cycle) else "bad"


def headline_of(cycle: Summary) -> str:
    """What a person must know first of a cycle."""
    return text(cycle, "headline") or (text(cycle, "outcome") or "?").capitalize()


def _urgency(cycle: Summary) -> tuple[bool, bool, int]:
    """Sorts before another where it is smaller."""
    left_inside = value(cycle, "inside_at_end") is True
    return not left_inside, not harms(cycle), KINDS.index(kind_of(cycle))


def verdict(day: Mapping[str, Any]) -> DayVerdict:
    """The first line of a day. day: the key ``day`` of the JSON, with at least one cycle."""
    cycles = rows(day, "cycles")
    done, repeat = sum(is_completed(cycle) for cycle in cycles), value(day, "repeat")
    count = f"{done} of {repeat} cycles completed"
    worst = min(cycles, key=_urgency)
    kind, refusal = kind_of(worst), text(day, "refusal")
    if refusal is not None and kind != "bad":
        return DayVerdict("A further cycle was refused", "bad", f"{capitalise(refusal)}. {count}.")
    if kind == "good":
        return DayVerdict(count, "good" if done == repeat else "bad", "")
    said = f"Cycle {text(worst, 'number')}: {headline_of(worst)}"
    if kind == "notice" and done == repeat:
        amber = [cycle for cycle in cycles if kind_of(cycle) == "notice"]
        number = "one" if len(amber) == 1 else str(len(amber))
        return DayVerdict(f"{count}, {number} to look at", "notice", f"{said}.")
    others = [cycle for cycle in cycles if cycle is not worst and kind_of(cycle) != "good"]
    more = ""
    if others:
        numbers = ", ".join(text(cycle, "number") or "?" for cycle in others)
        more = f" Look at {'cycles' if len(others) > 1 else 'cycle'} {numbers} too."
    if kind == "notice" and done != repeat:
        kind = "bad"
    return DayVerdict(said, kind, f"{count}.{more}")
