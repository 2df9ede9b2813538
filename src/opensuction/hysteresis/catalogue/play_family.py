"""The catalogue's entries of models that are made of plays or relays; the paper: discrete ones.

The catalogue's entry of the Maxwell-slip model: slipping elements with lines, and drag.
"""

import math

import numpy as np

from opensuction.hysteresis import play, prandtl_ishlinskii, preisach
from opensuction.hysteresis.bank import maxwell_slip, play_lines
from opensuction.hysteresis.bank.maxwell_slip import MaxwellSlip
from opensuction.hysteresis.catalogue.hysteresis_model import (
    FitParameter,
    HysteresisModel,
    LinearForm,
    ModelParameter,
    Ranges,
    name_element,
)
from opensuction.hysteresis.play import InverseMove, ModelState, Play
from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii
from opensuction.hysteresis.preisach import Preisach
from opensuction.kernel.record import Array

REACHES = np.geomspace(0.01, 0.3, 6)
"""[design] Reaches of the elements, as shares of the input's range: neighbours differ twofold."""

WIDE_REACHES = np.append(REACHES, [0.38, 0.46])
"""[design] The same for wider loops: an element that reaches half of the range never slips."""

CELLS = 8
"""[design] Cells of each line."""

RIDGES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5)
"""Penalties on the factors, as shares of a column's variance."""

SPEEDS = np.array([0.02, 0.05, 0.15, 0.4, 1.0])
"""[design] Speeds from which a drag grows no more, as shares of the highest of a recording."""

LAGS = (4.0, 16.0)
"""[design] Time constants of the speed's lag, in samples."""


def guess(
    range_mm: float,
    top_speed_mm_s: float = 0.0,
    lag_s: float = 1.0,
    period_s: float = 1.0,
    reaches: Array = REACHES,
) -> MaxwellSlip:
    """A model of a range of the input with every factor 0; without drag where the speed is 0.

    reaches: of the elements, as shares of the range.
    """
    speeds_mm_s: Array = top_speed_mm_s * SPEEDS if top_speed_mm_s > 0.0 else np.empty(0)
    return MaxwellSlip(
        slope=0.0,
        reaches_mm=range_mm * reaches,
        gains=np.zeros((reaches.size, CELLS)),
        speeds_mm_s=speeds_mm_s,
        drags_mm=np.zeros(speeds_mm_s.size),
        lag_s=lag_s,
        period_s=period_s,
        offset_mm=0.0,
    )


def _name_factors(record: MaxwellSlip, ranges: Ranges) -> list[FitParameter]:
    elements = [name_element("gain", reach_mm, ranges) for reach_mm in record.reaches_mm]
    return [
        FitParameter("slope", "{out}/{in}"),
        *(
            FitParameter(f"{element.name}_cell_{cell}", element.unit)
            for element in elements
            for cell in range(record.gains.shape[1])
        ),
        *(FitParameter(f"drag_to_{speed:.4g}_per_s", "{out}") for speed in record.speeds_mm_s),
        FitParameter("offset", "{out}"),
    ]


def _is_well_posed(record: MaxwellSlip) -> bool:
    values = np.concatenate(
        [record.gains.ravel(), record.drags_mm, [record.slope, record.offset_mm]]
    )
    lengths = np.concatenate(
        [record.reaches_mm, record.speeds_mm_s, [record.lag_s, record.period_s]]
    )
    return bool(np.isfinite(values).all()) and bool((lengths > 0.0).all())


MAXWELL_SLIP = HysteresisModel(
    name="maxwell-slip",
    title="Maxwell slip, with drag",
    summary="lines over the deflections of slipping elements, and drag that saturates with "
    "speed; predicts only",
    source="[Iwan-1966]; [Al-Bender-2005] for lines and speed",
    cannot="loops that change with the place in the range, creep; it drives nothing, for its "
    "output may move the wrong way after a reversal",
    inverse="none: it predicts, and drives nothing",
    parameters=(
        ModelParameter("slope", "c", "mm/mm", "output per input with every element slipping"),
        ModelParameter("reaches_mm", "r_k", "mm", "deflection at which each element slips"),
        ModelParameter("gains", "g_kj", "mm/mm", "slope of the line over an element in a cell"),
        ModelParameter("speeds_mm_s", "v_q", "mm/s", "speed from which a drag grows no more"),
        ModelParameter("drags_mm", "D_q", "mm", "output that each drag adds from there on"),
        ModelParameter("lag_s", "T_v", "s", "time constant behind which the speed is taken"),
        ModelParameter("period_s", "T", "s", "time between samples"),
        ModelParameter("offset_mm", "y_0", "mm", "output at input 0, every element slipped back"),
    ),
    form=LinearForm(
        initial_guesses=lambda ranges: [guess(ranges.input_mm)],
        penalties=RIDGES,
        nonnegative=False,
        basis=maxwell_slip.basis,
        degree=lambda _record: 0,
        with_factors=maxwell_slip.with_factors,
        parameters=_name_factors,
    ),
    memory=maxwell_slip.start_elements_mm,
    step=maxwell_slip.step,
    output_mm=maxwell_slip.output_mm,
    simulate=maxwell_slip.simulate,
    inverse_step=maxwell_slip.refuse_inverse,
    is_well_posed=_is_well_posed,
    is_monotone=lambda _record: False,
    undriven="its output may move the wrong way after a reversal: it predicts only",
    has_inverse=False,
)


