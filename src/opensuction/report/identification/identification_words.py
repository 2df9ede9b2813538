"""An identification in words and key figures, for page and terminal.

summary: the JSON object of ``identify`` or ``compare``; a model: one entry of its ``models``, or
the object of ``identify`` itself.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

from opensuction.identification.judgement.fitted_range import FittedRange
from opensuction.kernel.disclaimer import NOT_A_DEVICE
from opensuction.report.figure import Figure, FigureVerdict
from opensuction.report.summary import Summary, number, rows, text, value, warnings
from opensuction.report.wording import amount

DISCLAIMER = f"{NOT_A_DEVICE} The figures describe the recording that was given, and nothing else."
"""Stands on every report of a recording: only its owner knows whether it is in-silico."""


MOST_DECIMALS = 8
MOST_PLAIN = 1e7
"""Numbers with more decimals, or larger ones, are written with an exponent."""


class ParameterRow(NamedTuple):
    """A parameter in the table: value and interval in as many digits as the interval supports."""

    name: str
    value: str
    unit: str
    interval: str


FEW_PARAMETERS = 12
"""More than this are folded up on a page, and left to the files in a terminal."""
MEASURES = {
    "Fitted": "rmse_percent_of_range",
    "Held out": "holdout_rmse_percent_of_range",
    "Cross-validation": "cross_validation_percent_of_range",
}
"""Errors of a model by the heading of their column: keys of the summary."""


def measures(summary: Summary) -> dict[str, str]:
    """Those of `MEASURES` that some model of the summary has."""
    return {
        heading: key
        for heading, key in MEASURES.items()
        if any(number(model, key) is not None for model in models(summary))
    }


def models(summary: Summary) -> list[Summary]:
    """Models of a summary, best first; one for the object of ``identify``."""
    return rows(summary, "models") or [summary]


def is_comparison(summary: Summary) -> bool:
    """Whether models were compared."""
    return bool(rows(summary, "models"))


def best(summary: Summary) -> Summary:
    """The model that is recommended, else the first."""
    known = models(summary)
    return next((model for model in known if value(model, "recommended") is True), known[0])


def percent(fraction: float | None) -> str:
    """Percentage in three digits, or a dash.

    >>> percent(0.2846), percent(None)
    ('0.285 %', '-')
    """
    return amount(fraction, "%", 3)


def outcome(summary: Summary) -> str:
    """The result in a line."""
    found = best(summary)
    name = text(found, "model") or "model"
    error = percent(number(found, "rmse_percent_of_range"))
    if is_comparison(summary):
        return f"Recommended: {name}, error {error} of the range"
    return f"{name}: error {error} of the range"


def sentences(summary: Summary) -> list[str]:
    """What was found, in plain words."""
    found = best(summary)
    named = {
        key: text(summary, "recording", key, "column") or f"the {key}"
        for key in ("input", "output")
    }
    unit = text(summary, "recording", "output", "unit") or ""
    words = text(found, "model_words")
    name = text(found, "model") if words is None else f"{text(found, 'model')}, {words},"
    said = [
        f"{name} follows {named['output']} from {named['input']} with an "
        f"error of {amount(number(found, 'rmse'), unit)} RMSE, "
        f"{percent(number(found, 'rmse_percent_of_range'))} of the output's range. A straight line "
        f"leaves {percent(number(summary, 'line_rmse_percent_of_range'))}."
    ]
    if is_comparison(summary):
        validated = number(found, "cross_validation_percent_of_range")
        count = len(models(summary))
        said.insert(
            0,
            f"{count} model{'s' if count > 1 else ''} compared on the same samples"
            + ("." if validated is None else f"; this one: {percent(validated)} where left out."),
        )
        left_out: dict[str, str] = value(summary, "left_out") or {}
        said[1:1] = [f"{model} is left out: {why}." for model, why in left_out.items()]
        said[:0] = value(found, "reasons") or []
    said.extend(_fitted_range(found, named["input"], text(summary, "recording", "input", "unit")))
    held = number(found, "holdout_rmse_percent_of_range")
    if held is not None:
        samples = int((number(found, "samples") or 0) - (number(found, "fitted_samples") or 0))
        said.append(f"On the last {samples} samples, which it has not seen, it is {percent(held)}.")
        if warnings(found):
            said.append("Warnings are about what comes before, unless they say otherwise.")
    said.extend(_gap(found, unit))
    said.extend(_coupling(found))
    return said


def _fitted_range(model: Summary, input_: str, unit: str | None) -> list[str]:
    """Over which inputs and speeds it was fitted."""
    ends = [number(model, "fitted_range", end) for end in FittedRange._fields]
    lowest, highest, slowest, fastest = (None if end is None else f"{end:.4g}" for end in ends)
    if lowest is None or highest is None:
        return []
    measure = f" {unit}" if unit else ""
    strokes = f", in strokes of {slowest} to {fastest}{measure} a second" if slowest else ""
    return [f"It was fitted over {input_} from {lowest} to {highest}{measure}{strokes}."]


def _coupling(model: Summary) -> list[str]:
    """What each of several inputs adds to the output."""
    shares = value(model, "coupling_percent_of_range") or {}
    if not shares:
        return []
    listed = ", ".join(f"{name} {percent(share)}" for name, share in shares.items())
    return [f"Of the output's range the inputs add, RMS: {listed}."]


def _gap(model: Summary, unit: str) -> list[str]:
    """How far apart the two ways are, of the one model where it is a simple quotient.

    Nothing of parameters that are not determined: at a bound, or 0 for all that is known.
    """
    if value(model, "determined") is False:
        return []
    gain = number(model, "parameters", "velocity_gain", "value")
    decay = number(model, "parameters", "decay", "value")
    if text(model, "model") != "modified-dahl" or gain is None or not decay:
        return []
    ends = [value(model, "parameters", name, "ci95") for name in ("velocity_gain", "decay")]
    if any(not isinstance(each, Sequence) or not each[0] > 0.0 for each in ends):
        return []
    gap = amount(2.0 * gain / decay, unit)
    return [f"Over long travels the way there and the way back lie {gap} apart: the gap."]


def figures(summary: Summary) -> list[Figure]:
    """Key figures of the best model; those that were not computed are left out."""
    found = best(summary)
    error = number(found, "rmse_percent_of_range")
    line = number(summary, "line_rmse_percent_of_range")
    held = number(found, "holdout_rmse_percent_of_range")
    validated = number(found, "cross_validation_percent_of_range")
    times = f"{line / error:.1f} times as much" if line is not None and error else ""
    listed = [
        ("Error", error, "RMSE, in percent of the output's range"),
        ("On samples held out", held, "predicted, not fitted"),
        ("Cross-validation", validated, "blocks left out in turn"),
        ("A straight line leaves", line, times),
    ]
    shown = [
        Figure(name, percent(known), limit, FigureVerdict.NEUTRAL, "")
        for name, known, limit in listed
        if known is not None
    ]
    posed = value(found, "well_posed")
    if posed is not None:
        shown.append(
            Figure("Continuous inverse", "yes", "", FigureVerdict.GOOD, "")
            if posed
            else Figure("Continuous inverse", "no", "", FigureVerdict.NOTICE, _why_none(found))
        )
    return shown


def _why_none(model: Summary) -> str:
    return "it predicts only" if inverse(model) == "none" else "reversals are gaps"


def inverse(model: Summary) -> str:
    """How a model can be inverted, in a word or two; a dash where that is not known."""
    if (text(model, "inverse") or "").startswith("none"):
        return "none"
    return {True: "continuous", False: "with gaps"}.get(value(model, "well_posed"), "-")


def parameters(model: Summary) -> list[ParameterRow]:
    """Parameters of a model as rows of a table."""
    entries = value(model, "parameters")
    shown = []
    for name, entry in (entries or {}).items():
        at, ends = number(entry, "value"), value(entry, "ci95")
        decimals = _decimals(ends)
        shown.append(
            ParameterRow(
                name=name,
                value="-" if at is None else _written(at, decimals),
                unit=text(entry, "unit") or "",
                interval=" to ".join(_written(end, decimals) for end in ends) if ends else "-",
            )
        )
    return shown


def _decimals(ends: Any) -> int | None:
    """Decimals that show two digits of the interval's half-width; None without an interval."""
    if not ends or not ends[1] > ends[0]:
        return None
    return max(1 - math.floor(math.log10(0.5 * (ends[1] - ends[0]))), 0)


def _written(number_: float, decimals: int | None) -> str:
    if decimals is None or decimals > MOST_DECIMALS or abs(number_) >= MOST_PLAIN:
        return f"{number_:.6g}"
    return f"{number_:.{decimals}f}"
