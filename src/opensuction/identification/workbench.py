"""One way to identify any model of the catalogue from a recording, and to compare them all.

Units are the caller's: a recording may be millimetres, degrees or encoder counts. Arguments that
carry them say how they are called, so that every unit and every message speaks of the recording.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from opensuction.hysteresis.catalogue.catalogue import CATALOGUE
from opensuction.hysteresis.catalogue.hysteresis_model import (
    HysteresisModel,
    LinearForm,
    VectorForm,
    write_unit,
)
from opensuction.identification import fold
from opensuction.identification.bank import readout_fit
from opensuction.identification.estimator import nonlinear, superposition
from opensuction.identification.estimator.nonlinear import NonlinearFit
from opensuction.identification.estimator.search import SEARCHES, search
from opensuction.identification.fold import Folds
from opensuction.identification.judgement import coupling, diagnosis
from opensuction.identification.judgement.candidate import (
    Candidate,
    Estimate,
    judge_readout,
    judge_superposition,
    judge_vector,
)
from opensuction.identification.judgement.diagnosis import Labels
from opensuction.identification.judgement.recommendation import Aim, Rated, check_purpose, recommend
from opensuction.identification.record import read_pair, read_samples
from opensuction.identification.single_thread import single_threaded
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array

MODELS = {name: model for name, model in CATALOGUE.items() if model.form is not None}
"""Models that can be identified from any recording."""

METHODS = {
    "variable-projection": "linear parameters solved exactly, a global search over the others",
    "genetic-algorithm": "the paper's way: a genetic algorithm, then Nelder-Mead",
    "differential-evolution": "differential evolution, then Nelder-Mead",
    "non-negative": "least squares with weights at least 0, complexity by cross-validation",
    "regularised": "least squares with a penalty, complexity by cross-validation",
}
"""Ways to identify them, and what they are."""

COUPLED = "play-readout"
"""The model that follows several inputs."""

LEAST_SAMPLES = 40
"""Fewest samples to fit: two for each block of a cross-validation."""

MOST_HOLDOUT_RATIO = 0.9
"""Largest share that can be held out; the rest must still show the hysteresis."""

Progress = Callable[[str, int, int], None]
"""Called before each model: its name, how many are done, how many there are."""


class FittedModel(NamedTuple):
    """A fitted model, its errors and warnings."""

    model: str
    method: str
    parameters: dict[str, Estimate]
    rmse: float
    """Root mean square residual of the fitted samples, in the output's unit."""
    rmse_percent_of_range: float
    """The same in percent of the range of the whole output."""
    holdout_rmse_percent_of_range: float
    """Of the samples held out, which no parameter has seen; not a number without them."""
    cross_validation_percent_of_range: float
    """Root mean square error on blocks of the fitted samples, each predicted from the others."""
    well_posed: bool
    """Whether the model has a continuous inverse, so that it can drive a compensator."""
    warnings: tuple[str, ...]
    samples: int
    """How many samples the recording has, those held out included."""
    fitted_samples: int
    """How many of them, from the first, the parameters were fitted to."""
    fitted: Array
    """The model's output for the whole recording, shape (samples,)."""
    autocorrelation: Array
    """Of the residuals of the fitted samples, at lags of 0, 1, 2, ... samples."""
    output_unit: str
    recommended: bool
    """Whether cross-validation prefers this model to the others compared with it."""
    transfer_percent_of_range: float
    """Root mean square error of two parts of the fitted samples, slow and fast strokes or both
    halves, each predicted from the other alone."""
    freedom: float
    """Effective number of parameters: a penalty leaves less than there are."""
    reasons: tuple[str, ...]
    """Why it is recommended, a sentence each; empty where it is not."""
    coupling_percent_of_range: dict[str, float]
    """What each of several inputs adds, root mean square about its mean in percent of the output's
    range; empty for a model of one."""


@single_threaded
def identify(
    input_: ArrayLike,
    output: ArrayLike,
    time_s: ArrayLike | None = None,
    model: str = "modified-dahl",
    method: str | None = None,
    holdout_ratio: float = 0.0,
    labels: Labels = Labels(),  # noqa: B008 - immutable
    beside: Mapping[str, ArrayLike] = MappingProxyType({}),
) -> FittedModel:
    """Identify one model from a recording.

    input_, output: the driven and the following position at the same instants, shape (n,), in any
    units; of several inputs, shape (inputs, n), the one that drives first. time_s: when they were
    taken; None: evenly. model, method: names of ``MODELS`` and ``METHODS``; None: the model's
    default. holdout_ratio: share of the recording, from its end, that is not fitted but predicted,
    from 0 to 0.9. beside: other columns of the recording, which may explain what the model leaves.

    Raises InputError, in one line, for what cannot be identified.
    """
    chosen = _choose_method(model, method)
    recording = _check(input_, output, time_s, holdout_ratio, labels)
    if len(recording.inputs) > 1 and model != COUPLED:
        raise InputError(
            f"model '{model}' follows one input, not {len(recording.inputs)}: take model "
            f"'{COUPLED}', or one input"
        )
    return _warn_of_others(recording, _fit(recording, MODELS[model], chosen)[0], beside)


