"""What self-calibration found over a day, as plain data and for the page."""

from typing import Any

import numpy as np

from opensuction.identification.estimator.gap_scale import ScaleRecord
from opensuction.report.sheet import Curve, Plot, Section, Table
from opensuction.safety.alarm.alarm_episode import Episode
from opensuction.safety.condition import Condition
from opensuction.session.cycle import cycle_summary
from opensuction.session.day.day_run import Day
from opensuction.session.plain import Json

CONDITION = Condition.CALIBRATION_OUT_OF_RANGE


def _records(day: Day) -> list[tuple[int, ScaleRecord]]:
    return [(cycle.number, cycle.gap) for cycle in day.cycles if cycle.gap is not None]


def row(record: ScaleRecord | None) -> Json | None:
    """One cycle's change of the scale; None without self-calibration or after a broken cycle."""
    if record is None:
        return None
    return {
        "used_scale": record.old,
        "contact_scale": record.estimated,
        "next_scale": record.new,
        "least_scale": record.limits.least,
        "most_scale": record.limits.most,
        "in_range": record.in_range,
    }


def words(record: ScaleRecord | None) -> str:
    """What a contact said, to be added to a line about its cycle."""
    if record is None:
        return ""
    if not np.isfinite(record.estimated):
        return ", nothing to learn of the gap"
    return f", gap {record.estimated:.2f} x the identified one"


def alarms(day: Day, time_s: float) -> list[Json]:
    """The alarm that a refused gap is, for the last cycle's JSON. time_s: when it was found."""
    if day.refusal is None:
        return []
    raised = Episode(
        condition=CONDITION,
        priority=CONDITION.row.handling.priority,
        started_s=time_s,
        ended_s=None,
        latched=False,
        acknowledged_s=None,
    )
    return cycle_summary.alarms([raised])


def notes(day: Day) -> list[str]:
    """Why no further cycle began, and what to do; nothing where all went well."""
    if day.refusal is None:
        return []
    done, repeat = len(day.cycles), day.asked.repeat
    kept = f" Cycle {done + 1} of {repeat} was refused." if done < repeat else ""
    refusal = day.refusal[0].upper() + day.refusal[1:]
    priority = CONDITION.row.handling.priority.name.lower()
    return [f"Alarm ({priority}): {refusal}.{kept} {CONDITION.row.remedy}"]


def _plot(records: list[tuple[int, ScaleRecord]]) -> Plot:
    bounds = [(record.limits.most, record.limits.least) for _, record in records]
    most, least = np.array(bounds).T
    numbers = np.array([float(number) for number, _ in records])
    return Plot(
        "Width of the gap, as a multiple of the identified one",
        "Cycle",
        "scale",
        (
            Curve("contact says", np.array([record.estimated for _, record in records]), "tip"),
            Curve(
                "compensated",
                np.array([record.old for _, record in records]),
                "reference",
                dashed=True,
            ),
            Curve("most", most, "head"),
            Curve("least", least, "head"),
        ),
        numbers,
        "What a contact says is compensated in the next cycle, never within one; beyond the bounds "
        "it is not used, and no cycle begins.",
    )


def section(day: Day) -> Section | None:
    """Part of the day's page: the scale of the gap from cycle to cycle with its bounds."""
    records = _records(day)
    if not records:
        return None
    table = Table(
        "Gap",
        (
            "cycle",
            "tracking, mm",
            "compensated",
            "contact says",
            "next cycle",
            "least",
            "most",
            "in range",
        ),
        tuple(
            (cycle.number, cycle.outcome.rmse_mm, *_cells(cycle.gap))
            for cycle in day.cycles
            if cycle.gap is not None
        ),
    )
    text = (
        "The switch at the tip stays closed on reversal until the gap is crossed: each contact "
        "measures the gap without a sensor of the tip's position. The governor's bounds on the tip "
        "stay those of the identified gap.",
    )
    # A single cycle is a point, and lines would show nothing of it.
    return Section(
        "Self-calibration", text, (table,), (_plot(records),) if len(records) > 1 else ()
    )


def _cells(record: ScaleRecord) -> tuple[Any, ...]:
    limits = record.limits
    values = (record.old, record.estimated, record.new, limits.least, limits.most)
    return (*values, record.in_range)
