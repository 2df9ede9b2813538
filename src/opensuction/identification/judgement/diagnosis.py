"""Weaknesses of a recording and of the residuals of a fit, a sentence each."""

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from opensuction.identification.record import REVERSAL_SHARE, check_motion, find_turns
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array

FEWEST_REVERSALS = 3
"""With fewer no branch of the loop is seen twice."""

TREMBLING = 0.5
"""Von Neumann ratio of an input that only trembles: independent samples have 2, travel has next
to 0. Source: [Neumann-1941]."""

FEWEST_STEPS = 100
"""Steps of an encoder in a range from which a gap of a few percent can still be seen."""

CLIPPED_SHARE = 0.005
"""Share of samples at one extreme of the output, while the input travels, that looks clipped."""

CLIPPED_TRAVEL = 0.02
"""Least outward travel of the input during such rests, as a share of its range."""

UNEVEN_SHARE = 0.1
"""Deviation of a sampling interval, as a share of the usual one, that gives a warning."""

JUMP_SHARE = 0.05
"""Least leap of both quantities between two samples, as a share of their ranges, that parts two
recordings."""

JUMP_FACTOR = 10.0
"""How much larger than nearly all other steps, 99 of 100, such a leap is."""

GOING_ALONG = 0.1
"""[design] Least share of the output's range that it travels in the later half of a stroke to be a
position, which goes along once the gap is crossed. A friction force has reached its height."""

LATER_HALF = (0.5, 0.95)
"""Shares of a stroke that have passed where that half begins and ends."""

LEADING_SHARE = 0.02
"""Area of the loop, as a share of both ranges' product for each stroke, from which an output that
turns before its input is told of."""

REVERSED_CORRELATION = -0.2
"""Correlation of input and output below which the sign is taken to be wrong."""

WORST_CONDITION = 1e4
"""Condition of the scaled Jacobian above which parameters trade against one another."""

EXPLAINED_SHARE = 0.5
"""Share of the output's variance explained below which there is a warning."""

ALIKE_SAMPLES = 0.3
"""Correlation of neighbouring residuals that gives a warning."""

PREDICTED_FACTOR = 1.5
"""Error of the held-out part over that of the fitted part that gives a warning."""

ROUNDING = 1e-9
"""Residuals below this share of the output are rounding, and may be alike."""

MOST_LAGS = 200
"""Lags of the autocorrelation that are kept for a plot."""


UNKNOWN_UNITS = ("input", "output")
"""What units are called where none is known: a slope is then in output/input."""


class Labels(NamedTuple):
    """Names of the caller's quantities and of their units."""

    input_name: str = "input"
    output_name: str = "output"
    input_unit: str = "mm"
    output_unit: str = "mm"
    time_name: str = "time"
    other_names: tuple[str, ...] = ()
    """Of further inputs; those without one are numbered."""

    @property
    def behind_input(self) -> str:
        """Text behind a number of the input: a space and its unit, nothing without one."""
        return "" if self.input_unit in UNKNOWN_UNITS else f" {self.input_unit}".rstrip()


def check_recording(input_: Array, output: Array, labels: Labels) -> None:
    """Refuse what can only be fitted with nonsense.

    Raises InputError for a quantity that does not move, an input that never reverses or only
    trembles, and an output whose sign is against the input's.
    """
    check_motion(labels[:2], input_, output, labels.behind_input.strip())
    range_ = float(np.ptp(input_))
    moves = np.diff(input_)
    about = input_ - input_.mean()
    if float(moves @ moves) > TREMBLING * float(about @ about):
        raise InputError(
            f"{labels.input_name}: trembles within {range_:.4g}{labels.behind_input} but does "
            "not travel; record a motion to and fro that is larger than the gap"
        )
    correlation = float(np.corrcoef(input_, output)[0, 1])
    if correlation < REVERSED_CORRELATION:
        raise InputError(
            f"{labels.output_name}: moves against {labels.input_name} (correlation "
            f"{correlation:.2f}), should follow it; negate one of them"
        )


def check_time(time_s: Array, name: str = "time") -> None:
    """Refuse a time that does not advance. Raises InputError."""
    back = np.flatnonzero(np.diff(time_s) <= 0.0)
    if back.size:
        raise InputError(
            f"{name}: does not advance at sample {back[0] + 1} ({time_s[back[0]]:g} then "
            f"{time_s[back[0] + 1]:g} s); sort the recording or remove doubled samples"
        )


