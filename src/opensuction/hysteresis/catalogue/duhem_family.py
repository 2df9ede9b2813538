"""The catalogue's entries of models that are a differential equation in the input.

The paper calls them continuous; Duhem models in the literature: Dahl, modified Dahl, Bouc-Wen.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from opensuction.hysteresis import bouc_wen, dahl, modified_dahl
from opensuction.hysteresis.bouc_wen import BoucWen
from opensuction.hysteresis.catalogue.hysteresis_model import (
    BRIEFEST,
    LONGEST,
    SHORTEST,
    STEEPEST,
    FitParameter,
    HysteresisModel,
    ModelParameter,
    Ranges,
    Record,
    VectorForm,
)
from opensuction.hysteresis.dahl import Dahl
from opensuction.hysteresis.modified_dahl import ModifiedDahl
from opensuction.hysteresis.play import InverseMove, ModelState
from opensuction.kernel.record import Array

SHALLOWEST = 0.1
"""Usual bound below a slope, over output range by input range [assumed]."""

HIGH_EXPONENT, HIGHEST_EXPONENT = 10.0, 30.0
"""Usual and utmost bound above a Bouc-Wen exponent: a corner as sharp as a play's within a
hundredth, and a four-hundredth, of its gap."""

BEND_RATIOS, FARTHEST_BEND_RATIOS = (-3.0, 0.95), (-20.0, 0.99)
"""Usual and utmost bounds on D / (B + D) of a Bouc-Wen model [assumed]: at 1 nothing of its bend
takes work; at -20 it comes home from saturation 42 times as fast as it reached it."""

FREE = (-math.inf, math.inf)
"""Limits of what is found without any: what the output is linear in."""

POSITIVE = (0.0, math.inf)
"""Limits of what has a sign."""


def _step_memory(
    step: Callable[[Any, float, float], float],
) -> Callable[[Record, ModelState, float], ModelState]:
    """Uniform step of a model whose memory is one number and whose step takes the move."""
    return lambda record, state, move_mm: ModelState(
        state.head_mm + move_mm, step(record, state.memory, move_mm)
    )


def _line_bounds(ranges: Ranges) -> tuple[tuple[float, float], tuple[float, float]]:
    """Bounds on the slope of a straight line and on its offset, the output where the input is 0."""
    farthest_mm = max(abs(ranges.input_low_mm), abs(ranges.input_high_mm))
    reach_mm = abs(ranges.output_mean_mm) + STEEPEST * ranges.gain * farthest_mm
    return (SHALLOWEST * ranges.gain, STEEPEST * ranges.gain), (-reach_mm, reach_mm)


def _simulate_dahl(vector: Array, inputs: Array) -> Array:
    stiffness, limit, offset, initial_output = vector.tolist()
    force: Array = dahl.simulate(Dahl(stiffness, limit), inputs, initial_output / stiffness)
    outputs: Array = force + offset
    return outputs


def _dahl_bounds(ranges: Ranges) -> Array:
    width, height = ranges.input_mm, ranges.output_mm
    return np.array(
        [
            (SHALLOWEST * height / width, 2.0 * height / (SHORTEST * width)),
            (SHALLOWEST * height, 2.0 * LONGEST * height),
            (ranges.output_low_mm - height, ranges.output_high_mm + height),
            (-height, height),
        ]
    )


DAHL = HysteresisModel(
    name="dahl",
    title="Dahl",
    summary="friction that saturates, without a line (eqs. 1 and 2)",
    source="[paper] eqs. (1) and (2); [Dahl-1976]",
    cannot="an output that goes on growing with the input (backlash), closed minor loops, "
    "breakaway and viscous friction, an offset",
    inverse="closed form, for outputs below saturation",
    parameters=(
        ModelParameter("stiffness_n_per_mm", "sigma_0", "N/mm", "slope where the force is 0"),
        ModelParameter("coulomb_n", "F_c", "N", "force in sliding"),
    ),
    form=VectorForm(
        parameters=(
            FitParameter("stiffness", "{out}/{in}", logarithmic=True),
            FitParameter("limit", "{out}", logarithmic=True),
            FitParameter("offset", "{out}"),
            FitParameter("initial_output", "{out}"),
        ),
        bounds=_dahl_bounds,
        limits=lambda _ranges: np.array([POSITIVE, POSITIVE, FREE, FREE]),
        record=lambda vector: Dahl(*vector[:2].tolist()),
        simulate=_simulate_dahl,
    ),
    memory=lambda record, _head_mm, ratio: ratio * dahl.saturation_mm(record),
    step=_step_memory(dahl.step),
    output_mm=lambda record, state: dahl.output_n(record, state.memory),
    simulate=dahl.simulate,
    inverse_step=lambda record, state, target: dahl.inverse_step(record, state.memory, target),
    is_well_posed=dahl.is_well_posed,
    is_monotone=dahl.is_well_posed,  # below F_c the force follows the input at once
    undriven="its output stands still once it is saturated, so that most depths have no inverse",
)


def _modified_dahl(vector: Array) -> ModifiedDahl:
    return ModifiedDahl(*vector[:4].tolist())


def _modified_dahl_bounds(ranges: Ranges) -> Array:
    slope, offset = _line_bounds(ranges)
    return np.array(
        [
            slope,
            (0.0, STEEPEST * ranges.gain),
            (1.0 / (LONGEST * ranges.input_mm), 1.0 / (SHORTEST * ranges.input_mm)),
            offset,
            (-ranges.output_mm, ranges.output_mm),
        ]
    )


def _decay_limits(ranges: Ranges) -> tuple[float, float]:
    return 1.0 / (LONGEST * ranges.input_mm), 1.0 / (BRIEFEST * ranges.input_mm)


def _invert_modified_dahl(record: ModifiedDahl, state: ModelState, target_mm: float) -> InverseMove:
    """Towards the target, beyond the gap where there is one."""
    missing_mm = target_mm - modified_dahl.output_mm(record, state.head_mm, state.memory)
    if missing_mm == 0.0 or not math.isfinite(missing_mm):
        return InverseMove(move_mm=0.0, reached=missing_mm == 0.0)
    direction = math.copysign(1.0, missing_mm)
    move_mm = modified_dahl.move_to(record, state.head_mm, state.memory, target_mm, direction)
    return InverseMove(move_mm=move_mm, reached=True)


MODIFIED_DAHL_FORM = VectorForm(
    parameters=(
        FitParameter("slope", "{out}/{in}"),
        FitParameter("velocity_gain", "{out}/{in}"),
        FitParameter("decay", "1/{in}", logarithmic=True),
        FitParameter("offset", "{out}"),
        FitParameter("initial_lag", "{out}"),
    ),
    bounds=_modified_dahl_bounds,
    limits=lambda ranges: np.array([FREE, POSITIVE, _decay_limits(ranges), FREE, FREE]),
    record=_modified_dahl,
    simulate=lambda vector, inputs: modified_dahl.simulate(
        _modified_dahl(vector), inputs, float(vector[4])
    ),
)

MODIFIED_DAHL = HysteresisModel(
    name="modified-dahl",
    title="modified Dahl",
    summary="straight line plus a Dahl state (the paper's model, eqs. 3 and 4)",
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
    form=MODIFIED_DAHL_FORM,
    memory=lambda record, _head_mm, ratio: -ratio * modified_dahl.saturation_mm(record),
    step=_step_memory(modified_dahl.step),
    output_mm=lambda record, state: modified_dahl.output_mm(record, state.head_mm, state.memory),
    simulate=modified_dahl.simulate,
    inverse_step=_invert_modified_dahl,
    is_well_posed=lambda record: (
        record.slope > 0.0 and record.velocity_gain >= 0.0 and record.decay_per_mm > 0.0
    ),
    is_monotone=modified_dahl.is_monotone,
)


def _bouc_wen(vector: Array) -> BoucWen:
    length, bend_ratio, exponent, slope, memory_gain, offset, _ = vector.tolist()
    gain = memory_gain * length
    dissipation, bend = (1.0 - bend_ratio) / length, bend_ratio / length
    return BoucWen(1.0 / length, dissipation, bend, exponent, slope, gain, offset)


def _bouc_wen_bounds(ranges: Ranges) -> Array:
    slope, offset = _line_bounds(ranges)
    return np.array(
        [
            (SHORTEST * ranges.input_mm, LONGEST * ranges.input_mm),
            BEND_RATIOS,
            (1.0, HIGH_EXPONENT),
            slope,
            (-STEEPEST * ranges.gain, STEEPEST * ranges.gain),
            offset,
            (-1.0, 1.0),
        ]
    )


def _bouc_wen_limits(ranges: Ranges) -> Array:
    lengths = BRIEFEST * ranges.input_mm, LONGEST * ranges.input_mm
    exponents = 1.0, HIGHEST_EXPONENT
    return np.array([lengths, FARTHEST_BEND_RATIOS, exponents, FREE, FREE, FREE, (-1.0, 1.0)])


BOUC_WEN_FORM = VectorForm(
    parameters=(
        FitParameter("memory_length", "{in}", logarithmic=True),
        FitParameter("bend_ratio", "1"),
        FitParameter("exponent", "1"),
        FitParameter("slope", "{out}/{in}"),
        FitParameter("memory_gain", "{out}/{in}"),
        FitParameter("offset", "{out}"),
        FitParameter("initial_memory_ratio", "1"),
    ),
    bounds=_bouc_wen_bounds,
    limits=_bouc_wen_limits,
    record=_bouc_wen,
    simulate=lambda vector, inputs: bouc_wen.simulate(_bouc_wen(vector), inputs, float(vector[6])),
)
"""The scale of the memory is free: the record counts it in shares of its saturation, so that no
power of a length is formed, and the vector's gain is output per input where the memory is 0. In
place of A, B and D stand the length over which it forgets, 1 / A, and D / (B + D), which keep their
size when m changes."""

BOUC_WEN = HysteresisModel(
    name="bouc-wen",
    title="Bouc-Wen",
    summary="line plus a Bouc-Wen state, standard form (eqs. 5 and 6)",
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
    form=BOUC_WEN_FORM,
    memory=lambda record, _head_mm, ratio: ratio * bouc_wen.saturation_mm(record),
    step=_step_memory(bouc_wen.step),
    output_mm=lambda record, state: bouc_wen.output_mm(record, state.head_mm, state.memory),
    simulate=bouc_wen.simulate,
    inverse_step=lambda record, state, target_mm: bouc_wen.inverse_step(
        record, state.head_mm, state.memory, target_mm
    ),
    is_well_posed=bouc_wen.is_well_posed,
    is_monotone=bouc_wen.is_monotone,
    undriven="its inverse is a search whose steps no tick could bound",
)
