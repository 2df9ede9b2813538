"""Secretions along the trachea, in bins: what lies where, what is near the tip, what is taken.

It is stepped with the patient. The machine gets the volume within reach of its tip, and gives back
the volume that it took.
"""

from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import Array

BIN_MM = 10.0
"""Length of one bin of secretions."""

Bins = Array
"""Secretions in each bin from the tube's lower end downwards, mL, shape (bins,)."""


@compiled
def _bin_at(secretion_ml: Bins, depth_mm: float) -> int:
    return min(max(int(depth_mm / BIN_MM), 0), secretion_ml.size - 1)


@compiled
def within_reach_ml(secretion_ml: Bins, tip_mm: float, reach_mm: float) -> float:
    """Secretions in the bins from the tip to ``reach_mm`` in front of it; none from the tube."""
    found = 0.0
    if tip_mm > -reach_mm:
        first = _bin_at(secretion_ml, tip_mm)
        last = _bin_at(secretion_ml, tip_mm + reach_mm)
        for i in range(first, last + 1):
            found += secretion_ml[i]
    return found


@compiled
def step(
    secretion_ml: Bins,
    produced_ml_per_s: Bins,
    tip_mm: float,
    reach_mm: float,
    taken_ml: float,
    dt_s: float,
) -> Bins:
    """Secretions after a volume was taken at the tip, what lies next to it first, and new came.

    produced_ml_per_s: in each bin, shape (bins,). taken_ml: at most `within_reach_ml` there.
    The arrays given stay as they are.
    """
    rest = secretion_ml.copy()
    left = taken_ml
    first = _bin_at(secretion_ml, tip_mm)
    last = _bin_at(secretion_ml, tip_mm + reach_mm)
    for i in range(first, last + 1):
        part = min(rest[i], left)
        rest[i] -= part
        left -= part
    for i in range(rest.size):
        rest[i] += produced_ml_per_s[i] * dt_s
    return rest
