"""A conduit that a real recording was fitted with: plays side by side, each read out by a line.

``y = y_0 + sum_k F_k(p_k)``: each p_k is a play of known width, F_k a line with corners at evenly
spaced places that never falls. With widths of whole levels and lines that are level beyond their
ends it is a Preisach model, row by row; with widths of any size and lines that go on, a play
readout. It is the twin's own code and shares nothing with what identifies and compensates but the
play itself: a plant is not graded by its own arithmetic.
Source: [Brokate-1996] ch. 2 for the rows of a Preisach triangle as plays.
"""

from typing import NamedTuple

import numpy as np

from opensuction.hysteresis import play
from opensuction.kernel.record import Array


class RecordedConduit(NamedTuple):
    """Parameters of such a conduit, head_mm to tip_mm."""

    widths_mm: Array
    """Full width of each play, at least 0; shape (k,)."""
    lows_mm: Array
    """Position of each play at which its line begins; shape (k,)."""
    cell_mm: float
    """Distance between two corners."""
    gains: Array
    """Slope of each line between its corners, at least 0; shape (k, m)."""
    goes_on: bool
    """Whether a line goes on beyond its ends as it ends; else it is level there."""
    offset_mm: float
    """Tip position with every play at its low end."""


def line_mm(conduit: RecordedConduit, row: int, position_mm: Array) -> Array:
    """Contribution of one play to the tip, mm; of the shape of ``position_mm``."""
    gains = conduit.gains[row]
    steps_mm = conduit.cell_mm * np.arange(gains.size + 1)
    place_mm = position_mm - conduit.lows_mm[row]
    line = np.interp(place_mm, steps_mm, conduit.cell_mm * np.append(0.0, np.cumsum(gains)))
    if conduit.goes_on:
        line = line + gains[0] * np.minimum(place_mm, 0.0)
        line += gains[-1] * np.maximum(place_mm - steps_mm[-1], 0.0)
    return np.asarray(line)


def tip_mm(
    conduit: RecordedConduit, head_mm: Array, gap_ratio: float = 1.0, past: float = -1.0
) -> Array:
    """Tip positions of head positions, both of shape (n,).

    gap_ratio: of every width, the conduit being laid otherwise. past: +1.0 after a long advance,
    -1.0 after a long retract, between for what lies between.
    """
    tip = np.full(head_mm.size, conduit.offset_mm)
    for row, width in enumerate(gap_ratio * conduit.widths_mm):
        start_mm = float(head_mm[0] - 0.5 * past * width)
        tip += line_mm(conduit, row, play.simulate(float(width), head_mm, start_mm))
    return tip


def triangle(levels: int, rows: int, low_mm: float, high_mm: float) -> RecordedConduit:
    """A Preisach grid over a range of the head, every gain 0.

    rows: how many of the triangle there are, the narrow ones; relays of wider gaps count nothing.
    """
    cell_mm = (high_mm - low_mm) / levels
    widths_mm: Array = cell_mm * np.arange(rows, dtype=np.float64)
    return RecordedConduit(
        widths_mm=widths_mm,
        lows_mm=low_mm + 0.5 * widths_mm,
        cell_mm=cell_mm,
        gains=np.zeros((rows, levels)),
        goes_on=False,
        offset_mm=0.0,
    )


def bank(widths_mm: Array, cells: int, low_mm: float, high_mm: float) -> RecordedConduit:
    """A bank of plays whose lines go over a range of the head, every gain 0."""
    return RecordedConduit(
        widths_mm=widths_mm,
        lows_mm=np.full(widths_mm.size, low_mm),
        cell_mm=(high_mm - low_mm) / cells,
        gains=np.zeros((widths_mm.size, cells)),
        goes_on=True,
        offset_mm=0.0,
    )
