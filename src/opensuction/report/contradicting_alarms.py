"""Alarms and broken bounds that speak against a figure: no figure is shown as if they were absent.

A figure comes from the twin's truth; an alarm from what the machine could measure. Where they
differ, both are shown, and never a figure in green beside an alarm that says the opposite.
"""

from typing import NamedTuple

from opensuction.report.figure import Figure, FigureVerdict
from opensuction.report.notice import Notice, notices
from opensuction.report.summary import Summary, harms


class AlarmContradiction(NamedTuple):
    """What speaks against a figure."""

    harms: tuple[str, ...]
    """Names of bounds, as in the JSON."""
    conditions: tuple[str, ...]
    """Names of conditions, as in the JSON, the one that is most about the figure first."""


AT_END = "Catheter at the end"
DEEPEST = "Deepest tip position"
SUCTION = "Time under negative pressure"
IN_AIRWAY = "Time in the airway"
VACUUM = "Highest vacuum"
SATURATION = "Lowest oxygen saturation"
HEART_RATE = "Lowest heart rate"
LUNG_VOLUME = "Lung volume lost"
PRESSURE = "Airway pressure"
REMOVED = "Secretions removed"
FORCE = "Force on the carina"
STOP = "Stopping error"

WITNESSES = {
    AT_END: AlarmContradiction(
        ("left-inside",),
        (
            "withdrawal-time",
            "withdrawal-blocked",
            "withdrawal-unseen",
            "head-sensors-disagree",
            "tip-detached",
        ),
    ),
    DEEPEST: AlarmContradiction(("tip-past-cap",), ("tip-beyond-cap", "carina-missed")),
    SUCTION: AlarmContradiction(("suction-time",), ("negative-pressure-time", "valve-stuck-open")),
    IN_AIRWAY: AlarmContradiction(
        ("airway-time", "left-inside"), ("in-airway-time", "withdrawal-time")
    ),
    VACUUM: AlarmContradiction(
        ("vacuum", "advance-under-vacuum"),
        ("vacuum-exceeded", "pump-runaway", "vacuum-lost", "vacuum-reading-invalid"),
    ),
    SATURATION: AlarmContradiction(("saturation",), ("spo2-low",)),
    HEART_RATE: AlarmContradiction((), ("heart-rate-low",)),
    LUNG_VOLUME: AlarmContradiction(("lung-volume",), ("lung-volume-lost", "circuit-disconnected")),
    PRESSURE: AlarmContradiction(
        ("airway-pressure",),
        ("airway-pressure-unsafe", "circuit-disconnected", "lung-volume-lost"),
    ),
    REMOVED: AlarmContradiction(
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
    FORCE: AlarmContradiction(
        ("force", "contact-time"),
        ("contact-time", "contact-stuck-open", "contact-stuck-closed"),
    ),
    STOP: AlarmContradiction((), ("carina-missed", "tip-beyond-cap", "calibration-out-of-range")),
}
"""By the name of the figure. Conditions that are here nowhere speak of the machine, not of
anything that a figure measures."""


def speaking(summary: Summary, name: str) -> list[Notice]:
    """Alarms that speak against a figure, the one that is most about it first."""
    own = WITNESSES[name].conditions
    found = [notice for notice in notices(summary) if notice.condition in own]
    return sorted(found, key=lambda notice: own.index(notice.condition))


def hear(summary: Summary, figure: Figure) -> Figure:
    """The figure as it may stand beside what was raised: never better than its witnesses allow."""
    witness = WITNESSES.get(figure.name)
    if witness is None or figure.verdict is FigureVerdict.ABSENT:
        return figure
    if any(harm in witness.harms for harm in harms(summary)):
        if figure.verdict is FigureVerdict.BAD:
            return figure
        return figure._replace(
            verdict=FigureVerdict.BAD, remark="the bound for the patient was broken"
        )
    against = speaking(summary, figure.name)
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
