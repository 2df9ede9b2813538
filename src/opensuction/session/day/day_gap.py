"""What self-calibration found over a day, as plain data and in words."""

import numpy as np

from opensuction.identification.estimator.gap_scale import ScaleRecord
from opensuction.safety.alarm.alarm_episode import Episode
from opensuction.safety.condition import Condition
from opensuction.session.cycle import cycle_summary
from opensuction.session.day.day_run import Day
from opensuction.session.plain import Json

CONDITION = Condition.CALIBRATION_OUT_OF_RANGE


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
