"""A page of sections, tables and plots: what a study came to, as one HTML file without a network.

`page` is the report of one cycle; this is the form of everything else that is shown on paper.

Rendering of all HTML pages of the project: templates, styles and scripts in one file.
"""

from functools import cache
from importlib import resources
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt
from markupsafe import Markup

from opensuction.report import ending, notice, series, wording

if TYPE_CHECKING:
    import jinja2

ROOM = "opensuction.report"


def read(*path: str) -> str:
    """Text of a file of this room."""
    return resources.files(ROOM).joinpath(*path).read_text(encoding="utf-8")


@cache
def _environment() -> "jinja2.Environment":
    """Templates that this process has used stay compiled."""
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.FunctionLoader(lambda name: read("template", name)),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["event"] = ending.event
    environment.filters["span"] = notice.span
    environment.filters["raiser"] = ending.raiser
    environment.filters["capitalise"] = wording.capitalise
    environment.filters["plain"] = wording.plain
    environment.filters["moment"] = wording.moment
    environment.filters["quantity"] = wording.quantity
    return environment


def render_part(template: str, **context: Any) -> str:
    """A template of ``template/`` filled in, alone: for a page that has its own styles."""
    return _environment().get_template(template).render(**context)


def render_template(template: str, scripts: tuple[str, ...], **context: Any) -> str:
    """A template of ``template/`` filled in, with disclaimer, styles, uPlot and its scripts.

    scripts: files of ``template/`` in the order in which they need one another.
    """
    return (
        _environment()
        .get_template(template)
        .render(
            disclaimer=wording.DISCLAIMER,
            styles=[
                Markup(read("vendor", "uPlot.min.css")),
                Markup(read("template", "page.css")),
                Markup(read("template", "anatomy.css")),
            ],
            scripts=[
                Markup(read("vendor", "uPlot.iife.min.js")),
                *(Markup(read("template", name)) for name in scripts),
            ],
            **context,
        )
    )


Values = npt.NDArray[np.float64]

SCRIPTS = ("plot_parts.js", "lanes.js", "sheet.js")
"""In this order: each uses those before it."""
BUCKETS = 300
"""Stretches of a curve of which each keeps its extremes: fewer than pixels."""


class Curve(NamedTuple):
    """One line of a plot."""

    label: str
    y: Values
    hue: str = "tip"
    """Colour by its name in the style sheet."""
    dashed: bool = False
    x: Values | None = None
    """Its own abscissa, where it has one: loops, or other times than the plot's."""


class Level(NamedTuple):
    """A line with a name across a plot: horizontal, or upright among a plot's ``marks``."""

    value: float
    name: str


class Stretch(NamedTuple):
    """A stretch of an abscissa with a name: shaded behind curves, or a bar of a lane."""

    name: str
    """Beside or within it; may be empty."""
    kind: str
    """Colour by its name in the style sheet."""
    start: float
    end: float
    """As its start: an instant."""


class Lane(NamedTuple):
    """A row of bars and instants under one name."""

    name: str
    stretches: tuple[Stretch, ...]
    named: bool = False
    """Names are below the bars and instants, in rows; else within a bar that is long enough."""


class Plot(NamedTuple):
    """Curves over one abscissa, or with one each; or lanes, which have no ordinate."""

    title: str
    x_label: str
    y_label: str
    curves: tuple[Curve, ...]
    x: Values | None = None
    caption: str = ""
    levels: tuple[Level, ...] = ()
    marks: tuple[Level, ...] = ()
    """Vertical lines: instants with a name."""
    shades: tuple[Stretch, ...] = ()
    """Behind the curves."""
    lanes: tuple[Lane, ...] = ()
    """In place of curves, the first one on top."""
    span: tuple[float, float] | None = None
    """Of the abscissa, for plots that stand below one another; None: what the curves span."""


class Cell(NamedTuple):
    """A cell that says more than its value does."""

    text: str
    kind: str = ""
    """``good``, ``notice``, ``bad``, ``number`` or nothing."""
    href: str = ""
    """A page beside this one, or ``#`` and the `Section.anchor` of a part of it."""


