"""What every hysteresis model offers under one set of names, whatever its record looks like.

Identification, comparison and the conformance suite know models only through this. Here ends
the exact typing of records: each model's own module keeps it, and is what the control core uses.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from opensuction.hysteresis.inverse_move import InverseMove
from opensuction.kernel.errors import InputError

Array = NDArray[np.float64]

Record = Any
"""A model's NamedTuple of parameters."""

MOST_SHOWN = 8
"""Values that a message shows."""


STEEPEST = 4.0
"""Bound on every gain, over output range by input range [assumed]: published ones are below 2."""


class ModelParameter(NamedTuple):
    """One parameter of a model, for tables and messages."""

    name: str
    """Field of the record; where it is an array, one value for each of its entries."""
    symbol: str
    """In the paper, or in the literature where the paper has none."""
    unit: str
    """Where input and output are in mm; a recording in degrees has degrees instead."""
    meaning: str


class Ranges(NamedTuple):
    """Where the input and the output of a recording lie."""

    input_low_mm: float
    input_high_mm: float
    output_low_mm: float
    output_high_mm: float

    @property
    def input_mm(self) -> float:
        """Width of the input's range."""
        return self.input_high_mm - self.input_low_mm

    @property
    def output_mm(self) -> float:
        """Width of the output's range."""
        return self.output_high_mm - self.output_low_mm

    @property
    def gain(self) -> float:
        """Output range over input range."""
        return self.output_mm / self.input_mm

    @property
    def offset_mm(self) -> float:
        """Output at input 0 on the line from the low ends with that gain."""
        return self.output_low_mm - self.gain * self.input_low_mm


def ranges_of(input_mm: Array, output_mm: Array) -> Ranges:
    """Ranges of a recording. Raises InputError where one of the two does not move."""
    ends = [float(end) for row in (input_mm, output_mm) for end in (row.min(), row.max())]
    ranges = Ranges(*ends)
    for name, width in (("input", ranges.input_mm), ("output", ranges.output_mm)):
        if not width > 0.0:
            raise InputError(f"{name}: constant or not a number, should move")
    return ranges


class Place(NamedTuple):
    """State of any model: where the input is, and the memory there."""

    head_mm: float
    memory: Any
    """A float, or an array; made by `HysteresisModel.start`."""


class HysteresisModel(NamedTuple):
    """A model of the catalogue. Functions take the model's record first."""

    name: str
    title: str
    source: str
    cannot: str
    """What it cannot represent."""
    inverse: str
    """How it is inverted, in words."""
    parameters: tuple[ModelParameter, ...]
    """The fields that a recording determines, in the order of `values`."""
    linear: bool
    """Whether the output is linear in them, so that `basis` exists."""
    rate_independent: bool
    """Whether speed plays no part."""
    unfitted: Callable[[Ranges], Record]
    """A record to begin a fit with: the right scales, and parameters in the middle or 0."""
    bounds: Callable[[Record, Ranges], Array]
    """Lowest and highest sensible values, shape (2, values); infinite where there is no limit.
    Equal ones are fixed."""
    values: Callable[[Record], Array]
    """The parameters in one row, arrays laid out."""
    with_values: Callable[[Record, Array], Record]
    """The record with other parameters; what is no parameter, such as a grid, is kept."""
    memory: Callable[[Record, float, float], Any]
    """Memory at an input for a past of one number: +1 advanced, -1 retracted, 0 relaxed."""
    step: Callable[[Record, Place, float], Place]
    """One monotone move of the input; the old state is kept."""
    output_mm: Callable[[Record, Place], float]
    simulate: Callable[[Record, Array, Any], Array]
    """A whole record of inputs from the memory at the first."""
    basis: Callable[[Record, Array, Any], Array] | None
    """For linear models the matrix, shape (n, values), with ``simulate = basis @ values``."""
    inverse_step: Callable[[Record, Place, float], InverseMove]
    """Move of the input that brings the output to a target."""
    is_well_posed: Callable[[Record], bool]
    """Whether the record means anything: output unique and bounded for a bounded input."""
    is_monotone: Callable[[Record], bool]
    """Whether the output follows the input at once and the right way, also after a reversal, so
    that a continuous inverse exists."""


def scalar_values(record: Record) -> Array:
    """The parameters of a record of plain numbers."""
    return np.array(record, dtype=np.float64)


def scalar_record(record_type: Callable[..., Record]) -> Callable[[Record, Array], Record]:
    """``with_values`` for a record of plain numbers."""
    return lambda _record, values: record_type(*(float(value) for value in values))


def offset_bounds_mm(ranges: Ranges) -> tuple[float, float]:
    """Output where the input is 0, for any gain up to the steepest."""
    farthest = max(abs(ranges.input_low_mm), abs(ranges.input_high_mm))
    swing = STEEPEST * ranges.gain * (farthest + ranges.input_mm)
    return ranges.output_low_mm - swing, ranges.output_high_mm + swing


def bound_rows(*bounds: tuple[float, float]) -> Array:
    """Pairs of lowest and highest value as `HysteresisModel.bounds` wants them."""
    return np.array(bounds, dtype=np.float64).T


def start(model: HysteresisModel, record: Record, head_mm: float, memory_ratio: float) -> Place:
    """State at an input after a past of one number: +1 advanced, -1 retracted, 0 relaxed."""
    return Place(head_mm, model.memory(record, head_mm, memory_ratio))


def simulate(
    model: HysteresisModel, record: Record, input_mm: ArrayLike, memory_ratio: float
) -> Array:
    """Outputs for a whole record of inputs from outside, checked.

    input_mm: shape (n,), at least one, finite. memory_ratio: the past before the first sample,
    from -1.0 (after a long retract) to +1.0 (after a long advance). Returns mm, shape (n,).
    Raises InputError for anything else, and for a record that is not well posed.
    """
    inputs = np.ascontiguousarray(input_mm, dtype=np.float64)
    if inputs.ndim != 1 or inputs.size == 0:
        raise InputError(f"input: shape {inputs.shape}, should be one row of numbers")
    bad = np.flatnonzero(~np.isfinite(inputs))
    if bad.size:
        raise InputError(
            f"input: sample {bad[0]} is {inputs[bad[0]]}, should be a finite number "
            f"({bad.size} such of {inputs.size})"
        )
    if not -1.0 <= memory_ratio <= 1.0:
        raise InputError(f"memory_ratio: {memory_ratio}, should be from -1 to 1")
    if not model.is_well_posed(record):
        values = ", ".join(f"{value:.6g}" for value in model.values(record)[:MOST_SHOWN])
        raise InputError(f"{model.name}: parameters {values} are not well posed")
    return model.simulate(record, inputs, model.memory(record, float(inputs[0]), memory_ratio))


def invert(
    model: HysteresisModel, record: Record, state: Place, targets_mm: ArrayLike
) -> tuple[Array, NDArray[np.bool_]]:
    """Inputs that make the output run through a row of targets, each from the one before.

    targets_mm: shape (n,). Returns the inputs in mm and whether each target was reached, both of
    shape (n,). Where a model is not monotone some targets are reached only by a jump of the input,
    or not at all: look at both.
    """
    targets = np.asarray(targets_mm, dtype=np.float64)
    inputs_mm, reached = np.empty(targets.size), np.empty(targets.size, dtype=np.bool_)
    for k in range(targets.size):
        found = model.inverse_step(record, state, float(targets[k]))
        state = model.step(record, state, found.move_mm)
        inputs_mm[k], reached[k] = state.head_mm, found.reached
    return inputs_mm, reached
