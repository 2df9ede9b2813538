"""The catalogue's entries of models that are a differential equation in the input.

The paper calls them continuous; Duhem models in the literature: Dahl, modified Dahl, Bouc-Wen.
"""

import math
from collections.abc import Callable
from typing import Any

from opensuction.hysteresis import bouc_wen, dahl, modified_dahl
from opensuction.hysteresis.bouc_wen import BoucWen
from opensuction.hysteresis.catalogue.hysteresis_model import (
    STEEPEST,
    Array,
    HysteresisModel,
    ModelParameter,
    Place,
    Ranges,
    Record,
    bound_rows,
    offset_bounds_mm,
    scalar_record,
    scalar_values,
)
from opensuction.hysteresis.dahl import Dahl
from opensuction.hysteresis.inverse_move import InverseMove
from opensuction.hysteresis.modified_dahl import ModifiedDahl

LEAST_TRAVEL_SHARE, MOST_TRAVEL_SHARE = 0.001, 20.0
"""Bounds on lengths that forget, over the input's range. Beyond them only products and quotients
of parameters show: the flat ridges of ``identification.estimator.modified_dahl``."""


def _moved(
    step: Callable[[Any, float, float], float],
) -> Callable[[Record, Place, float], Place]:
    """Uniform step of a model whose memory is one number and whose step takes the move."""
    return lambda record, place, move_mm: Place(
        place.head_mm + move_mm, step(record, place.memory, move_mm)
    )


DAHL = HysteresisModel(
    name="dahl",
    title="Dahl",
    source="[paper] eqs. (1) and (2); [Dahl-1976]",
    cannot="an output that goes on growing with the input (backlash), closed minor loops, "
    "breakaway and viscous friction, an offset",
    inverse="closed form, for outputs below saturation",
    parameters=(
        ModelParameter("stiffness_n_per_mm", "sigma_0", "N/mm", "slope where the force is 0"),
        ModelParameter("coulomb_n", "F_c", "N", "force in sliding"),
    ),
    linear=False,
    rate_independent=True,
    unfitted=lambda ranges: Dahl(ranges.gain * 2.0, ranges.output_mm),
    bounds=lambda _record, ranges: bound_rows(
        (0.05 * ranges.gain, ranges.gain / LEAST_TRAVEL_SHARE),
        (0.05 * ranges.output_mm, MOST_TRAVEL_SHARE * ranges.output_mm),
    ),
    values=scalar_values,
    with_values=scalar_record(Dahl),
    memory=lambda record, _head_mm, ratio: dahl.start_deflection_mm(record, ratio),
    step=_moved(dahl.step),
    output_mm=lambda record, place: dahl.output_n(record, place.memory),
    simulate=dahl.simulate,
    basis=None,
    inverse_step=lambda record, place, target: dahl.inverse_step(record, place.memory, target),
    is_well_posed=dahl.is_well_posed,
    is_monotone=dahl.is_monotone,
)


def _modified_dahl_inverse(record: ModifiedDahl, place: Place, target_mm: float) -> InverseMove:
    """Towards the target, beyond the gap where there is one."""
    missing_mm = target_mm - modified_dahl.output_mm(record, place.head_mm, place.memory)
    if missing_mm == 0.0 or not math.isfinite(missing_mm):
        return InverseMove(move_mm=0.0, reached=missing_mm == 0.0)
    direction = math.copysign(1.0, missing_mm)
    move_mm = modified_dahl.move_to(record, place.head_mm, place.memory, target_mm, direction)
    return InverseMove(move_mm=move_mm, reached=True)


