"""The Prandtl-Ishlinskii model: plays of known widths side by side, and its exact inverse.

``v = c*x + sum_j w_j*p_j(x; r_j)`` with plays p_j of half width r_j (the threshold) and weights
w_j >= 0; the tip is ``y = y_0 + v + kappa*v*v``, where the mild curvature kappa stands for a gain
that changes with depth. Along a travel in one direction v is a convex polygon of the travel: each
play adds its weight to the slope once its slot is used up. Its inverse is therefore exact, in as
many steps as it has corners.

What it cannot represent: creep and anything else that depends on time or speed; loops whose shape
changes with depth; loops that are not symmetric under reversal, but for the curvature.
Source: [Krasnoselskii-1989]; [Kuhnen-2003] for weights on a threshold grid and their inverse.
"""

import math
from typing import NamedTuple, Protocol

import numpy as np

from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import Array


class Curved(Protocol):
    """Parameters that both forms of the model have besides their plays."""

    @property
    def offset_mm(self) -> float:
        """y_0."""

    @property
    def curvature_per_mm(self) -> float:
        """Kappa."""


class PrandtlIshlinskii(NamedTuple):
    """Parameters of the model, head_mm to tip_mm."""

    thresholds_mm: Array
    """r: half the full width of each play, ascending, above 0, shape (n,)."""
    weights: Array
    """w: mm of tip for each mm of a play, >= 0, shape (n,)."""
    slope: float
    """c: weight of the head itself, >= 0 (a play of threshold 0)."""
    offset_mm: float
    """y_0: tip position for v = 0."""
    curvature_per_mm: float
    """kappa: change of the gain with depth; 0 is the classical model."""


@compiled
def retracted_positions_mm(model: PrandtlIshlinskii, head_mm: float) -> Array:
    """Positions of the plays after a long retract to ``head_mm``, shape (n,)."""
    return head_mm + model.thresholds_mm


@compiled
def step(model: PrandtlIshlinskii, positions_mm: Array, head_mm: float) -> Array:
    """Positions of the plays once the head has moved monotonically to ``head_mm``; exact.

    positions_mm: shape (n,), read and not changed. Returns a new array of that shape.
    """
    moved_mm = positions_mm.copy()
    _move(model, moved_mm, head_mm)
    return moved_mm


@compiled
def _move(model: PrandtlIshlinskii, positions_mm: Array, head_mm: float) -> None:
    """`step` in place."""
    for j in range(positions_mm.size):
        reach_mm = model.thresholds_mm[j]
        positions_mm[j] = min(max(positions_mm[j], head_mm - reach_mm), head_mm + reach_mm)


@compiled
def _inner_mm(model: PrandtlIshlinskii, positions_mm: Array, head_mm: float) -> float:
    """The sum v, before the curvature."""
    inner_mm = model.slope * head_mm
    for j in range(model.weights.size):
        inner_mm += model.weights[j] * positions_mm[j]
    return inner_mm


@compiled
def bent_mm(model: Curved, inner_mm: float) -> float:
    """Tip position for a sum v."""
    return model.offset_mm + inner_mm * (1.0 + model.curvature_per_mm * inner_mm)


@compiled
def straight_mm(model: Curved, tip_mm: float) -> float:
    """The sum v for a tip position: root of the parabola next to the straight line."""
    above_mm = tip_mm - model.offset_mm
    # Beyond the vertex there is no root: its position is the nearest there is.
    inside = max(1.0 + 4.0 * model.curvature_per_mm * above_mm, 0.0)
    return 2.0 * above_mm / (1.0 + math.sqrt(inside))


@compiled
def output_mm(model: PrandtlIshlinskii, positions_mm: Array, head_mm: float) -> float:
    """Tip position for a head position and positions of the plays, shape (n,)."""
    return bent_mm(model, _inner_mm(model, positions_mm, head_mm))