def judge_recording(
    input_: Array, output: Array, time_s: Array | None, labels: Labels
) -> tuple[str, ...]:
    """Weaknesses of a recording, a sentence each. Arrays of shape (n,)."""
    range_ = float(np.ptp(input_))
    said = []
    reversals = find_turns(input_, REVERSAL_SHARE * range_).size
    if reversals < FEWEST_REVERSALS:
        said.append(
            f"Too few reversals: {labels.input_name} turns {count_times(reversals)} by more than "
            f"{REVERSAL_SHARE:.0%} of its range, {FEWEST_REVERSALS} or more show each branch twice."
        )
    steps = np.abs(np.diff(input_))
    step = float(steps[steps > 0.0].min())
    if range_ < FEWEST_STEPS * step:
        said.append(
            f"Range too small: {labels.input_name} covers {range_ / step:.0f} steps of its "
            f"resolution ({step:.3g}{labels.behind_input}), {FEWEST_STEPS} or more are needed."
        )
    said.extend(_find_clipping(input_, output, labels))
    said.extend(_find_joint(input_, output, time_s, labels))
    if labels.input_unit == labels.output_unit:
        said.extend(_find_lead(input_, output, reversals, labels))
    if time_s is not None and find_period(time_s) is None:
        intervals = np.diff(time_s)
        said.append(
            f"Uneven sampling: intervals from {intervals.min():.3g} to {intervals.max():.3g} s,"
            f" usually {np.median(intervals):.3g} s. The models do not mind, but maxwell-slip goes "
            "without drag; the intervals assume even ones."
        )
    return tuple(said)


def find_period(time_s: Array) -> float | None:
    """Time between samples, s; None where they are not evenly apart. time_s: shape (n,)."""
    intervals = np.diff(time_s)
    usual = float(np.median(intervals))
    worst = float(np.max(np.abs(intervals - usual)))
    return None if worst > UNEVEN_SHARE * usual else usual


def count_times(count: int) -> str:
    """Count of turns, in words.

    >>> count_times(0), count_times(1), count_times(2)
    ('nowhere', 'once', 'twice')
    """
    return ("nowhere", "once", "twice")[count] if count < 3 else f"{count} times"


def _find_clipping(input_: Array, output: Array, labels: Labels) -> list[str]:
    """Warning of an output that rests at an extreme while the input travels on outwards.

    On the way back it may rest there: that is the gap.
    """
    said = []
    moves = np.diff(input_, prepend=input_[0])
    ends = (("highest", output.max(), moves), ("lowest", output.min(), -moves))
    for word, extreme, outward in ends:
        there = output == extreme
        both = there & np.concatenate([[False], there[:-1]]) & (outward > 0.0)
        travelled = float(outward[both].sum())
        enough = travelled > CLIPPED_TRAVEL * float(np.ptp(input_))
        if enough and np.count_nonzero(both) > CLIPPED_SHARE * output.size:
            said.append(
                f"Clipped: {labels.output_name} stays at its {word} value ({extreme:g}) while "
                f"{labels.input_name} travels on by {travelled:.3g}{labels.behind_input}; the "
                "sensor may be at its end."
            )
    return said


def _find_joint(input_: Array, output: Array, time_s: Array | None, labels: Labels) -> list[str]:
    """Warning of a place where recordings may have been joined: both quantities leap at once."""
    leaps = np.ones(input_.size - 1, dtype=bool)
    for values in (input_, output):
        steps = np.abs(np.diff(values))
        usual = float(np.quantile(steps, 0.99))
        leaps &= steps > max(JUMP_SHARE * float(np.ptp(values)), JUMP_FACTOR * usual)
    places = np.flatnonzero(leaps)
    if not places.size:
        return []
    first = int(places[0]) + 1
    place = f"sample {first}" if time_s is None else f"{time_s[first]:g} s (sample {first})"
    more = "" if places.size == 1 else f" and {places.size - 1} more"
    return [
        f"Recordings joined? {labels.input_name} leaps from {input_[first - 1]:.4g} to "
        f"{input_[first]:.4g}{labels.behind_input}, and {labels.output_name} with it, at {place}"
        f"{more}. No model follows that; identify each part by itself."
    ]


