"""Bounds that a fit ended at: what lies beyond them was not searched.

A parameter at a limit of its search, or a superposition most of whose hysteresis stands in the last
element of its grid, says how far the search went, not what the recording holds.
"""

import math

import numpy as np

from opensuction.hysteresis.bank import maxwell_slip
from opensuction.hysteresis.bank.maxwell_slip import MaxwellSlip
from opensuction.hysteresis.bank.play_readout import PlayReadout
from opensuction.hysteresis.bank.residual_readout import ResidualReadout
from opensuction.hysteresis.catalogue.generalised_model import DECAY_SETS, WIDE
from opensuction.hysteresis.catalogue.hysteresis_model import (
    BRIEFEST,
    LONGEST,
    FitParameter,
    Ranges,
    Record,
    VectorForm,
    name_element,
)
from opensuction.hysteresis.catalogue.play_family import LEVELS, MARGIN, PITCHES
from opensuction.hysteresis.catalogue.readout_model import DECAYS, WIDE_WIDTHS
from opensuction.hysteresis.catalogue.residual_model import DECAYS as RESIDUAL_DECAYS
from opensuction.hysteresis.catalogue.slip_model import WIDE_REACHES
from opensuction.hysteresis.generalised import Generalised
from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii
from opensuction.hysteresis.preisach import Preisach
from opensuction.identification.estimator.nonlinear import NonlinearFit
from opensuction.kernel.record import Array

NEAR = 1e-6
"""How near to a limit a value counts as being there, as a share of it."""

MOST = 0.5
"""Share of a model's elements in the last one of the grid from which the grid ended too soon."""

LEADS = (
    "; an output that leads its input, as friction does, and one without hysteresis end there: try "
    "dahl or bouc-wen"
)

REVERSALS = {
    "stiffness": f"a reversal is over within {BRIEFEST:.3%} of the input's range or less",
    "limit": f"a reversal is remembered for {LONGEST:g} times the input's range or more",
}
"""What it means that a Dahl state's length is at a limit, by the parameter that is held by it."""


def find_limits(form: VectorForm, found: NonlinearFit, ranges: Ranges) -> dict[str, str]:
    """Parameters at a limit of their search, with the sentence that says so.

    form: of the fitted model. ranges: of the recording. The memory at the first sample, which is
    the recording's own, may well be at its limit: after a long stroke it is.
    """
    said = {name: f"At its bound: {name}; {REVERSALS[name]}." for name in found.at_limit}
    limits = form.limits(ranges).tolist()
    named = zip(form.parameters[:-1], found.vector[:-1].tolist(), limits[:-1], strict=True)
    for parameter, value, (low, high) in named:
        for end, word in ((low, "lowest"), (high, "highest")):
            if math.isfinite(end) and math.isclose(value, end, rel_tol=NEAR, abs_tol=1e-300):
                said[parameter.name] = _describe(parameter, value, word)
    return said


def _describe(parameter: FitParameter, value: float, word: str) -> str:
    beyond = LEADS if parameter.name == "velocity_gain" else ""
    return (
        f"At its bound: {parameter.name} is {value:.4g}, the {word} that is searched, and so has "
        f"no interval; the best value may lie beyond{beyond}."
    )


def find_grid_ends(record: Record, ranges: Ranges) -> dict[str, str]:
    """Elements at the end of their grid, with the sentence that says so. ranges: as above.

    Usual grids end sooner than the widest ones that are tried; these were no better then.
    """
    match record:
        case PrandtlIshlinskii():
            widest = 1.0 - 1.0 / max(PITCHES)
            ends = [("play_weight", 2.0 * record.thresholds_mm, record.weights, widest)]
        case PlayReadout():
            gains = np.abs(record.gains).sum(axis=1)
            ends = [
                ("gain", record.widths_mm, gains, float(WIDE_WIDTHS[-1])),
                ("lag_weight", record.decays_mm, record.lags, max(DECAYS)),
            ]
        case Generalised():
            lags = record.decay_lengths_mm.size
            longest = max(max(decays) for decays in DECAY_SETS)
            ends = [
                ("lag_weight", record.decay_lengths_mm, record.weights[:lags], longest),
                ("play_weight", record.widths_mm, record.weights[lags:], max(WIDE)),
            ]
        case ResidualReadout():
            heights = np.abs(record.gains).sum(axis=1) * record.decays_mm
            ends = [("lag_gain", record.decays_mm, heights, max(RESIDUAL_DECAYS))]
        case MaxwellSlip():
            shares = maxwell_slip.share_out(record)
            ends = [("gain", record.reaches_mm, shares, float(WIDE_REACHES[-1]))]
        case Preisach():
            return _judge_levels(record)
        case _:
            return {}
    said = {}
    for kind, lengths, weights, end in ends:
        name = _find_end(kind, lengths, np.abs(weights), end, ranges)
        if name:
            said[name] = (
                f"At its bound: {name} holds most of its kind, and no longer one is tried: a wider "
                "loop or a longer memory than that may fit better."
            )
    return said


def _find_end(kind: str, lengths: Array, weights: Array, end: float, ranges: Ranges) -> str:
    """Name of the last element where the grid ended too soon; else empty. end: share of a range."""
    if not weights.sum() > 0.0 or lengths[-1] < (1.0 - 0.01) * end * ranges.input_mm:
        return ""
    holds = float(weights[-1]) > MOST * float(weights.sum())
    return name_element(kind, float(lengths[-1]), ranges).name if holds else ""


def _judge_levels(record: Preisach) -> dict[str, str]:
    levels = record.weights_mm.shape[0]
    if levels < LEVELS[-1]:
        return {}
    share = (1.0 + 2.0 * MARGIN) / levels
    return {
        "levels": f"At its bound: {levels} levels are the finest grid that is tried; gaps and "
        f"corners are followed in steps of {share:.1%} of the input's range."
    }
