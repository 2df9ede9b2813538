"""A fitted model of any kind, with its intervals: what the workbench scores and compares.

Suitability of a fitted model to drive a head: its form there, or the reason and a remedy.
"""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from opensuction.hysteresis.bank import play_lines
from opensuction.hysteresis.bank.play_lines import PlayLines
from opensuction.hysteresis.bank.play_readout import PlayReadout, is_rising
from opensuction.hysteresis.catalogue.hysteresis_model import (
    HysteresisModel,
    Ranges,
    Record,
    VectorForm,
    ranges_of,
)
from opensuction.hysteresis.catalogue.readout_model import PLAY_READOUT
from opensuction.identification.bank.readout_fit import ReadoutFit
from opensuction.identification.estimator import linear, superposition
from opensuction.identification.estimator.linear import jacobian
from opensuction.identification.estimator.nonlinear import NonlinearFit
from opensuction.identification.estimator.superposition import Superposition
from opensuction.identification.judgement import diagnosis, fitted_range
from opensuction.identification.judgement.confidence import estimate_spread
from opensuction.identification.record import REVERSAL_SHARE, Folds, Scores, find_turns
from opensuction.kernel.record import Array

LEAST_PLACES = 6
"""[design] Places at which a recording must turn for a model whose loops change with the place: a
Preisach model of two strokes over one range left 2.1 mm on the twin that it followed to .09."""
SAME_SHARE = 0.05
"""Gains of a play that differ by less along the range, as a share of all, are one gain."""


class Driven(NamedTuple):
    """A model as it drives a head."""

    lines: PlayLines | None = None
    """For `model-preview`; None where it cannot, or has a compensator of its own."""
    why_not: str = ""
    """Why no compensator takes it, and what would do; empty where one does."""


def judge(model: HysteresisModel, record: Record, inputs: Array) -> Driven:
    """Judge a fitted model as one that drives a head.

    record: of the first input. inputs: that were fitted, shape (inputs, n).
    """
    if model.lines is None:
        return Driven(why_not=model.undriven)
    if len(inputs) > 1:
        return Driven(why_not="it follows several inputs, and a head is one: give one --input")
    if np.size(getattr(record, "lags", ())) > 1:
        return Driven(why_not="it has more than one slow state")
    lines = model.lines(record)
    reason = play_lines.why_not_driven(lines)
    if reason is not None:
        return Driven(
            why_not=f"{reason}; identify another model, or a play readout with --method rising"
        )
    places = count_places(inputs[0])
    if changes_with_place(lines) and places < LEAST_PLACES:
        return Driven(
            why_not=f"its loops change with the place, and the recording turns at {places} places "
            f"only: record strokes that turn at {LEAST_PLACES} or more, or identify with --model "
            "prandtl-ishlinskii"
        )
    return Driven(lines)


def changes_with_place(lines: PlayLines) -> bool:
    """True where gains change along the range."""
    spread = float(np.ptp(lines.gains, axis=1).sum())
    return spread > SAME_SHARE * float(play_lines.total_slopes(lines).mean())


def count_places(input_: Array) -> int:
    """Number of places where an input turns, begins or ends; those near one another count once.

    input_: shape (n,).
    """
    least = REVERSAL_SHARE * float(np.ptp(input_))
    places = np.sort(input_[np.append(find_turns(input_, least), [0, input_.size - 1])])
    count, last = 0, -np.inf
    for place in places.tolist():
        if place - last > least:
            count, last = count + 1, place
    return count


NOT_DETERMINED = (
    "Not determined: the model fits equally well with a longer or shorter memory (range too small, "
    "no hysteresis to be seen, or one of another kind). The curve can be used, the parameters mean "
    "little."
)
NOT_INVERTIBLE = (
    "Not invertible: right after a reversal the model's output moves the wrong way, so that its "
    "inverse jumps. Cross the gap explicitly, as exact-inverse does, or use a model whose output "
    "never does so (prandtl-ishlinskii, preisach)."
)
LAGGING = (
    "Not invertible: its slow state lags by more than the play without width makes good, so that "
    "right after a reversal the output may move the wrong way. Use it to predict."
)

PREDICTS = (
    "Predicts only: its output may move the wrong way after a reversal, so that no inverse is "
    "offered. To drive a machine take --purpose compensate."
)
GAP = (
    "Has a gap: right after a reversal the model's output stands still, so that its inverse jumps. "
    "Cross the gap explicitly."
)


class Estimate(NamedTuple):
    """A parameter and the interval that holds the true value with 95 % confidence."""

    value: float
    unit: str
    low: float
    """Not a number where no interval can be given."""
    high: float


class Superposed(NamedTuple):
    """A fitted superposition over one input: what simulates it again."""

    record: Record
    memory_ratio: float
    """The past before the first sample that predicts best."""
    memory: Array | None = None
    """Memory at the first sample, where the fit found more of it than a ratio."""


class Candidate(NamedTuple):
    """A fitted model; in its units {in} and {out} stand for those of the recording."""

    parameters: dict[str, Estimate]
    simulate: Callable[[Array], Array]
    """Output for a record that begins as the fitted one did: of the inputs, shape (inputs, n)."""
    scores: Scores
    """Errors of what was left out, in units of the output."""
    freedom: float
    """Effective number of parameters."""
    well_posed: bool
    warnings: tuple[str, ...]
    parts: Callable[[Array], list[Array]] | None = None
    """What each of several inputs adds to it; None for a model of one."""
    superposed: tuple[Superposed, ...] = ()
    """One for each input; none for a model whose parameters say all."""
    driven: Driven = Driven()
    determined: bool = True
    """False where another memory fits equally well: parameters mean little."""
    at_bound: tuple[str, ...] = ()
    """Parameters or elements that a bound of the search holds; a warning says at which."""


