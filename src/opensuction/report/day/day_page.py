"""A day of cycles as a page, and what self-calibration found in it."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from opensuction.kernel.constant import HOUR_S
from opensuction.report.sheet import Curve, Plot, Section, Sheet, Table, Values
from opensuction.report.summary import Summary

COLUMNS = (
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
SCALES = ("used_scale", "contact_scale", "next_scale", "least_scale", "most_scale")
"""Of a cycle's ``gap``, in the order of the table's columns."""


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
    rows = tuple(
        (
            cycle["number"],
            cycle["start_min"] / 60.0,
            cycle["outcome"] == "completed",
            cycle["secretion_before_ml"],
            cycle["removed_ml"],
            cycle["negative_pressure_s"],
            cycle["spo2_nadir_percent"],
            cycle["lung_volume_loss_ml"],
            cycle["catheter_age_h"],
            "new" if cycle["catheter_changed"] else "",
            ", ".join(alarm["condition"] for alarm in cycle["alarms"]),
        )
        for cycle in cycles
    )
    return Table("Cycles", COLUMNS, rows)


def _plots(samples: Mapping[str, Values]) -> tuple[Plot, ...]:
    time_h = samples["time_s"] / HOUR_S
    return (
        Plot(
            "Secretions in the trachea",
            "Time (h)",
            "mL",
            (Curve("secretions", samples["secretion_ml"], "removed"),),
            time_h,
            "They gather between cycles; each cycle takes what its tip reaches in its time.",
        ),
        Plot(
            "Oxygen saturation as the oximeter shows it",
            "Time (h)",
            "SpO2 (%)",
            (Curve("SpO2", samples["spo2_percent"], "spo2"),),
            time_h,
        ),
        Plot(
            "Resting lung volume lost since the start",
            "Time (h)",
            "mL",
            (Curve("lost", samples["lung_volume_loss_ml"], "loss"),),
            time_h,
            "Each suction closes lung units; they open again within minutes.",
        ),
    )


def gap_sections(cycles: list[dict[str, Any]]) -> tuple[Section, ...]:
    """The scale of the gap from cycle to cycle with its bounds; none without self-calibration."""
    learned = [cycle for cycle in cycles if cycle["gap"] is not None]
    if not learned:
        return ()
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
            (
                cycle["number"],
                cycle["rmse_mm"],
                *(cycle["gap"][name] for name in SCALES),
                cycle["gap"]["in_range"],
            )
            for cycle in learned
        ),
    )
    text = (
        "The switch at the tip stays closed on reversal until the gap is crossed: each contact "
        "measures the gap without a sensor of the tip's position. The governor's bounds on the tip "
        "stay those of the identified gap.",
    )
    # A single cycle is a point, and lines would show nothing of it.
    plots = (_plot_gap(learned),) if len(learned) > 1 else ()
    return (Section("Self-calibration", text, (table,), plots),)


def _plot_gap(cycles: list[dict[str, Any]]) -> Plot:
    used, contact, _, least, most = (
        np.array([cycle["gap"][name] for cycle in cycles], dtype=np.float64) for name in SCALES
    )
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
