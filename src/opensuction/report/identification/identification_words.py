"""An identification, or a comparison of models, in words and key figures, for page and terminal.

An identification in the terminal: the result in a line, parameters or ranking, files.
"""

import math
from collections.abc import Iterable
from typing import NamedTuple

from rich.console import Console
from rich.table import Table
from rich.text import Text

from opensuction.kernel.vocabulary import NOT_A_DEVICE
from opensuction.report.figure import Figure, FigureVerdict
from opensuction.report.terminal import glyphs, print_end, print_indented
from opensuction.report.wording import amount
from opensuction.result.identification_result import (
    ComparisonResult,
    FittedParameter,
    ModelResult,
    PredictionResult,
    WorkbenchResult,
)

DISCLAIMER = f"{NOT_A_DEVICE} The figures describe the recording that was given, and nothing else."
"""Stands on every report of a recording: only its owner knows whether it is in-silico."""


MOST_DECIMALS = 8
MOST_PLAIN = 1e7
"""Numbers with more decimals, or larger ones, are written with an exponent."""

GAIN, DECAY = "velocity_gain", "decay"
"""Parameters of the modified Dahl model whose quotient is half its gap."""


class ParameterRow(NamedTuple):
    """A parameter in the table: value and interval in as many digits as the interval supports."""

    name: str
    value: str
    unit: str
    interval: str


FEW_PARAMETERS = 12
"""More than this are folded up on a page, and left to the files in a terminal."""


def errors(model: ModelResult) -> dict[str, float | None]:
    """Errors of a model in percent of the output's range, by the heading of their column."""
    return {
        "Fitted": model.rmse_percent_of_range,
        "Held out": model.holdout_rmse_percent_of_range,
        "Cross-validation": model.cross_validation_percent_of_range,
    }


def measures(result: WorkbenchResult) -> list[str]:
    """Headings of those `errors` that some model has."""
    listed = [errors(model) for model in result.models]
    return [heading for heading in listed[0] if any(each[heading] is not None for each in listed)]


def best(result: WorkbenchResult) -> ModelResult:
    """The model that is recommended, else the first."""
    return next((model for model in result.models if model.recommended), result.models[0])


def percent(fraction: float | None) -> str:
    """Percentage in three digits, or a dash.

    >>> percent(0.2846), percent(None)
    ('0.285 %', '-')
    """
    return amount(fraction, "%", 3)


def outcome(result: WorkbenchResult) -> str:
    """The result in a line."""
    found = best(result)
    error = percent(found.rmse_percent_of_range)
    if isinstance(result, ComparisonResult):
        return f"Recommended: {found.model}, error {error} of the range"
    return f"{found.model}: error {error} of the range"


def sentences(result: WorkbenchResult) -> list[str]:
    """Result of an identification or a comparison, in plain words."""
    found, recording = best(result), result.provenance.recording
    input_, output = recording.input.column or "the input", recording.output.column or "the output"
    unit = recording.output.unit
    said = _compared(result) if isinstance(result, ComparisonResult) else []
    said += [
        f"{found.model}, {found.model_words}, follows {output} from {input_} with an "
        f"error of {amount(found.rmse, unit)} RMSE, "
        f"{percent(found.rmse_percent_of_range)} of the output's range. A straight line "
        f"leaves {percent(result.provenance.line_rmse_percent_of_range)}."
    ]
    said.extend(_fitted_range(found, input_, recording.input.unit))
    held = found.holdout_rmse_percent_of_range
    if held is not None:
        samples = found.samples - found.fitted_samples
        said.append(f"On the last {samples} samples, which it has not seen, it is {percent(held)}.")
        if found.warnings:
            said.append("Warnings are about what comes before, unless they say otherwise.")
    said.extend(_gap(found, unit))
    said.extend(_coupling(found))
    return said


def _compared(result: ComparisonResult) -> list[str]:
    """Reasons for the recommendation, number of models compared, and those left out."""
    found, count = best(result), len(result.models)
    validated = found.cross_validation_percent_of_range
    return [
        *found.reasons,
        f"{count} model{'s' if count > 1 else ''} compared on the same samples"
        + ("." if validated is None else f"; this one: {percent(validated)} where left out."),
        *(f"{model} is left out: {why}." for model, why in result.left_out.items()),
    ]


def _fitted_range(model: ModelResult, input_: str, unit: str) -> list[str]:
    """Over which inputs and speeds it was fitted."""
    lowest, highest, slowest, fastest = (
        None if end is None else f"{end:.4g}" for end in model.fitted_range
    )
    if lowest is None or highest is None:
        return []
    measure = f" {unit}" if unit else ""
    strokes = f", in strokes of {slowest} to {fastest}{measure} a second" if slowest else ""
    return [f"It was fitted over {input_} from {lowest} to {highest}{measure}{strokes}."]


def _coupling(model: ModelResult) -> list[str]:
    """Share that each of several inputs adds to the output."""
    if not model.coupling_percent_of_range:
        return []
    shares = model.coupling_percent_of_range.items()
    listed = ", ".join(f"{name} {percent(share)}" for name, share in shares)
    return [f"Of the output's range the inputs add, RMS: {listed}."]


def _gap(model: ModelResult, unit: str) -> list[str]:
    """Gap between the two ways, of the one model where it is a simple quotient.

    Nothing of parameters that are not determined: at a bound, or 0 for all that is known.
    """
    if model.model != "modified-dahl" or not model.determined:
        return []
    gain, decay = (model.parameters.get(name) for name in (GAIN, DECAY))
    if gain is None or decay is None or not (_is_positive(gain) and _is_positive(decay)):
        return []
    if gain.value is None or not decay.value:
        return []
    gap = amount(2.0 * gain.value / decay.value, unit)
    return [f"Over long travels the way there and the way back lie {gap} apart: the gap."]


