"""A key figure of a cycle, beside its limit and with a verdict in words: the record."""

from enum import Enum, StrEnum
from typing import NamedTuple

from opensuction.report.wording import quantity


class FigureVerdict(Enum):
    """Verdict on a figure against its limit."""

    GOOD = "good"
    NOTICE = "notice"
    """Outside a recommendation or a usual range, inside the limit that was set."""
    BAD = "bad"
    NEUTRAL = "neutral"
    """There is no limit to hold it against."""
    ABSENT = "absent"


ATTENTION = (FigureVerdict.NOTICE, FigureVerdict.BAD)
"""Verdicts that a person should look at."""


class CycleFigure(StrEnum):
    """Key figures of a cycle, each with its title."""

    AT_END = "Catheter at the end"
    SATURATION = "Lowest oxygen saturation"
    HEART_RATE = "Lowest heart rate"
    PRESSURE = "Airway pressure"
    LUNG_VOLUME = "Lung volume lost"
    REMOVED = "Secretions removed"
    IN_AIRWAY = "Time in the airway"
    SUCTION = "Time under negative pressure"
    VACUUM = "Highest vacuum"
    DEEPEST = "Deepest tip position"
    FORCE = "Force on the carina"
    STOP = "Stopping error"
    TRACKING = "Tracking error (RMS)"
    RESTED = "Until the machine rested"


class Figure(NamedTuple):
    """One key figure."""

    name: str
    value: str
    limit: str
    """What it is held against, or a remark; may be empty."""
    verdict: FigureVerdict
    remark: str
    """The verdict in words; may be empty."""
    is_planned: bool = False
    """Outside a recommendation by design: shown, and no news about this cycle."""


def needs_look(figure: Figure) -> bool:
    """True if a person should look at it because of what happened in this cycle."""
    return figure.verdict in ATTENTION and not figure.is_planned


def against(value: float | None, limit: float | None, words: str) -> tuple[FigureVerdict, str]:
    """Verdict on a value that shall not exceed a limit; ``words`` names the limit."""
    if value is None:
        return FigureVerdict.ABSENT, ""
    if limit is None:
        return FigureVerdict.NEUTRAL, ""
    if value > limit:
        return FigureVerdict.BAD, f"over the {words}"
    return FigureVerdict.GOOD, f"within the {words}"


def known(words: str, value: float | None, unit: str, decimals: int = 1) -> list[str]:
    """A quantity with the word before it, where it is known."""
    return [] if value is None else [f"{words} {quantity(value, unit, decimals)}"]


def without_limit(
    name: str,
    value: float | None,
    unit: str,
    decimals: int = 1,
    beside: str = "",
    signed: bool = False,
) -> Figure:
    """A figure that there is no limit for. beside: what is said instead of one."""
    verdict = FigureVerdict.ABSENT if value is None else FigureVerdict.NEUTRAL
    return Figure(name, quantity(value, unit, decimals, signed=signed), beside, verdict, "")


def add(beside: str, words: str) -> str:
    """Join the text beside a figure with more words."""
    return ", ".join(filter(None, (beside, words)))


def attention(figure: Figure) -> str:
    """A figure in a few words, for a list of those that need a look."""
    value = "" if figure.verdict is FigureVerdict.ABSENT else f" ({figure.value})"
    return f"{figure.name.lower()}{value}"
