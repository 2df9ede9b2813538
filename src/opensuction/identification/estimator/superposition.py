"""Models that are superpositions of known elements: plays, relays, Dahl states, an envelope.

The catalogue's `LinearForm` of a model offers elements from coarse to fine; `linear.fit` chooses,
and, where the elements are hundreds of cells over a bank of plays, `identification.bank`.
The past of a recording is unknown: a long advance, a long retract and rest are tried.

A Maxwell-slip model from a recording: linear least squares, its complexity by cross-validation.

Tried are every past, no drag and drag behind either lag, each with every penalty; the simplest that
is not surely worse than the best is taken, as everywhere. Where the element of the longest reach
holds most of the loop, the same is done with longer ones.
"""

from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from opensuction.hysteresis.bank import maxwell_slip
from opensuction.hysteresis.bank.maxwell_slip import MaxwellSlip
from opensuction.hysteresis.bank.play_readout import PlayReadout
from opensuction.hysteresis.catalogue.hysteresis_model import (
    HysteresisModel,
    LinearForm,
    Ranges,
    Record,
    name_element,
    ranges_of,
)
from opensuction.hysteresis.catalogue.play_family import LAGS, REACHES, RIDGES, WIDE_REACHES, guess
from opensuction.hysteresis.catalogue.readout_model import PLAY_READOUT
from opensuction.identification import record as records
from opensuction.identification.bank import bank_problem, preisach_fit, readout_fit, residual_fit
from opensuction.identification.bank.bank_problem import PASTS, BankProblem, BankTrial, Scaled
from opensuction.identification.estimator import linear, modified_dahl
from opensuction.identification.estimator.linear import Design
from opensuction.identification.record import Folds, Scores, choose_simplest
from opensuction.identification.single_thread import single_threaded
from opensuction.kernel.record import Array

TOP = 0.995
"""Quantile of the speeds that counts as the highest: a glitch is none."""

ROUGH_RIDGE = RIDGES[2]
"""Penalty with which the past is chosen."""


WIDE_SHARE = 0.5
"""[design] Share of the loop in the element of the longest reach from which longer ones are
tried."""


class SlipFit(NamedTuple):
    """A Maxwell-slip model of a recording."""

    record: MaxwellSlip
    past: float
    """Memory ratio before the first sample."""
    scores: Scores
    freedom: float
    """Effective number of factors."""


def _gather(columns: Array, target: Array, edges: NDArray[np.int64]) -> BankProblem:
    """The sums of products of a recording, block by block. columns: the last one is 1."""
    table = np.column_stack([columns, target])
    blocks = zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True)
    sums = np.array([table[first:end].T @ table[first:end] for first, end in blocks])
    return bank_problem.pose(sums, np.zeros(columns.shape[1] - 1, dtype=np.bool_))


def _variances(problem: BankProblem) -> Array:
    """Of each factor's column."""
    whole, samples = problem.whole, float(problem.whole[-2, -2])
    means = whole[-2, :-2] / samples
    return np.asarray(np.maximum(np.diagonal(whole)[:-2] / samples - means * means, 0.0))


def _write(
    record: MaxwellSlip, factors: Array, offset: float, scaled: Scaled, period_s: float
) -> MaxwellSlip:
    """The model in the recording's own units. record: of ranges of 1 and periods of 1."""
    range_, height = float(scaled.ranges[0]), scaled.range_
    found = maxwell_slip.with_factors(record, height * np.append(factors, offset))
    slope = found.slope / range_
    return MaxwellSlip(
        slope=slope,
        reaches_mm=range_ * found.reaches_mm,
        gains=found.gains / range_,
        speeds_mm_s=range_ / period_s * found.speeds_mm_s,
        drags_mm=found.drags_mm,
        lag_s=period_s * found.lag_s,
        period_s=period_s,
        offset_mm=scaled.mean + found.offset_mm - slope * float(scaled.lows[0]),
    )


