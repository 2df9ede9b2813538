"""A day of cycles as a page, and what self-calibration found in it.

Verdict of a day of cycles in one line: the most urgent finding of all its cycles.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from opensuction.kernel.unit import HOUR_S
from opensuction.report.notice import gather
from opensuction.report.sheet import Cell, Curve, Plot, Rounded, Section, Sheet, Table, Values
from opensuction.report.wording import capitalise
from opensuction.result.cycle_result import CycleResult
from opensuction.result.day_result import DayCycleResult, DayResult, DaySamples, GapResult

KINDS = ("bad", "notice", "good")
"""Verdicts of a cycle, the most urgent first."""


class DayVerdict(NamedTuple):
    """The first line of a day."""

    text: str
    kind: str
    """One of `KINDS`."""
    lead: str


def kind_of(cycle: DayCycleResult) -> str:
    """Verdict of a cycle: its report's; where it has none, by how it ended."""
    if cycle.news is not None:
        return cycle.news.verdict
    return "good" if cycle.is_good else "bad"


def headline_of(cycle: DayCycleResult) -> str:
    """First line about a cycle, for a person."""
    return cycle.outcome.capitalize() if cycle.news is None else cycle.news.headline


def _urgency(cycle: DayCycleResult) -> tuple[bool, bool, int]:
    """Sorts before another where it is smaller."""
    return not cycle.inside_at_end, not cycle.harm, KINDS.index(kind_of(cycle))


def verdict(day: DayResult) -> DayVerdict:
    """The first line of a day, which has at least one cycle."""
    cycles, repeat, refusal = day.cycles, day.repeat, day.refusal
    done = sum(cycle.is_completed for cycle in cycles)
    count = f"{done} of {repeat} cycles completed"
    worst = min(cycles, key=_urgency)
    kind = kind_of(worst)
    if refusal is not None and kind != "bad":
        return DayVerdict("A further cycle was refused", "bad", f"{capitalise(refusal)}. {count}.")
    if kind == "good":
        return DayVerdict(count, "good" if done == repeat else "bad", "")
    said = f"Cycle {worst.number}: {headline_of(worst)}"
    if kind == "notice" and done == repeat:
        amber = [cycle for cycle in cycles if kind_of(cycle) == "notice"]
        number = "one" if len(amber) == 1 else str(len(amber))
        return DayVerdict(f"{count}, {number} to look at", "notice", f"{said}.")
    others = [cycle for cycle in cycles if cycle is not worst and kind_of(cycle) != "good"]
    more = ""
    if others:
        numbers = ", ".join(str(cycle.number) for cycle in others)
        more = f" Look at {'cycles' if len(others) > 1 else 'cycle'} {numbers} too."
    if kind == "notice" and done != repeat:
        kind = "bad"
    return DayVerdict(said, kind, f"{count}.{more}")


COLUMNS: dict[str, tuple[Callable[[DayCycleResult], float | None], int]] = {
    "at, h": (lambda cycle: cycle.start_min / 60.0, 2),
    "secretions before, mL": (lambda cycle: cycle.secretion_before_ml, 1),
    "removed, mL": (lambda cycle: cycle.removed_ml, 1),
    "removed, %": (lambda cycle: cycle.removed_percent, 0),
    "suction, s": (lambda cycle: cycle.negative_pressure_s, 1),
    "in the airway, s": (lambda cycle: cycle.in_airway_s, 1),
    "lowest SpO2, %": (lambda cycle: cycle.spo2_nadir_percent, 1),
    "lung volume lost, mL": (lambda cycle: cycle.lung_volume_loss_ml, 0),
    "catheter age, h": (lambda cycle: cycle.catheter_age_h, 1),
}
"""Numbers of the table by heading: how a cycle has them, and decimals."""
GapValue = Callable[[GapResult], float | None]
SCALES: dict[str, GapValue] = {
    "compensated": lambda gap: gap.used_scale,
    "contact says": lambda gap: gap.contact_scale,
    "barrier says": lambda gap: gap.mouth_scale,
    "next cycle": lambda gap: gap.next_scale,
    "least": lambda gap: gap.least_scale,
    "most": lambda gap: gap.most_scale,
}
"""Of a cycle's gap, by the heading of its column."""
OFFSETS: dict[str, GapValue] = {
    "tip compensated, mm deeper": lambda gap: gap.used_offset_mm,
    "barrier says, mm": lambda gap: gap.mouth_offset_mm,
    "next, mm": lambda gap: gap.next_offset_mm,
}
"""Likewise, of the tip's offset."""