def _is_positive(parameter: FittedParameter) -> bool:
    """True if its whole interval is above 0."""
    return parameter.ci95 is not None and parameter.ci95[0] > 0.0


def figures(result: WorkbenchResult) -> list[Figure]:
    """Key figures of the best model; those that were not computed are left out."""
    found = best(result)
    error, line = found.rmse_percent_of_range, result.provenance.line_rmse_percent_of_range
    held, validated = found.holdout_rmse_percent_of_range, found.cross_validation_percent_of_range
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
    shown.append(
        Figure("Continuous inverse", "yes", "", FigureVerdict.GOOD, "")
        if found.well_posed
        else Figure("Continuous inverse", "no", "", FigureVerdict.NOTICE, _why_none(found))
    )
    return shown


def _why_none(model: ModelResult) -> str:
    return "it predicts only" if inverse(model) == "none" else "reversals are gaps"


def inverse(model: ModelResult) -> str:
    """Kind of a model's inverse, in a word or two."""
    if model.inverse.startswith("none"):
        return "none"
    return "continuous" if model.well_posed else "with gaps"


def parameters(model: ModelResult) -> list[ParameterRow]:
    """Parameters of a model as rows of a table."""
    shown = []
    for name, found in model.parameters.items():
        ends, decimals = found.ci95, _decimals(found.ci95)
        shown.append(
            ParameterRow(
                name=name,
                value="-" if found.value is None else _written(found.value, decimals),
                unit=found.unit,
                interval=" to ".join(_written(end, decimals) for end in ends) if ends else "-",
            )
        )
    return shown


def _decimals(ends: tuple[float, float] | None) -> int | None:
    """Decimals that show two digits of the interval's half-width; None without an interval."""
    if not ends or not ends[1] > ends[0]:
        return None
    return max(1 - math.floor(math.log10(0.5 * (ends[1] - ends[0]))), 0)


def _written(number_: float, decimals: int | None) -> str:
    if decimals is None or decimals > MOST_DECIMALS or abs(number_) >= MOST_PLAIN:
        return f"{number_:.6g}"
    return f"{number_:.{decimals}f}"


def _table(*headings: str, numbers: Iterable[str], apart: int = 2) -> Table:
    """An empty table. numbers: headings of the columns that hold some. apart: spaces between."""
    table = Table(box=None, padding=(0, apart, 0, 0), pad_edge=False, header_style="dim")
    for heading in headings:
        table.add_column(heading, justify="right" if heading in numbers else "left", no_wrap=True)
    return table


def _parameters(model: ModelResult) -> Table:
    table = _table("Parameter", "Value", "Unit", "95 % interval", numbers=("Value",))
    for row in parameters(model):
        table.add_row(*(Text(cell) for cell in row))
    return table


def _ranking(result: ComparisonResult) -> Table:
    """Models, best first, with the errors that some of them have."""
    columns = measures(result)
    # Two spaces would make it 81 characters wide, and a terminal has 80.
    table = _table("Model", *columns, "Inverse", "", numbers=columns, apart=1)
    for model in result.models:
        shown = errors(model)
        table.add_row(
            Text(model.model),
            *(Text(percent(shown[measure])) for measure in columns),
            Text(inverse(model)),
            Text("recommended" if model.recommended else ""),
            style="bold" if model.recommended else "",
        )
    return table


def print_summary(console: Console, result: WorkbenchResult, files: Iterable[object] = ()) -> None:
    """Print what was found, with warnings, and the files that were written."""
    found = best(result)
    console.print()
    console.print(Text(f"{glyphs(console).done} {outcome(result)}", style="bold green"))
    print_indented(console, sentences(result))
    print_indented(console, [f"Warning: {warning}" for warning in found.warnings], "yellow")
    console.print()
    if isinstance(result, ComparisonResult):
        console.print(_ranking(result))
    elif len(found.parameters) <= FEW_PARAMETERS:
        console.print(_parameters(found))
    print_end(console, files, DISCLAIMER)


def prediction_sentences(result: PredictionResult) -> list[str]:
    """Result of a prediction in plain words."""
    unit = "" if result.unit == "output" else result.unit
    said = [
        f"{result.model} gives {amount(result.lowest, unit)} to {amount(result.highest, unit)} for "
        f"{', '.join(result.inputs)}."
    ]
    error = result.error
    if error is None:
        said.append("The recording has no output to hold it against.")
    else:
        said.append(
            f"From the measured {result.output} it is {amount(error.rmse, unit)} RMSE away, "
            f"{percent(error.rmse_percent_of_range)} of its range, at most "
            f"{amount(error.largest, unit)}."
        )
    if result.interval_half_width is not None:
        inside = None if error is None else error.inside_interval_ratio
        holds = "" if inside is None else f"; {percent(100.0 * inside)} of the measured lie in it"
        said.append(f"95 % interval: +- {amount(result.interval_half_width, unit)}{holds}.")
    return said


def print_prediction(
    console: Console, result: PredictionResult, files: Iterable[object] = ()
) -> None:
    """Print what was predicted, with warnings, and the files that were written."""
    console.print()
    samples = "1 sample" if result.samples == 1 else f"{result.samples} samples"
    done = f"{glyphs(console).done} {samples} predicted"
    console.print(Text(done, style="bold green"))
    print_indented(console, prediction_sentences(result))
    print_indented(console, [f"Warning: {warning}" for warning in result.warnings], "yellow")
    print_end(console, files, DISCLAIMER)
