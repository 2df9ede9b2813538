"""The literature's baselines: a curve for each direction, the head led from one to the other.

``lookup-table`` holds the head position of each tip depth as it was recorded on the way in and on
the way out; ``gap-width`` is its plainest case, two parallel lines one backlash width apart. Both
see only where the reference goes now: the gap is crossed once it has turned.
Source: [Kesner-2011] for the width, [Bardou-2012] for the table: references 20 and 23 of [paper].
"""

import math
from typing import NamedTuple

from opensuction.control import head_path
from opensuction.control.exact_inverse import HeadState
from opensuction.control.head_path import HeadLimits
from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import Array


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
def step(
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
    velocity = head_path.step(
        limits, goal_mm - state.head_mm, (ahead_mm - goal_mm) / dt_s, state.head_mm_per_s, dt_s
    )
    half_mm = max(0.5 * (inner_mm - outer_mm), 1e-9)  # its sign carries the branch
    return state._replace(
        head_mm=state.head_mm + velocity * dt_s,
        head_mm_per_s=velocity,
        lag_mm=half_mm if outwards else -half_mm,
    )
