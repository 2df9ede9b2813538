"""A dozen plays, each read out by a smooth line that never falls, as plain numbers for a tick.

A line is a cubic of the play's place in the recorded stroke, given by its slope at the low end, in
the middle and at the high end (as control points, so that slopes of 0 and above cannot make it
fall); beyond the stroke it goes on as it ends. The form that a `RecordedConduit` has in the twin:
its own plays, the narrowest twelve of them, and its lines smoothed (`smooth`).
Source: [Lawson-1974] for least squares with slopes held at 0 and above.

Classes of transmission: what kind of thing lies between the catheter's head and its tip.

A conduit that a real recording was fitted with: plays side by side, each read out by a line.

``y = y_0 + sum_k F_k(p_k)``: each p_k is a play of known width, F_k a line with corners at evenly
spaced places that never falls. With widths of whole levels and lines that are level beyond their
ends it is a Preisach model, row by row; with widths of any size and lines that go on, a play
readout. It is the twin's own code and shares nothing with what identifies and compensates but the
play itself: a plant is not graded by its own arithmetic.
Source: [Brokate-1996] ch. 2 for the rows of a Preisach triangle as plays.
"""

from enum import IntEnum
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from opensuction.hysteresis import play
from opensuction.hysteresis.play import PLAYS, Bundle
from opensuction.kernel.codegen.unrolled import unrolled
from opensuction.kernel.record import Array
from opensuction.kernel.vocabulary import by_name


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


ZEROS: Bundle = (0.0,) * PLAYS
TRIED_MM = 0.25
"""Head travel between two samples of the strokes that a smoothed conduit is fitted to."""
SHRINK = 0.75
"""Each of those strokes over the one before."""
SMALLEST = 0.1
"""The smallest of them, as a share of the recorded stroke."""


class PlayLines(NamedTuple):
    """Lines over plays; their widths stand in the transmission's ``widths_mm``."""

    lows_mm: Bundle
    """Position of each play at which its line begins."""
    spans_mm: Bundle
    """Length of each line, above 0."""
    low_slopes: Bundle
    """mm of tip per mm of play at the low end."""
    middle_slopes: Bundle
    """Control points between the ends."""
    high_slopes: Bundle
    widths_mm: Bundle
    """Full widths of the plays as they were fitted."""


NO_LINES = PlayLines(ZEROS, (1.0,) * PLAYS, ZEROS, ZEROS, ZEROS, ZEROS)


@unrolled
def read_out_mm(lines: PlayLines, positions_mm: Bundle) -> float:
    """Sum of what the plays add to the tip, mm."""
    total_mm = 0.0
    for j in range(PLAYS):
        place_mm = positions_mm[j] - lines.lows_mm[j]
        span_mm = lines.spans_mm[j]
        into_mm = min(max(place_mm, 0.0), span_mm)
        t = into_mm / span_mm
        low, middle, high = lines.low_slopes[j], lines.middle_slopes[j], lines.high_slopes[j]
        total_mm += into_mm * (low + t * (middle - low + t * (low - 2.0 * middle + high) / 3.0))
        total_mm += low * min(place_mm, 0.0) + high * max(place_mm - span_mm, 0.0)
    return total_mm


def _strokes_mm(low_mm: float, stroke_mm: float) -> Array:
    """Head over the whole stroke and back, then ever smaller strokes about its middle."""
    points, size = [low_mm, low_mm + stroke_mm, low_mm], 1.0
    while size > SMALLEST:
        size *= SHRINK
        half_mm = 0.5 * size * stroke_mm
        middle_mm = low_mm + 0.5 * stroke_mm
        points += [middle_mm + half_mm, middle_mm - half_mm]
    ways = [
        np.linspace(begin, end, max(int(abs(end - begin) / TRIED_MM), 1), endpoint=False)
        for begin, end in pairwise(points)
    ]
    return np.concatenate(ways)


