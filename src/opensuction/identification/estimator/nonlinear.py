"""Variable projection and its relatives for models that are not linear in their parameters.

Modified Dahl: `modified_dahl.fit`. Dahl: the same without the straight line. Bouc-Wen has four
parameters that are not linear (length, bend, exponent, start) and contains the modified Dahl model
(exponent 1, no bend), with a gain of either sign: backlash lags, friction leads. Its search starts
at the better of the two and at a few bent places, so that it is never worse. Slope, gain and offset
are solved for exactly and have no limits.
Source: [Golub-1973]; [Branch-1999] for the bounded least squares of
`scipy.optimize.least_squares`.
"""

import math
from typing import NamedTuple

import numpy as np

from opensuction.hysteresis import bouc_wen
from opensuction.hysteresis.bouc_wen import BoucWen
from opensuction.hysteresis.catalogue.duhem_family import BOUC_WEN_FORM
from opensuction.hysteresis.catalogue.hysteresis_model import BRIEFEST, LONGEST, ranges_of
from opensuction.hysteresis.modified_dahl import ModifiedDahl, simulate
from opensuction.identification.estimator import modified_dahl
from opensuction.identification.estimator.linear import solve_least_squares, squares
from opensuction.identification.extremum import find_minimum
from opensuction.identification.record import check_motion, thin
from opensuction.identification.single_thread import load
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array

GRID_POINTS = 56
"""Lengths of a Dahl state tried: neighbours differ by a factor of 1.3."""

BENT_STARTS = ((1.0, 0.0), (1.5, 0.5), (2.5, -1.0))
"""Exponent and bend ratio from which the Bouc-Wen search starts; the first is modified Dahl."""

NEAR = 1e-3
"""How near to a limit, as a share of the way between both, the Bouc-Wen search tries the limit."""

SEARCH_SAMPLES = 1500
"""Samples for the rough part of that search."""

ROUNDING = 1e-13
"""Residuals below this share of the output's largest value are rounding."""

Names = tuple[str, str]
NAMES = ("input", "output")


class NonlinearFit(NamedTuple):
    """Parameters in the order of the model's `VectorForm`."""

    vector: Array
    determined: bool
    """Whether the recording determines them, or a longer or shorter memory fits as well. Where the
    best memory is at a limit of the search that is not asked: what lies beyond is not known."""
    at_limit: tuple[str, ...] = ()
    """Parameters that a limit holds which is not one of their own in the form."""


class _Forgetting(NamedTuple):
    """The best model of a line and a Dahl state for the best length, its gain of either sign."""

    length: float
    gain: float
    """Of the Dahl state, a memory that follows the input: below 0 for backlash."""
    start_ratio: float
    """Memory at the first sample, as a share of the length."""
    squares: float
    line_squares: float
    """What the straight line alone leaves."""
    determined: bool
    """Whether the sum of squares rises towards the shortest and the longest length."""


def _find_forgetting(input_: Array, output: Array) -> _Forgetting:
    """Line and Dahl state by a grid of lengths. input_, output: shape (n,), few."""
    path = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(input_)))])
    range_, target = float(np.ptp(input_)), output - output.mean()
    place = (input_ - input_.mean()) / range_
    lengths = range_ * np.geomspace(BRIEFEST, LONGEST, GRID_POINTS)
    tried = []
    for length in lengths.tolist():
        unit = ModifiedDahl(slope=0.0, velocity_gain=1.0, decay_per_mm=1.0 / length, offset_mm=0.0)
        columns = np.stack([place, -simulate(unit, input_, 0.0) / length, np.exp(-path / length)])
        columns -= columns.mean(axis=1)[:, None]
        factors = solve_least_squares(columns, target)
        rest = target - factors @ columns
        tried.append((float(rest @ rest), length, factors))
    least, length, factors = min(tried, key=lambda each: each[0])
    line = target - float(place @ target) / float(place @ place) * place
    height = float(factors[1])
    return _Forgetting(
        length=length,
        gain=height / length,
        start_ratio=min(max(float(factors[2]) / height, -1.0), 1.0) if height != 0.0 else 0.0,
        squares=least,
        line_squares=float(line @ line),
        determined=min(tried[0][0], tried[-1][0])
        > (1.0 + modified_dahl.least_rise(output.size)) * least,
    )


def _is_seen(squares_left: float, line_squares: float, output: Array) -> bool:
    """True where a model leaves less than the straight line does, so that it shows a hysteresis.

    output: fitted values, shape (n,). A line that leaves no more than rounding or chance has shown
    none.
    """
    rounding = output.size * (ROUNDING * float(np.abs(output).max())) ** 2
    rise = modified_dahl.least_rise(output.size)
    return line_squares > max((1.0 + rise) * squares_left, rounding)


