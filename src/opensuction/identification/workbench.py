"""One way to identify any model of the catalogue from a recording, and to compare them all.

Units are the caller's: a recording may be millimetres, degrees or encoder counts. Arguments that
carry them say how they are called, so that every unit and every message speaks of the recording.

Models that can be identified from a recording, and the methods for each.
"""

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from opensuction.hysteresis.catalogue.catalogue import CATALOGUE
from opensuction.hysteresis.catalogue.hysteresis_model import (
    HysteresisModel,
    LinearForm,
    VectorForm,
    ranges_of,
    write_unit,
)
from opensuction.identification.bank import readout_fit
from opensuction.identification.bank.readout_fit import ReadoutFit
from opensuction.identification.checked_recording import (
    CheckedRecording,
    check,
    name_others,
)
from opensuction.identification.estimator import nonlinear, superposition
from opensuction.identification.estimator.nonlinear import NonlinearFit
from opensuction.identification.estimator.search import SEARCHES, search
from opensuction.identification.estimator.superposition import Superposition
from opensuction.identification.judgement import candidate, diagnosis
from opensuction.identification.judgement.candidate import (
    Candidate,
    Driven,
    Estimate,
    Superposed,
    judge_readout,
    judge_superposition,
    judge_vector,
)
from opensuction.identification.judgement.diagnosis import Labels
from opensuction.identification.judgement.fitted_range import (
    FittedRange,
    find_missing,
    measure_shares,
)
from opensuction.identification.judgement.recommendation import (
    Aim,
    Rated,
    check_purpose,
    recommend,
)
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
    "rising": "non-negative, and nothing else that could move the output the wrong way",
    "regularised": "least squares with a penalty, complexity by cross-validation",
}
"""Ways to identify them, and what they are."""

COUPLED = "play-readout"
"""The model that follows several inputs."""

RISING = "rising"
"""The method for a model that is to drive a head."""


def methods_of(model: HysteresisModel) -> tuple[str, ...]:
    """Names of the methods that can identify a model; the first is its default."""
    if model.name == COUPLED:
        return ("non-negative", RISING)
    match model.form:
        case VectorForm():
            return ("variable-projection", *SEARCHES)
        case LinearForm(nonnegative=nonnegative):
            return ("non-negative",) if nonnegative else ("regularised",)
        case None:
            return ()


def choose_for(model: HysteresisModel, purpose: str) -> str:
    """The method for a purpose: a model that is to drive a head must be able to."""
    methods = methods_of(model)
    return RISING if purpose == "compensate" and RISING in methods else methods[0]


def choose_method(model: str, method: str | None) -> str:
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
    fitted_range: FittedRange
    """Inputs and speeds of those samples."""
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
    superposed: tuple[Superposed, ...]
    """What simulates a superposition again, one for each input; none for a model whose parameters
    say all."""
    refit: Callable[[], object]
    """Does the fit alone once more, with its choice of complexity, without checks, intervals and
    warnings: for who has a clock."""
    driven: Driven = Driven()
    """How it drives a head, or why it does not."""
    determined: bool = True
    """Whether its parameters mean something: no other memory fits equally well, and most of the
    output is explained."""
    left_out: tuple[tuple[str, str], ...] = ()
    """Of the recommended model: those that this recording does not identify, each with why not."""
    at_bound: tuple[str, ...] = ()
    """Parameters, or elements of a grid, that a bound of the search holds: what lies beyond was not
    searched. A warning each says more."""


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
    chosen = choose_method(model, method)
    recording = check(input_, output, time_s, holdout_ratio, labels)
    if len(recording.inputs) > 1 and model != COUPLED:
        raise InputError(
            f"model '{model}' follows one input, not {len(recording.inputs)}: take model "
            f"'{COUPLED}', or one input"
        )
    found, _ = _fit(recording, MODELS[model], chosen)
    return _warn_of_others(recording, found, beside)


