"""Any number of plays side by side: the reference for bundles of fixed size, and a plant."""

import numpy as np
from numpy.typing import NDArray

from opensuction.hysteresis import play
from opensuction.kernel.compiled import compiled


@compiled
def step(
    widths_mm: NDArray[np.float64], positions_mm: NDArray[np.float64], head_mm: float
) -> float:
    """Move every element to follow the head and return their mean position in mm.

    widths_mm, positions_mm: shape (elements,), at least one. ``positions_mm`` is overwritten:
    it is the state, so a pure caller copies it first.
    """
    total_mm = 0.0
    for j in range(widths_mm.size):
        positions_mm[j] = play.step(widths_mm[j], positions_mm[j], head_mm)
        total_mm += positions_mm[j]
    return total_mm / widths_mm.size


@compiled
def simulate(
    widths_mm: NDArray[np.float64],
    gain: float,
    offset_mm: float,
    head_mm: NDArray[np.float64],
    positions_mm: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Tip positions, ``gain * mean(elements) + offset_mm``, for a record of head positions.

    widths_mm, positions_mm: shape (elements,); the positions before the first sample are read,
    not changed. head_mm: shape (n,). Returns mm, shape (n,).
    """
    state_mm = positions_mm.copy()
    tip_mm = np.empty(head_mm.size)
    for k in range(head_mm.size):
        tip_mm[k] = gain * step(widths_mm, state_mm, head_mm[k]) + offset_mm
    return tip_mm


@compiled
def retracted_positions_mm(widths_mm: NDArray[np.float64], head_mm: float) -> NDArray[np.float64]:
    """Element positions after a long retract to ``head_mm``: each at the far end of its slot.

    widths_mm: shape (elements,). Returns mm, shape (elements,).
    """
    return head_mm + 0.5 * widths_mm
