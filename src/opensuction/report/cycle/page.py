"""One cycle as a single HTML page: no network, opens from a disk, prints.

Instants of a cycle at which something went wrong, as the plots mark them.

Clinical requirements held against the plan of a cycle, as rows of a table.

The sound of an alarm as a file that any player opens.
"""

import io
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from opensuction.report import (
    airway_geometry,
    figures,
    headline,
    narrative,
    notice,
    series,
    sheet,
    wording,
)
from opensuction.report.notice import notices
from opensuction.report.series import Trace
from opensuction.report.wording import amount
from opensuction.result.cycle_result import CycleResult, PlannedCheck
from opensuction.result.plain import flatten, to_json
from opensuction.safety.alarm import alarm_signal
from opensuction.safety.handling import Priority

SAMPLE_RATE_HZ = 16_000
"""More than twice the highest harmonic of the highest tone (3300 Hz)."""
SECONDS = 10.0
"""Two bursts of a high alarm with the interval between them."""
FULL_SCALE = 32767
"""Largest sample of 16 bits."""


def encode_alarm(priority: Priority) -> bytes:
    """Sound of an alarm of this priority for `SECONDS`, as a WAV file of one channel."""
    samples = alarm_signal.repeat(priority, SECONDS, SAMPLE_RATE_HZ)
    buffer = io.BytesIO()
    from scipy.io import wavfile  # all of its formats: the console starts without them

    wavfile.write(buffer, SAMPLE_RATE_HZ, np.round(samples * FULL_SCALE).astype("<i2"))
    return buffer.getvalue()


BY_DESIGN = (
    "below the tube the tip goes in at 10 mm/s and no faster, so the way in alone takes seconds "
    "that a hand does not; the time under suction is kept within 15 s"
)
"""Why a cycle stays in the airway for longer than a guideline for hands allows."""
STAY = "time in the airway"
"""Name of the check that a guideline for hands has, too."""


class Requirement(NamedTuple):
    """One requirement in words and numbers."""

    name: str
    planned: str
    limit: str
    """With ``below`` or ``at most``."""
    met: bool
    source: str


def requirements(result: CycleResult) -> list[Requirement]:
    """Requirements in the order of the result; empty where it has none."""
    listed = []
    for check in _checks(result):
        word = "below" if check.strict else "at most"
        listed.append(
            Requirement(
                name=check.name.capitalize(),
                planned=amount(check.value, check.unit, 3),
                limit=f"{word} {amount(check.limit, check.unit, 3)}",
                met=check.ok,
                source=check.source,
            )
        )
    return listed + _by_hand(result)


def _checks(result: CycleResult) -> tuple[PlannedCheck, ...]:
    return () if result.simulated is None else result.simulated.checks


def _by_hand(result: CycleResult) -> list[Requirement]:
    """From insertion to removal as a guideline for hands has it, where it applies, and why not."""
    limit = result.timing.in_airway_guideline_s
    planned = next((check.value for check in _checks(result) if check.name == STAY), None)
    if limit is None or planned is None:
        return []
    met = planned <= limit
    return [
        Requirement(
            name="Insertion to removal, by hand",
            planned=amount(planned, "s", 3),
            limit=f"at most {amount(limit, 's', 3)}",
            met=met,
            source="[ACI-2014]" + ("" if met else f", exceeded by design: {BY_DESIGN}"),
        )
    ]


TOGETHER_S = 0.25
"""What comes within this time of the one before stands at one mark: their names would overlap."""


class Instant(NamedTuple):
    """An upright line across the plots, and its name."""

    label: str
    hue: str
    """Colour by its name in the style sheet."""
    time_s: float


def _injected(result: CycleResult) -> list[tuple[float, str]]:
    """Times and names of injected faults; one whose instant never came is left out."""
    return sorted(
        (fault.at_s, fault.name.replace("-", " "))
        for fault in result.faults
        if fault.at_s is not None
    )


def _raised(result: CycleResult) -> list[tuple[float, str]]:
    """Times and names of alarms, whoever raised them."""
    return sorted(
        (notice.started_s, notice.condition.replace("-", " "))
        for notice in notices(result)
        if notice.started_s is not None
    )


def _gather(what: str, hue: str, found: list[tuple[float, str]]) -> list[Instant]:
    groups: list[list[tuple[float, str]]] = []
    for entry in found:
        if groups and entry[0] - groups[-1][-1][0] <= TOGETHER_S:
            groups[-1].append(entry)
        else:
            groups.append([entry])
    return [
        Instant(f"{what}: {', '.join(dict.fromkeys(name for _, name in group))}", hue, group[0][0])
        for group in groups
    ]


def instants(result: CycleResult) -> list[Instant]:
    """Injected faults, then alarms, each in the order of time."""
    return [
        *_gather("Fault", "fault", _injected(result)),
        *_gather("Alarm", "bad", _raised(result)),
    ]


