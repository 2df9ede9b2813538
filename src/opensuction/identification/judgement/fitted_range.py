"""Range of inputs and speeds that a model was fitted to, and the check for inputs that leave it.

A model of hysteresis predicts nothing surely beyond either: its lines continue as they end, and the
speed of the recording is part of the fit, whether the model depends on speed or not.

Several inputs: what each adds to the output, and whether a column that was left out belongs in.

A column explains what a model leaves where a small fit to it and its plays predicts the residuals
of blocks that it has not seen.

Bounds that a fit ended at: what lies beyond them was not searched.

A parameter at a limit of its search, or a superposition most of whose hysteresis stands in the last
element of its grid, says how far the search went, not what the recording holds.
"""

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from opensuction.hysteresis import play
from opensuction.hysteresis.bank import maxwell_slip
from opensuction.hysteresis.bank.maxwell_slip import MaxwellSlip
from opensuction.hysteresis.bank.play_readout import PlayReadout
from opensuction.hysteresis.bank.residual_readout import ResidualReadout
from opensuction.hysteresis.catalogue.hysteresis_model import (
    BRIEFEST,
    LONGEST,
    FitParameter,
    Ranges,
    Record,
    VectorForm,
    name_element,
)
from opensuction.hysteresis.catalogue.play_family import LEVELS, MARGIN, PITCHES, WIDE_REACHES
from opensuction.hysteresis.catalogue.readout_model import (
    DECAY_SETS,
    DECAYS,
    RESIDUAL_DECAYS,
    WIDE,
    WIDE_WIDTHS,
)
from opensuction.hysteresis.generalised import Generalised
from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii
from opensuction.hysteresis.preisach import Preisach
from opensuction.identification import record
from opensuction.identification.estimator import linear
from opensuction.identification.estimator.linear import Design
from opensuction.identification.estimator.nonlinear import NonlinearFit
from opensuction.identification.judgement.diagnosis import Labels
from opensuction.identification.record import REVERSAL_SHARE, Folds, find_turns
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array

NEAR = 1e-6
"""How near to a limit a value counts as being there, as a share of it."""

MOST = 0.5
"""Share of a model's elements in the last one of the grid from which the grid ended too soon."""

LEADS = (
    "; an output that leads its input, as friction does, and one without hysteresis end there: try "
    "dahl or bouc-wen"
)

REVERSALS = {
    "stiffness": f"a reversal is over within {BRIEFEST:.3%} of the input's range or less",
    "limit": f"a reversal is remembered for {LONGEST:g} times the input's range or more",
}
"""What it means that a Dahl state's length is at a limit, by the parameter that is held by it."""


def find_limits(form: VectorForm, found: NonlinearFit, ranges: Ranges) -> dict[str, str]:
    """Parameters at a limit of their search, with the sentence that says so.

    form: of the fitted model. ranges: of the recording. The memory at the first sample, which is
    the recording's own, may well be at its limit: after a long stroke it is.
    """
    said = {name: f"At its bound: {name}; {REVERSALS[name]}." for name in found.at_limit}
    limits = form.limits(ranges).tolist()
    named = zip(form.parameters[:-1], found.vector[:-1].tolist(), limits[:-1], strict=True)
    for parameter, value, (low, high) in named:
        for end, word in ((low, "lowest"), (high, "highest")):
            if math.isfinite(end) and math.isclose(value, end, rel_tol=NEAR, abs_tol=1e-300):
                said[parameter.name] = _describe(parameter, value, word)
    return said


def _describe(parameter: FitParameter, value: float, word: str) -> str:
    beyond = LEADS if parameter.name == "velocity_gain" else ""
    return (
        f"At its bound: {parameter.name} is {value:.4g}, the {word} that is searched, and so has "
        f"no interval; the best value may lie beyond{beyond}."
    )


