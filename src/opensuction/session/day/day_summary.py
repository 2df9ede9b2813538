"""A day of cycles as plain data and as a page."""

import numpy as np

from opensuction import __version__
from opensuction.kernel.constant import HOUR_S
from opensuction.procedure.cycle import schedule
from opensuction.procedure.cycle.schedule import ScheduleMode
from opensuction.report.sheet import Curve, Plot, Section, Sheet, Table
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
        "trips": [item.trip.name.lower().replace("_", "-") for item in found.trips],
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
    data: Json = without_nan(
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
    return data


def _table(day: Day) -> Table:
    columns = (
        "cycle",
        "at, h",
        "completed",
        "secretions before, mL",
        "removed, mL",
        "suction, s",
        "lowest SpO2, %",
        "lung volume lost, mL",
        "catheter age, h",
        "catheter changed",
        "alarms",
    )
    rows = tuple(
        (
            cycle.number,
            cycle.start_s / HOUR_S,
            cycle.outcome.completed,
            cycle.secretion_before_ml,
            cycle.outcome.removed_ml,
            cycle.outcome.negative_pressure_s,
            cycle.outcome.spo2_nadir_percent,
            cycle.outcome.lung_volume_loss_ml,
            cycle.catheter_age_s / HOUR_S,
            "new" if cycle.catheter_changed else "",
            ", ".join(cycle_summary.alarm_name(alarm.condition) for alarm in cycle.outcome.alarms),
        )
        for cycle in day.cycles
    )
    return Table("Cycles", columns, rows)


def _plots(day: Day) -> tuple[Plot, ...]:
    samples = day.samples
    time_h = samples.time_s / HOUR_S
    return (
        Plot(
            "Secretions in the trachea",
            "Time (h)",
            "mL",
            (Curve("secretions", samples.secretion_ml, "removed"),),
            time_h,
            "They gather between cycles; each cycle takes what its tip reaches in its time.",
        ),
        Plot(
            "Oxygen saturation as the oximeter shows it",
            "Time (h)",
            "SpO2 (%)",
            (Curve("SpO2", samples.spo2_percent, "spo2"),),
            time_h,
        ),
        Plot(
            "Resting lung volume lost since the start",
            "Time (h)",
            "mL",
            (Curve("lost", samples.lung_volume_loss_ml, "loss"),),
            time_h,
            "Each suction closes lung units; they open again within minutes.",
        ),
    )


def page(day: Day) -> Sheet:
    """The day as a page."""
    resolved, repeat = day.last.resolved, day.asked.repeat
    equipment = resolved.equipment
    done = sum(cycle.outcome.completed for cycle in day.cycles)
    removed = sum(cycle.outcome.removed_ml for cycle in day.cycles)
    whole = done == repeat and day.refusal is None
    gap = day_gap.section(day)
    return Sheet(
        title="A day of automated suction cycles",
        verdict=f"{done} of {repeat} cycles completed",
        good=whole,
        lead=f"{removed:.1f} mL of secretions removed, {day.produced_ml:.1f} mL produced.",
        run=(
            ("machine", equipment.machine_name),
            ("patient", equipment.patient_name or ""),
            ("protocol", resolved.protocol_name),
            ("approach", resolved.choice.approach),
            ("every", f"{day.asked.every_min:g} min"),
            ("seed", str(equipment.seed)),
            ("version", __version__),
        ),
        sections=(
            Section("What happened", tuple(notes(day)), (_table(day),), _plots(day)),
            *(() if gap is None else (gap,)),
        ),
    )