class _Recording(NamedTuple):
    """A checked recording."""

    inputs: Array
    """Shape (inputs, n)."""
    output: Array
    fitted_samples: int
    labels: Labels
    warnings: tuple[str, ...]
    folds: Folds
    """Of the fitted samples."""


def _check(
    input_: ArrayLike,
    output: ArrayLike,
    time_s: ArrayLike | None,
    holdout_ratio: float,
    labels: Labels,
) -> _Recording:
    """The recording, fit to be fitted. Raises InputError."""
    first, *others = _split_inputs(input_)
    driven, answer = read_pair(labels[:2], first, output, LEAST_SAMPLES)
    inputs, names = [driven], _name_others(labels, len(others))
    for name, values in zip(names, others, strict=True):
        inputs.append(read_pair((name, labels.output_name), values, output, LEAST_SAMPLES)[0])
    check_holdout(holdout_ratio)
    fitted_samples = driven.size - int(driven.size * holdout_ratio)
    if fitted_samples < LEAST_SAMPLES:
        raise InputError(
            f"holdout {holdout_ratio:g}: leaves {fitted_samples} of {driven.size} samples to fit, "
            f"at least {LEAST_SAMPLES} are needed"
        )
    time = None
    if time_s is not None:
        time = read_samples(labels.time_name, time_s, driven.size)
        if time.size != driven.size:
            raise InputError(f"{labels.time_name} has {time.size} samples, not {driven.size}")
        diagnosis.check_time(time, labels.time_name)
    begin_in, begin_out = driven[:fitted_samples], answer[:fitted_samples]
    diagnosis.check_recording(begin_in, begin_out, labels)
    warnings = diagnosis.judge_recording(
        begin_in, begin_out, None if time is None else time[:fitted_samples], labels
    )
    folds = fold.cut(begin_in, None if time is None else time[:fitted_samples])
    for name, values in zip(names, inputs[1:], strict=True):
        if not np.ptp(values[:fitted_samples]) > 0.0:
            raise InputError(f"{name}: constant at {values[0]:g}, should move; leave it out")
    return _Recording(np.array(inputs), answer, fitted_samples, labels, warnings, folds)


def _split_inputs(input_: ArrayLike) -> Sequence[ArrayLike]:
    """Each input; one that is no row of rows is the only one."""
    if isinstance(input_, np.ndarray):
        return list(input_) if input_.ndim == 2 and len(input_) else [input_]
    rows = [*input_] if isinstance(input_, list | tuple) else []
    return rows if rows and all(np.ndim(row) == 1 for row in rows) else [input_]


def _name_others(labels: Labels, count: int) -> list[str]:
    """Names of the inputs after the first, unlike one another."""
    given = labels.other_names[:count]
    return [*given, *(f"input {place + 2}" for place in range(len(given), count))]


def methods_of(model: HysteresisModel) -> tuple[str, ...]:
    """Names of the methods that can identify a model; the first is its default."""
    match model.form:
        case VectorForm():
            return ("variable-projection", *SEARCHES)
        case LinearForm(nonnegative=nonnegative):
            return ("non-negative",) if nonnegative else ("regularised",)
        case None:
            return ()


def _candidate(recording: _Recording, model: HysteresisModel, method: str) -> Candidate:
    """The model fitted to the first part of the recording."""
    count = recording.fitted_samples
    inputs, output = recording.inputs[:, :count], recording.output[:count]
    input_ = np.ascontiguousarray(inputs[0])
    if model.name == COUPLED and len(inputs) > 1:
        names = _name_others(recording.labels, len(inputs) - 1)
        return judge_readout(readout_fit.fit(inputs, output, recording.folds), names)
    if not isinstance(model.form, VectorForm):
        return judge_superposition(superposition.fit(model, input_, output, recording.folds))
    if method in SEARCHES:
        found = NonlinearFit(search(method, model.form, input_, output), determined=True)
    else:
        found = nonlinear.FITS[model.name](input_, output, recording.labels[:2])
    return judge_vector(model, model.form, found, (input_, output), recording.folds)


def _fit(recording: _Recording, model: HysteresisModel, method: str) -> tuple[FittedModel, Rated]:
    """The fitted model with its scores, intervals and warnings, and what it is judged by."""
    found = _candidate(recording, model, method)
    rated = Rated(model.name, found.scores, found.freedom, found.well_posed)
    return _describe(recording, model.name, method, found), rated


