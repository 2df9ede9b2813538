"""An identification, or a comparison of models, as a single HTML page like that of a cycle.

Curves of an identification, thinned for a page: every extreme and every reversal is kept.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from markupsafe import Markup

from opensuction.report import sheet
from opensuction.report.identification import identification_words
from opensuction.report.identification.identification_words import ParameterRow
from opensuction.report.series import decimals_of, directions, keep_rows, to_list
from opensuction.result.identification_result import (
    ModelResult,
    RecordedColumn,
    WorkbenchResult,
)
from opensuction.result.plain import flatten, to_json

Array = npt.NDArray[np.float64]

BUCKETS = 350
"""Stretches of time of which each keeps its extremes: fewer than pixels, more than the eye asks."""

LOOP_REVERSALS = 30
"""Reversals that the loop plot shows; more lie on top of one another."""

REVERSAL_RATIO = 0.02
"""Motion against its direction, as a share of the range, that counts as a reversal."""

LAGS = 300
"""Lags of the autocorrelation that are drawn."""


class FittedCurves(NamedTuple):
    """A recording and what each model makes of it, arrays of shape (samples,)."""

    time_s: Array | None
    """None: samples are counted instead."""
    driven: Array
    answer: Array
    fitted: Mapping[str, Array]
    """By the name of the model, in the order of the page."""
    autocorrelation: Mapping[str, Array]
    """Of the residuals, from lag 0; by the name of the model."""
    fitted_samples: int
    """The samples after these were held out."""


def loop_end(driven: Array) -> int:
    """Number of samples that show the first `LOOP_REVERSALS` reversals; all of them if fewer."""
    rises = directions(driven, REVERSAL_RATIO * float(np.ptp(driven)))
    reversals = np.flatnonzero(np.diff(rises)) + 1
    return int(reversals[LOOP_REVERSALS] if reversals.size > LOOP_REVERSALS else driven.size)


def _loop(curves: FittedCurves, decimals: tuple[int, int]) -> dict[str, Any]:
    """Rows of the loop plot: consecutive in time, so that its lines are motions."""
    end = loop_end(curves.driven)
    shown = [curves.driven[:end], curves.answer[:end]]
    slope, intercept = (float(factor) for factor in np.polyfit(shown[0], shown[1], 1))
    line = slope * curves.driven + intercept
    rows = keep_rows([*shown, shown[1] - line[:end]], [], BUCKETS)
    return {
        "samples": end,
        "line": to_list(line[rows], decimals[1] + 1),
        "input": to_list(curves.driven[rows], decimals[0]),
        "output": to_list(curves.answer[rows], decimals[1]),
        "fitted": _thin(curves.fitted, rows, decimals[1]),
    }


def _thin(
    series: Mapping[str, Array], rows: npt.NDArray[np.int64], decimals: int
) -> dict[str, list[float | None]]:
    return {name: to_list(values[rows], decimals) for name, values in series.items()}


def _autocorrelation(curves: FittedCurves) -> dict[str, Any]:
    """Autocorrelation by lag, in seconds where the samples are evenly spaced in time."""
    most = max((values.size for values in curves.autocorrelation.values()), default=0)
    most = min(most, LAGS)
    step_s = 1.0
    if curves.time_s is not None and curves.time_s.size > 1:
        step_s = float(curves.time_s[-1] - curves.time_s[0]) / (curves.time_s.size - 1)
    return {
        "lag": to_list(step_s * np.arange(most, dtype=np.float64), 6),
        "values": {
            name: to_list(
                np.pad(values[:most], (0, most - values[:most].size), constant_values=np.nan), 4
            )
            for name, values in curves.autocorrelation.items()
        },
        # Residuals that are noise stay within this in 95 of 100 lags.
        "band": 1.96 / math.sqrt(curves.fitted_samples),
    }


def curve_plots(curves: FittedCurves) -> dict[str, Any]:
    """Data that the page's script draws, ready for JSON."""
    size = curves.answer.size
    time = np.arange(size, dtype=np.float64) if curves.time_s is None else curves.time_s
    rests = {name: curves.answer - fitted for name, fitted in curves.fitted.items()}
    rows = keep_rows([curves.answer, *rests.values()], [curves.fitted_samples - 1], BUCKETS)
    decimals = decimals_of(float(np.ptp(curves.driven))), decimals_of(float(np.ptp(curves.answer)))
    held = None if curves.fitted_samples >= size else float(time[curves.fitted_samples])
    return {
        "timed": curves.time_s is not None,
        "time": to_list(time[rows], decimals_of(float(np.ptp(time)))),
        "output": to_list(curves.answer[rows], decimals[1]),
        "fitted": _thin(curves.fitted, rows, decimals[1]),
        "rest": _thin(rests, rows, decimals[1] + 1),
        "held_from": held,
        "loop": _loop(curves, decimals),
        "autocorrelation": _autocorrelation(curves),
    }


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
    plots = curve_plots(curves) | {
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
        "partial": loop_end(curves.driven) < curves.answer.size,
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
        "own_style": Markup(sheet.read("template", "identification.css")),
    }
    return sheet.render_template("identification.html.j2", SCRIPTS, **context)


def _full_bar(models: Sequence[ShownModel], line: float | None) -> float:
    """Error of a full bar: the largest of the models that beat a straight line, if any does.

    One model that fits badly would make all the others' bars too short to tell apart.
    """
    errors = [error for model in models for error in model.errors.values() if error is not None]
    better = [error for error in errors if line is not None and error < line]
    return max(better or errors, default=1.0) or 1.0
