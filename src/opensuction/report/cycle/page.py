"""One cycle as a single HTML page: no network, opens from a disk, prints."""

from collections.abc import Mapping
from typing import Any, NamedTuple

from opensuction.report import figures, headline, html, narrative, notice, series, wording
from opensuction.report.cycle import airway_drawing, instant, requirement
from opensuction.report.series import Trace
from opensuction.result.cycle_result import CycleResult
from opensuction.result.plain import flatten, to_json

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
        "instants": instant.instants(result),
        "target_mm": result.tip.target_mm,
        "focus_s": series.focus_s(result),
        "is_quiet_after": _is_quiet_after(result),
        "cap_name": airway_drawing.cap_name(result),
        "cap_mm": result.anatomy.cap_mm,
        "boundary_mm": result.anatomy.patient_boundary_mm,
        "setpoint_mmhg": result.vacuum.setpoint_mmhg,
    }


def _is_quiet_after(result: CycleResult) -> bool:
    """True if nothing happens to the machine once the cycle is over: its plots begin with that."""
    end_s = series.focus_s(result)
    if end_s is None or result.is_inside:
        return False
    return all(found.time_s <= end_s for found in instant.instants(result))


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
        "requirements": requirement.requirements(result),
        "check_items": result.check.items,
        "phases": phases,
        "drawing": airway_drawing.drawing(result),
        "trips": result.trips,
        "alarms": notice.notices(result),
        "run": [(name, word) for name, word in ran(result).items() if word is not None],
        "tables": _tables(result, sections),
        "plots": _plots(result, trace, phases, is_one_of_many),
    }
    return html.render("page.html.j2", SCRIPTS, **context)
