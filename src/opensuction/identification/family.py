"""The models that are not linear in their parameters, each as a vector of numbers.

A vector has one order, one set of names and units, one box to search in; so any search, derivative
or interval works on any model. Units are the recording's: {in} and {out} stand for them.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from opensuction.hysteresis import bouc_wen, dahl, modified_dahl
from opensuction.hysteresis.bouc_wen import BoucWen
from opensuction.hysteresis.dahl import Dahl
from opensuction.hysteresis.modified_dahl import ModifiedDahl

Array = NDArray[np.float64]

SHORTEST = 1e-3
"""Shortest length over which a reversal is forgotten, as a share of the input's range."""

LONGEST = 20.0
"""Longest such length: beyond, the hysteresis is a straight line."""

HIGHEST_EXPONENT = 10.0
"""Largest Bouc-Wen exponent: a corner as sharp as a play's within a hundredth of its gap."""

DIFFERENCE = 1e-5
"""Step of the central differences, as a share of the parameter."""


class Parameter(NamedTuple):
    """One place of the vector."""

    name: str
    unit: str
    """{in} and {out} stand for the units of the recording."""
    logarithmic: bool
    """Whether it spans decades and is searched by its logarithm; then it is above 0."""


class Family(NamedTuple):
    """A nonlinear model as a function of a vector."""

    parameters: tuple[Parameter, ...]
    simulate: Callable[[Array, Array], Array]
    """Output for a vector, shape (p,), and a record of inputs, shape (n,)."""
    box: Callable[[Array, Array], Array]
    """Bounds for a recording (input, output), shape (p, 2)."""
    is_well_posed: Callable[[Array], bool]
    """Whether the model has a continuous inverse."""


def _modified_dahl(vector: Array) -> ModifiedDahl:
    return ModifiedDahl(*(float(value) for value in vector[:4]))


def _simulate_modified_dahl(vector: Array, input_: Array) -> Array:
    return modified_dahl.simulate(_modified_dahl(vector), input_, float(vector[4]))


def _modified_dahl_box(input_: Array, output: Array) -> Array:
    width, height = float(np.ptp(input_)), float(np.ptp(output))
    gain = height / width
    reach = abs(float(output.mean())) + 4.0 * gain * float(np.max(np.abs(input_)))
    return np.array(
        [
            (0.1 * gain, 4.0 * gain),
            (0.0, 4.0 * gain),
            (1.0 / (LONGEST * width), 1.0 / (SHORTEST * width)),
            (-reach, reach),
            (-height, height),
        ]
    )


def _dahl(vector: Array) -> Dahl:
    return Dahl(stiffness_n_per_mm=float(vector[0]), coulomb_n=float(vector[1]))


def _simulate_dahl(vector: Array, input_: Array) -> Array:
    model = _dahl(vector)
    start = float(vector[3]) / model.stiffness_n_per_mm
    output: Array = dahl.simulate(model, input_, start) + vector[2]
    return output


def _dahl_box(input_: Array, output: Array) -> Array:
    width, height = float(np.ptp(input_)), float(np.ptp(output))
    low, high = float(output.min()), float(output.max())
    return np.array(
        [
            (0.1 * height / width, 2.0 * height / (SHORTEST * width)),
            (0.1 * height, 2.0 * LONGEST * height),
            (low - height, high + height),
            (-height, height),
        ]
    )


def _bouc_wen(vector: Array) -> BoucWen:
    dissipation, bend, exponent, slope, memory_gain, offset_mm = (
        float(value) for value in vector[:6]
    )
    return BoucWen(1.0, dissipation, bend, exponent, slope, memory_gain, offset_mm)


def bouc_wen_vector(
    length: float, bend_ratio: float, exponent: float, linear: tuple[float, float, float, float]
) -> Array:
    """Vector of a Bouc-Wen model (A = 1) from numbers of a known size.

    length: saturation of the memory, in units of the input. bend_ratio: D / (B + D), below 1.
    linear: slope, memory gain, offset, memory at the first sample.
    """
    both = length**-exponent
    dissipation, bend = (1.0 - bend_ratio) * both, bend_ratio * both
    return np.array([dissipation, bend, exponent, *linear])


