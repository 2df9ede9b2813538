"""The catalogue's entry of the generalised model: Dahl states and plays side by side."""

from collections.abc import Iterable
from itertools import product

import numpy as np

from opensuction.hysteresis import generalised
from opensuction.hysteresis.catalogue.hysteresis_model import (
    FitParameter,
    HysteresisModel,
    LinearForm,
    ModelParameter,
    Ranges,
    name_element,
)
from opensuction.hysteresis.generalised import Generalised
from opensuction.hysteresis.model_state import InverseMove, ModelState

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
