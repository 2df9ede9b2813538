"""Upper bound of the head's position by the commands so far; a head beyond it runs away."""

from typing import NamedTuple

from opensuction.kernel.commands import Setpoints
from opensuction.kernel.compiled import compiled


class AdvanceBound(NamedTuple):
    """Bound on the head's depth, and on the speed with which it may still go deeper."""

    head_mm: float
    """Raised by the command and the braking distance beyond it, lowered again by the reading."""
    coast_mm_per_s: float
    """Speed inwards that a head may still have after its command has stopped."""


@compiled
def step(
    braking_mm_per_s2: float,
    found_mm_per_s: float,
    state: AdvanceBound,
    last: Setpoints,
    head_mm: float,
    jumped_mm: float,
    unseen: bool,
    dt_s: float,
) -> AdvanceBound:
    """Bring it up to this tick.

    found_mm_per_s: speed inwards that the head is found with. last: what was let through in the
    last tick. jumped_mm: how far the head is from where it was
    thought to be, other than it can have travelled. unseen: it may have moved without a reading.
    Where it is found then is taken for granted.
    """
    braked_mm_per_s = state.coast_mm_per_s - braking_mm_per_s2 * dt_s
    coast_mm_per_s = max(braked_mm_per_s, last.head_mm_per_s, found_mm_per_s)
    allowed_mm = max(state.head_mm + max(jumped_mm, 0.0) + coast_mm_per_s * dt_s, last.head_mm)
    if unseen:
        return AdvanceBound(head_mm, coast_mm_per_s)
    return AdvanceBound(min(allowed_mm, head_mm), coast_mm_per_s)
