"""A dozen plays side by side as plain numbers, for a twin that steps them every millisecond.

An array in a record costs: wherever the record is passed on a reference is counted, and every step
copies it. A tuple of numbers is part of the record. Its step is written out: see
`kernel.codegen.straight_line`.
"""

from collections.abc import Callable
from typing import Annotated

from annotated_types import Len

from opensuction.hysteresis import play
from opensuction.kernel.codegen import straight_line

PLAYS = 12
"""How many: more change no figure of the bench by 1 %."""

Bundle = Annotated[tuple[float, ...], Len(PLAYS, PLAYS)]
"""A number for each of them."""


def _stepper() -> Callable[[Bundle, Bundle, float], tuple[Bundle, float]]:
    moved = [f"p{j}" for j in range(PLAYS)]
    element = "    p{j} = play_step(widths_mm[{j}], positions_mm[{j}], head_mm)"
    lines = [
        "def step(widths_mm, positions_mm, head_mm):",
        *(element.format(j=j) for j in range(PLAYS)),
        f"    return ({', '.join(moved)}), ({' + '.join(moved)}) / {PLAYS}",
    ]
    step: Callable[[Bundle, Bundle, float], tuple[Bundle, float]] = straight_line.define(
        lines, "step of a play bundle", play_step=play.step
    )
    return step


def _scaler() -> Callable[[Bundle, float], Bundle]:
    parts = straight_line.tuple_of(f"ratio * values[{j}]" for j in range(PLAYS))
    lines = ["def scale(values, ratio):", f"    return {parts}"]
    scale: Callable[[Bundle, float], Bundle] = straight_line.define(lines, "scale of a bundle")
    return scale


scale = _scaler()
"""``scale(values, ratio)``: each of them times the ratio."""


step = _stepper()
"""``step(widths_mm, positions_mm, head_mm)``: the positions as they follow the head, and their
mean in mm. See `play.step`."""
