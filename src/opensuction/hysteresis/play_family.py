"""The catalogue's entries of models that are made of plays or relays.

The paper calls them discrete: play, Preisach, and the generalised model, which adds Dahl states.
"""

import math

import numpy as np

from opensuction.hysteresis import generalised, play, prandtl_ishlinskii, preisach
from opensuction.hysteresis.generalised import Generalised, GeneralisedState
from opensuction.hysteresis.hysteresis_model import (
    STEEPEST,
    Array,
    HysteresisModel,
    ModelParameter,
    Place,
    Ranges,
    bound_rows,
    offset_bounds_mm,
    scalar_record,
    scalar_values,
)
from opensuction.hysteresis.inverse_move import InverseMove
from opensuction.hysteresis.play import Play
from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii
from opensuction.hysteresis.preisach import Preisach, PreisachState

LEVELS = 20
"""Levels of a Preisach grid to begin with [assumed]: 210 cells."""

WIDTH_SHARES = (0.05, 0.1, 0.2, 0.4)
"""Widths of the plays of a generalised model to begin with, over the input's range [assumed]."""


def _play_simulate(record: Play, head_mm: Array, position_mm: float) -> Array:
    return record.gain * play.simulate(record.width_mm, head_mm, position_mm) + record.offset_mm


def _play_step(record: Play, place: Place, move_mm: float) -> Place:
    head_mm = place.head_mm + move_mm
    return Place(head_mm, play.step(record.width_mm, place.memory, head_mm))


PLAY = HysteresisModel(
    name="play",
    title="play",
    source="[paper] Fig. 5; [Krasnoselskii-1989]",
    cannot="rounded corners, any motion inside the gap",
    inverse="exact: the smallest move; it jumps across the gap",
    parameters=(
        ModelParameter("width_mm", "w", "mm", "travel lost at a reversal"),
        ModelParameter("gain", "k", "mm/mm", "output per input outside the gap"),
        ModelParameter("offset_mm", "y_0", "mm", "output for the element at 0"),
    ),
    linear=False,
    rate_independent=True,
    unfitted=lambda ranges: Play(
        width_mm=0.1 * ranges.input_mm,
        gain=ranges.gain,
        offset_mm=ranges.offset_mm,
    ),
    bounds=lambda _record, ranges: bound_rows(
        (0.0, ranges.input_mm), (0.0, STEEPEST * ranges.gain), offset_bounds_mm(ranges)
    ),
    values=scalar_values,
    with_values=scalar_record(Play),
    memory=play.start_position_mm,
    step=_play_step,
    output_mm=lambda record, place: play.output_mm(record, place.memory),
    simulate=_play_simulate,
    basis=None,
    inverse_step=lambda record, place, target_mm: play.inverse_step(
        record, place.head_mm, place.memory, target_mm
    ),
    is_well_posed=lambda record: record.width_mm >= 0.0 and record.gain > 0.0,
    is_monotone=lambda record: record.width_mm == 0.0 and record.gain > 0.0,
)


THRESHOLD_SHARES = tuple(0.025 * (j + 1) for j in range(20))
"""Half widths of a Prandtl-Ishlinskii model's plays to begin with, over the input's range
[assumed]: full widths up to the range."""


def _prandtl_ishlinskii_unfitted(ranges: Ranges) -> PrandtlIshlinskii:
    return PrandtlIshlinskii(
        thresholds_mm=np.array(THRESHOLD_SHARES) * ranges.input_mm,
        weights=np.zeros(len(THRESHOLD_SHARES)),
        slope=ranges.gain,
        offset_mm=ranges.offset_mm,
        curvature_per_mm=0.0,
    )


def _prandtl_ishlinskii_with_values(record: PrandtlIshlinskii, values: Array) -> PrandtlIshlinskii:
    plays = record.weights.size
    return PrandtlIshlinskii(
        thresholds_mm=record.thresholds_mm,
        weights=values[:plays].copy(),
        slope=float(values[plays]),
        offset_mm=float(values[plays + 1]),
        curvature_per_mm=record.curvature_per_mm,
    )