MODIFIED_DAHL = HysteresisModel(
    name="modified-dahl",
    title="modified Dahl",
    source="[paper] eqs. (3) and (4)",
    cannot="a gap with corners or with a known width, closed minor loops (it drifts in them), "
    "loops that differ along the range; with c <= 2 beta it moves the wrong way after a reversal",
    inverse="exact, by Newton's method; beyond the gap where c <= 2 beta",
    parameters=(
        ModelParameter("slope", "c", "mm/mm", "output per input over long travels"),
        ModelParameter("velocity_gain", "beta", "mm/mm", "how fast the lag follows the input"),
        ModelParameter("decay_per_mm", "alpha_0", "1/mm", "inverse of the travel that forgets"),
        ModelParameter("offset_mm", "y_0", "mm", "output for input and lag at 0"),
    ),
    linear=False,
    rate_independent=True,
    unfitted=lambda ranges: ModifiedDahl(
        slope=ranges.gain,
        velocity_gain=0.4 * ranges.gain,
        decay_per_mm=10.0 / ranges.input_mm,
        offset_mm=ranges.offset_mm,
    ),
    bounds=lambda _record, ranges: bound_rows(
        (0.0, STEEPEST * ranges.gain),
        (0.0, STEEPEST * ranges.gain),
        (
            1.0 / (MOST_TRAVEL_SHARE * ranges.input_mm),
            1.0 / (LEAST_TRAVEL_SHARE * ranges.input_mm),
        ),
        offset_bounds_mm(ranges),
    ),
    values=scalar_values,
    with_values=scalar_record(ModifiedDahl),
    memory=lambda record, _head_mm, ratio: -ratio * modified_dahl.saturation_mm(record),
    step=_moved(modified_dahl.step),
    output_mm=lambda record, place: modified_dahl.output_mm(record, place.head_mm, place.memory),
    simulate=modified_dahl.simulate,
    basis=None,
    inverse_step=_modified_dahl_inverse,
    is_well_posed=lambda record: (
        record.slope > 0.0 and record.velocity_gain >= 0.0 and record.decay_per_mm > 0.0
    ),
    is_monotone=modified_dahl.is_monotone,
)


def _bouc_wen_bounds(_record: BoucWen, ranges: Ranges) -> Array:
    """A is fixed at 1: the scale of the memory is free."""
    shortest = LEAST_TRAVEL_SHARE * ranges.input_mm
    bend = max(1.0 / shortest, 1.0 / (shortest * shortest))
    return bound_rows(
        (1.0, 1.0),
        (1e-3 / (MOST_TRAVEL_SHARE * ranges.input_mm), bend),
        (-bend, bend),
        (1.0, 2.0),
        (0.0, STEEPEST * ranges.gain),
        (-STEEPEST * ranges.gain, STEEPEST * ranges.gain),
        offset_bounds_mm(ranges),
    )


BOUC_WEN = HysteresisModel(
    name="bouc-wen",
    title="Bouc-Wen",
    source="[paper] eqs. (5) and (6), standard form; [Wen-1976]",
    cannot="a gap with corners, closed minor loops (it drifts in them), loops that differ along "
    "the range; for D > B some excursions give more work than was stored",
    inverse="numerical, by bracketing, where it is monotone",
    parameters=(
        ModelParameter("input_gain", "A", "mm/mm", "memory per input where it is 0; free scale"),
        ModelParameter("dissipation", "B", "mm^-m", "part of the bend that takes work"),
        ModelParameter("bend", "D", "mm^-m", "part of the bend that gives it back"),
        ModelParameter("exponent", "m", "1", "how late and how sharply it bends"),
        ModelParameter("slope", "a_x", "mm/mm", "output per input over long travels"),
        ModelParameter("memory_gain", "a_zeta", "mm/mm", "output per memory"),
        ModelParameter("offset_mm", "Theta_0", "mm", "output for input and memory at 0"),
    ),
    linear=False,
    rate_independent=True,
    unfitted=lambda ranges: BoucWen(
        input_gain=1.0,
        dissipation=10.0 / ranges.input_mm,
        bend=0.0,
        exponent=1.0,
        slope=ranges.gain,
        memory_gain=-0.4 * ranges.gain,
        offset_mm=ranges.offset_mm,
    ),
    bounds=_bouc_wen_bounds,
    values=scalar_values,
    with_values=scalar_record(BoucWen),
    memory=lambda record, _head_mm, ratio: bouc_wen.start_memory_mm(record, ratio),
    step=_moved(bouc_wen.step),
    output_mm=lambda record, place: bouc_wen.output_mm(record, place.head_mm, place.memory),
    simulate=bouc_wen.simulate,
    basis=None,
    inverse_step=lambda record, place, target_mm: bouc_wen.inverse_step(
        record, place.head_mm, place.memory, target_mm
    ),
    is_well_posed=bouc_wen.is_well_posed,
    is_monotone=bouc_wen.is_monotone,
)
