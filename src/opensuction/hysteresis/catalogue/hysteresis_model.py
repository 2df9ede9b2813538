"""Common interface of the hysteresis models, whatever their records look like.

Identification, comparison and the conformance suite use models only through this. Records have
the type `Any` here; each model's own module types them exactly, and is what the control core uses.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from opensuction.hysteresis.bank.play_lines import PlayLines
from opensuction.hysteresis.play import InverseMove, ModelState
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array

Record = Any
"""A model's NamedTuple of parameters."""

MOST_SHOWN = 8
"""Values that a message shows."""

STEEPEST = 4.0
"""Usual bound on every gain, over output range by input range [assumed]: published ones of backlash
are below 2. Gains of friction are above it, and searches go on beyond."""

SHORTEST, LONGEST = 1e-3, 20.0
"""Usual bounds on the travel that forgets a reversal, over the input's range. Below, most
recordings do not show it; above, the hysteresis is a straight line, and only products and quotients
of parameters show: a flat ridge of the sum of squares, so that no search goes on there."""

BRIEFEST = 1e-5
"""Limit of that travel where a fit ends at `SHORTEST`: stiff friction, densely sampled."""


class ModelParameter(NamedTuple):
    """One field of a model's record, for tables."""

    name: str
    """Where the field is an array, one value for each of its entries."""
    symbol: str
    """In the paper, or in the literature where the paper has none."""
    unit: str
    """Where input and output are in mm; a recording in degrees has degrees instead."""
    meaning: str


class FitParameter(NamedTuple):
    """One number that an identification finds and reports."""

    name: str
    unit: str
    """{in} and {out} stand for the units of the recording."""
    logarithmic: bool = False
    """Whether it spans decades and is searched by its logarithm; then it is above 0."""


def write_unit(unit: str, input_unit: str, output_unit: str) -> str:
    """The unit of a `FitParameter` with those of a recording in place of {in} and {out}."""
    return unit.replace("{in}", input_unit).replace("{out}", output_unit)


class Ranges(NamedTuple):
    """Ranges of the input and the output of a recording."""

    input_low_mm: float
    input_high_mm: float
    output_low_mm: float
    output_high_mm: float
    output_mean_mm: float

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


def ranges_of(input_mm: Array, output_mm: Array) -> Ranges:
    """Ranges of a recording. Raises InputError where one of the two does not move."""
    ranges = Ranges(
        input_low_mm=float(input_mm.min()),
        input_high_mm=float(input_mm.max()),
        output_low_mm=float(output_mm.min()),
        output_high_mm=float(output_mm.max()),
        output_mean_mm=float(output_mm.mean()),
    )
    for name, width in (("input", ranges.input_mm), ("output", ranges.output_mm)):
        if not width > 0.0:
            raise InputError(f"{name}: constant or not a number, should move")
    return ranges


class VectorForm(NamedTuple):
    """Form for the identification of a model that is not linear in its parameters: one vector.

    A vector has one order, one box of bounds and one of limits, so any search, derivative or
    interval works on any model. Its last number is the memory at the first sample. A straight
    line's part of it is called ``slope`` and ``offset``.
    """

    parameters: tuple[FitParameter, ...]
    bounds: Callable[[Ranges], Array]
    """Usual lowest and highest values for a recording, shape (p, 2): where searches that draw lots
    begin. No limit."""
    limits: Callable[[Ranges], Array]
    """Ends of what any search goes to, shape (p, 2); infinite where it is free."""
    record: Callable[[Array], Record]
    """The model's record for a vector, shape (p,)."""
    simulate: Callable[[Array, Array], Array]
    """Output for a vector, shape (p,), and a whole record of inputs, shape (n,)."""


class LinearForm(NamedTuple):
    """Form for identifying a model linear in its factors: ``simulate = basis @ factors``."""

    initial_guesses: Callable[[Ranges], list[Record]]
    """Records with the elements that suit a recording and factors of 0, from coarse to fine."""
    penalties: tuple[float, ...]
    """Ridges to try, as shares of a column's variance."""
    nonnegative: bool
    """Whether the factors, but for the offset, are held at 0 or above, so that the output never
    moves the wrong way."""
    basis: Callable[[Record, Array, Any], Array]
    """Columns for a record of inputs and the memory at the first of them, shape (n, factors)."""
    degree: Callable[[Record], int]
    """The last columns are the powers 0 to ``degree`` of the place in the input's range."""
    with_factors: Callable[[Record, Array], Record]
    """The record with other factors; its elements are kept."""
    parameters: Callable[[Record, Ranges], list[FitParameter]]
    """Names and units of the factors."""
    wide_guesses: Callable[[Ranges], list[Record]] | None = None
    """Records for loops that none of the others is wide enough for; None where these reach all."""


def name_element(kind: str, length_mm: float, ranges: Ranges) -> FitParameter:
    """The factor of an element, named by its length in percent of the input's range."""
    return FitParameter(f"{kind}_{100.0 * length_mm / ranges.input_mm:.4g}_percent", "{out}/{in}")


class HysteresisModel(NamedTuple):
    """A model of the catalogue. Functions take the model's record first."""

    name: str
    title: str
    summary: str
    """What it is made of, in a line."""
    source: str
    cannot: str
    """What it cannot represent."""
    inverse: str
    """How it is inverted, in words."""
    parameters: tuple[ModelParameter, ...]
    """The fields of the record that a recording determines."""
    form: VectorForm | LinearForm | None
    """How any recording identifies it; None for a model that only known excitations do."""
    memory: Callable[[Record, float, float], Any]
    """Memory at an input for a past of one number: +1 advanced, -1 retracted, 0 relaxed."""
    step: Callable[[Record, ModelState, float], ModelState]
    """One monotone move of the input; the old state is kept."""
    output_mm: Callable[[Record, ModelState], float]
    simulate: Callable[[Record, Array, Any], Array]
    """A whole record of inputs from the memory at the first."""
    inverse_step: Callable[[Record, ModelState, float], InverseMove]
    """Move of the input that brings the output to a target."""
    is_well_posed: Callable[[Record], bool]
    """Whether the record means anything: output unique and bounded for a bounded input."""
    is_monotone: Callable[[Record], bool]
    """Whether the output follows the input at once and the right way, also after a reversal, so
    that a continuous inverse exists."""
    lines: Callable[[Record], PlayLines] | None = None
    """The form in which `model-preview` drives a head by it; None where it has none."""
    undriven: str = ""
    """Why no compensator takes it, whatever its parameters; empty where one does."""
    has_inverse: bool = True
    """Whether `inverse_step` ever finds a move; a model that only predicts has none."""


def start(
    model: HysteresisModel, record: Record, head_mm: float, memory_ratio: float
) -> ModelState:
    """State at an input after a past of one number: +1 advanced, -1 retracted, 0 relaxed."""
    return ModelState(head_mm, model.memory(record, head_mm, memory_ratio))


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
        fields = np.concatenate([np.ravel(field) for field in record])
        values = ", ".join(f"{value:.6g}" for value in fields[:MOST_SHOWN])
        raise InputError(f"{model.name}: parameters {values} are not well posed")
    return model.simulate(record, inputs, model.memory(record, float(inputs[0]), memory_ratio))


def invert(
    model: HysteresisModel, record: Record, state: ModelState, targets_mm: ArrayLike
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
