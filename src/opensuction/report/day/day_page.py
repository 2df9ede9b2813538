"""A day of cycles as a page, and what self-calibration found in it."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from opensuction.kernel.constant import HOUR_S
from opensuction.report.sheet import Curve, Plot, Section, Sheet, Table, Values
from opensuction.report.summary import Summary

COLUMNS = {
    "cycle": "number",
    "at, h": "start_h",
    "completed": "is_completed",
    "secretions before, mL": "secretion_before_ml",
    "removed, mL": "removed_ml",
    "suction, s": "negative_pressure_s",
    "lowest SpO2, %": "spo2_nadir_percent",
    "lung volume lost, mL": "lung_volume_loss_ml",
    "catheter age, h": "catheter_age_h",
    "catheter changed": "new_catheter",
    "alarms": "alarm_names",
}
"""Of the table: what stands in each, keys of a cycle or of what `_cycles` adds."""
SCALES = {
    "compensated": "used_scale",
    "contact says": "contact_scale",
    "next cycle": "next_scale",
    "least": "least_scale",
    "most": "most_scale",
}
"""Of a cycle's ``gap``, by the heading of its column."""


def page(data: Summary, samples: Mapping[str, Values]) -> Sheet:
    """The page. data: the JSON object of the command. samples: of the whole day, by name."""
    day = data["day"]
    cycles, repeat = day["cycles"], day["repeat"]
    done = sum(cycle["outcome"] == "completed" for cycle in cycles)
    return Sheet(
        title="A day of automated suction cycles",
        verdict=f"{done} of {repeat} cycles completed",
        good=done == repeat and day["refusal"] is None,
        lead=f"{day['removed_ml']:.1f} mL of secretions removed, {day['produced_ml']:.1f} mL "
        "produced.",
        run=(
            ("machine", data["machine"]),
            ("patient", data["patient"] or ""),
            ("protocol", data["protocol"]),
            ("approach", data["approach"]),
            ("every", f"{day['every_min']:g} min"),
            ("seed", str(data["seed"])),
            ("version", data["version"]),
        ),
        sections=(
            Section("What happened", tuple(day["notes"]), (_cycles(cycles),), _plots(samples)),
            *gap_sections(cycles),
        ),
    )


def _cycles(cycles: list[dict[str, Any]]) -> Table:
    shown = (
        cycle
        | {
            "start_h": cycle["start_min"] / 60.0,
            "is_completed": cycle["outcome"] == "completed",
            "new_catheter": "new" if cycle["catheter_changed"] else "",
            "alarm_names": ", ".join(alarm["condition"] for alarm in cycle["alarms"]),
        }
        for cycle in cycles
    )
    rows = tuple(tuple(cycle[key] for key in COLUMNS.values()) for cycle in shown)
    return Table("Cycles", tuple(COLUMNS), rows)


def _plots(samples: Mapping[str, Values]) -> tuple[Plot, ...]:
    time_h = samples["time_s"] / HOUR_S
    secretions = Curve("secretions", samples["secretion_ml"], "removed")
    saturation = Curve("SpO2", samples["spo2_percent"], "spo2")
    loss = Curve("lost", samples["lung_volume_loss_ml"], "loss")
    gather = "They gather between cycles; each cycle takes what its tip reaches in its time."
    close = "Each suction closes lung units; they open again within minutes."
    listed = (
        ("Secretions in the trachea", "mL", secretions, gather),
        ("Oxygen saturation as the oximeter shows it", "SpO2 (%)", saturation, ""),
        ("Resting lung volume lost since the start", "mL", loss, close),
    )
    return tuple(
        Plot(title, "Time (h)", label, (curve,), time_h, caption)
        for title, label, curve, caption in listed
    )


def gap_sections(cycles: list[dict[str, Any]]) -> tuple[Section, ...]:
    """The scale of the gap from cycle to cycle with its bounds; none without self-calibration."""
    learned = [cycle for cycle in cycles if cycle["gap"] is not None]
    if not learned:
        return ()
    rows = tuple(
        (cycle["number"], cycle["rmse_mm"], *_scales(cycle), cycle["gap"]["in_range"])
        for cycle in learned
    )
    table = Table("Gap", ("cycle", "tracking, mm", *SCALES, "in range"), rows)
    text = (
        "The switch at the tip stays closed on reversal until the gap is crossed: each contact "
        "measures the gap without a sensor of the tip's position. The governor's bounds on the tip "
        "stay those of the identified gap.",
    )
    # A single cycle is a point, and lines would show nothing of it.
    plots = (_plot_gap(learned),) if len(learned) > 1 else ()
    return (Section("Self-calibration", text, (table,), plots),)


def _scales(cycle: dict[str, Any]) -> list[float | None]:
    return [cycle["gap"][name] for name in SCALES.values()]


def _plot_gap(cycles: list[dict[str, Any]]) -> Plot:
    scales = np.array([_scales(cycle) for cycle in cycles], dtype=np.float64)
    used, contact, _, least, most = scales.T
    return Plot(
        "Width of the gap, as a multiple of the identified one",
        "Cycle",
        "scale",
        (
            Curve("contact says", contact, "tip"),
            Curve("compensated", used, "reference", dashed=True),
            Curve("most", most, "head"),
            Curve("least", least, "head"),
        ),
        np.array([cycle["number"] for cycle in cycles], dtype=np.float64),
        "What a contact says is compensated in the next cycle, never within one; beyond the bounds "
        "it is not used, and no cycle begins.",
    )