def _prandtl_ishlinskii_basis(
    record: PrandtlIshlinskii, head_mm: Array, positions_mm: Array
) -> Array:
    """Each play, the head, and 1; linear only without curvature."""
    columns = [
        play.simulate(2.0 * threshold_mm, head_mm, position_mm)
        for threshold_mm, position_mm in zip(record.thresholds_mm, positions_mm, strict=True)
    ]
    return np.column_stack([*columns, head_mm, np.ones(head_mm.size)])


def _prandtl_ishlinskii_step(record: PrandtlIshlinskii, place: Place, move_mm: float) -> Place:
    head_mm = place.head_mm + move_mm
    return Place(head_mm, prandtl_ishlinskii.step(record, place.memory, head_mm))


def _prandtl_ishlinskii_inverse(
    record: PrandtlIshlinskii, place: Place, target_mm: float
) -> InverseMove:
    """Refused for targets that are no number, and for a model that never moves."""
    if not (math.isfinite(target_mm) and prandtl_ishlinskii.total_slope(record) > 0.0):
        return InverseMove(move_mm=0.0, reached=False)
    move_mm = prandtl_ishlinskii.inverse_step(record, place.memory, place.head_mm, target_mm)
    return InverseMove(move_mm=move_mm, reached=True)


def _prandtl_ishlinskii_is_well_posed(record: PrandtlIshlinskii) -> bool:
    values = np.array([*record.weights, record.slope, record.offset_mm, record.curvature_per_mm])
    return bool(np.isfinite(values).all() and (record.thresholds_mm >= 0.0).all())


PRANDTL_ISHLINSKII = HysteresisModel(
    name="prandtl-ishlinskii",
    title="Prandtl-Ishlinskii",
    source="[Krasnoselskii-1989]; [Kuhnen-2003]",
    cannot="loops whose shape changes with the place in the range, loops that are not symmetric "
    "under reversal, corners at other widths than its thresholds",
    inverse="exact, corner by corner",
    parameters=(
        ModelParameter("weights", "w_j", "mm/mm", "share of each play"),
        ModelParameter("slope", "c", "mm/mm", "share of the input itself"),
        ModelParameter("offset_mm", "y_0", "mm", "output for input and plays at 0"),
    ),
    linear=True,
    rate_independent=True,
    unfitted=_prandtl_ishlinskii_unfitted,
    bounds=lambda record, _ranges: bound_rows(
        *[(0.0, math.inf)] * (record.weights.size + 1), (-math.inf, math.inf)
    ),
    values=lambda record: np.array([*record.weights, record.slope, record.offset_mm]),
    with_values=_prandtl_ishlinskii_with_values,
    memory=lambda record, head_mm, ratio: head_mm - ratio * record.thresholds_mm,
    step=_prandtl_ishlinskii_step,
    output_mm=lambda record, place: prandtl_ishlinskii.output_mm(
        record, place.memory, place.head_mm
    ),
    simulate=prandtl_ishlinskii.simulate,
    basis=_prandtl_ishlinskii_basis,
    inverse_step=_prandtl_ishlinskii_inverse,
    is_well_posed=_prandtl_ishlinskii_is_well_posed,
    is_monotone=lambda record: (
        record.slope > 0.0
        and bool((record.weights >= 0.0).all())
        and record.curvature_per_mm == 0.0
    ),
)


def _preisach_unfitted(ranges: Ranges) -> Preisach:
    none = np.zeros(preisach.cell_count(LEVELS) + 1)
    return preisach.from_factors(ranges.input_low_mm, ranges.input_high_mm, LEVELS, none)


def _preisach_values(record: Preisach) -> Array:
    levels = record.weights_mm.shape[0]
    rows = [record.weights_mm[k, : levels - k] for k in range(levels)]
    return np.concatenate([*rows, [record.offset_mm]])


def _preisach_bounds(record: Preisach, _ranges: Ranges) -> Array:
    size = preisach.cell_count(record.weights_mm.shape[0])
    return bound_rows(*[(0.0, math.inf)] * size, (-math.inf, math.inf))


