"""The catalogue's entry of the play readout: a smooth line over each play of a bank.

The catalogue's entry of the generalised model: Dahl states and plays side by side.

The catalogue's entry of the residual readout: a modified Dahl model and what it leaves.
"""

from collections.abc import Iterable
from itertools import product

import numpy as np

from opensuction.hysteresis import generalised
from opensuction.hysteresis.bank import play_lines, play_readout, residual_readout
from opensuction.hysteresis.bank.play_readout import PlayReadout
from opensuction.hysteresis.bank.residual_readout import ResidualReadout
from opensuction.hysteresis.catalogue.hysteresis_model import (
    FitParameter,
    HysteresisModel,
    LinearForm,
    ModelParameter,
    Ranges,
    name_element,
)
from opensuction.hysteresis.generalised import Generalised
from opensuction.hysteresis.play import InverseMove, ModelState
from opensuction.kernel.record import Array

CORNERS = 49
"""[design] Corners of each line: cells of a fiftieth of the range, the pitch of a gear's teeth or a
cable's turns on the recordings that it was drawn up on."""

RESIDUAL_DECAYS = (0.01, 0.03, 0.1, 0.3)
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
        decays_mm=range_mm * np.array(RESIDUAL_DECAYS),
        gains=np.zeros((len(RESIDUAL_DECAYS), CORNERS)),
        fades_mm=range_mm * np.array(fades, dtype=np.float64),
    )


def _guess_usual(ranges: Ranges) -> list[ResidualReadout]:
    decay_per_mm = 1.0 / (USUAL_DECAY * ranges.input_mm)
    return [guess(ranges.input_low_mm, ranges.input_high_mm, decay_per_mm, FADES)]


def _name_residual_factors(record: ResidualReadout, _ranges: Ranges) -> list[FitParameter]:
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
        parameters=_name_residual_factors,
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


DECAY_SETS = ((0.1,), (0.03, 0.1), (0.01, 0.03, 0.1, 0.3))
"""Decay lengths of the generalised model, as shares of the range of the input: from one state to
four, threefold apart."""

WIDE = (0.02, 0.08, 0.2, 0.32, 0.44, 0.56, 0.68, 0.8, 0.92)
"""Full widths of its plays for gaps of a good part of the range, likewise."""

WIDTH_SETS = ((), (0.02, 0.08, 0.32), (0.01, 0.02, 0.04, 0.08, 0.16, 0.32))
"""Full widths of its plays, likewise: none, fourfold and twofold apart."""

DEGREES = (1, 3, 5)
"""Degrees of its envelope: even ones bend the two ends differently and come with the next odd.
Higher ones follow noise (found on recordings of a tendon-driven tool)."""


Lengths = tuple[float, ...]


def _guess(ranges: Ranges, sets: Iterable[tuple[Lengths, Lengths]]) -> list[Generalised]:
    """Of every degree with each of some pairs of decay lengths and widths."""
    return [
        generalised.on_range(
            ranges.input_low_mm,
            ranges.input_high_mm,
            ranges.input_mm * np.array(decays),
            ranges.input_mm * np.array(widths),
            degree,
        )
        for (decays, widths), degree in product(sets, DEGREES)
    ]


def _invert_generalised(record: Generalised, state: ModelState, target_mm: float) -> InverseMove:
    """Refused where the model is not monotone: the root found would be one of several."""
    if not generalised.is_monotone(record):
        return InverseMove(move_mm=0.0, reached=False)
    return generalised.inverse_step(record, state, target_mm)


def _generalised_is_well_posed(record: Generalised) -> bool:
    lengths = bool(np.all(record.decay_lengths_mm > 0.0) and np.all(record.widths_mm >= 0.0))
    finite = np.isfinite(record.weights).all() and np.isfinite(record.envelope_mm).all()
    return lengths and bool(finite) and record.half_range_mm > 0.0


GENERALISED = HysteresisModel(
    name="generalised",
    title="generalised, linear in its parameters",
    summary="Dahl states, plays and a polynomial envelope",
    source="Dahl states of [paper] eq. (3) and plays of Fig. 5, with a polynomial envelope",
    cannot="loops whose height depends on where in the range they lie; noise is fitted where the "
    "elements are too many",
    inverse="numerical, by bracketing, where it is monotone",
    parameters=(
        ModelParameter("weights", "w_j", "mm/mm", "share of each Dahl state, then of each play"),
        ModelParameter("envelope_mm", "c_k", "mm", "coefficients of the envelope on -1 to 1"),
    ),
    form=LinearForm(
        initial_guesses=lambda ranges: _guess(ranges, product(DECAY_SETS, WIDTH_SETS)),
        wide_guesses=lambda ranges: _guess(ranges, [(DECAY_SETS[1], WIDE)]),
        penalties=(1e-6, 1e-5, 1e-4),  # a thousandth to a hundredth of a column in amplitude
        nonnegative=False,
        basis=generalised.basis,
        degree=lambda record: record.envelope_mm.size - 1,
        with_factors=generalised.with_factors,
        parameters=lambda record, ranges: [
            *(name_element("lag_weight", length, ranges) for length in record.decay_lengths_mm),
            *(name_element("play_weight", width, ranges) for width in record.widths_mm),
            *(FitParameter(f"envelope_{k}", "{out}") for k in range(record.envelope_mm.size)),
        ],
    ),
    memory=generalised.start_elements_mm,
    step=generalised.step,
    output_mm=generalised.output_mm,
    simulate=generalised.simulate,
    inverse_step=_invert_generalised,
    is_well_posed=_generalised_is_well_posed,
    is_monotone=generalised.is_monotone,
    undriven="its weights may have either sign, so that its tip may move the wrong way, and its "
    "inverse is a search whose steps no tick could bound",
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
