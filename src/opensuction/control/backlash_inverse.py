"""The modified Dahl model inverted exactly, its reversal treated as a gap to be crossed.

The procedure says in which direction the tip will move next. The head then goes, within its
speed and acceleration limits, to the point on that branch of the loop where the model puts the
tip on the reference: before insertion and at the end of the dwell this crosses the gap while the
tip stands still.

The paper's feedforward, exactly as printed: eq. (7) with the lag of eq. (8) one tick late.

With the published parameters (c < 2 beta) the pair of equations has no continuous solution after
a reversal: moves grow by 2 beta / c from tick to tick until the command has jumped by about
2.6 mm. It is kept so that the paper can be reproduced; the product compensates otherwise.

The literature's baselines: a curve for each direction, the head led from one to the other.

``lookup-table`` holds the head position of each tip depth as it was recorded on the way in and on
the way out; ``gap-width`` is its plainest case, two parallel lines one backlash width apart. Both
see only where the reference goes now: the gap is crossed once it has turned.
Source: [Kesner-2011] for the width, [Bardou-2012] for the table: references 20 and 23 of [paper].
"""

import math
from typing import NamedTuple

from opensuction.control import motion_profile
from opensuction.control.motion_profile import HeadLimits
from opensuction.hysteresis import modified_dahl
from opensuction.hysteresis.modified_dahl import ModifiedDahl
from opensuction.hysteresis.play_sum import NONE_MM, Sixteen
from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import Array

STEEPEST = 4.0
"""Head travel for each mm of tip that is still followed; right after the gap the model wants more
for an instant."""


class HeadState(NamedTuple):
    """Commanded head and what the models remember there, whichever of them is in use."""

    head_mm: float
    head_mm_per_s: float
    lag_mm: float
    """Of the modified Dahl model, or a slow state; of the curves half the gap, above 0 on the way
    out."""
    plays_mm: Sixteen
    """Positions of the Prandtl-Ishlinskii plays, or the turning points that plays of any width
    follow from (`hysteresis.bank.turning_point`)."""


AT_REST = HeadState(0.0, 0.0, 0.0, NONE_MM)
"""A head at 0 with nothing to remember."""


@compiled
def step(
    model: ModifiedDahl,
    limits: HeadLimits,
    state: HeadState,
    reference_mm: float,
    reference_mm_per_s: float,
    direction: float,
    dt_s: float,
) -> HeadState:
    """Head command for a desired tip position approached in one direction.

    direction: +1.0 when the tip's next motion is towards the carina, -1.0 when it is back. The
    head never moves against it: where it turns while the head is moving, the head stops at once.
    """
    distance = modified_dahl.move_to(model, state.head_mm, state.lag_mm, reference_mm, direction)
    goal_lag = modified_dahl.step(model, state.lag_mm, distance)
    slope = modified_dahl.advance_slope(model, goal_lag, direction)
    per_tip = min(1.0 / slope, STEEPEST) if slope > 0.0 else STEEPEST
    if distance == 0.0:
        # The reference is behind: let it catch up, by the distance the head is early.
        early = reference_mm - modified_dahl.output_mm(model, state.head_mm, state.lag_mm)
        distance = early * per_tip
    velocity = motion_profile.step(
        limits, distance, reference_mm_per_s * per_tip, state.head_mm_per_s, dt_s
    )
    if velocity * direction < 0.0:
        velocity = 0.0  # turning back would open the gap again
    move = velocity * dt_s
    return state._replace(
        head_mm=state.head_mm + move,
        head_mm_per_s=velocity,
        lag_mm=modified_dahl.step(model, state.lag_mm, move),
    )


DEAD_MOVE_MM = 1e-9
"""Smaller moves leave the estimate alone: rounding would grow and trigger the jump by itself."""


@compiled
def direct_step(
    model: ModifiedDahl, state: HeadState, reference_mm: float, dt_s: float
) -> HeadState:
    """Head command for a desired tip position. Source: [paper] eqs. (7) and (8)."""
    head = (reference_mm - state.lag_mm - model.offset_mm) / model.slope
    move = head - state.head_mm
    lag = state.lag_mm
    if abs(move) >= DEAD_MOVE_MM:
        lag = modified_dahl.step(model, state.lag_mm, move)
    return state._replace(head_mm=head, head_mm_per_s=move / dt_s, lag_mm=lag)


class Curves(NamedTuple):
    """Head position over tip depth, one curve for each direction."""

    first_mm: float
    """Tip depth of the first entry."""
    spacing_mm: float
    """Distance from one depth to the next, above 0."""
    inwards_mm: Array
    """Head on the way in, shape (n,), at least two."""
    outwards_mm: Array
    """Head on the way out, shape (n,)."""


@compiled
def _between(values: Array, index: int, share: float) -> float:
    return float(values[index] + share * (values[index + 1] - values[index]))


@compiled
def branches_mm(curves: Curves, tip_mm: float) -> tuple[float, float]:
    """Head on the way in and on the way out, mm; the end pieces go on straight beyond the table."""
    place = (tip_mm - curves.first_mm) / curves.spacing_mm
    index = min(max(math.floor(place), 0), curves.inwards_mm.size - 2)
    share = place - index
    return _between(curves.inwards_mm, index, share), _between(curves.outwards_mm, index, share)


@compiled
def tip_mm(curves: Curves, head_mm: float, outwards: bool) -> float:
    """Tip depth at which a branch has the head; linear between the entries and beyond them."""
    heads = curves.outwards_mm if outwards else curves.inwards_mm
    index = 0
    while index < heads.size - 2 and heads[index + 1] < head_mm:
        index += 1
    share = (head_mm - heads[index]) / (heads[index + 1] - heads[index])
    return float(curves.first_mm + curves.spacing_mm * (index + share))


@compiled
def step_lookup_table(
    curves: Curves,
    limits: HeadLimits,
    state: HeadState,
    reference_mm: float,
    reference_mm_per_s: float,
    dt_s: float,
) -> HeadState:
    """Head command of one tick: towards the branch on which the reference moves, or moved last."""
    outwards = state.lag_mm > 0.0
    if reference_mm_per_s != 0.0:
        outwards = reference_mm_per_s < 0.0
    inner_mm, outer_mm = branches_mm(curves, reference_mm)
    ahead_in_mm, ahead_out_mm = branches_mm(curves, reference_mm + reference_mm_per_s * dt_s)
    goal_mm, ahead_mm = (outer_mm, ahead_out_mm) if outwards else (inner_mm, ahead_in_mm)
    velocity = motion_profile.step(
        limits, goal_mm - state.head_mm, (ahead_mm - goal_mm) / dt_s, state.head_mm_per_s, dt_s
    )
    half_mm = max(0.5 * (inner_mm - outer_mm), 1e-9)  # its sign carries the branch
    return state._replace(
        head_mm=state.head_mm + velocity * dt_s,
        head_mm_per_s=velocity,
        lag_mm=half_mm if outwards else -half_mm,
    )