def _find_lead(input_: Array, output: Array, reversals: int, labels: Labels) -> list[str]:
    """Warning of an output that turns before the input: of two positions, the one that is driven.

    A loop that lags is passed the other way round than one that leads; the sign of its area tells.
    """
    area = float(np.sum(0.5 * (output[1:] + output[:-1]) * np.diff(input_)))
    area += 0.5 * float((output[0] + output[-1]) * (input_[0] - input_[-1]))
    whole = float(np.ptp(input_) * np.ptp(output)) * max(reversals, 1)
    if area <= LEADING_SHARE * whole or _measure_going_along(input_, output) < GOING_ALONG:
        return []
    return [
        f"Columns swapped? {labels.output_name} turns before {labels.input_name}, as what drives "
        "does and what follows behind a gap cannot. Try it with input and output exchanged; of a "
        "force that a displacement makes it is as it should be."
    ]


def _measure_going_along(input_: Array, output: Array) -> float:
    """Share of its range that the output travels with the input in the later half of a stroke.

    The median of strokes between turns of the input; 1 where there are none.
    """
    turns = find_turns(input_, REVERSAL_SHARE * float(np.ptp(input_))).tolist()
    ways = []
    for first, last in pairwise(turns):
        way = float(input_[last] - input_[first])
        passed = (input_[first : last + 1] - input_[first]) / way
        # Not to the turn itself, where what follows behind a gap stands for long.
        half, end = (first + int(np.argmax(passed >= share)) for share in LATER_HALF)
        ways.append(math.copysign(1.0, way) * float(output[end] - output[half]))
    return float(np.median(ways) / np.ptp(output)) if ways else 1.0


def autocorrelation(rest: Array) -> Array:
    """Autocorrelation of residuals at lags of 0, 1, 2, ... samples; shape (lags,), at most 201."""
    lags = min(MOST_LAGS, rest.size - 1)
    about = rest - rest.mean()
    power = float(about @ about)
    if not power > 0.0:
        return np.eye(1, lags + 1, dtype=np.float64).ravel()
    size = 2 ** math.ceil(math.log2(2 * rest.size))
    spectrum = np.fft.rfft(about, size)
    products: Array = np.fft.irfft(np.abs(spectrum) ** 2, size)[: lags + 1]
    return np.asarray(products / power, dtype=np.float64)


def measure_explained(output: Array, rest: Array) -> float:
    """Share of the output's variance that a model explains. rest: what it leaves."""
    return 1.0 - float(rest.var()) / float(output.var())


def judge_residuals(
    output: Array,
    rest: Array,
    held_out: Array,
    correlations: Array,
    leaves_range: bool = False,
) -> tuple[str, ...]:
    """Findings of the residuals on the model, a sentence each.

    output, rest: of the fitted samples. held_out: residuals of the samples held out, maybe none.
    leaves_range: whether these go beyond what was fitted.
    """
    said = []
    explained = measure_explained(output, rest)
    if explained < EXPLAINED_SHARE:
        said.append(
            f"The model explains {max(explained, 0.0):.0%} of the output's variance: its "
            "parameters mean nothing."
        )
    rounding = float(rest.std()) < ROUNDING * float(output.std())
    if correlations.size > 1 and correlations[1] > ALIKE_SAMPLES and not rounding:
        below = np.flatnonzero(correlations < math.exp(-1.0))
        last = f"{below[0]}" if below.size else f"more than {correlations.size - 1}"
        said.append(
            f"Neighbouring residuals are alike (correlation {correlations[1]:.2f}, for {last} "
            "samples): drift, filtered noise, or something the model leaves out. Intervals, "
            "where given, allow for it."
        )
    if held_out.size:
        fitted, predicted = math.sqrt(np.mean(rest**2)), math.sqrt(np.mean(held_out**2))
        why = "the plant changed, or the model follows noise"
        if leaves_range:
            why = "it leaves what was fitted"
        if predicted > PREDICTED_FACTOR * fitted and not rounding:
            said.append(
                f"The held-out part is predicted {predicted / max(fitted, 1e-300):.1f} times worse "
                f"than the fitted part: {why}."
            )
    return tuple(said)


def condition(jacobian: Array) -> float:
    """Condition number of the columns' directions about their means.

    Without the means, since an origin far away is no fault of the recording; rows that hardly vary
    (an offset, a parameter at its bound) do not count.
    """
    lengths = np.sqrt(np.einsum("ij,ij->i", jacobian, jacobian))
    about = jacobian - jacobian.mean(axis=1)[:, None]
    spreads = np.sqrt(np.einsum("ij,ij->i", about, about))
    varied = spreads > ROUNDING * lengths
    scaled = about[varied] / spreads[varied, None]
    if not len(scaled):
        return math.inf
    sizes = np.sqrt(np.maximum(np.linalg.eigvalsh(scaled @ scaled.T), 0.0))
    return float(sizes.max() / sizes.min()) if sizes.min() > 0.0 else math.inf
