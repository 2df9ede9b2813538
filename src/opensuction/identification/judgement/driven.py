"""Suitability of a fitted model to drive a head: its form there, or the reason and a remedy."""

from typing import NamedTuple

import numpy as np

from opensuction.hysteresis.bank import play_lines
from opensuction.hysteresis.bank.play_lines import PlayLines
from opensuction.hysteresis.catalogue.hysteresis_model import HysteresisModel, Record
from opensuction.identification.record import REVERSAL_SHARE, find_turns
from opensuction.kernel.record import Array

LEAST_PLACES = 6
"""[design] Places at which a recording must turn for a model whose loops change with the place: a
Preisach model of two strokes over one range left 2.1 mm on the twin that it followed to .09."""
SAME_SHARE = 0.05
"""Gains of a play that differ by less along the range, as a share of all, are one gain."""


class Driven(NamedTuple):
    """A model as it drives a head."""

    lines: PlayLines | None = None
    """For `model-preview`; None where it cannot, or has a compensator of its own."""
    why_not: str = ""
    """Why no compensator takes it, and what would do; empty where one does."""


def judge(model: HysteresisModel, record: Record, inputs: Array) -> Driven:
    """Judge a fitted model as one that drives a head.

    record: of the first input. inputs: that were fitted, shape (inputs, n).
    """
    if model.lines is None:
        return Driven(why_not=model.undriven)
    if len(inputs) > 1:
        return Driven(why_not="it follows several inputs, and a head is one: give one --input")
    if np.size(getattr(record, "lags", ())) > 1:
        return Driven(why_not="it has more than one slow state")
    lines = model.lines(record)
    reason = play_lines.why_not_driven(lines)
    if reason is not None:
        return Driven(
            why_not=f"{reason}; identify another model, or a play readout with --method rising"
        )
    places = count_places(inputs[0])
    if changes_with_place(lines) and places < LEAST_PLACES:
        return Driven(
            why_not=f"its loops change with the place, and the recording turns at {places} places "
            f"only: record strokes that turn at {LEAST_PLACES} or more, or identify with --model "
            "prandtl-ishlinskii"
        )
    return Driven(lines)


def changes_with_place(lines: PlayLines) -> bool:
    """True where gains change along the range."""
    spread = float(np.ptp(lines.gains, axis=1).sum())
    return spread > SAME_SHARE * float(play_lines.total_slopes(lines).mean())


def count_places(input_: Array) -> int:
    """Number of places where an input turns, begins or ends; those near one another count once.

    input_: shape (n,).
    """
    least = REVERSAL_SHARE * float(np.ptp(input_))
    places = np.sort(input_[np.append(find_turns(input_, least), [0, input_.size - 1])])
    count, last = 0, -np.inf
    for place in places.tolist():
        if place - last > least:
            count, last = count + 1, place
    return count
