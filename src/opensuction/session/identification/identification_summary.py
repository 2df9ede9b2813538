"""Results of the workbench as plain data: the JSON objects and the parameter file.

Keys and units are a contract (docs/reference/results.md); ``null`` is what could not be computed.
"""

import math
from datetime import datetime

import numpy as np

from opensuction import __version__
from opensuction.identification.estimator import modified_dahl
from opensuction.identification.judgement.candidate import Estimate
from opensuction.identification.judgement.diagnosis import UNKNOWN_UNITS
from opensuction.identification.judgement.driven import Driven
from opensuction.identification.method import METHODS, MODELS
from opensuction.identification.workbench import FittedModel
from opensuction.kernel.errors import InputError
from opensuction.result.plain import Json, without_nan
from opensuction.session.identification import identification_run
from opensuction.session.identification.identification_run import LoadedRecording
from opensuction.settings import lines_section, model_structure
from opensuction.settings.identification_file import (
    COMPENSATOR_OF_MODEL,
    FORMAT_VERSION,
    NO_COMPENSATOR,
    IdentificationFile,
    Identified,
    IdentifiedParameter,
    Quantity,
    Source,
)
from opensuction.settings.model_structure import FittedPart, Structure


def _interval(estimate: Estimate) -> list[float]:
    """Both ends of the 95 % interval; empty where there is none."""
    ends = [estimate.low, estimate.high]
    return ends if all(math.isfinite(end) for end in ends) else []


def _figures(result: FittedModel, fit_seconds: float) -> Json:
    """One model's figures."""
    return {
        "model": result.model,
        "model_words": MODELS[result.model].summary,
        "method": result.method,
        "method_words": METHODS[result.method],
        "parameters": {
            name: {"value": found.value, "unit": found.unit, "ci95": _interval(found) or None}
            for name, found in result.parameters.items()
        },
        "rmse": result.rmse,
        "rmse_unit": result.output_unit,
        "rmse_percent_of_range": result.rmse_percent_of_range,
        "holdout_rmse_percent_of_range": result.holdout_rmse_percent_of_range,
        "cross_validation_percent_of_range": result.cross_validation_percent_of_range,
        "well_posed": result.well_posed,
        "determined": result.determined,
        "transfer_percent_of_range": result.transfer_percent_of_range,
        "effective_parameters": result.freedom,
        "recommended": result.recommended,
        "reasons": list(result.reasons),
        "coupling_percent_of_range": result.coupling_percent_of_range or None,
        "warnings": list(result.warnings),
        "at_bound": list(result.at_bound),
        "samples": result.samples,
        "fitted_samples": result.fitted_samples,
        "fitted_range": result.fitted_range._asdict(),
        "fit_seconds": fit_seconds,
        "inverse": MODELS[result.model].inverse,
        "compensator": _compensator(result),
        "undriven": result.driven.why_not or None,
        "parameter_file": None,
    }


def _provenance(loaded: LoadedRecording, now: datetime, seconds: float) -> Json:
    """What was identified, by what, and when."""
    choice, pair = loaded.choice, loaded.pair
    range_ = float(np.ptp(pair.answer))
    return {
        "recording": {
            "file": choice.file.name,
            "sha256": loaded.table.sha256,
            "size_bytes": loaded.table.size_bytes,
            "samples": int(pair.driven.size),
            "skipped_rows": loaded.skipped_rows,
            "from_s": None if pair.time_s is None else float(pair.time_s[0]),
            "to_s": None if pair.time_s is None else float(pair.time_s[-1]),
            "input": _quantity(loaded, output=False)._asdict(),
            "other_inputs": list(choice.input[1:]),
            "output": _quantity(loaded, output=True)._asdict(),
            "time": choice.time,
        },
        "holdout_ratio": choice.holdout,
        "line_rmse_percent_of_range": 100.0 * identification_run.fit_line(pair)[1] / range_,
        "version": __version__,
        "date_utc": now.isoformat(timespec="seconds"),
        "seconds": seconds,
    }


def _quantity(loaded: LoadedRecording, output: bool) -> Quantity:
    choice = loaded.choice
    values = loaded.pair.answer if output else loaded.pair.driven
    column = choice.output if output else choice.input[0]
    labels = loaded.labels
    unit = labels.output_unit if output else labels.input_unit
    return Quantity(
        column=column,
        unit="" if unit in UNKNOWN_UNITS else unit,
        negated=output and choice.negate_output,
        lowest=float(values.min()),
        highest=float(values.max()),
    )


def summarise(
    loaded: LoadedRecording, results: list[FittedModel], now: datetime, seconds: float
) -> Json:
    """The JSON object of ``identify``, or of ``compare`` with its models best first.

    now: in UTC. seconds: that all fits took together, with checks and intervals.
    """
    fit_seconds = identification_run.time_fits(results)
    models = [_figures(result, fit_seconds[result.model]) for result in results]
    found = models[0]
    if loaded.model is None:
        found = {"models": models, "left_out": dict(results[0].left_out)}
    return without_nan(found | _provenance(loaded, now, seconds))


def make_parameter_file(loaded: LoadedRecording, result: FittedModel, now: datetime) -> Identified:
    """The parameter file of one model."""
    driven, nominal = result.driven, None
    if driven.lines is not None:
        fitted = slice(result.fitted_samples)
        try:
            pair = loaded.pair.driven[fitted], loaded.pair.answer[fitted]
            nominal = modified_dahl.fit(*pair).model
        except InputError as refused:
            why = f"no modified Dahl model, by which the tip is bounded, was found ({refused})"
            result = result._replace(driven=Driven(why_not=why))
    compensator, driven = _compensator(result), result.driven
    return Identified(
        about=IdentificationFile(
            format_version=FORMAT_VERSION,
            software_version=__version__,
            date_utc=now.replace(microsecond=0),
            model=result.model,
            method=result.method,
            compensator=compensator or NO_COMPENSATOR,
            well_posed=result.well_posed,
            rmse=result.rmse,
            rmse_unit=result.output_unit,
            rmse_percent_of_range=result.rmse_percent_of_range,
            recording=Source(
                file=loaded.choice.file.name,
                sha256=loaded.table.sha256,
                samples=result.samples,
                fitted_samples=result.fitted_samples,
                input=_quantity(loaded, output=False),
                output=_quantity(loaded, output=True),
            ),
            undriven=driven.why_not,
        ),
        parameters={
            name: IdentifiedParameter(found.value, found.unit, _interval(found))
            for name, found in result.parameters.items()
        },
        servo=None,
        structure=_structure(loaded, result),
        driven=None if driven.lines is None else lines_section.write(driven.lines, result.model),
        nominal=nominal,
    )


def _structure(loaded: LoadedRecording, result: FittedModel) -> tuple[Structure, ...]:
    """What the names of the parameters stand for, for each input."""
    pair, count = loaded.pair, result.fitted_samples
    inputs = zip(loaded.choice.input, (pair.driven, *pair.others), strict=True)
    parts = [
        FittedPart(column, values[:count], *one)
        for one, (column, values) in zip(result.superposed, inputs, strict=False)
    ]
    return model_structure.describe(result.model, parts, result.parameters)


def _compensator(result: FittedModel) -> str | None:
    """The compensator that a model is meant for; None where it drives no head."""
    return None if result.driven.why_not else COMPENSATOR_OF_MODEL.get(result.model)
