"""The Prandtl-Ishlinskii model with its plays as plain numbers: the form in which a tick has it.

Model and numbers are those of `hysteresis.prandtl_ishlinskii`, bit for bit; there the plays are an
array of any length. A record that is handed on each millisecond holds none, for every hand would
count a reference to it. So there is room for sixteen plays in a tuple; a spare one has threshold
and weight 0: it stands where the head is and adds nothing to any sum. What is done for each play is
written out: see `kernel.codegen.straight_line`.
"""

import math
from collections.abc import Callable, Iterable
from typing import Annotated, Any, NamedTuple

import numpy as np
from annotated_types import Len

from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii, bent_mm, straight_mm
from opensuction.kernel.codegen import straight_line
from opensuction.kernel.compiled import compiled
from opensuction.kernel.errors import InputError

PLAYS = 16
"""Room for so many: 240 machines of the twin were identified with 7 to 13."""
ENGAGED_MM = 1e-9
"""A play counts as engaged once so little of its slot is left."""
Sixteen = Annotated[tuple[float, ...], Len(PLAYS, PLAYS)]
"""A number for each play."""


class PlaySum(NamedTuple):
    """Parameters of the model: see `PrandtlIshlinskii`."""

    thresholds_mm: Sixteen
    weights: Sixteen
    slope: float
    offset_mm: float
    curvature_per_mm: float


def padded(values: Iterable[float]) -> Sixteen:
    """A number for each play, 0 for the spare ones."""
    found = tuple(float(value) for value in values)
    return found + (0.0,) * (PLAYS - len(found))


NONE_MM: Sixteen = padded(())
"""Positions of plays that nobody uses."""
NO_PLAYS = PlaySum(NONE_MM, NONE_MM, 0.0, 0.0, 0.0)


def bundle(model: PrandtlIshlinskii) -> PlaySum:
    """A model in this form. Raises InputError for more than `PLAYS` plays."""
    if model.weights.size > PLAYS:
        raise InputError(
            f"the compensation has {model.weights.size} plays, should have at most {PLAYS}: "
            "join neighbouring thresholds"
        )
    return PlaySum(padded(model.thresholds_mm), padded(model.weights), *model[2:])


def unbundle(model: PlaySum) -> PrandtlIshlinskii:
    """The model with its plays as arrays, the spare ones among them."""
    return PrandtlIshlinskii(np.array(model.thresholds_mm), np.array(model.weights), *model[2:])


def _written_out(head: str, each: str, result: str) -> Any:
    """A function with a line for each play j that returns ``result``; see `_each`."""
    return straight_line.define(
        [head, *("    " + each.format(j=j) for j in range(PLAYS)), f"    return {result}"], "plays"
    )


def _each(element: str) -> str:
    """A tuple with an element for each play j."""
    return straight_line.tuple_of(element.format(j=j) for j in range(PLAYS))


retracted_positions_mm: Callable[[PlaySum, float], Sixteen] = _written_out(
    "def retracted_positions_mm(model, head_mm):",
    "p{j} = head_mm + model.thresholds_mm[{j}]",
    _each("p{j}"),
)
"""``retracted_positions_mm(model, head_mm)``: after a long retract to a head position."""

step: Callable[[PlaySum, Sixteen, float], Sixteen] = _written_out(
    "def step(model, positions_mm, head_mm):",
    "r = model.thresholds_mm[{j}]; p{j} = min(max(positions_mm[{j}], head_mm - r), head_mm + r)",
    _each("p{j}"),
)
"""``step(model, positions_mm, head_mm)``: positions of the plays once the head has moved
monotonically to a position; exact."""

_weigh: Callable[[float, Sixteen, Sixteen], float] = _written_out(
    "def weigh(total, weights, values):", "total += weights[{j}] * values[{j}]", "total"
)
_left_mm: Callable[[PlaySum, Sixteen, float, float], Sixteen] = _written_out(
    "def left_mm(model, positions_mm, head_mm, direction):",
    "l{j} = model.thresholds_mm[{j}] + direction * (positions_mm[{j}] - head_mm)",
    _each("l{j}"),
)
"""What is left of each slot for a head that goes on in a direction."""
_engage: Callable[[PlaySum, Sixteen, float], tuple[float, float]] = _written_out(
    "def engage(model, left_mm, needed_mm):\n    slope = model.slope",
    "w, l = model.weights[{j}], left_mm[{j}]\n"
    "    if not l * slope < needed_mm: return slope, needed_mm\n"
    "    slope += w; needed_mm += w * l",
    "slope, needed_mm",
)
"""Slope with every play that engages before v has been gained, and ``needed_mm`` with theirs."""
_slope: Callable[[PlaySum, Sixteen, float], float] = _written_out(
    "def slope(model, left_mm, least_mm):\n    slope = model.slope",
    "slope += model.weights[{j}] if left_mm[{j}] <= least_mm else 0.0",
    "slope",
)


@compiled
def _inner_mm(model: PlaySum, positions_mm: Sixteen, head_mm: float) -> float:
    """The sum v, before the curvature."""
    return _weigh(model.slope * head_mm, model.weights, positions_mm)


@compiled
def output_mm(model: PlaySum, positions_mm: Sixteen, head_mm: float) -> float:
    """Tip position for a head position and positions of the plays."""
    return bent_mm(model, _inner_mm(model, positions_mm, head_mm))


@compiled
def advance_slope(model: PlaySum, positions_mm: Sixteen, head_mm: float, direction: float) -> float:
    """Slope dy/dx when the head moves on from here in one direction (+1.0 carina, -1.0 back)."""
    slope = _slope(model, _left_mm(model, positions_mm, head_mm, direction), ENGAGED_MM)
    inner_mm = _inner_mm(model, positions_mm, head_mm)
    return slope * (1.0 + 2.0 * model.curvature_per_mm * inner_mm)


@compiled
def inverse_step(model: PlaySum, positions_mm: Sixteen, head_mm: float, target_mm: float) -> float:
    """Head move that brings the tip to a target: as `prandtl_ishlinskii.inverse_step`."""
    gain_mm = straight_mm(model, target_mm) - _inner_mm(model, positions_mm, head_mm)
    if gain_mm == 0.0:
        return 0.0
    direction = math.copysign(1.0, gain_mm)
    left_mm = _left_mm(model, positions_mm, head_mm, direction)
    slope, needed_mm = _engage(model, left_mm, abs(gain_mm))
    travel_mm = needed_mm / slope if slope > 0.0 else 0.0
    return direction * travel_mm if math.isfinite(travel_mm) else 0.0
