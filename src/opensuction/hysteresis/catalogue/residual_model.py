"""The catalogue's entry of the residual readout: a modified Dahl model and what it leaves."""

import numpy as np

from opensuction.hysteresis.bank import residual_readout
from opensuction.hysteresis.bank.residual_readout import ResidualReadout
from opensuction.hysteresis.catalogue.hysteresis_model import (
    FitParameter,
    HysteresisModel,
    LinearForm,
    ModelParameter,
    Ranges,
    name_element,
)
from opensuction.kernel.record import Array

CORNERS = 49
"""[design] Corners of each line: cells of a fiftieth of the range, the pitch of a gear's teeth or a
cable's turns on the recordings that it was drawn up on."""

DECAYS = (0.01, 0.03, 0.1, 0.3)
"""[design] Decay lengths of the further lags, as shares of the input's range: half a decade
apart."""

FADES = (0.03, 0.1, 0.3, 1.0, 3.0)
"""[design] Travels over which what was before the recording fades, likewise."""

USUAL_DECAY = 0.05
"""[design] Decay length of the model beneath, likewise, until a recording tells it."""

SCALES = tuple(float(scale) for scale in 10.0 ** np.arange(-2.0, 4.1, 0.5))
"""Scales of the penalty on the lines: from hardly any to one that leaves the modified Dahl model
alone."""


def guess(
    low_mm: float, high_mm: float, decay_per_mm: float, fades: tuple[float, ...]
) -> ResidualReadout:
    """A model of a range with every factor 0. fades: shares of the range."""
    range_mm = high_mm - low_mm
    return ResidualReadout(
        low_mm=low_mm,
        high_mm=high_mm,
        slope=0.0,
        velocity_gain=0.0,
        decay_per_mm=decay_per_mm,
        offset_mm=0.0,
        curve_mm=np.zeros(CORNERS),
        decays_mm=range_mm * np.array(DECAYS),
        gains=np.zeros((len(DECAYS), CORNERS)),
        fades_mm=range_mm * np.array(fades, dtype=np.float64),
    )


def _guess_usual(ranges: Ranges) -> list[ResidualReadout]:
    decay_per_mm = 1.0 / (USUAL_DECAY * ranges.input_mm)
    return [guess(ranges.input_low_mm, ranges.input_high_mm, decay_per_mm, FADES)]


def _name_factors(record: ResidualReadout, _ranges: Ranges) -> list[FitParameter]:
    range_ = Ranges(record.low_mm, record.high_mm, 0.0, 1.0, 0.0)
    lags = [name_element("lag_gain", length, range_) for length in record.decays_mm]
    corners = range(record.curve_mm.size)
    return [
        FitParameter("slope", "{out}/{in}"),
        FitParameter("velocity_gain", "{out}/{in}"),
        *(FitParameter(f"curve_{corner}", "{out}") for corner in corners),
        *(
            FitParameter(f"{lag.name}_corner_{corner}", lag.unit)
            for lag in lags
            for corner in corners
        ),
        FitParameter("offset", "{out}"),
    ]


def _is_well_posed(record: ResidualReadout) -> bool:
    values: Array = np.concatenate([record.curve_mm, record.gains.ravel(), record[2:6]])
    lengths = np.concatenate([record.decays_mm, record.fades_mm, [record.decay_per_mm]])
    finite = bool(np.isfinite(values).all())
    return finite and bool((lengths > 0.0).all()) and record.high_mm > record.low_mm


RESIDUAL_READOUT = HysteresisModel(
    name="residual-readout",
    title="residual readout",
    summary="a modified Dahl model, and a smooth readout of what it leaves; predicts only",
    source="[paper] eqs. (3) and (4); [Eilers-1996] and [MacKay-1992] for its penalty",
    cannot="speed and creep, closed minor loops; it drives nothing, for its output may move the "
    "wrong way after a reversal",
    inverse="none: it predicts, and drives nothing",
    parameters=(
        ModelParameter("slope", "c", "mm/mm", "output per input of the model beneath"),
        ModelParameter("velocity_gain", "beta", "mm/mm", "how fast its lag follows the input"),
        ModelParameter("decay_per_mm", "alpha_0", "1/mm", "inverse of the travel that it forgets"),
        ModelParameter("offset_mm", "y_0", "mm", "output for input and lags at 0, but for g"),
        ModelParameter("curve_mm", "g_m", "mm", "what the place adds at each corner"),
        ModelParameter("gains", "G_sm", "mm/mm", "output of each further lag at each corner"),
    ),
    form=LinearForm(
        initial_guesses=_guess_usual,
        penalties=SCALES,
        nonnegative=False,
        basis=residual_readout.basis,
        degree=lambda _record: 0,
        with_factors=residual_readout.with_factors,
        parameters=_name_factors,
    ),
    memory=residual_readout.start_elements_mm,
    step=residual_readout.step,
    output_mm=residual_readout.output_mm,
    simulate=residual_readout.simulate,
    inverse_step=residual_readout.refuse_inverse,
    is_well_posed=_is_well_posed,
    is_monotone=lambda _record: False,
    undriven="its output may move the wrong way after a reversal: it predicts only",
    has_inverse=False,
)