def find_grid_ends(record: Record, ranges: Ranges) -> dict[str, str]:
    """Elements at the end of their grid, with the sentence that says so. ranges: as above.

    Usual grids end sooner than the widest ones that are tried; these were no better then.
    """
    match record:
        case PrandtlIshlinskii():
            widest = 1.0 - 1.0 / max(PITCHES)
            ends = [("play_weight", 2.0 * record.thresholds_mm, record.weights, widest)]
        case PlayReadout():
            gains = np.abs(record.gains).sum(axis=1)
            ends = [
                ("gain", record.widths_mm, gains, float(WIDE_WIDTHS[-1])),
                ("lag_weight", record.decays_mm, record.lags, max(DECAYS)),
            ]
        case Generalised():
            lags = record.decay_lengths_mm.size
            longest = max(max(decays) for decays in DECAY_SETS)
            ends = [
                ("lag_weight", record.decay_lengths_mm, record.weights[:lags], longest),
                ("play_weight", record.widths_mm, record.weights[lags:], max(WIDE)),
            ]
        case ResidualReadout():
            heights = np.abs(record.gains).sum(axis=1) * record.decays_mm
            ends = [("lag_gain", record.decays_mm, heights, max(RESIDUAL_DECAYS))]
        case MaxwellSlip():
            shares = maxwell_slip.share_out(record)
            ends = [("gain", record.reaches_mm, shares, float(WIDE_REACHES[-1]))]
        case Preisach():
            return _judge_levels(record)
        case _:
            return {}
    said = {}
    for kind, lengths, weights, end in ends:
        name = _find_end(kind, lengths, np.abs(weights), end, ranges)
        if name:
            said[name] = (
                f"At its bound: {name} holds most of its kind, and no longer one is tried: a wider "
                "loop or a longer memory than that may fit better."
            )
    return said


def _find_end(kind: str, lengths: Array, weights: Array, end: float, ranges: Ranges) -> str:
    """Name of the last element where the grid ended too soon; else empty. end: share of a range."""
    if not weights.sum() > 0.0 or lengths[-1] < (1.0 - 0.01) * end * ranges.input_mm:
        return ""
    holds = float(weights[-1]) > MOST * float(weights.sum())
    return name_element(kind, float(lengths[-1]), ranges).name if holds else ""


def _judge_levels(record: Preisach) -> dict[str, str]:
    levels = record.weights_mm.shape[0]
    if levels < LEVELS[-1]:
        return {}
    share = (1.0 + 2.0 * MARGIN) / levels
    return {
        "levels": f"At its bound: {levels} levels are the finest grid that is tried; gaps and "
        f"corners are followed in steps of {share:.1%} of the input's range."
    }


WIDTHS = (0.02, 0.08, 0.32)
"""[design] Plays of a column that is tried, as shares of its range."""

PENALTY = 1e-3
"""[design] Ridge of that fit, as a share of each column's variance."""

EXPLAINED = 0.25
"""[design] Least share of the residuals' power that is worth a warning."""

MOST_COLUMNS = 20
"""[design] Columns of a file that are tried: more are seldom measured."""


def measure_shares(parts: Mapping[str, Array], range_: float) -> dict[str, float]:
    """Share of each input, root mean square about its mean, in percent of the output's range.

    parts: what it adds to the output, by its name; shape (n,).
    """
    return {name: 100.0 * float(part.std()) / range_ for name, part in parts.items()}


def explain(rest: Array, column: Array, folds: Folds) -> float:
    """Share of the residuals' power that a column predicts on blocks not seen; 0 if not surely any.

    rest: residuals, shape (n,); column: likewise.
    """
    range_ = float(np.ptp(column))
    if not (range_ > 0.0 and np.isfinite(column).all()):
        return 0.0
    scaled = (column - column.min()) / range_
    plays = [play.simulate(width, scaled, float(scaled[0])) for width in WIDTHS]
    try:
        design = Design(np.array([scaled, *plays]), PENALTY, 0)
        found = linear.fit([design], rest, linear.solve_free, folds)
    except InputError:
        return 0.0
    about = rest - rest.mean()
    before = np.array([float(about[cut] @ about[cut]) for cut in folds.cuts])
    after = found.scores.blocks
    if not record.is_surely_worse(before, after):
        return 0.0
    return 1.0 - float(after.sum()) / float(before.sum())


