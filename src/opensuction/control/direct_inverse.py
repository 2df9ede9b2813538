"""The paper's feedforward, exactly as printed: eq. (7) with the lag of eq. (8) one tick late.

With the published parameters (c < 2 beta) the pair of equations has no continuous solution after
a reversal: moves grow by 2 beta / c from tick to tick until the command has jumped by about
2.6 mm. It is kept so that the paper can be reproduced; the product compensates otherwise.
"""

from opensuction.control.exact_inverse import HeadState
from opensuction.hysteresis import modified_dahl
from opensuction.hysteresis.modified_dahl import ModifiedDahl
from opensuction.kernel.compiled import compiled

DEAD_MOVE_MM = 1e-9
"""Smaller moves leave the estimate alone: rounding would grow and trigger the jump by itself."""


@compiled
def step(model: ModifiedDahl, state: HeadState, reference_mm: float, dt_s: float) -> HeadState:
    """Head command for a desired tip position. Source: [paper] eqs. (7) and (8)."""
    head = (reference_mm - state.lag_mm - model.offset_mm) / model.slope
    move = head - state.head_mm
    lag = state.lag_mm
    if abs(move) >= DEAD_MOVE_MM:
        lag = modified_dahl.step(model, state.lag_mm, move)
    return state._replace(head_mm=head, head_mm_per_s=move / dt_s, lag_mm=lag)