def _simulate_bouc_wen(vector: Array, input_: Array) -> Array:
    return bouc_wen.simulate(_bouc_wen(vector), input_, float(vector[6]))


def _natural_bouc_wen(natural: Array) -> Array:
    """`bouc_wen_vector` of (length, bend ratio, exponent, slope, memory gain, offset, start)."""
    length, bend_ratio, exponent, slope, memory_gain, offset, start = (float(x) for x in natural)
    return bouc_wen_vector(
        length, bend_ratio, exponent, (slope, memory_gain, offset, start * length)
    )


def _bouc_wen_box(input_: Array, output: Array) -> Array:
    line = _modified_dahl_box(input_, output)
    width, gain = float(np.ptp(input_)), float(np.ptp(output)) / float(np.ptp(input_))
    return np.array(
        [
            (SHORTEST * width, LONGEST * width),
            (-3.0, 0.95),
            (1.0, HIGHEST_EXPONENT),
            tuple(line[0]),
            (-4.0 * gain, 4.0 * gain),
            tuple(line[3]),
            (-1.0, 1.0),
        ]
    )


FAMILIES = {
    "modified-dahl": Family(
        parameters=(
            Parameter("slope", "{out}/{in}", logarithmic=False),
            Parameter("velocity_gain", "{out}/{in}", logarithmic=False),
            Parameter("decay", "1/{in}", logarithmic=True),
            Parameter("offset", "{out}", logarithmic=False),
            Parameter("initial_lag", "{out}", logarithmic=False),
        ),
        simulate=_simulate_modified_dahl,
        box=_modified_dahl_box,
        is_well_posed=lambda vector: bool(modified_dahl.is_monotone(_modified_dahl(vector))),
    ),
    "dahl": Family(
        parameters=(
            Parameter("stiffness", "{out}/{in}", logarithmic=True),
            Parameter("limit", "{out}", logarithmic=True),
            Parameter("offset", "{out}", logarithmic=False),
            Parameter("initial_output", "{out}", logarithmic=False),
        ),
        simulate=_simulate_dahl,
        box=_dahl_box,
        is_well_posed=lambda vector: bool(dahl.is_monotone(_dahl(vector))),
    ),
    "bouc-wen": Family(
        parameters=(
            Parameter("memory_length", "{in}", logarithmic=True),
            Parameter("bend_ratio", "1", logarithmic=False),
            Parameter("exponent", "1", logarithmic=False),
            Parameter("slope", "{out}/{in}", logarithmic=False),
            Parameter("memory_gain", "{out}/{in}", logarithmic=False),
            Parameter("offset", "{out}", logarithmic=False),
            Parameter("initial_memory_ratio", "1", logarithmic=False),
        ),
        simulate=lambda vector, input_: _simulate_bouc_wen(_natural_bouc_wen(vector), input_),
        box=_bouc_wen_box,
        is_well_posed=lambda vector: bool(
            bouc_wen.is_monotone(_bouc_wen(_natural_bouc_wen(vector)))
        ),
    ),
}
"""Bouc-Wen is written with A = 1 (the scale of its memory is free), and by the length over which
it forgets, (B + D)^(-1/m), and D / (B + D), which unlike B and D keep their size when m changes."""


def squares(family: Family, vector: Array, input_: Array, output: Array) -> float:
    """Sum of squares of a vector; infinite where the model has no answer."""
    rest = family.simulate(vector, input_) - output
    total = float(rest @ rest)
    return total if math.isfinite(total) else math.inf


def jacobian(family: Family, vector: Array, input_: Array, box: Array) -> Array:
    """Change of the output with each parameter, central differences inside the box.

    Returns shape (p, n). A parameter at its bound is taken as given: a row of zeros.
    """
    rows = np.zeros((vector.size, input_.size))
    for place, (low, high) in enumerate(box):
        step = DIFFERENCE * max(abs(float(vector[place])), 1e-3 * (high - low))
        if vector[place] - step < low or vector[place] + step > high:
            continue
        ahead, behind = vector.copy(), vector.copy()
        ahead[place] += step
        behind[place] -= step
        rows[place] = (family.simulate(ahead, input_) - family.simulate(behind, input_)) / (
            2.0 * step
        )
    return rows