def _simulate_play(record: Play, head_mm: Array, position_mm: float) -> Array:
    return record.gain * play.simulate(record.width_mm, head_mm, position_mm) + record.offset_mm


def _step_play(record: Play, state: ModelState, move_mm: float) -> ModelState:
    head_mm = state.head_mm + move_mm
    return ModelState(head_mm, play.step(record.width_mm, state.memory, head_mm))


PLAY = HysteresisModel(
    name="play",
    title="play",
    summary="a gap of one width with corners (Fig. 5)",
    source="[paper] Fig. 5; [Krasnoselskii-1989]",
    cannot="rounded corners, any motion inside the gap",
    inverse="exact: the smallest move; it jumps across the gap",
    parameters=(
        ModelParameter("width_mm", "w", "mm", "travel lost at a reversal"),
        ModelParameter("gain", "k", "mm/mm", "output per input outside the gap"),
        ModelParameter("offset_mm", "y_0", "mm", "output for the element at 0"),
    ),
    form=None,
    memory=lambda record, head_mm, ratio: head_mm - 0.5 * ratio * record.width_mm,
    step=_step_play,
    output_mm=lambda record, state: play.output_mm(record, state.memory),
    simulate=_simulate_play,
    inverse_step=lambda record, state, target_mm: play.inverse_step(
        record, state.head_mm, state.memory, target_mm
    ),
    is_well_posed=lambda record: record.width_mm >= 0.0 and record.gain > 0.0,
    is_monotone=lambda record: record.width_mm == 0.0 and record.gain > 0.0,
    undriven="no recording identifies it: gap-width is the compensator on a gap of one width",
)


PLAY_COUNTS = (5, 10, 20, 40)
"""Plays of a Prandtl-Ishlinskii model, evenly spaced from no width to ``USUAL_WIDEST``."""

USUAL_WIDEST = 0.5
"""Widest of them, as a share of the input's range: a wider one moves for less than half of it."""

PITCHES = (20, 60)
"""Shares of the input's range between the plays of models for wider gaps; their widest play is
narrower than the range by one: wider ones never move. A compensator takes no more than 64."""


def _guess_prandtl_ishlinskii(ranges: Ranges) -> list[PrandtlIshlinskii]:
    usual = [np.linspace(0.0, USUAL_WIDEST, plays + 1)[1:] for plays in PLAY_COUNTS]
    wide = [np.linspace(0.0, 1.0, pitches + 1)[1:-1] for pitches in PITCHES]
    return [
        PrandtlIshlinskii(
            thresholds_mm=0.5 * (ranges.input_mm * widths),
            weights=np.zeros(widths.size),
            slope=0.0,
            offset_mm=0.0,
            curvature_per_mm=0.0,
        )
        for widths in (*usual, *wide)
    ]


def _prandtl_ishlinskii_basis(
    record: PrandtlIshlinskii, head_mm: Array, positions_mm: Array
) -> Array:
    """The head, each play, and 1; linear only without curvature."""
    columns = np.ones((head_mm.size, record.weights.size + 2))
    columns[:, 0] = head_mm
    for j, (threshold_mm, position_mm) in enumerate(
        zip(record.thresholds_mm, positions_mm, strict=True), start=1
    ):
        columns[:, j] = play.simulate(2.0 * threshold_mm, head_mm, position_mm)
    return columns


def _step_prandtl_ishlinskii(
    record: PrandtlIshlinskii, state: ModelState, move_mm: float
) -> ModelState:
    head_mm = state.head_mm + move_mm
    return ModelState(head_mm, prandtl_ishlinskii.step(record, state.memory, head_mm))


def _invert_prandtl_ishlinskii(
    record: PrandtlIshlinskii, state: ModelState, target_mm: float
) -> InverseMove:
    """Refused for targets that are no number, and for a model that never moves."""
    if not (math.isfinite(target_mm) and prandtl_ishlinskii.total_slope(record) > 0.0):
        return InverseMove(move_mm=0.0, reached=False)
    move_mm = prandtl_ishlinskii.inverse_step(record, state.memory, state.head_mm, target_mm)
    return InverseMove(move_mm=move_mm, reached=True)


