"""A key figure of a cycle, beside its limit and with a verdict in words: the record.

Alarms and broken bounds that speak against a figure: no figure is shown as if they were absent.

A figure comes from the twin's truth; an alarm from what the machine could measure. Where they
differ, both are shown, and never a figure in green beside an alarm that says the opposite.
"""

from enum import Enum, StrEnum
from typing import NamedTuple

from opensuction.report.notice import Notice, notices
from opensuction.report.wording import quantity
from opensuction.result.cycle_result import CycleResult


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


class AlarmContradiction(NamedTuple):
    """Bounds and alarms that contradict a figure."""

    harms: tuple[str, ...]
    """Names of bounds, as in the JSON."""
    conditions: tuple[str, ...]
    """Names of conditions, as in the JSON, the one that is most about the figure first."""


WITNESSES: dict[str, AlarmContradiction] = {
    CycleFigure.AT_END: AlarmContradiction(
        ("left-inside",),
        (
            "withdrawal-time",
            "withdrawal-blocked",
            "withdrawal-unseen",
            "head-sensors-disagree",
            "tip-detached",
        ),
    ),
    CycleFigure.DEEPEST: AlarmContradiction(("tip-past-cap",), ("tip-beyond-cap", "carina-missed")),
    CycleFigure.SUCTION: AlarmContradiction(
        ("suction-time",), ("negative-pressure-time", "valve-stuck-open")
    ),
    CycleFigure.IN_AIRWAY: AlarmContradiction(
        ("airway-time", "left-inside"), ("in-airway-time", "withdrawal-time")
    ),
    CycleFigure.VACUUM: AlarmContradiction(
        ("vacuum", "advance-under-vacuum"),
        ("vacuum-exceeded", "pump-runaway", "vacuum-lost", "vacuum-reading-invalid"),
    ),
    CycleFigure.SATURATION: AlarmContradiction(("saturation",), ("spo2-low",)),
    CycleFigure.HEART_RATE: AlarmContradiction((), ("heart-rate-low",)),
    CycleFigure.LUNG_VOLUME: AlarmContradiction(
        ("lung-volume",), ("lung-volume-lost", "circuit-disconnected")
    ),
    CycleFigure.PRESSURE: AlarmContradiction(
        ("airway-pressure",),
        ("airway-pressure-unsafe", "circuit-disconnected", "lung-volume-lost"),
    ),
    CycleFigure.REMOVED: AlarmContradiction(
        (),
        (
            "vacuum-lost",
            "line-leaking",
            "line-clogged",
            "canister-full",
            "valve-stuck-closed",
            "pass-limit-reached",
        ),
    ),
    CycleFigure.FORCE: AlarmContradiction(
        ("force", "contact-time"),
        ("contact-time", "contact-stuck-open", "contact-stuck-closed"),
    ),
    CycleFigure.STOP: AlarmContradiction(
        (), ("carina-missed", "tip-beyond-cap", "calibration-out-of-range")
    ),
}
"""By the figure. Conditions that are here nowhere speak of the machine, not of
anything that a figure measures."""


def speaking(result: CycleResult, name: str) -> list[Notice]:
    """Alarms that speak against a figure, the one that is most about it first."""
    own = WITNESSES[name].conditions
    found = [notice for notice in notices(result) if notice.condition in own]
    return sorted(found, key=lambda notice: own.index(notice.condition))


def hear(result: CycleResult, figure: Figure) -> Figure:
    """The figure as it may stand beside what was raised: never better than its witnesses allow."""
    witness = WITNESSES.get(figure.name)
    if witness is None or figure.verdict is FigureVerdict.ABSENT:
        return figure
    if any(harm in witness.harms for harm in result.harms):
        if figure.verdict is FigureVerdict.BAD:
            return figure
        return figure._replace(
            verdict=FigureVerdict.BAD, remark="the bound for the patient was broken"
        )
    against = speaking(result, figure.name)
    if not against or figure.verdict is FigureVerdict.BAD:
        return figure
    is_high = any(notice.priority == "high" for notice in against)
    is_bad = is_high and figure.verdict is not FigureVerdict.GOOD
    remark = f"alarm: {against[0].sentence}"
    if figure.verdict is FigureVerdict.NOTICE and not figure.is_planned:
        remark = f"{figure.remark}; {remark}"
    return figure._replace(
        verdict=FigureVerdict.BAD if is_bad else FigureVerdict.NOTICE,
        remark=remark,
        is_planned=False,
    )
