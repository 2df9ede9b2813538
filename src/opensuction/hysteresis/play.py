"""Play (backlash) of one or many clearances between the catheter's head and its tip.

A play element is a block in a slot of full width w: the head moves the slot, the slot's ends
move the block. Many elements of different widths side by side round off the corners, as the
clearance of a catheter that lies against its conduit in many places does. A twin that steps a dozen
every millisecond has them as a tuple of numbers: an array in a record costs, for wherever the
record is passed on a reference is counted, and every step copies it. Loops over the tuple are
written out for the compiled core: see `kernel.codegen.unrolled`.

What one play cannot represent: rounded corners, and any motion of the output inside the gap. So
it has no continuous inverse; the smallest move that gives a wanted output exists (`inverse_step`).
Source: [paper] Fig. 5 (one element); [Krasnoselskii-1989] for the play operator and its
superposition.
"""

import math
from typing import Annotated, Any, NamedTuple

import numpy as np
from annotated_types import Ge, Gt, Len

from opensuction.kernel.codegen.unrolled import unrolled
from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import Array


class ModelState(NamedTuple):
    """Position of the input, and the memory there."""

    head_mm: float
    memory: Any
    """A float, or an array of elements."""


class InverseMove(NamedTuple):
    """A move of the input found by inverting a model."""

    move_mm: float
    """Signed move of the input from where it is."""
    reached: bool
    """Whether the output is at the target after it. If not, no move reaches the target: the move
    is 0 or ends where the model's output or the range it holds for ends; each model says which."""


class Play(NamedTuple):
    """One play element as a model of the transmission, head_mm to tip_mm."""

    width_mm: Annotated[float, Ge(0)]
    """Full width of the slot: head travel lost at a reversal."""
    gain: Annotated[float, Gt(0)]
    """mm of tip per mm of element."""
    offset_mm: float
    """Tip position for the element at 0."""


@compiled
def step(width_mm: float, position_mm: float, head_mm: float) -> float:
    """Position of a play element once the head has moved monotonically to ``head_mm``; exact.

    width_mm: full width of the slot, >= 0. position_mm: the element before the move.
    """
    half_mm = 0.5 * width_mm
    return min(max(position_mm, head_mm - half_mm), head_mm + half_mm)


@compiled
def simulate(width_mm: float, head_mm: Array, position_mm: float) -> Array:
    """Positions of one play element for a whole record of head positions.

    head_mm: shape (n,). position_mm: the element before the first sample; it is brought within
    its slot there. Returns mm, shape (n,).
    """
    positions_mm = np.empty(head_mm.size)
    for k in range(head_mm.size):
        position_mm = step(width_mm, position_mm, head_mm[k])
        positions_mm[k] = position_mm
    return positions_mm


@compiled
def output_mm(model: Play, position_mm: float) -> float:
    """Tip position for a position of the element, mm."""
    return model.gain * position_mm + model.offset_mm


@compiled
def inverse_step(model: Play, head_mm: float, position_mm: float, target_mm: float) -> InverseMove:
    """Smallest head move that brings the tip to a target; exact, and always there.

    head_mm, position_mm: where the head and the element are. A tip that is on its target asks for
    no move, wherever in the gap the head is.
    """
    goal_mm = (target_mm - model.offset_mm) / model.gain
    if not math.isfinite(goal_mm):
        return InverseMove(move_mm=0.0, reached=False)
    if goal_mm == position_mm:
        return InverseMove(move_mm=0.0, reached=True)
    push_mm = math.copysign(0.5 * model.width_mm, goal_mm - position_mm)
    return InverseMove(move_mm=goal_mm + push_mm - head_mm, reached=True)


PLAYS = 12
"""Plays of a bundle: more change no figure of the bench by 1 %."""
Bundle = Annotated[tuple[float, ...], Len(PLAYS, PLAYS)]
"""A number for each of them."""


@unrolled
def scale_bundle(values: Bundle, ratio: float) -> Bundle:
    """Each of them times the ratio."""
    return tuple(ratio * values[j] for j in range(PLAYS))


@unrolled
def step_bundle(widths_mm: Bundle, positions_mm: Bundle, head_mm: float) -> tuple[Bundle, float]:
    """Positions as they follow the head, and their mean in mm. See `step`."""
    moved_mm = tuple(step(widths_mm[j], positions_mm[j], head_mm) for j in range(PLAYS))
    total_mm = moved_mm[0]
    for j in range(1, PLAYS):
        total_mm += moved_mm[j]
    return moved_mm, total_mm / PLAYS
