"""An identification, or a comparison of models, as a single HTML page like that of a cycle."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from markupsafe import Markup

from opensuction.report import html
from opensuction.report.identification import identification_series, identification_words
from opensuction.report.identification.identification_series import FittedCurves
from opensuction.report.identification.identification_words import ParameterRow
from opensuction.result.identification_result import (
    ModelResult,
    RecordedColumn,
    WorkbenchResult,
)
from opensuction.result.plain import flatten, to_json

SCRIPTS = ("plot_parts.js", "identification_loop.js", "identification_plots.js")
"""In this order: each uses those before it."""

HUES = ("tip", "head", "valve", "line-vacuum", "tip-vacuum", "removed", "deepest", "contact")
"""Colours of the models, in their order; more models than colours begin anew, dashed."""


class ShownModel(NamedTuple):
    """One model as the template shows it."""

    name: str
    words: str
    method: str
    hue: str
    dashed: bool
    recommended: bool
    errors: Mapping[str, float | None]
    """By the heading of their column."""
    inverse: str
    parameters: Sequence[ParameterRow]
    warnings: Sequence[str]
    parameter_file: str | None


def _axis(column: RecordedColumn, otherwise: str) -> str:
    """Label of an axis: the column as it was used, with its unit where that is known."""
    label = f"{'-' if column.negated else ''}{column.column or otherwise}"
    return f"{label} ({column.unit})" if column.unit else label


def _model(model: ModelResult, place: int) -> ShownModel:
    """One model for the template."""
    return ShownModel(
        name=model.model,
        words=model.model_words,
        method=model.method,
        hue=HUES[place % len(HUES)],
        dashed=place >= len(HUES),
        recommended=model.recommended,
        errors=identification_words.errors(model),
        inverse=identification_words.inverse(model),
        parameters=identification_words.parameters(model),
        warnings=model.warnings,
        parameter_file=model.parameter_file,
    )


def _tables(result: WorkbenchResult) -> dict[str, list[tuple[str, Any]]]:
    """Tables at the end of the page: what was identified, and by what."""
    found, fitted = result.provenance, identification_words.best(result)
    return {
        "Recording": [
            *flatten(to_json(found.recording)),
            ("fitted_samples", float(fitted.fitted_samples)),
            ("holdout_ratio", found.holdout_ratio),
        ],
        "Software": [
            ("version", found.version),
            ("date_utc", found.date_utc),
            ("seconds", found.seconds),
        ],
    }


def render(result: WorkbenchResult, curves: FittedCurves) -> str:
    """The report of ``identify`` or ``compare`` as a self-contained HTML page.

    curves: the samples that were used and what each model makes of them, by the models' names.
    """
    models = [_model(model, place) for place, model in enumerate(result.models)]
    found, recording = identification_words.best(result), result.provenance.recording
    axes = _axis(recording.input, "input"), _axis(recording.output, "output")
    plots = identification_series.plots(curves) | {
        "models": [
            {
                "name": model.name,
                "hue": model.hue,
                "dashed": model.dashed,
                "shown": model.name == found.model,
            }
            for model in models
        ],
        "input_label": axes[0],
        "output_label": axes[1],
        "unit": recording.output.unit,
    }
    context = {
        "title": "Models compared" if len(models) > 1 else "Identification",
        "outcome": identification_words.outcome(result),
        "sentences": identification_words.sentences(result),
        "warnings": found.warnings,
        "partial": identification_series.loop_end(curves.driven) < curves.answer.size,
        "figures": identification_words.figures(result),
        "models": models,
        "best": found.model,
        "most": _full_bar(models, result.provenance.line_rmse_percent_of_range),
        "measures": identification_words.measures(result),
        "few": identification_words.FEW_PARAMETERS,
        "run": [
            (name, shown)
            for name, shown in (
                ("recording", recording.file),
                ("input", axes[0]),
                ("output", axes[1]),
                ("samples", recording.samples),
            )
            if shown
        ],
        "tables": _tables(result),
        "plots": plots,
        "notice": identification_words.DISCLAIMER,
        "percent": identification_words.percent,
        "own_style": Markup(html.read("template", "identification.css")),
    }
    return html.render("identification.html.j2", SCRIPTS, **context)


def _full_bar(models: Sequence[ShownModel], line: float | None) -> float:
    """Error of a full bar: the largest of the models that beat a straight line, if any does.

    One model that fits badly would make all the others' bars too short to tell apart.
    """
    errors = [error for model in models for error in model.errors.values() if error is not None]
    better = [error for error in errors if line is not None and error < line]
    return max(better or errors, default=1.0) or 1.0
