"""The catalogue's entry of the Maxwell-slip model: slipping elements with lines, and drag."""

import numpy as np

from opensuction.hysteresis.bank import maxwell_slip
from opensuction.hysteresis.bank.maxwell_slip import MaxwellSlip
from opensuction.hysteresis.catalogue.hysteresis_model import (
    FitParameter,
    HysteresisModel,
    LinearForm,
    ModelParameter,
    Ranges,
    name_element,
)
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
