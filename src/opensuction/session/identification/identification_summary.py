"""Results of the workbench as plain data: the JSON objects and the parameter file.

Keys and units are a contract (docs/reference/results.md); ``null`` is what could not be computed.
"""

import math
from datetime import datetime

import numpy as np

from opensuction import __version__
from opensuction.identification.judgement.candidate import Estimate
from opensuction.identification.workbench import METHODS, MODELS, FittedModel
from opensuction.session.identification import identification_run
from opensuction.session.identification.identification_run import LoadedRecording
from opensuction.session.plain import Json, without_nan
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


def _interval(estimate: Estimate) -> list[float]:
    """Both ends of the 95 % interval; empty where there is none."""
    ends = [estimate.low, estimate.high]
    return ends if all(math.isfinite(end) for end in ends) else []


def _figures(result: FittedModel) -> Json:
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
        "transfer_percent_of_range": result.transfer_percent_of_range,
        "effective_parameters": result.freedom,
        "recommended": result.recommended,
        "reasons": list(result.reasons),
        "coupling_percent_of_range": result.coupling_percent_of_range or None,
        "warnings": list(result.warnings),
        "samples": result.samples,
        "fitted_samples": result.fitted_samples,
        "compensator": COMPENSATOR_OF_MODEL.get(result.model),
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
    given = choice.output_unit if output else choice.input_unit
    return Quantity(
        column=column,
        unit=identification_run.choose_unit(given, column),
        negated=output and choice.negate_output,
        lowest=float(values.min()),
        highest=float(values.max()),
    )


def summarise(
    loaded: LoadedRecording, results: list[FittedModel], now: datetime, seconds: float
) -> Json:
    """The JSON object of ``identify``, or of ``compare`` with its models best first.

    now: in UTC. seconds: that the fit took.
    """
    models = [_figures(result) for result in results]
    found = {"models": models} if loaded.model is None else models[0]
    return without_nan(found | _provenance(loaded, now, seconds))


def make_parameter_file(loaded: LoadedRecording, result: FittedModel, now: datetime) -> Identified:
    """The parameter file of one model."""
    return Identified(
        about=IdentificationFile(
            format_version=FORMAT_VERSION,
            software_version=__version__,
            date_utc=now.replace(microsecond=0),
            model=result.model,
            method=result.method,
            compensator=COMPENSATOR_OF_MODEL.get(result.model, NO_COMPENSATOR),
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
        ),
        parameters={
            name: IdentifiedParameter(found.value, found.unit, _interval(found))
            for name, found in result.parameters.items()
        },
        servo=None,
    )