def _search(
    recording: CheckedRecording, model: HysteresisModel, method: str, purpose: str
) -> tuple[Callable[[], Any], Callable[[Any], Candidate]]:
    """The fit of a model to the first part of the recording, to be done, and who judges it."""
    count, folds, labels = recording.fitted_samples, recording.folds, recording.labels
    inputs, output = recording.inputs[:, :count], recording.output[:count]
    input_ = np.ascontiguousarray(inputs[0])
    form = model.form
    if model.name == COUPLED and len(inputs) > 1:
        others = name_others(labels, len(inputs) - 1)

        def judge_coupled(found: ReadoutFit) -> Candidate:
            drives = candidate.judge(model, found.records[0], inputs)
            return judge_readout(found, others)._replace(driven=drives)

        return lambda: readout_fit.fit(inputs, output, folds), judge_coupled
    if not isinstance(form, VectorForm):
        rising = method == RISING
        fading = purpose != "transfer"  # what a recording begins with is its own

        def judge_sum(found: Superposition) -> Candidate:
            drives = candidate.judge(model, found.record, inputs)
            return judge_superposition(found, ranges_of(input_, output))._replace(driven=drives)

        return (
            lambda: superposition.fit(
                model, input_, output, folds, rising, fading, recording.period_s
            ),
            judge_sum,
        )
    pair = input_, output

    def find() -> NonlinearFit:
        if method in SEARCHES:
            return NonlinearFit(search(method, form, *pair), determined=True)
        return nonlinear.FITS[model.name](*pair, labels[:2])

    def judge(found: NonlinearFit) -> Candidate:
        judged = judge_vector(model, form, found, pair, folds)
        return judged._replace(driven=Driven(why_not=model.undriven))

    return find, judge


def _fit(
    recording: CheckedRecording, model: HysteresisModel, method: str, purpose: str = "predict"
) -> tuple[FittedModel, Rated]:
    """The fitted model with its scores, intervals and warnings, and what it is judged by."""
    find, judge = _search(recording, model, method, purpose)
    found = judge(find())
    rated = Rated(model.name, found.scores, found.freedom, found.well_posed, found.driven.why_not)
    return _describe(recording, model.name, method, found)._replace(refit=find), rated


def _describe(
    recording: CheckedRecording, model: str, method: str, found: Candidate
) -> FittedModel:
    """A candidate as it is reported."""
    labels, count, output = recording.labels, recording.fitted_samples, recording.output
    fitted = found.simulate(recording.inputs)
    rest = output - fitted
    range_ = float(np.ptp(output))
    correlations = diagnosis.autocorrelation(rest[:count])
    said = diagnosis.judge_residuals(
        output[:count], rest[:count], rest[count:], correlations, recording.leaves_range
    )
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
        fitted_range=recording.fitted_range,
        fitted=fitted,
        autocorrelation=correlations,
        output_unit=labels.output_unit,
        recommended=False,
        transfer_percent_of_range=100.0 * found.scores.apart_rmse / range_,
        freedom=found.freedom,
        reasons=(),
        coupling_percent_of_range=_share(recording, found, range_),
        superposed=found.superposed,
        refit=lambda: None,
        driven=found.driven,
        determined=found.determined
        and diagnosis.measure_explained(output[:count], rest[:count]) >= diagnosis.EXPLAINED_SHARE,
        at_bound=found.at_bound,
    )


def _share(recording: CheckedRecording, found: Candidate, range_: float) -> dict[str, float]:
    """Share of each input, of a model of several."""
    if found.parts is None:
        return {}
    names = [recording.labels.input_name]
    names += name_others(recording.labels, len(recording.inputs) - 1)
    parts = found.parts(recording.inputs)
    return measure_shares(dict(zip(names, parts, strict=True)), range_)


def _warn_of_others(
    recording: CheckedRecording, found: FittedModel, beside: Mapping[str, ArrayLike]
) -> FittedModel:
    """The model with a warning where another column explains what it leaves."""
    count = recording.fitted_samples
    columns = {name: np.asarray(values, dtype=np.float64) for name, values in beside.items()}
    usable = {name: each[:count] for name, each in columns.items() if each.size >= count}
    rest = (recording.output - found.fitted)[:count]
    said = find_missing(rest, usable, recording.folds)
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
    out (`FittedModel.left_out`). Raises InputError where none can, and for a purpose that the
    recording cannot serve.
    """
    recording = check(input_, output, time_s, holdout_ratio, labels)
    check_purpose(aim.purpose, recording.folds)
    results, rated = {}, []
    refusals: dict[str, InputError] = {}
    for done, model in enumerate(MODELS.values()):
        if progress is not None:
            progress(model.name, done, len(MODELS))
        try:
            method = choose_for(model, aim.purpose)
            results[model.name], judged = _fit(recording, model, method, aim.purpose)
            rated.append(judged)
        except InputError as refused:
            refusals[model.name] = refused
    if not results:
        raise next(iter(refusals.values()))
    advice = recommend(rated, aim, recording.folds)
    chosen = results.pop(advice.model)._replace(
        recommended=True,
        reasons=advice.reasons,
        left_out=tuple((name, str(refused)) for name, refused in refusals.items()),
    )
    rest = sorted(results.values(), key=lambda each: advice.errors[each.model])
    return [_warn_of_others(recording, chosen, beside), *rest]


def _rms(values: Array) -> float:
    """Root mean square; not a number for no values."""
    return math.sqrt(float(values @ values) / values.size) if values.size else math.nan
