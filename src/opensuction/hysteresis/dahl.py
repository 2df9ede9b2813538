"""The Dahl model of friction before and in sliding, and its exact inverse.

A bristle of stiffness sigma_0 bends with the input until it carries the Coulomb force F_c. Along
one direction of travel the force approaches that limit as an exponential; each function here is
that closed form: no integration step, no error, independent of speed.

What it cannot represent: an output that goes on growing with the input (a backlash; the modified
Dahl model adds the line), a force above F_c, closed minor loops (after a small excursion the
force does not come back to where it was, it drifts), breakaway (Stribeck) and viscous friction.
Source: [paper] eqs. (1) and (2); [Dahl-1976].
"""

import math
from typing import Annotated, NamedTuple

import numpy as np
from annotated_types import Gt

from opensuction.hysteresis.play import InverseMove
from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import Array


class Dahl(NamedTuple):
    """Parameters of the Dahl model, displacement in mm to force in N.

    For a recording whose output is no force read the output's unit for N.
    """

    stiffness_n_per_mm: Annotated[float, Gt(0)]
    """sigma_0: slope of the force where it is zero."""
    coulomb_n: Annotated[float, Gt(0)]
    """F_c: force in sliding, never exceeded."""


@compiled
def saturation_mm(model: Dahl) -> float:
    """Bristle deflection in sliding, F_c/sigma_0, mm; it is also the length that forgets."""
    return model.coulomb_n / model.stiffness_n_per_mm


@compiled
def step(model: Dahl, deflection_mm: float, move_mm: float) -> float:
    """Deflection z after one monotone move of the input, of any size; exact.

    Source: [paper] eq. (1), integrated in closed form.
    """
    # expm1 keeps a small move exact and leaves the deflection untouched by none.
    length_mm = saturation_mm(model)
    goal_mm = math.copysign(length_mm, move_mm)
    return deflection_mm + (deflection_mm - goal_mm) * math.expm1(-abs(move_mm) / length_mm)


@compiled
def output_n(model: Dahl, deflection_mm: float) -> float:
    """Force for a deflection, N. Source: [paper] eq. (2)."""
    return model.stiffness_n_per_mm * deflection_mm


@compiled
def simulate(model: Dahl, input_mm: Array, deflection_mm: float) -> Array:
    """Forces for a whole record of inputs.

    input_mm: shape (n,), finite; each step between samples is one monotone move.
    deflection_mm: deflection at the first sample. Returns N, shape (n,).
    """
    force_n = np.empty(input_mm.size)
    for k in range(input_mm.size):
        if k > 0:
            deflection_mm = step(model, deflection_mm, input_mm[k] - input_mm[k - 1])
        force_n[k] = output_n(model, deflection_mm)
    return force_n


@compiled
def is_well_posed(model: Dahl) -> bool:
    """True where the force stays bounded and the solution is unique: both parameters above 0."""
    return model.stiffness_n_per_mm > 0.0 and model.coulomb_n > 0.0


@compiled
def inverse_step(model: Dahl, deflection_mm: float, target_n: float) -> InverseMove:
    """Move of the input that brings the force to a target; exact.

    A target of F_c or more is met by no finite move and not reached: the move is then 0. So it is
    for the force there already is, reached.
    Source: [paper] eqs. (1) and (2), solved for the input.
    """
    if target_n == output_n(model, deflection_mm):
        return InverseMove(move_mm=0.0, reached=True)
    goal_mm = target_n / model.stiffness_n_per_mm
    length_mm = saturation_mm(model)
    if not (abs(goal_mm) < length_mm and math.isfinite(deflection_mm)):
        return InverseMove(move_mm=0.0, reached=False)
    direction = math.copysign(1.0, goal_mm - deflection_mm)
    # The share of the way to saturation that is left afterwards, less one; log1p keeps a small
    # move exact.
    left = (deflection_mm - goal_mm) / (direction * length_mm - deflection_mm)
    return InverseMove(move_mm=-direction * length_mm * math.log1p(left), reached=True)
