"""An identification, or a comparison of models, as a single HTML page like that of a cycle."""

from typing import Any

from markupsafe import Markup

from opensuction.report import html
from opensuction.report.identification import identification_series, identification_words
from opensuction.report.identification.identification_series import FittedCurves
from opensuction.report.summary import Summary, flatten, number, text, value, warnings

SCRIPTS = ("plot_parts.js", "identification_loop.js", "identification_plots.js")
"""In this order: each uses those before it."""

HUES = ("tip", "head", "valve", "line-vacuum", "tip-vacuum", "removed", "deepest", "contact")
"""Colours of the models, in their order; more models than colours begin anew, dashed."""

SOFTWARE = ("version", "date_utc", "seconds")
"""How it was computed."""


def _axis(summary: Summary, which: str) -> str:
    """Label of an axis: the column as it was used, with its unit where that is known."""
    column = text(summary, "recording", which, "column") or which
    sign = "-" if value(summary, "recording", which, "negated") is True else ""
    unit = text(summary, "recording", which, "unit")
    return f"{sign}{column} ({unit})" if unit else f"{sign}{column}"


def _model(model: Summary, place: int) -> dict[str, Any]:
    """One model for the template."""
    return {
        "name": text(model, "model") or "model",
        "words": text(model, "model_words") or "",
        "method": text(model, "method") or "",
        "hue": HUES[place % len(HUES)],
        "dashed": place >= len(HUES),
        "recommended": value(model, "recommended") is True,
        "errors": {
            heading: number(model, key) for heading, key in identification_words.MEASURES.items()
        },
        "inverse": identification_words.inverse(model),
        "parameters": identification_words.parameters(model),
        "warnings": warnings(model),
        "parameter_file": text(model, "parameter_file"),
    }


def _tables(summary: Summary) -> dict[str, list[tuple[str, Any]]]:
    """Tables at the end of the page: what was identified, and by what."""
    recording = value(summary, "recording") or {}
    fitted = identification_words.best(summary)
    recording = dict(recording) | {
        "fitted_samples": number(fitted, "fitted_samples"),
        "holdout_ratio": number(summary, "holdout_ratio"),
    }
    return {
        "Recording": flatten(recording),
        "Software": [(key, value(summary, key)) for key in SOFTWARE],
    }


def render(summary: Summary, curves: FittedCurves) -> str:
    """The report of ``identify`` or ``compare`` as a self-contained HTML page.

    summary: the JSON object of the command. curves: the samples that were used and what each
    model makes of them, by the models' names.
    """
    models = [
        _model(model, place) for place, model in enumerate(identification_words.models(summary))
    ]
    best = text(identification_words.best(summary), "model")
    plots = identification_series.plots(curves) | {
        "models": [
            {key: model[key] for key in ("name", "hue", "dashed")}
            | {"shown": model["name"] == best}
            for model in models
        ],
        "input_label": _axis(summary, "input"),
        "output_label": _axis(summary, "output"),
        "unit": text(summary, "recording", "output", "unit") or "",
    }
    context = {
        "title": "Models compared" if len(models) > 1 else "Identification",
        "outcome": identification_words.outcome(summary),
        "sentences": identification_words.sentences(summary),
        "warnings": warnings(identification_words.best(summary)),
        "partial": plots["loop"]["samples"] < curves.answer.size,
        "figures": identification_words.figures(summary),
        "models": models,
        "best": best,
        "most": _full_bar(models, number(summary, "line_rmse_percent_of_range")),
        "measures": identification_words.measures(summary),
        "few": identification_words.FEW_PARAMETERS,
        "run": [
            (name, shown)
            for name, shown in (
                ("recording", text(summary, "recording", "file")),
                ("input", _axis(summary, "input")),
                ("output", _axis(summary, "output")),
                ("samples", text(summary, "recording", "samples")),
            )
            if shown
        ],
        "tables": _tables(summary),
        "plots": plots,
        "notice": identification_words.DISCLAIMER,
        "percent": identification_words.percent,
        "own_style": Markup(html.read("template", "identification.css")),
    }
    return html.render("identification.html.j2", SCRIPTS, **context)


def _full_bar(models: list[dict[str, Any]], line: float | None) -> float:
    """Error of a full bar: the largest of the models that beat a straight line, if any does.

    One model that fits badly would make all the others' bars too short to tell apart.
    """
    errors = [error for model in models for error in model["errors"].values() if error is not None]
    better = [error for error in errors if line is not None and error < line]
    return max(better or errors, default=1.0) or 1.0
