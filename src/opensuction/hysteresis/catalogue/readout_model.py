"""The catalogue's entry of the play readout: a smooth line over each play of a bank."""

import numpy as np

from opensuction.hysteresis.bank import play_lines, play_readout
from opensuction.hysteresis.bank.play_readout import PlayReadout
from opensuction.hysteresis.catalogue.hysteresis_model import (
    FitParameter,
    HysteresisModel,
    LinearForm,
    ModelParameter,
    Ranges,
    name_element,
)

WIDTHS = np.concatenate([[0.0], np.geomspace(0.005, 0.8, 19)])
"""[design] Full widths of the plays, as shares of the input's range: neighbours differ by a
third."""

WIDE_WIDTHS = np.concatenate([[0.0], np.geomspace(0.01, 0.4, 7), np.linspace(0.45, 0.97, 12)])
"""[design] Widths of as many plays for gaps of a good part of the range; a play as wide as the
range never moves."""

CELLS = 12
"""[design] Cells that the range is cut into."""

RIDGES = (1e3, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
"""Penalties on what the gains of a play depart from their mean, as shares of the input's variance;
the first leaves every play one gain."""

DECAYS = (0.3, 1.0, 3.0, 10.0)
"""[design] Decay lengths of the slow state, as shares of the input's range: one of them, or
none."""


def _guess_readout(ranges: Ranges) -> list[PlayReadout]:
    decays = [np.empty(0), *(ranges.input_mm * np.array([share]) for share in DECAYS)]
    return [
        PlayReadout(
            low_mm=ranges.input_low_mm,
            high_mm=ranges.input_high_mm,
            widths_mm=ranges.input_mm * WIDTHS,
            gains=np.zeros((WIDTHS.size, CELLS)),
            decays_mm=decays_mm,
            lags=np.zeros(decays_mm.size),
            offset_mm=0.0,
        )
        for decays_mm in decays
    ]


def _name_factors(record: PlayReadout, ranges: Ranges) -> list[FitParameter]:
    plays = [name_element("gain", width_mm, ranges) for width_mm in record.widths_mm]
    return [
        *(
            FitParameter(f"{play.name}_cell_{cell}", play.unit)
            for play in plays
            for cell in range(record.gains.shape[1])
        ),
        *(name_element("lag_weight", length, ranges) for length in record.decays_mm),
        FitParameter("offset", "{out}"),
    ]


def _readout_is_well_posed(record: PlayReadout) -> bool:
    values = np.concatenate([record.gains.ravel(), record.lags, [record.offset_mm]])
    lengths = bool((record.widths_mm >= 0.0).all() and (record.decays_mm > 0.0).all())
    return lengths and bool(np.isfinite(values).all()) and record.high_mm > record.low_mm


PLAY_READOUT = HysteresisModel(
    name="play-readout",
    title="play readout",
    summary="a smooth line over each of twenty plays, and a slow state",
    source="[Krasnoselskii-1989]; [Brokate-1996] ch. 2; [Eilers-1996] for its penalty",
    cannot="speed and creep; a recording with few reversals leaves it no more than a "
    "Prandtl-Ishlinskii model is",
    inverse="numerical, by bracketing, where its gains are at least 0 and its slow state small",
    parameters=(
        ModelParameter("gains", "g_kj", "mm/mm", "slope of the line over a play in a cell"),
        ModelParameter("lags", "w_s", "mm/mm", "share of each slow state"),
        ModelParameter("offset_mm", "y_0", "mm", "output for plays at the low end"),
    ),
    form=LinearForm(
        initial_guesses=_guess_readout,
        penalties=RIDGES,
        nonnegative=True,
        basis=play_readout.basis,
        degree=lambda _record: 0,
        with_factors=play_readout.with_factors,
        parameters=_name_factors,
    ),
    memory=play_readout.start_elements_mm,
    step=play_readout.step,
    output_mm=play_readout.output_mm,
    simulate=play_readout.simulate,
    inverse_step=play_readout.inverse_step,
    is_well_posed=_readout_is_well_posed,
    is_monotone=play_readout.is_monotone,
    lines=play_lines.of_readout,
)
