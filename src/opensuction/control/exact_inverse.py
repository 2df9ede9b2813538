"""The modified Dahl model inverted exactly, its reversal treated as a gap to be crossed.

The procedure says in which direction the tip will move next. The head then goes, within its
speed and acceleration limits, to the point on that branch of the loop where the model puts the
tip on the reference: before insertion and at the end of the dwell this crosses the gap while the
tip stands still.
"""

from typing import NamedTuple

from opensuction.control import head_path
from opensuction.control.head_path import HeadLimits
from opensuction.hysteresis import modified_dahl
from opensuction.hysteresis.modified_dahl import ModifiedDahl
from opensuction.hysteresis.play_sum import NONE_MM, Sixteen
from opensuction.kernel.compiled import compiled

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
    velocity = head_path.step(
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