def fit_modified_dahl(input_: Array, output: Array, names: Names = NAMES) -> NonlinearFit:
    """Modified Dahl by variable projection. names: of the two in a refusal."""
    found = modified_dahl.fit(input_, output, names)
    vector, determined = np.array([*found.model, found.lag_mm]), found.determined
    if not determined:
        forgetting = _find_forgetting(*thin(input_, output, SEARCH_SAMPLES))
        length = 1.0 / (found.model.decay_per_mm * float(np.ptp(input_)))
        friction = found.model.velocity_gain == 0.0 and forgetting.gain > 0.0
        held = found.model.velocity_gain > 0.0 and not 1.001 * BRIEFEST < length < 0.999 * LONGEST
        seen = _is_seen(forgetting.squares, forgetting.line_squares, output)
        determined = (friction or held) and seen
    return NonlinearFit(vector, determined)


def fit_dahl(input_: Array, output: Array, names: Names = NAMES) -> NonlinearFit:
    """Dahl by variable projection: stiffness, offset and start are linear for one length.

    names: of the two in a refusal.
    Raises InputError where the output turns against the input.
    """
    range_ = float(np.ptp(input_))

    def projected(log_length: float, input_: Array, output: Array) -> tuple[float, Array]:
        """Sum of squares and best vector for one length."""
        path = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(input_)))])
        length, mean = math.exp(log_length), float(output.mean())
        unit = ModifiedDahl(slope=0.0, velocity_gain=1.0, decay_per_mm=1.0 / length, offset_mm=0.0)
        columns = np.stack([-simulate(unit, input_, 0.0), np.exp(-path / length)])
        means = columns.mean(axis=1)
        columns -= means[:, None]
        factors = solve_least_squares(columns, output - mean)
        rest = output - mean - factors @ columns
        offset = mean - float(factors @ means)
        vector = np.array([factors[0], factors[0] * length, offset, factors[1]])
        return float(rest @ rest), vector

    grid = np.linspace(math.log(BRIEFEST * range_), math.log(LONGEST * range_), GRID_POINTS)
    short = thin(input_, output, SEARCH_SAMPLES)
    heights = [projected(float(point), *short)[0] for point in grid]
    least = int(np.argmin(heights))
    valley = (float(grid[max(least - 1, 0)]), float(grid[min(least + 1, GRID_POINTS - 1)]))
    found = find_minimum(lambda point: projected(point, input_, output)[0], *valley, width=1e-8)
    _, vector = projected(found.place, input_, output)
    if not vector[0] > 0.0:
        raise InputError(
            f"{names[1]}: turns against {names[0]} (stiffness {vector[0]:.4g}), should follow it; "
            "negate one of them"
        )
    if abs(found.place - grid[0]) < NEAR:
        return NonlinearFit(vector, determined=True, at_limit=("stiffness",))
    if abs(found.place - grid[-1]) < NEAR:
        return NonlinearFit(vector, determined=True, at_limit=("limit",))
    bottom = projected(found.place, *short)[0]
    rise = modified_dahl.least_rise(short[0].size)
    determined = min(heights[0], heights[-1]) > (1.0 + rise) * bottom
    return NonlinearFit(vector, determined)


def _simulate_memory(place: Array, shares: Array) -> Array:
    """Memory of a Bouc-Wen model in shares of its saturation, shape (n,).

    place: logarithm of the length over the input's range, of 1 - bend ratio and of the exponent;
    memory at the first sample. shares: inputs over their range, shape (n,).
    """
    rate, dissipation, exponent = math.exp(-place[0]), math.exp(place[1]), math.exp(place[2])
    model = BoucWen(rate, dissipation * rate, (1.0 - dissipation) * rate, exponent, 0.0, 1.0, 0.0)
    memory: Array = bouc_wen.simulate(model, shares, float(place[3]))
    return memory


def _solve_line(place: Array, shares: Array, target: Array) -> tuple[Array, Array]:
    """Best slope and memory gain at a place, and what they leave. shares, target: about means."""
    memory = _simulate_memory(place, shares)
    if not np.isfinite(memory).all():
        return np.zeros(2), np.full(target.size, 1e9)
    columns = np.stack([shares, memory - memory.mean()])
    factors = solve_least_squares(columns, target)
    return factors, target - factors @ columns


def _polish_bouc_wen(start: Array, limits: Array, pair: tuple[Array, Array]) -> Array:
    """The place at the bottom of the valley that a place lies in. pair: as `_solve_line`."""
    margin = 1e-9 * (limits[:, 1] - limits[:, 0])
    found = load("scipy.optimize").least_squares(
        lambda place: _solve_line(place, *pair)[1],
        np.clip(start, limits[:, 0] + margin, limits[:, 1] - margin),
        bounds=limits.T,
        xtol=1e-9,
        ftol=1e-11,
        gtol=1e-11,
        max_nfev=200,
    )
    return np.asarray(found.x)