@single_threaded
def fit_slip_fit(input_: Array, output: Array, folds: Folds, period_s: float | None) -> SlipFit:
    """A Maxwell-slip model of a recording.

    input_, output: shape (n,). folds: of the recording. period_s: time between samples; None where
    they are not even: without drag. Raises InputError where no factors are found.
    """
    usual = _fit(input_, output, folds, period_s, REACHES)
    shares = maxwell_slip.share_out(usual.record)
    if shares[-1] <= WIDE_SHARE:
        return usual
    wide = _fit(input_, output, folds, period_s, WIDE_REACHES)
    return (usual, wide)[choose_simplest([usual.scores.blocks, wide.scores.blocks])]


def _fit(
    input_: Array, output: Array, folds: Folds, period_s: float | None, reaches: Array
) -> SlipFit:
    """A Maxwell-slip model with these reaches, as shares of the input's range."""
    scaled = bank_problem.scale(input_[None], output)
    place = scaled.inputs[0]

    def pose(record: MaxwellSlip, past: float) -> BankProblem:
        elements = maxwell_slip.start_elements_mm(record, float(place[0]), past)
        columns = maxwell_slip.basis(record, place, elements)
        return _gather(columns, scaled.output, folds.edges)

    def left(problem: BankProblem) -> float:
        found = bank_problem.fit(problem, ROUGH_RIDGE * _variances(problem))
        return bank_problem.squares_left(problem.whole, found)

    still = guess(1.0, reaches=reaches)
    past = min(PASTS, key=lambda ratio: left(pose(still, ratio)))
    drags = [(0.0, 1.0)]
    if period_s is not None:
        for lag in LAGS:
            speeds = np.abs(maxwell_slip.find_speeds(place, lag, 1.0))
            drags.append((float(np.quantile(speeds, TOP)), lag))
    records = [guess(1.0, top_speed, lag, reaches=reaches) for top_speed, lag in drags]
    tried: list[tuple[MaxwellSlip, BankTrial, float]] = []
    for record in records:
        problem = pose(record, past)
        for ridge in RIDGES:
            trial = bank_problem.evaluate(problem, ridge * _variances(problem), folds)
            freedom = bank_problem.freedom(problem, trial.penalty, trial.solution)
            tried.append((record, trial, freedom))
    tried.sort(key=lambda each: each[2])
    chosen = choose_simplest([trial.blocks for _, trial, _ in tried])
    record, trial, freedom = tried[chosen]
    found = trial.solution
    clock_s = 1.0 if period_s is None else period_s
    return SlipFit(
        record=_write(record, found.found.factors, found.offset, scaled, clock_s),
        past=past,
        scores=bank_problem.score(trial, folds, scaled.range_),
        freedom=freedom,
    )


WORTH_WIDE = 0.25
"""[design] Wide elements of either sign are taken where they halve the error left out: by less they
are a finer grid and not a wider one."""


class Superposition(NamedTuple):
    """A fitted superposition."""

    model: HysteresisModel
    record: Record
    memory_ratio: float
    """The past before the first sample that predicts best."""
    factors: dict[str, tuple[float, str]]
    """Name, value and unit of each factor, those held at 0 left out; {in} and {out} stand for the
    recording's units."""
    nonnegative: bool
    """Whether they were held at 0 or above."""
    scores: Scores
    """Errors of what was left out, in units of the output."""
    freedom: float
    """Effective number of factors: a penalty leaves less than there are."""
    elements: Array | None = None
    """Memory at the first sample, where the fit found more of it than a ratio."""

    def simulate(self, input_: Array) -> Array:
        """Output for a record of inputs, shape (n,), that begins after the same past."""
        memory = self.elements
        if memory is None:
            memory = self.model.memory(self.record, float(input_[0]), self.memory_ratio)
        return self.model.simulate(self.record, input_, memory)


