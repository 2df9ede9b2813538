"""Rendering of all HTML pages of the project: templates, styles and scripts in one file."""

from importlib import resources
from typing import Any

import jinja2
from markupsafe import Markup

from opensuction.report import ending, notice, wording

ROOM = "opensuction.report"


def read(*path: str) -> str:
    """Text of a file of this room."""
    return resources.files(ROOM).joinpath(*path).read_text(encoding="utf-8")


def _environment() -> jinja2.Environment:
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


def render(template: str, scripts: tuple[str, ...], **context: Any) -> str:
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
