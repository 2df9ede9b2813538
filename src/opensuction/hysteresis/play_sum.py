"""The Prandtl-Ishlinskii model with its plays as plain numbers: the form in which a tick has it.

Model and numbers are those of `hysteresis.prandtl_ishlinskii`, bit for bit; there the plays are an
array of any length. A record that is handed on each millisecond holds none, for every hand would
count a reference to it. So there is room for sixteen plays in a tuple; a spare one has threshold
and weight 0: it stands where the head is and adds nothing to any sum. The loops are written out for
the compiled core: see `kernel.codegen.unrolled`.
"""

import math
from collections.abc import Iterable
from typing import Annotated, NamedTuple

import numpy as np
from annotated_types import Len

from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii, bent_mm, straight_mm
from opensuction.kernel.codegen.unrolled import unrolled
from opensuction.kernel.compiled import compiled
from opensuction.kernel.errors import InputError

PLAYS = 16
"""Room for so many: 240 machines of the twin were identified with 7 to 13."""
ENGAGED_MM = 1e-9
"""A play counts as engaged once so little of its slot is left."""
Sixteen = Annotated[tuple[float, ...], Len(PLAYS, PLAYS)]
"""A number for each play."""


class PlaySum(NamedTuple):
    """Parameters of the model: see `PrandtlIshlinskii`."""

    thresholds_mm: Sixteen
    weights: Sixteen
    slope: float
    offset_mm: float
    curvature_per_mm: float


def padded(values: Iterable[float]) -> Sixteen:
    """A number for each play, 0 for the spare ones."""
    found = tuple(float(value) for value in values)
    return found + (0.0,) * (PLAYS - len(found))


NONE_MM: Sixteen = padded(())
"""Positions of plays that nobody uses."""
NO_PLAYS = PlaySum(NONE_MM, NONE_MM, 0.0, 0.0, 0.0)


def bundle(model: PrandtlIshlinskii) -> PlaySum:
    """A model in this form. Raises InputError for more than `PLAYS` plays."""
    if model.weights.size > PLAYS:
        raise InputError(
            f"the compensation has {model.weights.size} plays, should have at most {PLAYS}: "
            "join neighbouring thresholds"
        )
    return PlaySum(padded(model.thresholds_mm), padded(model.weights), *model[2:])


def unbundle(model: PlaySum) -> PrandtlIshlinskii:
    """The model with its plays as arrays, the spare ones among them."""
    return PrandtlIshlinskii(np.array(model.thresholds_mm), np.array(model.weights), *model[2:])


@unrolled
def retracted_positions_mm(model: PlaySum, head_mm: float) -> Sixteen:
    """Positions of the plays after a long retract to a head position."""
    return tuple(head_mm + model.thresholds_mm[j] for j in range(PLAYS))


@unrolled
def step(model: PlaySum, positions_mm: Sixteen, head_mm: float) -> Sixteen:
    """Positions of the plays once the head has moved monotonically to a position; exact."""
    return tuple(
        min(
            max(positions_mm[j], head_mm - model.thresholds_mm[j]), head_mm + model.thresholds_mm[j]
        )
        for j in range(PLAYS)
    )


@unrolled
def _weigh(total: float, weights: Sixteen, values: Sixteen) -> float:
    """A sum, and behind it each value times its weight."""
    for j in range(PLAYS):
        total += weights[j] * values[j]
    return total


@unrolled
def _left_mm(model: PlaySum, positions_mm: Sixteen, head_mm: float, direction: float) -> Sixteen:
    """Rest of each slot for a head that goes on in a direction."""
    return tuple(
        model.thresholds_mm[j] + direction * (positions_mm[j] - head_mm) for j in range(PLAYS)
    )


@unrolled
def _engage(model: PlaySum, left_mm: Sixteen, needed_mm: float) -> tuple[float, float]:
    """Slope with every play that engages before v is gained, and ``needed_mm`` with theirs."""
    slope = model.slope
    for j in range(PLAYS):
        if not left_mm[j] * slope < needed_mm:
            return slope, needed_mm
        slope += model.weights[j]
        needed_mm += model.weights[j] * left_mm[j]
    return slope, needed_mm


@unrolled
def _slope(model: PlaySum, left_mm: Sixteen, least_mm: float) -> float:
    """Slope with every play whose slot has no more left than this."""
    slope = model.slope
    for j in range(PLAYS):
        slope += model.weights[j] if left_mm[j] <= least_mm else 0.0
    return slope


@compiled
def _inner_mm(model: PlaySum, positions_mm: Sixteen, head_mm: float) -> float:
    """The sum v, before the curvature."""
    return _weigh(model.slope * head_mm, model.weights, positions_mm)


@compiled
def output_mm(model: PlaySum, positions_mm: Sixteen, head_mm: float) -> float:
    """Tip position for a head position and positions of the plays."""
    return bent_mm(model, _inner_mm(model, positions_mm, head_mm))


@compiled
def advance_slope(model: PlaySum, positions_mm: Sixteen, head_mm: float, direction: float) -> float:
    """Slope dy/dx when the head moves on from here in one direction (+1.0 carina, -1.0 back)."""
    slope = _slope(model, _left_mm(model, positions_mm, head_mm, direction), ENGAGED_MM)
    inner_mm = _inner_mm(model, positions_mm, head_mm)
    return slope * (1.0 + 2.0 * model.curvature_per_mm * inner_mm)


@compiled
def inverse_step(model: PlaySum, positions_mm: Sixteen, head_mm: float, target_mm: float) -> float:
    """Head move that brings the tip to a target: as `prandtl_ishlinskii.inverse_step`."""
    gain_mm = straight_mm(model, target_mm) - _inner_mm(model, positions_mm, head_mm)
    if gain_mm == 0.0:
        return 0.0
    direction = math.copysign(1.0, gain_mm)
    left_mm = _left_mm(model, positions_mm, head_mm, direction)
    slope, needed_mm = _engage(model, left_mm, abs(gain_mm))
    travel_mm = needed_mm / slope if slope > 0.0 else 0.0
    return direction * travel_mm if math.isfinite(travel_mm) else 0.0