def _prandtl_ishlinskii_is_well_posed(record: PrandtlIshlinskii) -> bool:
    values = np.array([*record.weights, record.slope, record.offset_mm, record.curvature_per_mm])
    return bool(np.isfinite(values).all() and (record.thresholds_mm >= 0.0).all())


PRANDTL_ISHLINSKII = HysteresisModel(
    name="prandtl-ishlinskii",
    title="Prandtl-Ishlinskii",
    summary="plays of known widths, weights at least 0",
    source="[Krasnoselskii-1989]; [Kuhnen-2003]",
    cannot="loops whose shape changes with the place in the range, loops that are not symmetric "
    "under reversal, corners at other widths than its thresholds",
    inverse="exact, corner by corner",
    parameters=(
        ModelParameter("weights", "w_j", "mm/mm", "share of each play"),
        ModelParameter("slope", "c", "mm/mm", "share of the input itself"),
        ModelParameter("offset_mm", "y_0", "mm", "output for input and plays at 0"),
    ),
    form=LinearForm(
        initial_guesses=_guess_prandtl_ishlinskii,
        penalties=(0.0,),
        nonnegative=True,
        basis=_prandtl_ishlinskii_basis,
        degree=lambda _record: 0,
        with_factors=lambda record, factors: record._replace(
            slope=float(factors[0]), weights=factors[1:-1].copy(), offset_mm=float(factors[-1])
        ),
        parameters=lambda record, ranges: [
            *(
                name_element("play_weight", width_mm, ranges)
                for width_mm in (0.0, *(2.0 * record.thresholds_mm))
            ),
            FitParameter("envelope_0", "{out}"),
        ],
    ),
    memory=lambda record, head_mm, ratio: head_mm - ratio * record.thresholds_mm,
    step=_step_prandtl_ishlinskii,
    output_mm=lambda record, state: prandtl_ishlinskii.output_mm(
        record, state.memory, state.head_mm
    ),
    simulate=prandtl_ishlinskii.simulate,
    inverse_step=_invert_prandtl_ishlinskii,
    is_well_posed=_prandtl_ishlinskii_is_well_posed,
    is_monotone=lambda record: (
        record.slope > 0.0
        and bool((record.weights >= 0.0).all())
        and record.curvature_per_mm == 0.0
    ),
    lines=play_lines.of_prandtl_ishlinskii,
)


LEVELS = (5, 10, 15, 20, 30, 40)
"""Levels of the Preisach model: 15 to 820 cells."""

CELL_RIDGES = (1e-2, 1e-3, 1e-4, 1e-5)
"""Penalties on its cells, as shares of each column's variance: cells hardly visited are pulled to
0."""

MARGIN = 0.02
"""By how much its grid reaches beyond the range of the recording, as a share of it."""


def _guess_preisach(ranges: Ranges) -> list[Preisach]:
    reach_mm = MARGIN * ranges.input_mm
    low_mm, high_mm = ranges.input_low_mm - reach_mm, ranges.input_high_mm + reach_mm
    return [Preisach(low_mm, high_mm, np.zeros((levels, levels)), 0.0) for levels in LEVELS]


def _name_cells(record: Preisach, _ranges: Ranges) -> list[FitParameter]:
    levels = record.weights_mm.shape[0]
    cells = [(k, place) for k in range(levels) for place in range(levels - k)]
    return [
        *(FitParameter(f"cell_{k}_{place}", "{out}") for k, place in cells),
        FitParameter("offset", "{out}"),
    ]


PREISACH = HysteresisModel(
    name="preisach",
    title="Preisach",
    summary="a triangle of relays, weights at least 0",
    source="[Preisach-1935]; [Mayergoyz-1991]",
    cannot="minor loops of equal input that differ in shape with the output, outputs beyond its "
    "grid, gaps of other widths than whole levels",
    inverse="numerical, by bracketing, for weights of 0 and above",
    parameters=(
        ModelParameter("weights_mm", "mu", "mm", "output of each cell of relays"),
        ModelParameter("offset_mm", "y_0", "mm", "output with every relay down"),
    ),
    form=LinearForm(
        initial_guesses=_guess_preisach,
        penalties=CELL_RIDGES,
        nonnegative=True,
        basis=preisach.basis,
        degree=lambda _record: 0,
        with_factors=lambda record, factors: preisach.from_factors(
            record.low_mm, record.high_mm, record.weights_mm.shape[0], factors
        ),
        parameters=_name_cells,
    ),
    memory=preisach.start_positions_mm,
    step=preisach.step,
    output_mm=preisach.output_mm,
    simulate=preisach.simulate,
    inverse_step=preisach.inverse_step,
    is_well_posed=lambda record: (
        record.high_mm > record.low_mm
        and bool(np.isfinite([*record.weights_mm.ravel(), record.offset_mm]).all())
    ),
    is_monotone=preisach.is_monotone,
    lines=play_lines.of_preisach,
)
