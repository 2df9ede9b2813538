"""One cycle as a single HTML page: no network, opens from a disk, prints."""

from collections.abc import Mapping
from typing import Any, NamedTuple

from opensuction.report import figures, headline, html, narrative, notice, series, wording
from opensuction.report.cycle import airway_drawing, instant, requirement
from opensuction.report.series import Trace
from opensuction.report.summary import (
    Summary,
    flatten,
    is_inside,
    number,
    rows,
    text,
    value,
    write_seed,
)
from opensuction.report.summary import warnings as warnings_of

Sections = Mapping[str, Mapping[str, Any]]
"""Tables by title: names and values, which may be nested."""

SCRIPTS = ("plot_parts.js", "loop_plot.js", "patient_plots.js", "plots.js")
"""In this order: each uses those before it."""

RUN = ("machine", "protocol", "approach", "compensation", "patient", "catheter", "conduit", "seed")
"""What ran, in the order of the page."""
SOFTWARE = ("version", "wall_s", "realtime_factor")
"""How it was computed."""


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


def bands(summary: Summary) -> list[PhaseBand]:
    """Phases that took time, each with its share of the time line; the rest after them is none."""
    known: list[tuple[str, float, float]] = []
    for phase in rows(summary, "phases"):
        start, end = number(phase, "start_s"), number(phase, "end_s")
        if start is not None and end is not None and end - start >= SHORTEST_S:
            known.append((str(phase.get("name", "")), start, end))
    while known and known[-1][0] in wording.REST:
        known.pop()
    total = sum(end - start for _, start, end in known)
    listed = []
    for i, (name, start, end) in enumerate(known, start=1):
        label, meaning, kind = wording.phase_words(name)
        share = round(100.0 * (end - start) / total, 3)
        listed.append(PhaseBand(i, label, meaning, kind, start, end, share))
    return listed


def _tables(summary: Summary, sections: Sections | None) -> dict[str, list[tuple[str, Any]]]:
    """Tables at the end of the page by title: what ran, what was set, what it ran on."""
    drawn = {"seed": write_seed(summary)}
    tables = {"This run": [(key, drawn.get(key, value(summary, key))) for key in RUN]}
    identification = value(summary, "identification")
    if isinstance(identification, Mapping):
        tables["Identification of the transmission"] = flatten(identification)
    for title, section in (sections or {}).items():
        tables[title] = flatten(section)
    tables["Software"] = [(key, value(summary, key)) for key in SOFTWARE]
    return tables


def _ran(summary: Summary) -> list[tuple[str, str]]:
    """What ran, as the head of the page says it."""
    words = {key: text(summary, key) for key in RUN} | {"seed": write_seed(summary)}
    return [(key, word) for key, word in words.items() if word is not None]


def _plots(
    summary: Summary, trace: Trace, phases: list[PhaseBand], is_one_of_many: bool
) -> dict[str, Any]:
    """What the page's script draws."""
    coarser = series.COARSE if is_one_of_many else 1
    return {
        "series": series.machine(summary, trace, series.BUCKETS // coarser),
        "patient": series.patient(summary, trace, series.BREATHS_BUCKETS // coarser),
        "phases": [[band.label, band.kind, band.start_s, band.end_s] for band in phases],
        "instants": instant.instants(summary),
        "target_mm": number(summary, "tip", "target_mm"),
        "focus_s": series.focus_s(summary),
        "is_quiet_after": _is_quiet_after(summary),
        "cap_name": airway_drawing.cap_name(summary),
        "cap_mm": number(summary, "anatomy", "cap_mm"),
        "boundary_mm": number(summary, "anatomy", "patient_boundary_mm"),
        "setpoint_mmhg": number(summary, "vacuum", "setpoint_mmhg"),
    }


def _is_quiet_after(summary: Summary) -> bool:
    """Whether nothing happens to the machine once the cycle is over: its plots begin with that."""
    end_s = series.focus_s(summary)
    if end_s is None or is_inside(summary):
        return False
    return all(found.time_s <= end_s for found in instant.instants(summary))


def render(
    summary: Summary,
    trace: Trace,
    sections: Sections | None = None,
    *,
    is_one_of_many: bool = False,
) -> str:
    """The report of one cycle as a self-contained HTML page.

    summary: the JSON object of the ``cycle`` command; what is null or missing is shown as not
    simulated or left out. trace: columns of ``simulation.closed_loop`` by name; those that are
    missing are not drawn. sections: further tables for the end of the page, for example
    ``{"Protocol settings": {"travel_mm": 90.0}}``. is_one_of_many: smaller, with
    less detail.
    """
    phases = bands(summary)
    context = {
        "summary": summary,
        "first": headline.headline(summary),
        "sentences": narrative.sentences(summary),
        "warnings": warnings_of(summary),
        "figures": figures.figures(summary),
        "requirements": requirement.requirements(summary),
        "check_items": rows(value(summary, "check") or {}, "items"),
        "phases": phases,
        "drawing": airway_drawing.drawing(summary),
        "trips": rows(summary, "trips"),
        "alarms": notice.notices(summary),
        "run": _ran(summary),
        "tables": _tables(summary, sections),
        "plots": _plots(summary, trace, phases, is_one_of_many),
    }
    return html.render("page.html.j2", SCRIPTS, **context)
