"""What every page is made of: templates, styles and scripts, all of them inside the page."""

from collections.abc import Iterable
from importlib import resources

import jinja2
from markupsafe import Markup

from opensuction.report import narrative, wording

ROOM = "opensuction.report"


def _read(*path: str) -> str:
    return resources.files(ROOM).joinpath(*path).read_text(encoding="utf-8")


def environment() -> jinja2.Environment:
    """Templates of this room, with the filters that they use."""
    made = jinja2.Environment(
        loader=jinja2.FunctionLoader(lambda name: _read("template", name)),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters["event"] = narrative.event
    made.filters["plain"] = wording.plain
    made.filters["quantity"] = wording.quantity
    return made


def styles(names: Iterable[str] = ()) -> list[Markup]:
    """Style sheets: the plots', every page's, and those of a page of its own."""
    own = [Markup(_read("template", name)) for name in ("page.css", *names)]
    return [Markup(_read("vendor", "uPlot.min.css")), *own]


def scripts(names: Iterable[str]) -> list[Markup]:
    """The plotting library and the scripts of a page, in this order."""
    own = [Markup(_read("template", name)) for name in names]
    return [Markup(_read("vendor", "uPlot.iife.min.js")), *own]