def _search_bouc_wen(start: Array, limits: Array, recording: tuple[Array, Array]) -> Array:
    """The best place that a search from a start finds, at a limit where it ends next to one."""

    def scaled(input_: Array, output: Array) -> tuple[Array, Array]:
        shares = input_ / float(np.ptp(recording[0]))
        return shares - shares.mean(), (output - output.mean()) / float(np.ptp(recording[1]))

    def left(place: Array, pair: tuple[Array, Array]) -> float:
        rest = _solve_line(place, *pair)[1]
        return float(rest @ rest)

    short, whole = scaled(*thin(*recording, SEARCH_SAMPLES)), scaled(*recording)
    rough = [start]
    for exponent, bend in BENT_STARTS:
        bent = start.copy()
        bent[1:3] = math.log(1.0 - bend), math.log(exponent)
        rough.append(_polish_bouc_wen(bent, limits, short))
    best = _polish_bouc_wen(min(rough, key=lambda place: left(place, short)), limits, whole)
    near = NEAR * (limits[:, 1] - limits[:, 0])
    squares_left = left(best, whole)
    for place in np.flatnonzero((np.abs(best[:, None] - limits) < near[:, None]).any(axis=1)):
        held = best.copy()
        held[place] = min(limits[place], key=lambda end: abs(end - best[place]))
        if left(held, whole) <= squares_left * (1.0 + NEAR * modified_dahl.LEAST_RISE):
            best = held
    return best


def fit_bouc_wen(input_: Array, output: Array, names: Names = NAMES) -> NonlinearFit:
    """Bouc-Wen by variable projection, from a Dahl state of either sign and from bent places.

    names: of the two in a refusal.
    """
    check_motion(names, input_, output)
    forgetting = _find_forgetting(*thin(input_, output, SEARCH_SAMPLES))
    range_, plain = float(np.ptp(input_)), None
    length, ratio = forgetting.length, forgetting.start_ratio
    friction = forgetting.gain > 0.0 and _is_seen(
        forgetting.squares, forgetting.line_squares, output
    )
    try:
        first = modified_dahl.fit(input_, output, names)
    except InputError:
        if not friction:
            raise
    else:
        (slope, gain, decay, offset), lag = first.model, first.lag_mm
        start_ratio = min(max(-lag * decay / gain, -1.0), 1.0) if gain > 0.0 else 0.0
        plain = np.array([1.0 / decay, 0.0, 1.0, slope, -gain, offset, start_ratio])
        if not friction:
            length, ratio = 1.0 / decay, start_ratio
    limits = BOUC_WEN_FORM.limits(ranges_of(input_, output))
    ends = np.array(
        [np.log(limits[0] / range_), np.log(1.0 - limits[1][::-1]), np.log(limits[2]), limits[6]]
    )
    start = np.array([math.log(length / range_), 0.0, 0.0, ratio])
    place = _search_bouc_wen(start, ends, (input_, output))
    vector = _write_bouc_wen(place, input_, output, limits)
    left = squares(BOUC_WEN_FORM, vector, input_, output)
    if plain is not None and squares(BOUC_WEN_FORM, plain, input_, output) < left:
        vector, left = plain, squares(BOUC_WEN_FORM, plain, input_, output)
    determined = forgetting.determined
    if vector[0] in limits[0]:
        line = output - np.polynomial.Polynomial.fit(input_, output, 1)(input_)
        determined = _is_seen(left, float(line @ line), output)
    return NonlinearFit(vector, determined)


def _write_bouc_wen(place: Array, input_: Array, output: Array, limits: Array) -> Array:
    """The vector at a place of the search; one at a limit is there to the last digit."""
    range_, height = float(np.ptp(input_)), float(np.ptp(output))
    shares, target = input_ / range_, (output - output.mean()) / height
    middle = float(shares.mean())
    factors, _ = _solve_line(place, shares - middle, target)
    length, exponent = range_ * math.exp(place[0]), math.exp(place[2])
    vector = np.array(
        [
            length,
            1.0 - math.exp(place[1]),
            exponent,
            float(factors[0]) * height / range_,
            float(factors[1]) * height / length,
            0.0,
            float(place[3]),
        ]
    )
    for at in (0, 1, 2):
        end = min(limits[at], key=lambda end: abs(end - vector[at]))
        if math.isclose(end, vector[at], rel_tol=1e-9):
            vector[at] = end
    vector[5] = float(np.mean(output - BOUC_WEN_FORM.simulate(vector, input_)))
    return vector


FITS = {"modified-dahl": fit_modified_dahl, "dahl": fit_dahl, "bouc-wen": fit_bouc_wen}
