"""Range of inputs and speeds that a model was fitted to, and the check for inputs that leave it.

A model of hysteresis predicts nothing surely beyond either: its lines continue as they end, and the
speed of the recording is part of the fit, whether the model depends on speed or not.
"""

import math
from typing import NamedTuple

import numpy as np

from opensuction.identification.judgement.diagnosis import Labels
from opensuction.identification.record import REVERSAL_SHARE, find_turns
from opensuction.kernel.record import Array

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
