"""The paper's backlash-like hysteresis: a straight line plus a Dahl state, and its exact inverse.

Between two reversals the state obeys a linear differential equation in the head travel, so every
function here is its closed form: no integration step, no error, independent of speed.

In the direction of travel s (+1 towards the carina, -1 back) the tip gains, over a travel d >= 0,
``c*d + u*(exp(-alpha*d) - 1)`` with ``u = s*z + beta/alpha``. Where ``u*alpha > c`` this dips
before it rises: the modelled tip first moves the wrong way and is back only after the *gap*.
Source: [paper] eqs. (3) and (4).
"""

import math
from typing import Annotated, NamedTuple

import numpy as np
from annotated_types import Ge, Gt

from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import Array

NEWTON_STEPS = 80
"""Bound on Newton steps: 6 are usual, 40 at the tangent point, where each halves the error."""

RELATIVE_STEP = 2.0e-16
"""A Newton step below this share of the travel is rounding (half the spacing of doubles)."""


class ModifiedDahl(NamedTuple):
    """Parameters of the modified Dahl model of the transmission, head_mm to tip_mm."""

    slope: Annotated[float, Gt(0)]
    """c: mm of tip per mm of head over long travels."""
    velocity_gain: Annotated[float, Ge(0)]
    """beta: how fast the lag follows the head, mm per mm; 0 is a straight line."""
    decay_per_mm: Annotated[float, Gt(0)]
    """alpha_0: inverse of the head travel over which a reversal is forgotten."""
    offset_mm: float
    """y_0: tip position for head and lag at 0."""


PUBLISHED = ModifiedDahl(slope=0.9677, velocity_gain=0.854, decay_per_mm=0.077, offset_mm=-7.151)
"""Identified parameters of [paper] III-B. Not monotone: c < 2 beta."""


@compiled
def step(model: ModifiedDahl, lag_mm: float, move_mm: float) -> float:
    """Advance the hysteretic lag by one monotone move of the head; exact.

    lag_mm: internal state z before the move. move_mm: signed head travel, any size.
    Returns the lag after the move. Source: [paper] eq. (3), integrated in closed form.
    """
    # expm1 keeps a small move exact and leaves the lag untouched by none.
    reach_mm = math.copysign(model.velocity_gain / model.decay_per_mm, move_mm)
    return lag_mm + (lag_mm + reach_mm) * math.expm1(-model.decay_per_mm * abs(move_mm))


@compiled
def output_mm(model: ModifiedDahl, head_mm: float, lag_mm: float) -> float:
    """Tip position for a head position and a lag, mm. Source: [paper] eq. (4)."""
    return model.slope * head_mm + lag_mm + model.offset_mm


@compiled
def simulate(model: ModifiedDahl, head_mm: Array, lag_mm: float) -> Array:
    """Tip positions for a whole record of head positions.

    head_mm: shape (n,); each step between samples is taken as one monotone move.
    lag_mm: lag at the first sample. Returns tip positions in mm, shape (n,).
    """
    tip_mm = np.empty(head_mm.size)
    for k in range(head_mm.size):
        if k > 0:
            lag_mm = step(model, lag_mm, head_mm[k] - head_mm[k - 1])
        tip_mm[k] = output_mm(model, head_mm[k], lag_mm)
    return tip_mm


@compiled
def saturation_mm(model: ModifiedDahl) -> float:
    """Lag after a long retract, mm; after a long advance it is minus that (beta/alpha)."""
    return model.velocity_gain / model.decay_per_mm


@compiled
def gap_mm(model: ModifiedDahl) -> float:
    """Distance between the advancing and the retracting branch, mm of tip (2 beta/alpha)."""
    return 2.0 * model.velocity_gain / model.decay_per_mm


@compiled
def reversal_slope(model: ModifiedDahl) -> float:
    """Slope dy/dx right after a saturated reversal (c - 2 beta); negative is the wrong way."""
    return model.slope - 2.0 * model.velocity_gain


@compiled
def is_monotone(model: ModifiedDahl) -> bool:
    """True where the tip always follows the head: a continuous inverse exists (c > 2 beta)."""
    return model.slope > 2.0 * model.velocity_gain