def judge_superposition(found: Superposition, ranges: Ranges) -> Candidate:
    """A candidate without intervals: weights that were pulled to 0 or held there have none.

    ranges: of the fitted samples.
    """
    well_posed = bool(found.model.is_monotone(found.record))
    refused = () if well_posed else (_refuse(found.model, found.record, found.nonnegative),)
    bounds = fitted_range.find_grid_ends(found.record, ranges)
    return Candidate(
        parameters={
            name: Estimate(value, unit, math.nan, math.nan)
            for name, (value, unit) in found.factors.items()
        },
        simulate=lambda inputs: found.simulate(inputs[0]),
        scores=found.scores,
        freedom=found.freedom,
        well_posed=well_posed,
        warnings=(*refused, *bounds.values()),
        superposed=(Superposed(found.record, found.memory_ratio, found.elements),),
        at_bound=tuple(bounds),
    )


def _refuse(model: HysteresisModel, record: Record, nonnegative: bool) -> str:
    """Reason why a superposition has no continuous inverse."""
    if not model.has_inverse:
        return PREDICTS
    if not nonnegative:
        return NOT_INVERTIBLE
    lags = isinstance(record, PlayReadout) and not is_rising(record)
    return LAGGING if lags else GAP


def judge_readout(found: ReadoutFit, names: Sequence[str]) -> Candidate:
    """A candidate of several inputs; its inverse is that of the first, the others held.

    names: of the inputs after the first; a parameter of theirs begins with it.
    """

    def parts(inputs: Array) -> list[Array]:
        """Contribution of each input."""
        return [
            PLAY_READOUT.simulate(
                record, input_, PLAY_READOUT.memory(record, float(input_[0]), past)
            )
            for record, input_, past in zip(found.records, inputs, found.pasts, strict=True)
        ]

    parameters = {}
    for prefix, record in zip(("", *(f"{name}: " for name in names)), found.records, strict=True):
        for name, (value, unit) in superposition.list_readout(record).items():
            parameters[prefix + name] = Estimate(value, unit, math.nan, math.nan)
    first = found.records[0]
    well_posed = bool(PLAY_READOUT.is_monotone(first))
    refused = () if well_posed else (_refuse(PLAY_READOUT, first, found.bounded),)
    bounds = fitted_range.find_grid_ends(first, Ranges(first.low_mm, first.high_mm, 0.0, 1.0, 0.0))
    return Candidate(
        parameters=parameters,
        simulate=lambda inputs: np.sum(parts(inputs), axis=0),
        scores=found.scores,
        freedom=found.freedom,
        well_posed=well_posed,
        warnings=(*refused, *bounds.values()),
        parts=parts,
        superposed=tuple(map(Superposed, found.records, found.pasts)),
        at_bound=tuple(bounds),
    )


def judge_vector(
    model: HysteresisModel,
    form: VectorForm,
    found: NonlinearFit,
    pair: tuple[Array, Array],
    folds: Folds,
) -> Candidate:
    """A candidate of a model that is not linear, with intervals by `confidence.estimate_spread`.

    form: the model's. pair: input and output of the fitted samples, each of shape (n,). folds: of
    them.
    """
    input_, output = pair
    vector = found.vector
    rest = output - form.simulate(vector, input_)
    ranges = ranges_of(input_, output)
    rows = jacobian(form, vector, input_, ranges)
    moving = np.flatnonzero(np.any(rows != 0.0, axis=1))
    half_widths = np.full(vector.size, math.nan)
    half_widths[moving] = estimate_spread(rows[moving], rest).half_widths
    parameters = {
        parameter.name: Estimate(value, parameter.unit, value - half, value + half)
        for parameter, value, half in zip(
            form.parameters, vector.tolist(), half_widths.tolist(), strict=True
        )
    }
    well_posed = bool(model.is_monotone(form.record(vector)))
    bounds = fitted_range.find_limits(form, found, ranges)
    return Candidate(
        parameters=parameters,
        simulate=lambda inputs: form.simulate(vector, inputs[0]),
        # Without the memory at the first sample, which the first block alone knows.
        scores=linear.estimate_left_out(rows[:-1], rest, folds),
        freedom=float(vector.size),
        well_posed=well_posed,
        determined=found.determined,
        warnings=(*_warnings(parameters, rows, found.determined, well_posed), *bounds.values()),
        at_bound=tuple(bounds),
    )


def _warnings(
    parameters: dict[str, Estimate], rows: Array, determined: bool, well_posed: bool
) -> tuple[str, ...]:
    """Warnings on the parameters of a fit. rows: the Jacobian."""
    said = [] if determined else [NOT_DETERMINED]
    worst = diagnosis.condition(rows)
    if worst > diagnosis.WORST_CONDITION:
        said.append(
            f"Ill-conditioned: parameters trade against one another (condition {worst:.1e}); "
            "record larger and more varied strokes."
        )
    *_, initial_memory = parameters
    vague = [
        name
        for name, found in parameters.items()
        if found.low < 0.0 < found.high and name not in ("offset", initial_memory)
    ]
    if vague:
        said.append(f"Uncertain: the interval of {', '.join(vague)} includes 0.")
    if not well_posed:
        said.append(NOT_INVERTIBLE)
    return tuple(said)
