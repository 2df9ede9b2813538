"""Alarms and broken bounds that speak against a figure: no figure is shown as if they were absent.

A figure comes from the twin's truth; an alarm from what the machine could measure. Where they
differ, both are shown, and never a figure in green beside an alarm that says the opposite.
"""

from typing import NamedTuple

from opensuction.report.figure import CycleFigure, Figure, FigureVerdict
from opensuction.report.notice import Notice, notices
from opensuction.result.cycle_result import CycleResult


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
