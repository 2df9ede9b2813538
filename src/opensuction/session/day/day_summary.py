"""A day of cycles as plain data."""

import numpy as np

from opensuction.kernel.constant import HOUR_S
from opensuction.procedure.cycle import schedule
from opensuction.procedure.cycle.schedule import ScheduleMode
from opensuction.session.cycle import cycle_summary
from opensuction.session.day import day_gap
from opensuction.session.day.day_run import Day, DayCycle
from opensuction.session.plain import Json, without_nan

MINUTE_S = 60.0


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
        "in_airway_s": found.in_airway_s,
        "spo2_nadir_percent": found.spo2_nadir_percent,
        "lung_volume_loss_ml": found.lung_volume_loss_ml,
        "trips": [cycle_summary.name_of(item.trip) for item in found.trips],
        "alarms": cycle_summary.alarms(found.alarms),
        "catheter_age_h": cycle.catheter_age_s / HOUR_S,
        "catheter_changed": cycle.catheter_changed,
        "gap": day_gap.row(cycle.gap),
    }


def notes(day: Day) -> list[str]:
    """What a person should know of the day, in sentences."""
    said = schedule.notes(schedule.schedule(ScheduleMode.TIMED, day.asked.every_s))
    said += day_gap.notes(day)
    repeat = day.asked.repeat
    if len(day.cycles) < repeat and day.refusal is None:
        said.append(
            f"The day ended with cycle {len(day.cycles)} of {repeat}: it was broken off, and a "
            "halted machine waits for a person."
        )
    first, last = day.cycles[0].secretion_before_ml, day.left_ml
    if len(day.cycles) > 1 and last > first:
        said.append(
            f"Secretions gather faster than these cycles remove them: {first:.1f} mL at the "
            f"start, {last:.1f} mL at the end. Cycles would have to come more often, or a person "
            "clear what the tip does not reach."
        )
    return said


def plain(day: Day) -> Json:
    """The key ``day`` of the command's JSON."""
    return without_nan(
        {
            "repeat": day.asked.repeat,
            "every_min": day.asked.every_min,
            "cycles": [_row(cycle) for cycle in day.cycles],
            "produced_ml": day.produced_ml,
            "removed_ml": sum(cycle.outcome.removed_ml for cycle in day.cycles),
            "left_ml": day.left_ml,
            "canister_ml": day.canister_ml,
            "spo2_nadir_percent": float(np.min(day.samples.spo2_percent)),
            "catheter_changes": sum(cycle.catheter_changed for cycle in day.cycles),
            "refusal": day.refusal,
            "notes": notes(day),
        }
    )
