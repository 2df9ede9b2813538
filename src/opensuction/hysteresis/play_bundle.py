"""A dozen plays side by side as plain numbers, for a twin that steps them every millisecond.

An array in a record costs: wherever the record is passed on a reference is counted, and every step
copies it. A tuple of numbers is part of the record. Its loops are written out for the compiled
core: see `kernel.codegen.unrolled`.
"""

from typing import Annotated

from annotated_types import Len

from opensuction.hysteresis import play
from opensuction.kernel.codegen.unrolled import unrolled

PLAYS = 12
"""How many: more change no figure of the bench by 1 %."""

Bundle = Annotated[tuple[float, ...], Len(PLAYS, PLAYS)]
"""A number for each of them."""


@unrolled
def scale(values: Bundle, ratio: float) -> Bundle:
    """Each of them times the ratio."""
    return tuple(ratio * values[j] for j in range(PLAYS))


@unrolled
def step(widths_mm: Bundle, positions_mm: Bundle, head_mm: float) -> tuple[Bundle, float]:
    """Positions as they follow the head, and their mean in mm. See `play.step`."""
    moved_mm = tuple(play.step(widths_mm[j], positions_mm[j], head_mm) for j in range(PLAYS))
    total_mm = moved_mm[0]
    for j in range(1, PLAYS):
        total_mm += moved_mm[j]
    return moved_mm, total_mm / PLAYS