Sections = Mapping[str, Mapping[str, Any]]
"""Tables by title: names and values, which may be nested."""

SCRIPTS = ("plot_parts.js", "loop_plot.js", "patient_plots.js", "plots.js")
"""In this order: each uses those before it."""


SHORTEST_S = 0.05
"""A phase that was passed through in less than what rounds to 0.1 s is not shown."""


class PhaseBand(NamedTuple):
    """A phase on the time line."""

    number: int
    label: str
    meaning: str
    kind: str
    start_s: float
    end_s: float
    width_percent: float


def bands(result: CycleResult) -> list[PhaseBand]:
    """Phases that took time, each with its share of the time line; the rest after them is none."""
    known = [phase for phase in result.phases if phase.end_s - phase.start_s >= SHORTEST_S]
    while known and known[-1].name in wording.REST:
        known.pop()
    total = sum(end - start for _, start, end in known)
    listed = []
    for i, (name, start, end) in enumerate(known, start=1):
        label, meaning, kind = wording.phase_words(name)
        share = round(100.0 * (end - start) / total, 3)
        listed.append(PhaseBand(i, label, meaning, kind, start, end, share))
    return listed


def _tables(result: CycleResult, sections: Sections | None) -> dict[str, list[tuple[str, Any]]]:
    """Tables at the end of the page by title: what ran, what was set, what it ran on."""
    simulated = result.simulated
    tables: dict[str, list[tuple[str, Any]]] = {"This run": list(ran(result).items())}
    if simulated is not None and simulated.identification is not None:
        model = to_json(simulated.identification)
        tables["Identification of the transmission"] = flatten(model)
    for title, section in (sections or {}).items():
        tables[title] = flatten(section)
    tables["Software"] = [
        ("version", result.version),
        ("wall_s", simulated and simulated.wall_s),
        ("realtime_factor", simulated and simulated.realtime_factor),
    ]
    return tables


def ran(result: CycleResult) -> dict[str, str | None]:
    """Choices of the run, by name in the order of the page; None where one does not apply."""
    return {
        "machine": result.machine,
        "protocol": result.protocol,
        "approach": result.approach,
        "compensation": result.compensation,
        "patient": result.patient,
        "catheter": result.catheter,
        "conduit": None if result.simulated is None else result.simulated.conduit,
        "seed": result.drawn_by,
    }


def _plots(
    result: CycleResult, trace: Trace, phases: list[PhaseBand], is_one_of_many: bool
) -> dict[str, Any]:
    """Data that the page's script draws."""
    coarser = series.COARSE if is_one_of_many else 1
    return {
        "series": series.machine(result, trace, series.BUCKETS // coarser),
        "patient": series.patient(result, trace, series.BREATHS_BUCKETS // coarser),
        "phases": [[band.label, band.kind, band.start_s, band.end_s] for band in phases],
        "instants": instants(result),
        "target_mm": result.tip.target_mm,
        "focus_s": series.focus_s(result),
        "is_quiet_after": _is_quiet_after(result),
        "cap_name": airway_geometry.cap_name(result),
        "cap_mm": result.anatomy.cap_mm,
        "boundary_mm": result.anatomy.patient_boundary_mm,
        "setpoint_mmhg": result.vacuum.setpoint_mmhg,
    }


def _is_quiet_after(result: CycleResult) -> bool:
    """True if nothing happens to the machine once the cycle is over: its plots begin with that."""
    end_s = series.focus_s(result)
    if end_s is None or result.is_inside:
        return False
    return all(found.time_s <= end_s for found in instants(result))


def render(
    result: CycleResult,
    trace: Trace,
    sections: Sections | None = None,
    *,
    is_one_of_many: bool = False,
) -> str:
    """The report of one cycle as a self-contained HTML page.

    result: what is None in it is shown as not simulated or left out. trace: columns of
    ``simulation.closed_loop`` by name; those that are missing are not drawn. sections: further
    tables for the end of the page, for example ``{"Protocol settings": {"travel_mm": 90.0}}``.
    is_one_of_many: smaller, with less detail.
    """
    phases = bands(result)
    context = {
        "result": result,
        "first": headline.headline(result),
        "sentences": narrative.sentences(result),
        "warnings": result.warnings,
        "figures": figures.figures(result),
        "requirements": requirements(result),
        "check_items": result.check.items,
        "phases": phases,
        "drawing": airway_geometry.drawing(result),
        "trips": result.trips,
        "alarms": notice.notices(result),
        "run": [(name, word) for name, word in ran(result).items() if word is not None],
        "tables": _tables(result, sections),
        "plots": _plots(result, trace, phases, is_one_of_many),
    }
    return sheet.render_template("page.html.j2", SCRIPTS, **context)
