"""A day of cycles as a page, and what self-calibration found in it."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from opensuction.kernel.constant import HOUR_S
from opensuction.report.day import day_verdict
from opensuction.report.notice import notices
from opensuction.report.sheet import Cell, Curve, Plot, Rounded, Section, Sheet, Table, Values
from opensuction.report.summary import Summary, write_seed

COLUMNS = {
    "at, h": ("start_h", 2),
    "secretions before, mL": ("secretion_before_ml", 1),
    "removed, mL": ("removed_ml", 1),
    "removed, %": ("removed_percent", 0),
    "suction, s": ("negative_pressure_s", 1),
    "in the airway, s": ("in_airway_s", 1),
    "lowest SpO2, %": ("spo2_nadir_percent", 1),
    "lung volume lost, mL": ("lung_volume_loss_ml", 0),
    "catheter age, h": ("catheter_age_h", 1),
}
"""Numbers of the table by heading: the key of a cycle or of what `_cycles` adds, and decimals."""
SCALES = {
    "compensated": "used_scale",
    "contact says": "contact_scale",
    "barrier says": "mouth_scale",
    "next cycle": "next_scale",
    "least": "least_scale",
    "most": "most_scale",
}
"""Of a cycle's ``gap``, by the heading of its column."""
OFFSETS = {
    "tip compensated, mm deeper": "used_offset_mm",
    "barrier says, mm": "mouth_offset_mm",
    "next, mm": "next_offset_mm",
}
"""Likewise, of the tip's offset."""


def page(data: Summary, samples: Mapping[str, Values]) -> Sheet:
    """The page. data: the JSON object of the command. samples: of the whole day, by name."""
    day = data["day"]
    cycles = day["cycles"]
    first = day_verdict.verdict(day)
    secretions = (
        f"{day['removed_ml']:.1f} mL of secretions removed, {day['produced_ml']:.1f} mL produced."
    )
    return Sheet(
        title="A day of automated suction cycles",
        verdict=first.text,
        good=first.kind == "good",
        kind=first.kind,
        lead=f"{first.lead} {secretions}".strip(),
        run=(
            ("machine", data["machine"]),
            ("patient", data["patient"] or ""),
            ("protocol", data["protocol"]),
            ("approach", data["approach"]),
            ("every", f"{day['every_min']:g} min"),
            ("seed", write_seed(data) or ""),
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
            Cell(str(cycle["number"]), "number", cycle.get("report") or ""),
            Cell(day_verdict.headline_of(cycle), day_verdict.kind_of(cycle)),
            *_numbers(cycle | {"start_h": cycle["start_min"] / 60.0}),
            "new" if cycle["catheter_changed"] else "",
            ", ".join(dict.fromkeys(_alarms(cycle))),
        )
        for cycle in cycles
    )
    headings = ("cycle", "what to know first", *COLUMNS, "catheter changed", "alarms")
    return Table("Cycles: the number leads to the cycle's report", headings, rows)


def _numbers(cycle: dict[str, Any]) -> tuple[Rounded, ...]:
    return tuple(Rounded(cycle[key], decimals) for key, decimals in COLUMNS.values())


def _alarms(cycle: dict[str, Any]) -> list[str]:
    """Names of what people were told, whoever told it, the most urgent first."""
    return [notice.condition for notice in notices(cycle)]


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
    """Gap and offset from cycle to cycle with the bounds; none without self-calibration."""
    learned = [cycle for cycle in cycles if cycle["gap"] is not None]
    if not learned:
        return ()
    rows = tuple(
        (
            cycle["number"],
            cycle["rmse_mm"],
            *_learned(cycle, SCALES),
            *_learned(cycle, OFFSETS),
            cycle["gap"]["finding"],
            cycle["gap"]["mouth_missed"] or "",
            cycle["gap"]["contact_spoilt"] or "",
        )
        for cycle in learned
    )
    headings = (
        "cycle",
        "tracking, mm",
        *SCALES,
        *OFFSETS,
        "finding",
        "barrier not used",
        "contact not used",
    )
    table = Table("Gap and offset", headings, rows)
    text = (
        "The tip passes the light barrier at the tube's mouth on its way in and on its way out: "
        "where the head is then tells how wide the gap is and how deep the tip lies. By contact "
        "the switch at the tip stays closed on reversal until the gap is crossed, which tells the "
        "width too. The governor's bounds on the tip stay those of the identified gap.",
    )
    # A single cycle is a point, and lines would show nothing of it.
    plots = (_plot_gap(learned), _plot_offset(learned)) if len(learned) > 1 else ()
    return (Section("Self-calibration", text, (table,), plots),)


def _learned(cycle: dict[str, Any], names: Mapping[str, str]) -> list[float | None]:
    return [cycle["gap"][name] for name in names.values()]


def _numbers_of(cycles: list[dict[str, Any]]) -> Values:
    return np.array([cycle["number"] for cycle in cycles], dtype=np.float64)


def _plot_gap(cycles: list[dict[str, Any]]) -> Plot:
    scales = np.array([_learned(cycle, SCALES) for cycle in cycles], dtype=np.float64)
    used, contact, mouth, _, least, most = scales.T
    return Plot(
        "Width of the gap, as a multiple of the identified one",
        "Cycle",
        "scale",
        (
            Curve("contact says", contact, "tip"),
            Curve("barrier says", mouth, "removed"),
            Curve("compensated", used, "reference", dashed=True),
            Curve("most", most, "head"),
            Curve("least", least, "head"),
        ),
        _numbers_of(cycles),
        "What a cycle says is compensated in the next one, never within it; beyond the bounds it "
        "is not used, and no cycle begins.",
    )


def _plot_offset(cycles: list[dict[str, Any]]) -> Plot:
    used, mouth, _ = np.array([_learned(one, OFFSETS) for one in cycles], dtype=np.float64).T
    return Plot(
        "Depth of the tip, as far as it is deeper than identified",
        "Cycle",
        "mm",
        (
            Curve("barrier says", mouth, "removed"),
            Curve("compensated", used, "reference", dashed=True),
        ),
        _numbers_of(cycles),
        "An offset takes of the room that the bounds leave for the gap.",
    )
