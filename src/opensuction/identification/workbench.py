"""One way to identify any model of the catalogue from a recording, and to compare them all.

Units are the caller's: a recording may be millimetres, degrees or encoder counts. Arguments that
carry them say how they are called, so that every unit and every message speaks of the recording.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from opensuction.hysteresis import modified_dahl
from opensuction.identification import modified_dahl as modified_dahl_estimator
from opensuction.identification.record import checked, checked_pair
from opensuction.kernel.errors import InputError

Array = NDArray[np.float64]

MODELS = {
    "modified-dahl": "straight line plus a Dahl state (the paper's model, eqs. 3 and 4)",
}
"""Models that can be identified, and what they are."""

METHODS = {
    "variable-projection": "linear parameters solved exactly, a global search over the others",
}
"""Ways to identify them, and what they are."""

METHODS_OF_MODEL = {"modified-dahl": ("variable-projection",)}
"""Which methods a model can be identified by; the first is its default."""

LEAST_SAMPLES = modified_dahl_estimator.LEAST_SAMPLES

MOST_HOLDOUT_RATIO = 0.9
"""Largest share that can be held out; the rest must still show the hysteresis."""

Progress = Callable[[str, int, int], None]
"""Told before each model: its name, how many are done, how many there are."""


class Labels(NamedTuple):
    """How the caller's quantities and their units are called."""

    input_name: str = "input"
    output_name: str = "output"
    input_unit: str = "mm"
    output_unit: str = "mm"


class Estimate(NamedTuple):
    """A parameter and the interval that holds the true value with 95 % confidence."""

    value: float
    unit: str
    low: float
    """Not a number where no interval can be given."""
    high: float


class Result(NamedTuple):
    """A fitted model and how far it can be trusted."""

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
    """Mean error on blocks of the fitted samples left out in turn; not a number where the model
    was identified alone."""
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


def identify(
    input_: ArrayLike,
    output: ArrayLike,
    time_s: ArrayLike | None = None,
    model: str = "modified-dahl",
    method: str | None = None,
    holdout_ratio: float = 0.0,
    labels: Labels = Labels(),  # noqa: B008 - immutable
) -> Result:
    """Identify one model from a recording.

    input_, output: the driven and the following position at the same instants, shape (n,), in any
    units. time_s: when they were taken; None: evenly. model, method: names of ``MODELS`` and
    ``METHODS``; None: the model's default. holdout_ratio: share of the recording, from its end,
    that is not fitted but predicted, from 0 to 0.9.

    Raises InputError, in one line, for what cannot be identified.
    """
    chosen = _checked_method(model, method)
    driven, answer = checked_pair(
        (labels.input_name, labels.output_name), input_, output, LEAST_SAMPLES
    )
    if time_s is not None:
        checked("time", time_s, driven.size)
    fitted_samples = _fitted_samples(driven.size, holdout_ratio)
    found = modified_dahl_estimator.fit(driven[:fitted_samples], answer[:fitted_samples])
    fitted = modified_dahl.simulate(found.model, driven, found.lag_mm)
    rest = answer - fitted
    range_ = float(np.ptp(answer))
    nan = math.nan
    gain_unit = f"{labels.output_unit}/{labels.input_unit}"
    return Result(
        model=model,
        method=chosen,
        parameters={
            "slope": Estimate(found.model.slope, gain_unit, nan, nan),
            "velocity_gain": Estimate(found.model.velocity_gain, gain_unit, nan, nan),
            "decay": Estimate(found.model.decay_per_mm, f"1/{labels.input_unit}", nan, nan),
            "offset": Estimate(found.model.offset_mm, labels.output_unit, nan, nan),
            "initial_lag": Estimate(found.lag_mm, labels.output_unit, nan, nan),
        },
        rmse=found.rmse_mm,
        rmse_percent_of_range=100.0 * found.rmse_mm / range_,
        holdout_rmse_percent_of_range=_rms(rest[fitted_samples:]) * 100.0 / range_,
        cross_validation_percent_of_range=nan,
        well_posed=found.well_posed,
        warnings=(),
        samples=driven.size,
        fitted_samples=fitted_samples,
        fitted=fitted,
        autocorrelation=np.ones(1),
        output_unit=labels.output_unit,
        recommended=False,
    )


def compare(
    input_: ArrayLike,
    output: ArrayLike,
    time_s: ArrayLike | None = None,
    holdout_ratio: float = 0.0,
    labels: Labels = Labels(),  # noqa: B008 - immutable
    progress: Progress | None = None,
) -> list[Result]:
    """Identify every model from the same recording, best first; one is recommended.

    Arguments as `identify`. A model that cannot be identified is left out; InputError is raised
    where none can.
    """
    results = []
    for done, model in enumerate(MODELS):
        if progress is not None:
            progress(model, done, len(MODELS))
        results.append(identify(input_, output, time_s, model, None, holdout_ratio, labels))
    return [results[0]._replace(recommended=True), *results[1:]]


def _checked_method(model: str, method: str | None) -> str:
    """The method to use; InputError for an unknown name or a pair that does not go together."""
    if model not in MODELS:
        raise InputError(f"model '{model}' is not known: one of {', '.join(MODELS)}")
    methods = METHODS_OF_MODEL[model]
    if method is None:
        return methods[0]
    if method not in METHODS:
        raise InputError(f"method '{method}' is not known: one of {', '.join(METHODS)}")
    if method not in methods:
        raise InputError(
            f"method '{method}' cannot identify model '{model}': one of {', '.join(methods)}"
        )
    return method


def _fitted_samples(samples: int, holdout_ratio: float) -> int:
    """How many samples from the first are fitted; InputError for an impossible share."""
    if not 0.0 <= holdout_ratio <= MOST_HOLDOUT_RATIO:
        raise InputError(
            f"holdout {holdout_ratio:g}: should be from 0 to {MOST_HOLDOUT_RATIO:g}, the share of "
            "the recording that is predicted instead of fitted"
        )
    return samples - int(samples * holdout_ratio)


def _rms(values: Array) -> float:
    """Root mean square; not a number for no values."""
    return math.sqrt(float(values @ values) / values.size) if values.size else math.nan
