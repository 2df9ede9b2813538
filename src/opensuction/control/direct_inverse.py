"""The paper's feedforward, exactly as printed: eq. (7) with the lag of eq. (8) one tick late.

With the published parameters (c < 2 beta) the pair of equations has no continuous solution after
a reversal: moves grow by 2 beta / c from tick to tick until the command has jumped by about
2.6 mm. It is kept so that the paper can be reproduced; the product compensates otherwise.
"""

from typing import NamedTuple

from opensuction.hysteresis import modified_dahl
from opensuction.hysteresis.modified_dahl import ModifiedDahl
from opensuction.kernel.compiled import compiled

DEAD_MOVE_MM = 1e-9
"""Smaller moves leave the estimate alone: rounding would grow and trigger the jump by itself."""


class EstimatedLag(NamedTuple):
    """Commanded head position and the lag estimated for it."""

    head_mm: float
    lag_mm: float


@compiled
def step(model: ModifiedDahl, state: EstimatedLag, reference_mm: float) -> EstimatedLag:
    """Head command for a desired tip position. Source: [paper] eqs. (7) and (8)."""
    head = (reference_mm - state.lag_mm - model.offset_mm) / model.slope
    move = head - state.head_mm
    lag = state.lag_mm
    if abs(move) >= DEAD_MOVE_MM:
        lag = modified_dahl.step(model, state.lag_mm, move)
    return EstimatedLag(head_mm=head, lag_mm=lag)