def _columns(conduit: RecordedConduit, spans_mm: Array, head_mm: Array) -> Array:
    """Tip travel by a slope of 1 at each control point of each play, mm."""
    columns = []
    for row, span_mm in enumerate(spans_mm):
        width = float(conduit.widths_mm[row])
        position_mm = play.simulate(width, head_mm, float(head_mm[0]) + 0.5 * width)
        place_mm = position_mm - conduit.lows_mm[row]
        into_mm = np.clip(place_mm, 0.0, span_mm)
        t = into_mm / span_mm
        columns.append(into_mm * (1.0 - t + t * t / 3.0) + np.minimum(place_mm, 0.0))
        columns.append(into_mm * (t - 2.0 * t * t / 3.0))
        columns.append(into_mm * t * t / 3.0 + np.maximum(place_mm - span_mm, 0.0))
    return np.column_stack(columns)


def _spans_mm(conduit: RecordedConduit) -> Array:
    """Length of the lines of the plays that there is room for: a triangle's become shorter."""
    rows = np.arange(min(conduit.widths_mm.size, PLAYS))
    cells = np.full(rows.size, conduit.gains.shape[1])
    return conduit.cell_mm * (cells if conduit.goes_on else cells - rows).astype(np.float64)


def _bundle(values: Array, spare: float = 0.0) -> Bundle:
    """A number for each play."""
    return tuple(float(value) for value in values) + (spare,) * (PLAYS - values.size)


def smooth(conduit: RecordedConduit) -> tuple[PlayLines, float, float]:
    """A recorded conduit in this form; its offset, mm; and what is lost by it, RMS in mm.

    What is lost is that of the strokes that it is fitted to: a whole one, and ever smaller ones.
    """
    spans_mm = _spans_mm(conduit)
    head_mm = _strokes_mm(float(conduit.lows_mm[0]), float(spans_mm[0]))
    wanted_mm = tip_mm(conduit, head_mm)
    # Loading it takes a third of the start of each process of a machine.
    from scipy.optimize import nnls

    columns = _columns(conduit, spans_mm, head_mm)
    one = np.ones(head_mm.size)
    whole = np.column_stack([columns, one, -one])
    found, left = nnls(whole, wanted_mm, maxiter=20 * whole.shape[1])
    slopes = found[:-2].reshape(spans_mm.size, 3)
    lines = PlayLines(
        lows_mm=_bundle(conduit.lows_mm[:PLAYS]),
        spans_mm=_bundle(spans_mm, 1.0),
        low_slopes=_bundle(slopes[:, 0]),
        middle_slopes=_bundle(slopes[:, 1]),
        high_slopes=_bundle(slopes[:, 2]),
        widths_mm=_bundle(conduit.widths_mm[:PLAYS]),
    )
    return lines, float(found[-2] - found[-1]), float(left / np.sqrt(head_mm.size))


class TransmissionKind(IntEnum):
    """Kind of the transmission from the head to the catheter's tip."""

    PLAYS = 0
    """Clearances along the bends, and a narrow friction-limited stretch behind them."""
    BOUC_WEN = 1
    """No clearance: a lag that bends into saturation, by the Bouc-Wen equations."""
    RUBBING = 2
    """Clearances, and behind them a stretch whose friction depends on speed."""
    RECORDED = 3
    """Plays read out by lines of their own, as a real recording asks for."""


KIND_OF_NAME = by_name(TransmissionKind)


class TransmissionClass(NamedTuple):
    """A class with what its parameters in the machine's table do not say."""

    name: str
    kind: TransmissionKind
    lines: PlayLines
    """Of a recorded conduit."""
    offset_mm: float
    """Tip of a recorded conduit with every play at its low end."""


SUM_OF_PLAYS = TransmissionClass("plays", TransmissionKind.PLAYS, NO_LINES, 0.0)
BOUC_WEN = TransmissionClass("bouc-wen", TransmissionKind.BOUC_WEN, NO_LINES, 0.0)
RUBBING = TransmissionClass("rubbing", TransmissionKind.RUBBING, NO_LINES, 0.0)


def recorded(name: str, lines: PlayLines, offset_mm: float) -> TransmissionClass:
    """The class of a conduit that a recording was fitted with."""
    return TransmissionClass(name, TransmissionKind.RECORDED, lines, offset_mm)
