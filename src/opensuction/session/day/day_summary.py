"""A day of cycles, and what self-calibration found in it, as plain data and in words."""

from collections.abc import Sequence

import numpy as np

from opensuction.identification.estimator.gap_scale import ScaleRecord
from opensuction.kernel.constant import HOUR_S
from opensuction.kernel.name import name_of
from opensuction.procedure.cycle import schedule
from opensuction.procedure.cycle.schedule import ScheduleMode
from opensuction.report.wording import capitalise
from opensuction.safety.alarm.alarm_episode import Episode
from opensuction.safety.condition import Condition
from opensuction.session.cycle import cycle_summary
from opensuction.session.day import cycle_report
from opensuction.session.day.cycle_report import CycleReport
from opensuction.session.day.day_run import Day, DayCycle
from opensuction.session.plain import Json, without_nan

MINUTE_S = 60.0
CONDITION = Condition.CALIBRATION_OUT_OF_RANGE


def _row(cycle: DayCycle) -> Json:
    found = cycle.outcome
    return {
        "number": cycle.number,
        "start_min": cycle.start_s / MINUTE_S,
        "outcome": "completed" if found.completed else "aborted",
        "rmse_mm": found.rmse_mm,
        "secretion_before_ml": cycle.secretion_before_ml,
        "removed_ml": found.removed_ml,
        "removed_percent": found.removed_percent,
        "bore_ml": cycle.bore_ml,
        "negative_pressure_s": found.negative_pressure_s,
        "in_airway_s": found.exposure.in_airway_s,
        "inside_at_end": found.exposure.inside_at_end,
        "end_mm": found.exposure.end_mm,
        "harm": [one.name for one in found.harm],
        "told": cycle_summary.told(found.told),
        "spo2_nadir_percent": found.exposure.spo2_least_percent,
        "lung_volume_loss_ml": found.exposure.lung_volume_loss_ml,
        "trips": [name_of(item.trip) for item in found.trips],
        "alarms": cycle_summary.alarms(found.alarms),
        "catheter_age_h": cycle.catheter_age_s / HOUR_S,
        "catheter_changed": cycle.catheter_changed,
        "assessed": cycle.assessed,
        "preoxygenation": cycle.preoxygenation,
        "gap": _gap(cycle.gap),
    }


def notes(day: Day) -> list[str]:
    """What a person should know of the day, in sentences."""
    said = schedule.notes(schedule.schedule(ScheduleMode.TIMED, day.asked.every_s))
    said += attendance_notes(day)
    said += gap_notes(day)
    repeat = day.asked.repeat
    if day.reset_cycles:
        numbers = ", ".join(str(number) for number in day.reset_cycles)
        said.append(
            f"The machine halted in cycle {numbers}: a person looked at the patient and reset it. "
            "What was broken was not mended."
        )
    if len(day.cycles) < repeat and day.refusal is None:
        said.append(
            f"The day ended with cycle {len(day.cycles)} of {repeat}: it was broken off, and a "
            "halted machine, or one without its controller, waits for a person."
        )
    first, last = day.cycles[0].secretion_before_ml, day.left_ml
    if len(day.cycles) > 1 and last > first:
        said.append(
            f"Secretions gather faster than these cycles remove them: {first:.1f} mL at the "
            f"start, {last:.1f} mL at the end. Cycles would have to come more often, or a person "
            "clear what the tip does not reach."
        )
    return said


def plain(day: Day, reports: Sequence[CycleReport] = ()) -> Json:
    """The key ``day`` of the command's JSON. reports: of its cycles, where they were made."""
    reported = [cycle_report.plain(report) for report in reports] or [{}] * len(day.cycles)
    cycles = [_row(cycle) | more for cycle, more in zip(day.cycles, reported, strict=True)]
    return without_nan(
        {
            "repeat": day.asked.repeat,
            "every_min": day.asked.every_min,
            "cycles": cycles,
            "produced_ml": day.produced_ml,
            "removed_ml": sum(cycle.outcome.removed_ml for cycle in day.cycles),
            "left_ml": day.left_ml,
            "coughed_ml": day.coughed_ml,
            "canister_ml": day.canister_ml,
            "spo2_nadir_percent": float(np.min(day.samples.spo2_percent)),
            "catheter_changes": sum(cycle.catheter_changed for cycle in day.cycles),
            "assessments": sum(cycle.assessed for cycle in day.cycles),
            "refusal": day.refusal,
            "notes": notes(day),
        }
    )


def _gap(record: ScaleRecord | None) -> Json | None:
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


def gap_words(record: ScaleRecord | None) -> str:
    """What a contact said, to be added to a line about its cycle."""
    if record is None:
        return ""
    if not np.isfinite(record.estimated):
        return ", nothing to learn of the gap"
    return f", gap {record.estimated:.2f} x the identified one"


def gap_alarms(day: Day, time_s: float) -> list[Json]:
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


def attendance_notes(day: Day) -> list[str]:
    """What somebody did at the bed, without which the cycles would not have begun."""
    said = []
    given = [cycle.preoxygenation for cycle in day.cycles]
    for state in sorted(set(given) - {"not-required"}):
        said.append(f"Pre-oxygenation was {state} by a person before {given.count(state)} cycles.")
    looked = sum(cycle.assessed for cycle in day.cycles)
    if looked:
        most = day.last.loop.controller.service.passes.most_passes
        often = "once, after" if looked == 1 else f"{looked} times, each after"
        said.append(
            f"A person looked at the patient {often} {most} passes: without that the next cycle "
            "is refused."
        )
    return said


def gap_notes(day: Day) -> list[str]:
    """Why no further cycle began, and what to do; nothing where all went well."""
    if day.refusal is None:
        return []
    done, repeat = len(day.cycles), day.asked.repeat
    kept = f" Cycle {done + 1} of {repeat} was refused." if done < repeat else ""
    priority = CONDITION.row.handling.priority.name.lower()
    return [f"Alarm ({priority}): {capitalise(day.refusal)}.{kept} {CONDITION.row.remedy}"]
