"""Residual of a model against a recording, and the derivative of its output by each parameter."""

import math

import numpy as np

from opensuction.hysteresis.catalogue.hysteresis_model import Ranges, VectorForm
from opensuction.kernel.record import Array

DIFFERENCE = 1e-5
"""Step of the central differences, as a share of the parameter."""


def squares(form: VectorForm, vector: Array, input_: Array, output: Array) -> float:
    """Sum of squares of a vector, shape (p,); infinite where the model has no answer."""
    rest = form.simulate(vector, input_) - output
    total = float(rest @ rest)
    return total if math.isfinite(total) else math.inf


def jacobian(form: VectorForm, vector: Array, input_: Array, ranges: Ranges) -> Array:
    """Change of the output with each parameter, central differences inside the limits.

    ranges: of the recording. Returns shape (p, n). A parameter at its limit is taken as given: a
    row of zeros.
    """
    rows = np.zeros((vector.size, input_.size))
    widths = np.diff(form.bounds(ranges), axis=1).ravel()
    for place, (low, high) in enumerate(form.limits(ranges)):
        step = DIFFERENCE * max(abs(float(vector[place])), 1e-3 * float(widths[place]))
        if vector[place] - step < low or vector[place] + step > high:
            continue
        ahead, behind = vector.copy(), vector.copy()
        ahead[place] += step
        behind[place] -= step
        rows[place] = (form.simulate(ahead, input_) - form.simulate(behind, input_)) / (2.0 * step)
    return rows