@compiled
def simulate(model: PrandtlIshlinskii, head_mm: Array, positions_mm: Array) -> Array:
    """Tip positions for a whole record of head positions.

    head_mm: shape (k,); each step between samples is taken as one monotone move. positions_mm:
    the plays before the first sample, shape (n,). Returns tip positions in mm, shape (k,).
    """
    tip_mm = np.empty(head_mm.size)
    for k in range(head_mm.size):
        tip_mm[k] = model.slope * head_mm[k]
    # One play after the other, each in a register: twice as fast as all of them at each sample.
    for j in range(model.weights.size):
        position_mm, reach_mm, weight = positions_mm[j], model.thresholds_mm[j], model.weights[j]
        for k in range(head_mm.size):
            position_mm = min(max(position_mm, head_mm[k] - reach_mm), head_mm[k] + reach_mm)
            tip_mm[k] += weight * position_mm
    for k in range(head_mm.size):
        tip_mm[k] = bent_mm(model, tip_mm[k])
    return tip_mm


@compiled
def total_slope(model: PrandtlIshlinskii) -> float:
    """Slope of v over long travels, every play moving: ``c + sum_j w_j``."""
    slope = model.slope
    for j in range(model.weights.size):
        slope += model.weights[j]
    return slope


@compiled
def inverse_step(
    model: PrandtlIshlinskii, positions_mm: Array, head_mm: float, target_mm: float
) -> float:
    """Head move that brings the tip to a target, signed mm; exact, the shortest there is.

    positions_mm, head_mm: where plays and head are now. A target where the tip already is needs
    no move: the gap of a reversal is crossed for the first target beyond it. Needs a positive
    `total_slope`; a target beyond the vertex of the curvature is taken as the vertex.
    """
    gain_mm = straight_mm(model, target_mm) - _inner_mm(model, positions_mm, head_mm)
    if gain_mm == 0.0:
        return 0.0
    direction = math.copysign(1.0, gain_mm)
    # v gained over a travel d is c*d + sum w*max(d - left, 0). Wider plays engage later: whoever
    # is reached before what is needed is gained adds its weight, and what it has not moved before.
    slope, needed_mm = model.slope, abs(gain_mm)
    for j in range(model.weights.size):
        left_mm = model.thresholds_mm[j] + direction * (positions_mm[j] - head_mm)
        if not left_mm * slope < needed_mm:
            break
        slope += model.weights[j]
        needed_mm += model.weights[j] * left_mm
    travel_mm = needed_mm / slope if slope > 0.0 else 0.0
    return direction * travel_mm if math.isfinite(travel_mm) else 0.0


@compiled
def saturated_head_mm(model: PrandtlIshlinskii, tip_mm: float, direction: float) -> float:
    """Head at the end of a long travel that brought the tip to a position.

    direction: of that travel, +1.0 towards the carina, -1.0 back.
    """
    behind_mm = 0.0
    for j in range(model.weights.size):
        behind_mm += model.weights[j] * model.thresholds_mm[j]
    return (straight_mm(model, tip_mm) + direction * behind_mm) / total_slope(model)


def gap_mm(model: PrandtlIshlinskii) -> float:
    """Distance between the advancing and the retracting branch, mm of tip (curvature left out)."""
    return 2.0 * float(model.thresholds_mm @ model.weights)


def is_well_posed(model: PrandtlIshlinskii, deepest_mm: float, highest_mm: float) -> bool:
    """True where a continuous inverse exists for tip positions from highest to deepest.

    It does where weights and slope are >= 0, their sum is above 0 and the gain stays positive over
    the range.
    """
    weights = np.append(model.weights, model.slope)
    bend = 4.0 * model.curvature_per_mm
    ends = (deepest_mm - model.offset_mm, highest_mm - model.offset_mm)
    return bool(
        np.isfinite(weights).all()
        and (weights >= 0.0).all()
        and weights.sum() > 0.0
        and (model.thresholds_mm > 0.0).all()
        and all(1.0 + bend * above_mm > 0.0 for above_mm in ends)
    )


def scale_widths(model: PrandtlIshlinskii, scale: float) -> PrandtlIshlinskii:
    """The same model with every width multiplied by ``scale``: another routing of the conduit."""
    return model._replace(thresholds_mm=scale * model.thresholds_mm)