@single_threaded
def fit(
    model: HysteresisModel,
    input_: Array,
    output: Array,
    folds: Folds | None = None,
    rising: bool = False,
    fading: bool = True,
    period_s: float | None = None,
) -> Superposition:
    """Fit a model that is linear in its factors; cross-validation decides how fine it is.

    input_, output: shape (n,), of any recording of unknown past. folds: of the recording; None:
    cut here. A compensator's plays come from a known excitation by `prandtl_ishlinskii.fit`, which
    says why there are two. rising: leave out of a play readout what could move its output the
    wrong way. fading: as `residual_fit.fit` takes it. period_s: as `slip_fit.fit` takes it.
    Raises InputError where the factors cannot be found, TypeError for a model that is not linear.
    """
    form = model.form
    if not isinstance(form, LinearForm):
        raise TypeError(f"{model.name} is not linear in its parameters")
    cut = records.cut(input_) if folds is None else folds
    if model.name == "residual-readout":
        return _fit_residual(model, form, (input_, output), cut, fading)
    solved = _solve(model, form, (input_, output), cut, rising, period_s)
    record, factors = solved.record, solved.factors
    constant = factors.size - 1 - form.degree(record)
    parameters = form.parameters(record, ranges_of(input_, output))
    return Superposition(
        model=model,
        record=record,
        memory_ratio=solved.past,
        factors={
            parameter.name: (float(factor), parameter.unit)
            for place, (parameter, factor) in enumerate(zip(parameters, factors, strict=True))
            if factor != 0.0 or place == constant or not form.nonnegative
        },
        nonnegative=solved.nonnegative,
        scores=solved.scores,
        freedom=solved.freedom,
    )


class _Solved(NamedTuple):
    """A record with its factors in the order of their names, from whichever solver is for it."""

    record: Record
    past: float
    factors: Array
    scores: Scores
    freedom: float
    nonnegative: bool


def _solve(
    model: HysteresisModel,
    form: LinearForm,
    pair: tuple[Array, Array],
    folds: Folds,
    rising: bool,
    period_s: float | None,
) -> _Solved:
    """The factors of every model but `residual-readout`; arguments as of `fit`."""
    input_, output = pair
    match model.name:
        case "play-readout":
            readout = readout_fit.fit(input_[None], output, folds, rising)
            lines, past = readout.records[0], readout.pasts[0]
            factors = np.concatenate([lines.gains.ravel(), lines.lags, [lines.offset_mm]])
            return _Solved(lines, past, factors, readout.scores, readout.freedom, readout.bounded)
        case "preisach":
            relays = preisach_fit.fit(input_, output, folds)
            weights = relays.record.weights_mm
            factors = np.append(weights[_in_triangle(weights)], relays.record.offset_mm)
            return _Solved(relays.record, relays.past, factors, relays.scores, relays.freedom, True)
        case "maxwell-slip":
            slip = fit_slip_fit(input_, output, folds, period_s)
            rubbing = slip.record
            factors = np.concatenate(
                [[rubbing.slope], rubbing.gains.ravel(), rubbing.drags_mm, [rubbing.offset_mm]]
            )
            return _Solved(rubbing, slip.past, factors, slip.scores, slip.freedom, False)
        case _:
            record, past, factors, scores = _fit_columns(model, form, input_, output, folds)
            freedom = float(np.count_nonzero(factors))
            return _Solved(record, past, factors, scores, freedom, form.nonnegative)


