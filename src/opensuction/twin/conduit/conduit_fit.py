"""A conduit from a real recording: the gains of its lines by bounded least squares.

The recordings that the project's conduits were fitted to (`settings/conduit`) are of a cable-driven
instrument: degrees in, degrees out. They are brought to the head's stroke by one factor, the same
for input and output, so that gain and loop keep their proportions.
Source: [Lawson-1974] for least squares with gains held at 0 and above.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from opensuction.hysteresis import play
from opensuction.kernel.record import Array
from opensuction.twin.conduit import play_line
from opensuction.twin.conduit.play_line import RecordedConduit

STROKE_MM = 120.0
"""Head travel that the input's range becomes: what the paper's trapezoid and a gap ask for."""
LOWEST_TIP_MM = -7.0
"""Tip at the low end of its range; the paper's offsets are -7.1 and -7.2 mm."""
LEVELS = 40
"""Of a Preisach grid over the stroke: 3 mm each."""
ROWS = 12
"""Of its triangle: gaps up to 33 mm, where the recordings' are 3 to 10 mm."""
WIDTHS_MM = (0.0, 1.5, 3.0, 4.5, 6.0, 8.0, 10.0, 14.0, 20.0, 36.0)
"""Of a bank of plays: dense where the recordings' gaps are, 3 to 10 mm."""
CELLS = 12
"""Of each line of a bank."""
PASTS = (-1.0, 0.0, 1.0)
"""What may have been before a recording begins."""
RIDGE = 1e-4
"""Penalty on each gain, as a share of its column's variance."""
BEND = 3e-5
"""Penalty on the difference of neighbouring gains of a play, over the square of the stroke."""
COVERED = 0.1
"""Share of the stroke at either end in which repeats are not compared: they turn there."""
PLACES = 60
"""Head positions at which repeats are compared."""


class FittedConduit(NamedTuple):
    """A conduit of a recording, and how well it describes it."""

    conduit: RecordedConduit
    past: float
    """What came before the recording: see `recorded_conduit.tip_mm`."""
    residual_mm: float
    """Root mean square of what the conduit leaves of the recording."""


def scale(input_deg: Array, output_deg: Array) -> tuple[Array, Array]:
    """Head and tip in mm of a recording in degrees, shape (n,) each; they rise together."""
    mm_per_deg = STROKE_MM / float(np.ptp(input_deg))
    head_mm = mm_per_deg * (input_deg - input_deg.min())
    return head_mm, mm_per_deg * (output_deg - output_deg.min()) + LOWEST_TIP_MM


def empty(kind: str) -> RecordedConduit:
    """Plays and corners of a kind, ``preisach`` or ``readout``, every gain 0."""
    if kind == "preisach":
        return play_line.triangle(LEVELS, ROWS, 0.0, STROKE_MM)
    return play_line.bank(np.array(WIDTHS_MM), CELLS, 0.0, STROKE_MM)


def fit(kind: str, head_mm: Array, tip_mm: Array) -> FittedConduit:
    """The conduit of a kind that describes a recording best; head_mm, tip_mm: shape (n,)."""
    tried = [_fit_after(empty(kind), head_mm, tip_mm, past) for past in PASTS]
    return min(tried, key=lambda found: found.residual_mm)


def _cells(start: RecordedConduit, row: int) -> int:
    """Number of cells of a row that count: the triangle's rows become shorter."""
    cells = int(start.gains.shape[1])
    return cells if start.goes_on else cells - row


def _columns(start: RecordedConduit, head_mm: Array, past: float) -> Array:
    """Travel of each play in each of its cells, mm; shape (n, cells)."""
    columns = []
    for row, width in enumerate(start.widths_mm):
        first_mm = float(head_mm[0] - 0.5 * past * width)
        position_mm = play.simulate(float(width), head_mm, first_mm)
        last = _cells(start, row) - 1
        for cell in range(last + 1):
            lowest = -np.inf if start.goes_on and cell == 0 else 0.0
            highest = np.inf if start.goes_on and cell == last else start.cell_mm
            into_mm = position_mm - start.lows_mm[row] - cell * start.cell_mm
            columns.append(np.clip(into_mm, lowest, highest))
    return np.column_stack(columns)


def _penalties(start: RecordedConduit, centred: Array) -> Array:
    """Rows of the least-squares problem that hold gains back and neighbours together."""
    from scipy.linalg import block_diag

    deviations = centred.std(axis=0)
    deviations += 1e-3 * deviations.max()  # a cell that nothing passes stays at 0
    counts = [_cells(start, row) for row in range(start.gains.shape[0])]
    steps = block_diag(*(np.diff(np.eye(count), axis=0) for count in counts))
    rows = [np.sqrt(RIDGE) * np.diag(deviations), np.sqrt(BEND) * STROKE_MM * steps]
    return np.asarray(np.sqrt(float(centred.shape[0])) * np.vstack(rows))


def _fit_after(start: RecordedConduit, head_mm: Array, tip_mm: Array, past: float) -> FittedConduit:
    from scipy.optimize import nnls

    columns = _columns(start, head_mm, past)
    means = columns.mean(axis=0)
    penalties = _penalties(start, columns - means)
    wanted = np.append(tip_mm - tip_mm.mean(), np.zeros(penalties.shape[0]))
    found, _ = nnls(np.vstack([columns - means, penalties]), wanted, maxiter=20 * means.size)
    gains, first = np.zeros_like(start.gains), 0
    for row in range(gains.shape[0]):
        cells = _cells(start, row)
        gains[row, :cells] = found[first : first + cells]
        first += cells
    conduit = start._replace(gains=gains, offset_mm=float(tip_mm.mean() - means @ found))
    left_mm = tip_mm - play_line.tip_mm(conduit, head_mm, past=past)
    return FittedConduit(conduit, past, float(np.sqrt(np.mean(np.square(left_mm)))))


def scatter_mm(head_mm: Array, tip_mm: Array) -> float:
    """Scatter of repeats of the same stroke: standard deviation, mm.

    Of all full strokes of a recording in one direction, at the same head positions, pooled over
    places and directions. No model that knows only the head's way can leave less.
    """
    stroke = float(np.ptp(head_mm))
    low = float(head_mm.min())
    places = np.linspace(low + COVERED * stroke, low + (1.0 - COVERED) * stroke, PLACES)
    strokes: dict[bool, list[Array]] = {True: [], False: []}
    turns = _turns(head_mm, 0.5 * stroke)
    for first, last in pairwise(turns):
        heads, tips = head_mm[first : last + 1], tip_mm[first : last + 1]
        if heads.min() <= places[0] and heads.max() >= places[-1]:
            order = np.argsort(heads, kind="stable")
            rising = bool(heads[-1] > heads[0])
            strokes[rising].append(np.interp(places, heads[order], tips[order]))
    variances = [np.var(group, axis=0, ddof=1) for group in strokes.values() if len(group) > 1]
    return float(np.sqrt(np.mean(variances)))


def _turns(head_mm: Array, least_mm: float) -> list[int]:
    """Samples at which the head turns and goes back at least so far; first and last with them."""
    turns, best, direction = [0], 0, 0.0
    for k in range(1, head_mm.size):
        ahead = direction * (head_mm[k] - head_mm[best])
        if direction == 0.0:
            if abs(head_mm[k] - head_mm[0]) >= least_mm:
                direction = float(np.sign(head_mm[k] - head_mm[0]))
                best = k
        elif ahead > 0.0:
            best = k
        elif ahead <= -least_mm:
            turns.append(best)
            best, direction = k, -direction
    turns.append(best)
    return turns
