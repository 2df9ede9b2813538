"""A fitted model of any kind, with its intervals: what the workbench scores and compares."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from opensuction.identification.estimator import linear
from opensuction.identification.estimator.superposition import Superposition
from opensuction.identification.family import Family, jacobian
from opensuction.identification.judgement import diagnosis
from opensuction.identification.judgement.confidence import spread

Array = NDArray[np.float64]

NOT_DETERMINED = (
    "Not determined: the recording fits equally well with a longer or shorter memory (range too "
    "small, or no hysteresis to be seen). The curve can be used, the parameters mean little."
)
NOT_INVERTIBLE = (
    "Not invertible: right after a reversal the model's output moves the wrong way, so that its "
    "inverse jumps. Cross the gap explicitly, or use a model with weights at least 0."
)

GAP = (
    "Has a gap: right after a reversal the model's output stands still, so that its inverse jumps. "
    "Cross the gap explicitly."
)


class Bounded(NamedTuple):
    """A parameter with its 95 % interval; {in} and {out} stand for the recording's units."""

    name: str
    value: float
    unit: str
    low: float
    high: float


class Candidate(NamedTuple):
    """A fitted model."""

    estimates: tuple[Bounded, ...]
    simulate: Callable[[Array], Array]
    """Output for a record that begins as the fitted one did."""
    cross_validation: float
    """Root mean square error of blocks left out, in units of the output."""
    well_posed: bool
    warnings: tuple[str, ...]


def of_superposition(found: Superposition) -> Candidate:
    """A candidate without intervals: weights that were pulled to 0 or held there have none."""
    return Candidate(
        estimates=tuple(
            Bounded(name, value, unit, math.nan, math.nan)
            for name, (value, unit) in found.weights.items()
        ),
        simulate=found.simulate,
        cross_validation=found.cross_validation,
        well_posed=found.well_posed,
        warnings=() if found.well_posed else (GAP if found.nonnegative else NOT_INVERTIBLE,),
    )


def of_vector(
    family: Family, vector: Array, determined: bool, input_: Array, output: Array
) -> Candidate:
    """A candidate of a nonlinear family with intervals by `interval.spread`.

    determined: whether the fit found its optimum between its bounds. Arrays of the fitted samples.
    """
    rest = output - family.simulate(vector, input_)
    rows = jacobian(family, vector, input_, family.box(input_, output))
    moving = np.flatnonzero(np.any(rows != 0.0, axis=1))
    half_widths = np.full(vector.size, math.nan)
    half_widths[moving] = spread(rows[moving], rest).half_widths
    static = [
        place
        for place, parameter in enumerate(family.parameters)
        if not parameter.name.startswith("initial")
    ]
    well_posed = family.is_well_posed(vector)
    return Candidate(
        estimates=tuple(
            Bounded(parameter.name, value, parameter.unit, value - half, value + half)
            for parameter, value, half in zip(
                family.parameters, vector.tolist(), half_widths.tolist(), strict=True
            )
        ),
        simulate=lambda record: family.simulate(vector, record),
        cross_validation=linear.linearised(rows[static], rest),
        well_posed=well_posed,
        warnings=_warnings(family, vector, rows, half_widths, determined, well_posed),
    )


def _warnings(
    family: Family,
    vector: Array,
    rows: Array,
    half_widths: Array,
    determined: bool,
    well_posed: bool,
) -> tuple[str, ...]:
    """What the parameters of a fit cannot carry."""
    said = [] if determined else [NOT_DETERMINED]
    worst = diagnosis.condition(rows)
    if worst > diagnosis.WORST_CONDITION:
        said.append(
            f"Ill-conditioned: parameters trade against one another (condition {worst:.1e}); "
            "record larger and more varied strokes."
        )
    vague = [
        parameter.name
        for parameter, value, half in zip(family.parameters, vector, half_widths, strict=True)
        if half > abs(value) and not parameter.name.startswith(("initial", "offset"))
    ]
    if vague:
        said.append(f"Uncertain: the interval of {', '.join(vague)} includes 0.")
    at_bound = [
        parameter.name
        for parameter, row in zip(family.parameters, rows, strict=True)
        if not np.any(row != 0.0)
    ]
    if at_bound:
        said.append(f"At its bound, so without an interval: {', '.join(at_bound)}.")
    if not well_posed:
        said.append(NOT_INVERTIBLE)
    return tuple(said)
