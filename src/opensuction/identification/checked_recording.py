"""A recording as the workbench takes it: checked, cut into folds, its inputs named."""

import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from opensuction.identification import record
from opensuction.identification.judgement import diagnosis, fitted_range
from opensuction.identification.judgement.diagnosis import Labels
from opensuction.identification.judgement.fitted_range import FittedRange
from opensuction.identification.record import Folds, read_pair, read_samples
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array

LEAST_SAMPLES = 40
"""Fewest samples to fit: two for each block of a cross-validation."""

MOST_HOLDOUT_RATIO = 0.9
"""Largest share that can be held out; the rest must still show the hysteresis."""


class CheckedRecording(NamedTuple):
    """A checked recording."""

    inputs: Array
    """Shape (inputs, n)."""
    output: Array
    fitted_samples: int
    labels: Labels
    warnings: tuple[str, ...]
    folds: Folds
    """Of the fitted samples."""
    period_s: float | None
    """Between samples, where all are as far apart but for a jitter; 1 where no time is known."""
    fitted_range: FittedRange
    leaves_range: bool
    """Whether what is held out goes beyond it; a warning says how."""


def check(
    input_: ArrayLike,
    output: ArrayLike,
    time_s: ArrayLike | None,
    holdout_ratio: float,
    labels: Labels,
) -> CheckedRecording:
    """The recording, fit to be fitted.

    Arguments as `workbench.identify`. Raises InputError for unequal lengths, too few or missing
    samples, times that do not rise, and an input or output that cannot show a hysteresis.
    """
    first, *others = _split_inputs(input_)
    driven, answer = read_pair(labels[:2], first, output, LEAST_SAMPLES)
    inputs, names = [driven], name_others(labels, len(others))
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
    begin_in = driven[:fitted_samples]
    warnings = _judge_fitted(driven, answer, time, fitted_samples, labels)
    begin_time = None if time is None else time[:fitted_samples]
    folds = record.cut(begin_in, begin_time)
    fitted = fitted_range.measure(begin_in, begin_time)
    rest_time = None if time is None else time[fitted_samples:]
    beyond = fitted_range.judge_beyond(fitted, driven[fitted_samples:], rest_time, labels)
    for name, values in zip(names, inputs[1:], strict=True):
        if not np.ptp(values[:fitted_samples]) > 0.0:
            raise InputError(f"{name}: constant at {values[0]:g}, should move; leave it out")
    period_s = 1.0 if time is None else diagnosis.find_period(time)
    return CheckedRecording(
        inputs=np.array(inputs),
        output=answer,
        fitted_samples=fitted_samples,
        labels=labels,
        warnings=(*warnings, *beyond),
        folds=folds,
        period_s=period_s,
        fitted_range=fitted,
        leaves_range=bool(beyond),
    )


def _judge_fitted(
    input_: Array, output: Array, time_s: Array | None, fitted: int, labels: Labels
) -> tuple[str, ...]:
    """Weaknesses of the samples that are fitted; says so where the whole recording has none.

    Raises InputError where they cannot be fitted.
    """
    begin = input_[:fitted], output[:fitted]
    begin_time = None if time_s is None else time_s[:fitted]
    if fitted == input_.size:
        diagnosis.check_recording(*begin, labels)
        return diagnosis.judge_recording(*begin, begin_time, labels)
    part = f"the fitted part, the first {fitted} of {input_.size} samples"
    try:
        diagnosis.check_recording(*begin, labels)
    except InputError as refused:
        diagnosis.check_recording(input_, output, labels)
        raise InputError(f"{refused}. That is of {part}: lower --holdout") from None
    kinds = {_kind(said) for said in diagnosis.judge_recording(input_, output, time_s, labels)}
    return tuple(
        said if _kind(said) in kinds else f"{said} That is of {part}, not of the whole."
        for said in diagnosis.judge_recording(*begin, begin_time, labels)
    )


def _kind(warning: str) -> str:
    """The words that a warning begins with."""
    return re.split("[:?]", warning, maxsplit=1)[0]


def _split_inputs(input_: ArrayLike) -> Sequence[ArrayLike]:
    """Each input; one that is no row of rows is the only one."""
    if isinstance(input_, np.ndarray):
        return list(input_) if input_.ndim == 2 and len(input_) else [input_]
    rows = [*input_] if isinstance(input_, list | tuple) else []
    return rows if rows and all(np.ndim(row) == 1 for row in rows) else [input_]


def name_others(labels: Labels, count: int) -> list[str]:
    """Names of the inputs after the first, unlike one another."""
    given = labels.other_names[:count]
    return [*given, *(f"input {place + 2}" for place in range(len(given), count))]


def check_holdout(ratio: float, name: str = "holdout") -> None:
    """Refuse an impossible share to hold out; raises InputError. name: as the message calls it."""
    if not 0.0 <= ratio <= MOST_HOLDOUT_RATIO:
        raise InputError(
            f"{name} {ratio:g}: should be from 0 to {MOST_HOLDOUT_RATIO:g}, the share of "
            "the recording that is predicted instead of fitted"
        )