def find_missing(rest: Array, columns: Mapping[str, Array], folds: Folds) -> list[str]:
    """A sentence where another column explains what is left; the one that explains most.

    columns: the others of the file by their names, each of shape (n,).
    """
    tried = list(columns.items())[:MOST_COLUMNS]
    shares = {name: explain(rest, column, folds) for name, column in tried}
    best = max(shares, key=lambda name: shares[name], default=None)
    if best is None or shares[best] < EXPLAINED:
        return []
    return [
        f"Another input: column '{best}' explains {shares[best]:.0%} of what the model leaves; if "
        f"it drives too, add --input {best}."
    ]


BEYOND_SHARE = 0.02
"""An input counts as beyond the fitted ones from this share of their range on."""

OTHER_SPEED = 1.5
"""Strokes count as faster or slower than the fitted ones from this ratio on."""


class FittedRange(NamedTuple):
    """Of the samples that a model was fitted to."""

    lowest: float
    """Of the input."""
    highest: float
    slowest: float
    """Mean speed of the slowest stroke between two turns of the input, in its unit a second; not a
    number where no times are known."""
    fastest: float
    """Likewise, of the fastest."""


def measure(input_: Array, time_s: Array | None) -> FittedRange:
    """The range of what is fitted. input_: shape (n,); time_s: likewise, None: not known."""
    lowest, highest = float(input_.min()), float(input_.max())
    if time_s is None:
        return FittedRange(lowest, highest, math.nan, math.nan)
    speeds = _stroke_speeds(input_, time_s, highest - lowest)
    return FittedRange(lowest, highest, float(speeds.min()), float(speeds.max()))


def _stroke_speeds(input_: Array, time_s: Array, range_: float) -> Array:
    """Mean speed of every stroke, shape (strokes,).

    Of whole strokes, where there are any: the first and the last begin and end somewhere.
    """
    turns = find_turns(input_, REVERSAL_SHARE * range_)
    marks = turns if turns.size > 1 else np.concatenate([[0], turns, [input_.size - 1]])
    return np.asarray(np.abs(np.diff(input_[marks])) / np.diff(time_s[marks]))


def judge_beyond(
    fitted: FittedRange, input_: Array, time_s: Array | None, labels: Labels
) -> tuple[str, ...]:
    """Warnings on samples held out that leave the fitted range, a sentence each.

    input_: of the samples held out, maybe none, shape (m,); time_s: likewise.
    """
    if input_.size == 0:
        return ()
    range_ = fitted.highest - fitted.lowest
    said, unit = [], labels.behind_input
    margin = BEYOND_SHARE * range_
    beyond = (input_ < fitted.lowest - margin) | (input_ > fitted.highest + margin)
    if beyond.any():
        low, high = float(input_.min()), float(input_.max())
        ends = [f"down to {low:.4g}"] if low < fitted.lowest - margin else []
        ends += [f"up to {high:.4g}"] if high > fitted.highest + margin else []
        said.append(
            f"Beyond the fitted range: {np.mean(beyond):.0%} of what is held out has "
            f"{labels.input_name} outside {fitted.lowest:.4g} to {fitted.highest:.4g}{unit} "
            f"({', '.join(ends)}). What a model says there is a guess: fit strokes over all that "
            "it is to be used for."
        )
    if time_s is None or find_turns(input_, REVERSAL_SHARE * range_).size < 2:
        return tuple(said)
    speeds = _stroke_speeds(input_, time_s, range_)
    slowest, fastest = float(speeds.min()), float(speeds.max())
    if fastest > OTHER_SPEED * fitted.fastest or OTHER_SPEED * slowest < fitted.slowest:
        said.append(
            f"Beyond the fitted speeds: strokes held out take {slowest:.3g} to {fastest:.3g}{unit} "
            f"a second, those fitted {fitted.slowest:.3g} to {fitted.fastest:.3g}. Fit strokes at "
            "all speeds that the model is to be used at; --purpose transfer asks how it carries "
            "over."
        )
    return tuple(said)