class Rounded(NamedTuple):
    """A number with as many decimals as mean anything; None where there is none."""

    value: float | None
    decimals: int


class Table(NamedTuple):
    """Rows of cells: numbers right-aligned, True and False as verdicts, None and nan as a dash."""

    caption: str
    columns: tuple[str, ...]
    rows: tuple[tuple[Any, ...], ...]


class Section(NamedTuple):
    """Part of a page."""

    title: str
    text: tuple[str, ...] = ()
    tables: tuple[Table, ...] = ()
    plots: tuple[Plot, ...] = ()
    anchor: str = ""
    """Name that links lead to. A section with one is folded: it opens on demand."""


class Sheet(NamedTuple):
    """A whole page."""

    title: str
    verdict: str
    good: bool
    lead: str
    run: tuple[tuple[str, str], ...]
    """What ran, as names and values under the verdict."""
    sections: tuple[Section, ...]
    kind: str = ""
    """Of the verdict where good and bad are not enough: ``notice``."""


def _decimals(arrays: list[Values]) -> int:
    """Decimals that show a ten-thousandth of what the arrays span together."""
    known = [array[np.isfinite(array)] for array in arrays]
    known = [array for array in known if array.size]
    span = max(map(np.max, known)) - min(map(np.min, known)) if known else 0.0
    return series.decimals_of(float(span))


def to_plain(plot: Plot) -> dict[str, Any]:
    """A plot thinned and ready for JSON: extremes of every curve are kept."""
    data: dict[str, Any] = {
        "x_label": plot.x_label,
        "y_label": plot.y_label,
        "levels": [level._asdict() for level in plot.levels],
        "marks": [mark._asdict() for mark in plot.marks],
        "shades": plot.shades,
        "lanes": [lane._asdict() for lane in plot.lanes],
        "span": plot.span,
    }
    values = [curve.y for curve in plot.curves]
    kept, decimals = None, _decimals(values)
    if plot.x is not None and all(curve.x is None for curve in plot.curves):
        kept = series.keep_rows(values, [], BUCKETS)
        data["x"] = series.to_list(plot.x[kept], _decimals([plot.x]))
    data["curves"] = []
    for curve in plot.curves:
        drawn: dict[str, Any] = {"label": curve.label, "hue": curve.hue, "dashed": curve.dashed}
        rows = kept
        if rows is None:
            x = curve.x if curve.x is not None else plot.x
            if x is None:
                raise ValueError(f"curve '{curve.label}' of '{plot.title}' has no abscissa")
            rows = series.keep_rows([x, curve.y], [], BUCKETS)
            drawn["x"] = series.to_list(x[rows], _decimals([x]))
        data["curves"].append(drawn | {"y": series.to_list(curve.y[rows], decimals)})
    return data


def cell(value: Any) -> dict[str, str]:
    """Text of a table's cell, the class that it is shown in, and the page that it leads to."""
    if isinstance(value, Cell):
        return value._asdict()
    if isinstance(value, Rounded):
        if value.value is None or not np.isfinite(value.value):
            return {"text": "-", "kind": "number"}
        return {"text": f"{value.value:.{value.decimals}f}", "kind": "number"}
    if isinstance(value, bool | np.bool_):
        return {"text": "✓ yes" if value else "✕ no", "kind": "good" if value else "bad"}
    if value is None or (isinstance(value, float) and not np.isfinite(value)):
        return {"text": "-", "kind": "number"}
    if isinstance(value, int | np.integer):
        return {"text": f"{value:d}", "kind": "number"}
    if isinstance(value, float | np.floating):
        return {"text": f"{value:.4g}", "kind": "number"}
    return {"text": str(value), "kind": ""}


def render(sheet: Sheet) -> str:
    """The page as self-contained HTML that needs no network."""
    plots = {
        f"plot-{number}-{i}": to_plain(plot)
        for number, section in enumerate(sheet.sections, start=1)
        for i, plot in enumerate(section.plots, start=1)
    }
    return render_template("sheet.html.j2", SCRIPTS, sheet=sheet, plots=plots, cell=cell)
