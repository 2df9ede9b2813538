"""Variable projection and its relatives for models that are not linear in their parameters.

Modified Dahl: `modified_dahl.fit`. Dahl: the same without the straight line. Bouc-Wen has three
parameters that are not linear (length, bend, exponent) and contains the modified Dahl model
(exponent 1, no bend): its search starts there and at a few bent places, so that it is never worse.
Source: [Golub-1973]; [Branch-1999] for the bounded least squares of
`scipy.optimize.least_squares`.
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares, minimize_scalar

from opensuction.hysteresis.catalogue.duhem_family import BOUC_WEN_FORM
from opensuction.hysteresis.catalogue.hysteresis_model import LONGEST, SHORTEST, ranges_of
from opensuction.hysteresis.modified_dahl import ModifiedDahl, simulate
from opensuction.identification.estimator import modified_dahl
from opensuction.identification.estimator.normal_equation import solve_least_squares
from opensuction.identification.record import thin
from opensuction.identification.residual import squares
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array

GRID_POINTS = 40
"""Lengths of a Dahl state tried: neighbours differ by a factor of 1.3."""

BENT_STARTS = ((1.0, 0.0), (1.5, 0.5), (2.5, -1.0))
"""Exponent and bend ratio from which the Bouc-Wen search starts; the first is modified Dahl."""

SEARCH_SAMPLES = 1500
"""Samples for the rough part of that search."""

Names = tuple[str, str]
NAMES = ("input", "output")


class NonlinearFit(NamedTuple):
    """Parameters in the order of the model's `VectorForm`."""

    vector: Array
    determined: bool
    """Whether the recording determines them, or a longer or shorter memory fits as well."""


def fit_modified_dahl(input_: Array, output: Array, names: Names = NAMES) -> NonlinearFit:
    """Modified Dahl by variable projection. names: of the two in a refusal."""
    found = modified_dahl.fit(input_, output, names)
    return NonlinearFit(np.array([*found.model, found.lag_mm]), found.determined)


def fit_dahl(input_: Array, output: Array, names: Names = NAMES) -> NonlinearFit:
    """Dahl by variable projection: stiffness, offset and start are linear for one length.

    names: of the two in a refusal.
    Raises InputError where the output turns against the input.
    """
    path = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(input_)))])
    mean, range_ = float(output.mean()), float(np.ptp(input_))

    def projected(log_length: float) -> tuple[float, Array]:
        """Sum of squares and best vector for one length."""
        length = math.exp(log_length)
        unit = ModifiedDahl(slope=0.0, velocity_gain=1.0, decay_per_mm=1.0 / length, offset_mm=0.0)
        columns = np.stack([-simulate(unit, input_, 0.0), np.exp(-path / length)])
        means = columns.mean(axis=1)
        columns -= means[:, None]
        factors = solve_least_squares(columns, output - mean)
        rest = output - mean - factors @ columns
        offset = mean - float(factors @ means)
        vector = np.array([factors[0], factors[0] * length, offset, factors[1]])
        return float(rest @ rest), vector

    grid = np.linspace(math.log(SHORTEST * range_), math.log(LONGEST * range_), GRID_POINTS)
    heights = [projected(float(point))[0] for point in grid]
    least = int(np.argmin(heights))
    valley = (float(grid[max(least - 1, 0)]), float(grid[min(least + 1, GRID_POINTS - 1)]))
    found = minimize_scalar(
        lambda point: projected(float(point))[0],
        bounds=valley,
        method="bounded",
        options={"xatol": 1e-8},
    )
    bottom, vector = projected(float(found.x))
    if not vector[0] > 0.0:
        raise InputError(
            f"{names[1]}: turns against {names[0]} (stiffness {vector[0]:.4g}), should follow it; "
            "negate one of them"
        )
    determined = min(heights[0], heights[-1]) > (1.0 + modified_dahl.LEAST_RISE) * bottom
    return NonlinearFit(vector, determined)


def fit_bouc_wen(input_: Array, output: Array, names: Names = NAMES) -> NonlinearFit:
    """Bouc-Wen by bounded least squares from the modified Dahl optimum and from bent places.

    names: of the two in a refusal.
    """
    first = fit_modified_dahl(input_, output, names)
    slope, gain, decay, offset, lag = (float(value) for value in first.vector)
    box = BOUC_WEN_FORM.bounds(ranges_of(input_, output))
    width = box[:, 1] - box[:, 0]
    start_ratio = -lag * decay / gain if gain > 0.0 else 0.0
    short_input, short_output = thin(input_, output, SEARCH_SAMPLES)

    def polished(start: Array, record: Array, target: Array) -> Array:
        """The vector at the bottom of the valley that the start lies in."""
        inside = np.clip(start, box[:, 0] + 1e-9 * width, box[:, 1] - 1e-9 * width)
        found = least_squares(
            lambda vector: np.nan_to_num(BOUC_WEN_FORM.simulate(vector, record) - target, nan=1e9),
            inside,
            bounds=(box[:, 0], box[:, 1]),
            x_scale=np.maximum(np.abs(inside), 1e-3 * width),
            xtol=1e-10,
            ftol=1e-12,
            gtol=1e-12,
            max_nfev=200,
        )
        return np.asarray(found.x)

    plain = np.array([1.0 / decay, 0.0, 1.0, slope, -gain, offset, start_ratio])
    rough = [plain]
    for exponent, bend in BENT_STARTS:
        start = plain.copy()
        start[1:3] = bend, exponent
        rough.append(polished(start, short_input, short_output))
    best = min(rough, key=lambda vector: squares(BOUC_WEN_FORM, vector, short_input, short_output))
    candidates = [plain, polished(best, input_, output)]
    vector = min(candidates, key=lambda vector: squares(BOUC_WEN_FORM, vector, input_, output))
    return NonlinearFit(vector, first.determined)


FITS = {"modified-dahl": fit_modified_dahl, "dahl": fit_dahl, "bouc-wen": fit_bouc_wen}