def _describe(recording: _Recording, model: str, method: str, found: Candidate) -> FittedModel:
    """A candidate as it is reported."""
    labels, count, output = recording.labels, recording.fitted_samples, recording.output
    fitted = found.simulate(recording.inputs)
    rest = output - fitted
    range_ = float(np.ptp(output))
    correlations = diagnosis.autocorrelation(rest[:count])
    said = diagnosis.judge_residuals(output[:count], rest[:count], rest[count:], correlations)
    rmse = _rms(rest[:count])
    return FittedModel(
        model=model,
        method=method,
        parameters={
            name: estimate._replace(
                unit=write_unit(estimate.unit, labels.input_unit, labels.output_unit)
            )
            for name, estimate in found.parameters.items()
        },
        rmse=rmse,
        rmse_percent_of_range=100.0 * rmse / range_,
        holdout_rmse_percent_of_range=100.0 * _rms(rest[count:]) / range_,
        cross_validation_percent_of_range=100.0 * found.scores.rmse / range_,
        well_posed=found.well_posed,
        warnings=(*recording.warnings, *found.warnings, *said),
        samples=output.size,
        fitted_samples=count,
        fitted=fitted,
        autocorrelation=correlations,
        output_unit=labels.output_unit,
        recommended=False,
        transfer_percent_of_range=100.0 * found.scores.apart_rmse / range_,
        freedom=found.freedom,
        reasons=(),
        coupling_percent_of_range=_share(recording, found, range_),
    )


def _share(recording: _Recording, found: Candidate, range_: float) -> dict[str, float]:
    """What each input adds, of a model of several."""
    if found.parts is None:
        return {}
    names = [recording.labels.input_name]
    names += _name_others(recording.labels, len(recording.inputs) - 1)
    parts = found.parts(recording.inputs)
    return coupling.measure_shares(dict(zip(names, parts, strict=True)), range_)


def _warn_of_others(
    recording: _Recording, found: FittedModel, beside: Mapping[str, ArrayLike]
) -> FittedModel:
    """The model with a warning where another column explains what it leaves."""
    count = recording.fitted_samples
    columns = {name: np.asarray(values, dtype=np.float64) for name, values in beside.items()}
    usable = {name: each[:count] for name, each in columns.items() if each.size >= count}
    rest = (recording.output - found.fitted)[:count]
    said = coupling.find_missing(rest, usable, recording.folds)
    return found._replace(warnings=(*found.warnings, *said))


@single_threaded
def compare(
    input_: ArrayLike,
    output: ArrayLike,
    time_s: ArrayLike | None = None,
    holdout_ratio: float = 0.0,
    labels: Labels = Labels(),  # noqa: B008 - immutable
    progress: Progress | None = None,
    beside: Mapping[str, ArrayLike] = MappingProxyType({}),
    aim: Aim = Aim(),  # noqa: B008 - immutable
) -> list[FittedModel]:
    """Identify every model from the same recording; the recommended one is the first.

    Arguments as `identify`; of several inputs, models of one take the first. progress is called
    before each model. aim: what the recommended model is for. The others follow by their error for
    it, on the fitted samples alone. A model that cannot be identified from this recording is left
    out. Raises InputError where none can, and for a purpose that the recording cannot serve.
    """
    recording = _check(input_, output, time_s, holdout_ratio, labels)
    check_purpose(aim.purpose, recording.folds)
    results, rated, refusals = {}, [], []
    for done, model in enumerate(MODELS.values()):
        if progress is not None:
            progress(model.name, done, len(MODELS))
        try:
            results[model.name], judged = _fit(recording, model, methods_of(model)[0])
            rated.append(judged)
        except InputError as refused:
            refusals.append(refused)
    if not results:
        raise refusals[0]
    advice = recommend(rated, aim, recording.folds)
    chosen = results.pop(advice.model)._replace(recommended=True, reasons=advice.reasons)
    rest = sorted(results.values(), key=lambda each: advice.errors[each.model])
    return [_warn_of_others(recording, chosen, beside), *rest]


def _choose_method(model: str, method: str | None) -> str:
    """The method to use; InputError for an unknown name or a pair that does not go together."""
    if model not in MODELS:
        raise InputError(f"model '{model}' is not known: one of {', '.join(MODELS)}")
    methods = methods_of(MODELS[model])
    if method is None:
        return methods[0]
    if method not in METHODS:
        raise InputError(f"method '{method}' is not known: one of {', '.join(METHODS)}")
    if method not in methods:
        raise InputError(
            f"method '{method}' cannot identify model '{model}': one of {', '.join(methods)}"
        )
    return method


def check_holdout(ratio: float, name: str = "holdout") -> None:
    """Refuse an impossible share to hold out; raises InputError. name: as the message calls it."""
    if not 0.0 <= ratio <= MOST_HOLDOUT_RATIO:
        raise InputError(
            f"{name} {ratio:g}: should be from 0 to {MOST_HOLDOUT_RATIO:g}, the share of "
            "the recording that is predicted instead of fitted"
        )


def _rms(values: Array) -> float:
    """Root mean square; not a number for no values."""
    return math.sqrt(float(values @ values) / values.size) if values.size else math.nan