def page(last: CycleResult, day: DayResult, samples: DaySamples) -> Sheet:
    """The page. last: the day's last cycle. samples: of the whole day."""
    first = verdict(day)
    secretions = (
        f"{day.removed_ml:.1f} mL of secretions removed, {day.produced_ml:.1f} mL produced."
    )
    return Sheet(
        title="A day of automated suction cycles",
        verdict=first.text,
        good=first.kind == "good",
        kind=first.kind,
        lead=f"{first.lead} {secretions}".strip(),
        run=(
            ("machine", last.machine or ""),
            ("patient", last.patient or ""),
            ("protocol", last.protocol or ""),
            ("approach", last.approach or ""),
            ("every", f"{day.every_min:g} min"),
            ("seed", last.drawn_by or ""),
            ("version", last.version),
        ),
        sections=(
            Section("What happened", day.notes, (_cycles(day.cycles),), _plots(samples)),
            *gap_sections(day.cycles),
        ),
    )


def _cycles(cycles: Sequence[DayCycleResult]) -> Table:
    rows = tuple(
        (
            Cell(str(cycle.number), "number", _page_of(cycle)),
            Cell(headline_of(cycle), kind_of(cycle)),
            *(Rounded(value(cycle), decimals) for value, decimals in COLUMNS.values()),
            "new" if cycle.catheter_changed else "",
            ", ".join(dict.fromkeys(_alarms(cycle))),
        )
        for cycle in cycles
    )
    headings = ("cycle", "what to know first", *COLUMNS, "catheter changed", "alarms")
    return Table("Cycles: the number leads to the cycle's report", headings, rows)


def _page_of(cycle: DayCycleResult) -> str:
    return "" if cycle.news is None else cycle.news.report or ""


def _alarms(cycle: DayCycleResult) -> list[str]:
    """Names of what people were told, whoever told it, the most urgent first."""
    return [notice.condition for notice in gather(cycle.alarms, cycle.told)]


def _plots(samples: DaySamples) -> tuple[Plot, ...]:
    time_h = samples.time_s / HOUR_S
    secretions = Curve("secretions", samples.secretion_ml, "removed")
    saturation = Curve("SpO2", samples.spo2_percent, "spo2")
    loss = Curve("lost", samples.lung_volume_loss_ml, "loss")
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


def gap_sections(cycles: Sequence[DayCycleResult]) -> tuple[Section, ...]:
    """Gap and offset from cycle to cycle with the bounds; none without self-calibration."""
    learned = [(cycle, cycle.gap) for cycle in cycles if cycle.gap is not None]
    if not learned:
        return ()
    rows = tuple(
        (
            cycle.number,
            cycle.rmse_mm,
            *(value(gap) for value in SCALES.values()),
            *(value(gap) for value in OFFSETS.values()),
            gap.finding,
            gap.mouth_missed or "",
            gap.contact_spoilt or "",
        )
        for cycle, gap in learned
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
    numbers = np.array([cycle.number for cycle, _ in learned], dtype=np.float64)
    gaps = [gap for _, gap in learned]
    plots = (_plot_gap(numbers, gaps), _plot_offset(numbers, gaps)) if len(gaps) > 1 else ()
    return (Section("Self-calibration", text, (table,), plots),)


def _columns(
    gaps: list[GapResult], values: dict[str, Callable[[GapResult], float | None]]
) -> Values:
    """Values of each cycle's gap, shape (cycles, values); nan where nothing was told."""
    return np.array([[of(gap) for of in values.values()] for gap in gaps], dtype=np.float64)


def _plot_gap(numbers: Values, gaps: list[GapResult]) -> Plot:
    used, contact, mouth, _, least, most = _columns(gaps, SCALES).T
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
        numbers,
        "What a cycle says is compensated in the next one, never within it; beyond the bounds it "
        "is not used, and no cycle begins.",
    )


def _plot_offset(numbers: Values, gaps: list[GapResult]) -> Plot:
    used, mouth, _ = _columns(gaps, OFFSETS).T
    return Plot(
        "Depth of the tip, as far as it is deeper than identified",
        "Cycle",
        "mm",
        (
            Curve("barrier says", mouth, "removed"),
            Curve("compensated", used, "reference", dashed=True),
        ),
        numbers,
        "An offset takes of the room that the bounds leave for the gap.",
    )
