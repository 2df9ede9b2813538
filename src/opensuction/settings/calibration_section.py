"""Sections of the parameter file that only a calibration of the machine itself fills.

A recording of head and tip gives the modified Dahl model; the run on the machine adds the plays,
the curves of either direction, which machine it was and how a second run confirmed it. A
compensator drives the head by these numbers, so each is checked before it may.
"""

from collections.abc import Callable
from itertools import pairwise
from typing import Annotated, NamedTuple, TypeVar

import numpy as np
from annotated_types import Ge, Gt

from opensuction.control.lookup_table import Curves
from opensuction.hysteresis import prandtl_ishlinskii
from opensuction.hysteresis.play_sum import PLAYS
from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii
from opensuction.kernel.errors import InputError

Section = TypeVar("Section", bound=tuple[object, ...])

MOST_ENTRIES = 1000
"""Of a curve; the estimator makes 40."""


class CalibratedMachine(NamedTuple):
    """The machine that was calibrated."""

    name: str
    """Name of a preset or path of a machine file, as a person gave it."""
    preset: str
    catheter_mm: Annotated[float, Gt(0)]
    """Outer diameter of the catheter in it."""
    seed: Annotated[int, Ge(0)]
    """Which machine of the kind was drawn."""


class Validation(NamedTuple):
    """Errors of a second run, which nothing was fitted to; all root mean square."""

    model_rmse_mm: Annotated[float, Ge(0)]
    plays_rmse_mm: Annotated[float, Ge(0)]
    repeatability_mm: Annotated[float, Ge(0)]
    """Tip of the second run less tip of the first, at the same instants."""
    servo_rmse_v: Annotated[float, Ge(0)]
    """Voltage that the feedforward leaves unexplained in the first run."""


class Plays(NamedTuple):
    """`PrandtlIshlinskii` as lists."""

    thresholds_mm: list[float]
    weights: list[float]
    slope: Annotated[float, Ge(0)]
    offset_mm: float
    curvature_per_mm: float


class Branches(NamedTuple):
    """`Curves` as lists."""

    first_mm: float
    spacing_mm: Annotated[float, Gt(0)]
    inwards_mm: list[float]
    outwards_mm: list[float]


class Measured(NamedTuple):
    """Sections of a calibrated machine; a file has all of them or none."""

    machine: CalibratedMachine
    validation: Validation
    plays: Plays
    gap_width: Branches
    lookup_table: Branches


def write_section(section: Callable[..., Section], record: PrandtlIshlinskii | Curves) -> Section:
    """`Plays` or `Branches` of the record of the same fields."""
    return section(*(np.asarray(value).tolist() for value in record))


def read_plays(section: Plays, lowest_mm: float, highest_mm: float) -> PrandtlIshlinskii:
    """The model of a section. lowest_mm, highest_mm: tip positions that it must be invertible for.

    Raises InputError for lists of different length, thresholds that do not rise from above 0,
    negative weights, and a model without a continuous inverse.
    """
    thresholds, weights = section.thresholds_mm, section.weights
    if len(thresholds) != len(weights) or not 1 <= len(weights) <= PLAYS:
        raise InputError(
            f"plays has {len(thresholds)} thresholds_mm and {len(weights)} weights, should have "
            f"as many of one as of the other, 1 to {PLAYS}"
        )
    if not _rises([0.0, *thresholds]):
        raise InputError("plays.thresholds_mm should rise from each to the next, from above 0")
    if min(weights) < 0.0:
        raise InputError(f"plays.weights holds {min(weights):g}, none should be below 0")
    model = PrandtlIshlinskii(
        thresholds_mm=np.array(thresholds, dtype=np.float64),
        weights=np.array(weights, dtype=np.float64),
        slope=section.slope,
        offset_mm=section.offset_mm,
        curvature_per_mm=section.curvature_per_mm,
    )
    total = float(prandtl_ishlinskii.total_slope(model))
    if not 0.0 < total < np.inf:
        raise InputError(
            f"plays.slope and plays.weights come to {total:g} together, should be a number above 0"
        )
    if not prandtl_ishlinskii.is_well_posed(model, highest_mm, lowest_mm):
        raise InputError(
            f"plays.curvature_per_mm is {section.curvature_per_mm:g}, so that the gain would end "
            f"within the recorded depths, {lowest_mm:.1f} to {highest_mm:.1f} mm"
        )
    return model


def read_curves(section: Branches, name: str) -> Curves:
    """The curves of a section. name: of the section, for messages.

    Raises InputError for lists of different or impossible length, heads that do not rise with
    depth, and a way in that lies behind the way out.
    """
    inwards, outwards = section.inwards_mm, section.outwards_mm
    if len(inwards) != len(outwards) or not 2 <= len(inwards) <= MOST_ENTRIES:
        raise InputError(
            f"{name} has {len(inwards)} entries inwards_mm and {len(outwards)} outwards_mm, should "
            f"have as many of one as of the other, 2 to {MOST_ENTRIES}"
        )
    for key, heads in (("inwards_mm", inwards), ("outwards_mm", outwards)):
        if not _rises(heads):
            raise InputError(f"{name}.{key} should rise from each entry to the next")
    if any(inner < outer for inner, outer in zip(inwards, outwards, strict=True)):
        raise InputError(f"{name}.inwards_mm should nowhere be below {name}.outwards_mm")
    return Curves(
        first_mm=section.first_mm,
        spacing_mm=section.spacing_mm,
        inwards_mm=np.array(inwards, dtype=np.float64),
        outwards_mm=np.array(outwards, dtype=np.float64),
    )


def _rises(values: list[float]) -> bool:
    return all(later > earlier for earlier, later in pairwise(values))