def _preisach_is_well_posed(record: Preisach) -> bool:
    return record.high_mm > record.low_mm and bool(np.isfinite(_preisach_values(record)).all())


PREISACH = HysteresisModel(
    name="preisach",
    title="Preisach",
    source="[Preisach-1935]; [Mayergoyz-1991]",
    cannot="minor loops of equal input that differ in shape with the output, outputs beyond its "
    "grid, gaps of other widths than whole levels",
    inverse="numerical, by bracketing, for weights of 0 and above",
    parameters=(
        ModelParameter("weights_mm", "mu", "mm", "output of each cell of relays"),
        ModelParameter("offset_mm", "y_0", "mm", "output with every relay down"),
    ),
    linear=True,
    rate_independent=True,
    unfitted=_preisach_unfitted,
    bounds=_preisach_bounds,
    values=_preisach_values,
    with_values=lambda record, values: preisach.from_factors(
        record.low_mm, record.high_mm, record.weights_mm.shape[0], values
    ),
    memory=preisach.start_positions_mm,
    step=lambda record, place, move_mm: Place(
        *preisach.step(record, PreisachState(*place), move_mm)
    ),
    output_mm=lambda record, place: preisach.output_mm(record, PreisachState(*place)),
    simulate=preisach.simulate,
    basis=preisach.basis,
    inverse_step=lambda record, place, target_mm: preisach.inverse_step(
        record, PreisachState(*place), target_mm
    ),
    is_well_posed=_preisach_is_well_posed,
    is_monotone=preisach.is_monotone,
)


def _generalised_unfitted(ranges: Ranges) -> Generalised:
    return generalised.on_range(
        ranges.input_low_mm,
        ranges.input_high_mm,
        np.array(generalised.DECAY_SHARES) * ranges.input_mm,
        np.array(WIDTH_SHARES) * ranges.input_mm,
        generalised.HIGHEST_DEGREE,
    )


def _generalised_inverse(record: Generalised, place: Place, target_mm: float) -> InverseMove:
    """Refused where the model is not monotone: the root found would be one of several."""
    if not generalised.is_monotone(record):
        return InverseMove(move_mm=0.0, reached=False)
    return generalised.inverse_step(record, GeneralisedState(*place), target_mm)


def _generalised_is_well_posed(record: Generalised) -> bool:
    lengths = bool(np.all(record.decay_lengths_mm > 0.0) and np.all(record.widths_mm >= 0.0))
    finite = np.isfinite(record.weights).all() and np.isfinite(record.envelope_mm).all()
    return lengths and bool(finite) and record.half_range_mm > 0.0


GENERALISED = HysteresisModel(
    name="generalised",
    title="generalised, linear in its parameters",
    source="Dahl states of [paper] eq. (3) and plays of Fig. 5, with a polynomial envelope",
    cannot="loops whose height depends on where in the range they lie; noise is fitted where the "
    "elements are too many",
    inverse="numerical, by bracketing, where it is monotone",
    parameters=(
        ModelParameter("weights", "w_j", "mm/mm", "share of each Dahl state, then of each play"),
        ModelParameter("envelope_mm", "c_k", "mm", "coefficients of the envelope on -1 to 1"),
    ),
    linear=True,
    rate_independent=True,
    unfitted=_generalised_unfitted,
    bounds=lambda record, _ranges: bound_rows(
        *[(-math.inf, math.inf)] * (record.weights.size + record.envelope_mm.size)
    ),
    values=lambda record: np.concatenate([record.weights, record.envelope_mm]),
    with_values=generalised.with_factors,
    memory=generalised.start_elements_mm,
    step=lambda record, place, move_mm: Place(
        *generalised.step(record, GeneralisedState(*place), move_mm)
    ),
    output_mm=lambda record, place: generalised.output_mm(record, GeneralisedState(*place)),
    simulate=generalised.simulate,
    basis=generalised.basis,
    inverse_step=_generalised_inverse,
    is_well_posed=_generalised_is_well_posed,
    is_monotone=generalised.is_monotone,
)