@compiled
def advance_slope(model: ModifiedDahl, lag_mm: float, direction: float) -> float:
    """Slope dy/dx when the head starts to move from here in one direction.

    direction: +1.0 towards the carina, -1.0 back. Source: [paper] eqs. (3) and (4).
    """
    return model.slope - model.velocity_gain - direction * model.decay_per_mm * lag_mm


@compiled
def _turning_travel_mm(model: ModifiedDahl, pull_mm: float) -> float:
    """Travel at which the tip's wrong-way dip is deepest, mm; 0 without a dip.

    pull_mm: u, the lag that a long travel in this direction still has to undo.
    """
    steepness = pull_mm * model.decay_per_mm / model.slope
    return math.log(steepness) / model.decay_per_mm if steepness > 1.0 else 0.0


@compiled
def _gain_mm(model: ModifiedDahl, pull_mm: float, travel_mm: float) -> float:
    """Tip travel gained in the direction of a head travel, mm; both >= 0 means forward."""
    return model.slope * travel_mm + pull_mm * math.expm1(-model.decay_per_mm * travel_mm)


@compiled
def far_root_mm(model: ModifiedDahl, pull_mm: float, gain_mm: float) -> float:
    """Largest travel that gains exactly ``gain_mm``, which must be reachable; Newton, monotone.

    ``(gain + u)/c`` is where the curve's asymptote reaches the gain: right of the far root where
    the curve is convex (u > 0), left of it where concave. On either side Newton never crosses it.
    """
    travel_mm = max((gain_mm + pull_mm) / model.slope, 0.0)
    for _ in range(NEWTON_STEPS):
        # One exponential serves both the curve and its slope: this loop runs every tick.
        decayed = math.expm1(-model.decay_per_mm * travel_mm)
        slope = model.slope - pull_mm * model.decay_per_mm * (1.0 + decayed)
        if not slope > 0.0:  # the tangent point itself, or not a number
            break
        correction_mm = (model.slope * travel_mm + pull_mm * decayed - gain_mm) / slope
        travel_mm = max(travel_mm - correction_mm, 0.0)
        if not abs(correction_mm) > RELATIVE_STEP * travel_mm:
            break
    return travel_mm


@compiled
def move_to(
    model: ModifiedDahl, head_mm: float, lag_mm: float, target_mm: float, direction: float
) -> float:
    """Head move that brings the tip to a target, travelling in one direction only; exact.

    head_mm, lag_mm: where the head is now, and the lag there. target_mm: desired tip position.
    direction: +1.0 towards the carina, -1.0 back.

    Returns the signed move in mm, never against the direction. Of two solutions it is the one
    beyond the gap, from which the tip moves on the right way. A target that is behind, deeper
    than the dip, cannot be reached in this direction: the move to the bottom of the dip is
    returned, 0 for a curve without one. Compare the output there with the target to know.
    Source: [paper] eqs. (3) and (4) solved together, in place of eqs. (7) and (8).
    """
    pull_mm = direction * lag_mm + saturation_mm(model)
    gain_mm = direction * (target_mm - output_mm(model, head_mm, lag_mm))
    turning_mm = _turning_travel_mm(model, pull_mm)
    if gain_mm <= _gain_mm(model, pull_mm, turning_mm):
        return direction * turning_mm
    return direction * max(far_root_mm(model, pull_mm, gain_mm), turning_mm)


@compiled
def gap_move(model: ModifiedDahl, lag_mm: float, direction: float) -> float:
    """Head move, in one direction, after which the tip is back where it is now; signed mm.

    direction: +1.0 towards the carina, -1.0 back. 0 where the tip follows at once. With the
    published parameters, saturated the other way: 16.48 mm, 2.47 mm of dip after 7.38 mm.
    """
    pull_mm = direction * lag_mm + saturation_mm(model)
    turning_mm = _turning_travel_mm(model, pull_mm)
    if turning_mm == 0.0:
        return 0.0
    return direction * max(far_root_mm(model, pull_mm, 0.0), turning_mm)