def _fit_residual(
    model: HysteresisModel, form: LinearForm, pair: tuple[Array, Array], folds: Folds, fading: bool
) -> Superposition:
    """A residual readout, beneath it the decay of the modified Dahl model alone."""
    decay = modified_dahl.fit(*pair).model.decay_per_mm
    found = residual_fit.fit(*pair, folds, decay, fading)
    record, fades = found.record, found.record.fades_mm
    lines = [record.curve_mm, *record.gains]
    values = [record.slope, record.velocity_gain, *np.concatenate(lines), record.offset_mm]
    ranges = ranges_of(*pair)
    named = zip(form.parameters(record, ranges), values, strict=True)
    factors = {parameter.name: (float(value), parameter.unit) for parameter, value in named}
    for length, left in zip(fades, found.elements[found.elements.size - fades.size :], strict=True):
        factors[name_element("fade", length, ranges).name] = (float(left), "{out}")
    return Superposition(
        model=model,
        record=record,
        memory_ratio=0.0,
        factors={"decay": (decay, "1/{in}"), **factors},
        nonnegative=False,
        scores=found.scores,
        freedom=found.freedom,
        elements=found.elements,
    )


def list_readout(record: PlayReadout) -> dict[str, tuple[float, str]]:
    """Name, value and unit of a readout's factors, those of 0 left out but the offset."""
    form = PLAY_READOUT.form
    if not isinstance(form, LinearForm):
        raise TypeError(f"{PLAY_READOUT.name} is not linear in its parameters")
    ranges = Ranges(record.low_mm, record.high_mm, 0.0, 1.0, 0.0)
    factors = [*record.gains.ravel().tolist(), *record.lags.tolist(), record.offset_mm]
    named = zip(form.parameters(record, ranges), factors, strict=True)
    return {
        parameter.name: (factor, parameter.unit)
        for parameter, factor in named
        if factor != 0.0 or parameter.name == "offset"
    }


def _in_triangle(weights: Array) -> Array:
    """True at the places of a square of cells that belong to its triangle."""
    rows, places = np.indices(weights.shape)
    return np.asarray(rows + places < len(weights))


def _fit_columns(
    model: HysteresisModel, form: LinearForm, input_: Array, output: Array, folds: Folds
) -> tuple[Record, float, Array, Scores]:
    """Record, past, factors and scores of a model whose columns are few."""
    ranges = ranges_of(input_, output)
    usual = _fit_guesses(model, form, form.initial_guesses(ranges), (input_, output), folds)
    if form.wide_guesses is None:
        return usual
    wide = _fit_guesses(model, form, form.wide_guesses(ranges), (input_, output), folds)
    left, least = (float(each[-1].blocks.sum()) for each in (usual, wide))
    return wide if least < WORTH_WIDE * left else usual


def _fit_guesses(
    model: HysteresisModel,
    form: LinearForm,
    guesses: list[Record],
    pair: tuple[Array, Array],
    folds: Folds,
) -> tuple[Record, float, Array, Scores]:
    """The best of some guesses. pair: input and output, each of shape (n,)."""
    input_, output = pair

    def designs(past: float) -> list[Design]:
        """The elements of every guess after one past, with every penalty."""
        made = []
        for record in guesses:
            columns = form.basis(record, input_, model.memory(record, float(input_[0]), past)).T
            kept, _ = _order(len(columns), form.degree(record))
            made.append((columns[kept], min(form.degree(record), 1)))
        return [
            Design(columns, penalty, spared)
            for (columns, spared), penalty in product(made, form.penalties)
        ]

    solve = linear.solve_nonnegative if form.nonnegative else linear.solve_free
    fits = [(past, linear.fit(designs(past), output, solve, folds)) for past in PASTS]
    past, found = min(fits, key=lambda each: each[1].scores.rmse)
    guess = guesses[found.chosen // len(form.penalties)]
    factors = np.empty(found.factors.size + 1)
    kept, constant = _order(factors.size, form.degree(guess))
    factors[kept], factors[constant] = found.factors, found.offset
    return form.with_factors(guess, factors), past, factors, found.scores


def _order(columns: int, degree: int) -> tuple[slice | list[int], int]:
    """Columns of a basis in the order they are fitted in, and which one is the constant.

    The constant is fitted by centring. The straight line behind it is never penalised: it is last.
    """
    constant = columns - 1 - degree
    if degree == 0:
        return slice(constant), constant
    return [*range(constant), *range(constant + 2, columns), constant + 1], constant
