"""Results of the workbench: the records that reports and commands read, and the parameter file."""

import math
from collections.abc import Mapping, Sequence
from datetime import datetime
from types import MappingProxyType

import numpy as np

from opensuction import __version__
from opensuction.identification.estimator import modified_dahl
from opensuction.identification.judgement.candidate import Driven, Estimate
from opensuction.identification.judgement.diagnosis import UNKNOWN_UNITS
from opensuction.identification.workbench import METHODS, MODELS, FittedModel
from opensuction.kernel.errors import InputError
from opensuction.result.identification_result import (
    ComparisonResult,
    FittedParameter,
    IdentificationResult,
    IdentifiedRecording,
    InputRange,
    ModelResult,
    Provenance,
    RecordedColumn,
)
from opensuction.result.plain import measured
from opensuction.session.identification import identification_run
from opensuction.session.identification.identification_run import LoadedRecording
from opensuction.settings import calibration_section, model_structure
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

NO_FILES: Mapping[str, str] = MappingProxyType({})
"""Where no parameter file is written."""


def _interval(estimate: Estimate) -> tuple[float, float] | None:
    """Both ends of the 95 % interval; None where there is none."""
    ends = estimate.low, estimate.high
    return ends if all(math.isfinite(end) for end in ends) else None


def _model(result: FittedModel, fit_s: float, parameter_file: str | None) -> ModelResult:
    """One model's figures."""
    return ModelResult(
        model=result.model,
        model_words=MODELS[result.model].summary,
        method=result.method,
        method_words=METHODS[result.method],
        parameters={
            name: FittedParameter(found.value, found.unit, _interval(found))
            for name, found in result.parameters.items()
        },
        rmse=result.rmse,
        rmse_unit=result.output_unit,
        rmse_percent_of_range=result.rmse_percent_of_range,
        holdout_rmse_percent_of_range=result.holdout_rmse_percent_of_range,
        cross_validation_percent_of_range=result.cross_validation_percent_of_range,
        well_posed=result.well_posed,
        determined=result.determined,
        transfer_percent_of_range=result.transfer_percent_of_range,
        effective_parameters=result.freedom,
        recommended=result.recommended,
        reasons=result.reasons,
        coupling_percent_of_range=result.coupling_percent_of_range or None,
        warnings=result.warnings,
        at_bound=result.at_bound,
        samples=result.samples,
        fitted_samples=result.fitted_samples,
        fitted_range=InputRange(**result.fitted_range._asdict()),
        fit_seconds=fit_s,
        inverse=MODELS[result.model].inverse,
        compensator=_compensator(result),
        undriven=result.driven.why_not or None,
        parameter_file=parameter_file,
    )


def _models(
    results: Sequence[FittedModel], parameter_files: Mapping[str, str], timed: bool
) -> tuple[ModelResult, ...]:
    fit_s = identification_run.time_fits(results) if timed else {}
    return tuple(
        _model(result, fit_s.get(result.model, math.nan), parameter_files.get(result.model))
        for result in results
    )


def _provenance(loaded: LoadedRecording, now: datetime, seconds: float) -> Provenance:
    """Provenance of an identification: its recording, software and date."""
    choice, pair = loaded.choice, loaded.pair
    range_ = float(np.ptp(pair.answer))
    return Provenance(
        recording=IdentifiedRecording(
            file=choice.file.name,
            sha256=loaded.table.sha256,
            size_bytes=loaded.table.size_bytes,
            samples=int(pair.driven.size),
            skipped_rows=loaded.skipped_rows,
            from_s=None if pair.time_s is None else float(pair.time_s[0]),
            to_s=None if pair.time_s is None else float(pair.time_s[-1]),
            input=RecordedColumn(**_quantity(loaded, output=False)._asdict()),
            other_inputs=tuple(choice.input[1:]),
            output=RecordedColumn(**_quantity(loaded, output=True)._asdict()),
            time=choice.time,
        ),
        holdout_ratio=choice.holdout,
        line_rmse_percent_of_range=100.0 * identification_run.fit_line(pair)[1] / range_,
        version=__version__,
        date_utc=now.isoformat(timespec="seconds"),
        seconds=seconds,
    )


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


def summarise_fit(
    loaded: LoadedRecording,
    result: FittedModel,
    now: datetime,
    seconds: float,
    parameter_files: Mapping[str, str] = NO_FILES,
    timed: bool = True,
) -> IdentificationResult:
    """The result of ``identify``.

    now: in UTC. seconds: that all fits took together, with checks and intervals. parameter_files:
    paths of those that are written, by model. timed: ``fit_seconds`` is measured, for which each
    fit is done again.
    """
    (model,) = _models((result,), parameter_files, timed)
    return measured(IdentificationResult(model, _provenance(loaded, now, seconds)))


def summarise_comparison(
    loaded: LoadedRecording,
    results: Sequence[FittedModel],
    now: datetime,
    seconds: float,
    parameter_files: Mapping[str, str] = NO_FILES,
    timed: bool = True,
) -> ComparisonResult:
    """The result of ``compare``. results: best first; the other arguments as `summarise_fit`."""
    return measured(
        ComparisonResult(
            models=_models(results, parameter_files, timed),
            left_out=dict(results[0].left_out),
            provenance=_provenance(loaded, now, seconds),
        )
    )


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
            name: IdentifiedParameter(found.value, found.unit, list(_interval(found) or ()))
            for name, found in result.parameters.items()
        },
        servo=None,
        structure=_structure(loaded, result),
        driven=None
        if driven.lines is None
        else calibration_section.write(driven.lines, result.model),
        nominal=nominal,
    )


def _structure(loaded: LoadedRecording, result: FittedModel) -> tuple[Structure, ...]:
    """Structure of the model for each input: the meaning of its parameters."""
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
