"""The gap measured without a tip sensor: by how much the play widths have changed, from contact.

At the carina the switch stays closed on reversal until the tip has drawn back by what it was
pressed in. With the identified weights p_j (shares) and full widths w_j, the head's travel d from
reversal to opening then satisfies ``sum_j p_j max(d - s w_j, 0) = delta/k`` for the scale s of the
widths. The plain travel would be biased: the narrow plays open the switch first.
Source: [calc-gap-scale].

Gap and offset measured without contact: the tip passes a light barrier on its way in and out.

The barrier is a sensor of the tip at one depth. Inwards the plays of the transmission are taken up
one way, outwards the other: two positions of the head with the tip at the same known depth tell the
scale of the widths (from their distance) and the offset (from their middle). Any model of the
transmission will do that says where the tip is after a way of the head: see `TipModel`.
Source: [calc-mouth-passage].
"""

from collections.abc import Callable
from enum import IntEnum
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.typing import ArrayLike

from opensuction.hysteresis import modified_dahl, prandtl_ishlinskii
from opensuction.hysteresis.bank import play_lines
from opensuction.hysteresis.bank.play_lines import PlayLines
from opensuction.hysteresis.modified_dahl import ModifiedDahl
from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii
from opensuction.identification.extremum import find_root
from opensuction.identification.record import find_turns, read_pair
from opensuction.safety.limits import GAP_LEAST, GAP_MOST

Array = npt.NDArray[np.float64]
TipModel = Callable[[float, Array], float]
"""``tip_mm(scale, turns_mm)``: where the tip is, mm, at the end of a way of the head.

scale: of the model's widths. turns_mm: head at the start, where a long retract ended, at each turn
and at the end, shape (n,); monotone between them.
"""

SMALLEST_TURN_MM = 0.005
"""Turns of less are the encoder's own steps."""
DIRECTION_TICKS = 10
"""The head must have moved the right way over so many ticks either side of a passage."""
SCALES = np.linspace(0.0, 2.0, 81)
"""Scales that are searched; the first that explains both passages is meant. Beyond it the plays are
so wide that the tip would not have moved."""

LEAST_SCALE = 1e-3
"""A modified Dahl model without any gap would have an infinite decay."""


class Missed(IntEnum):
    """Reason why a cycle's passages teach nothing; `SENTENCES` has the words."""

    NOTHING = 0
    """Nothing is missing."""
    NO_BARRIER = 1
    NO_PASSAGE = 2
    UNCLEAN = 3
    NOT_ON_THE_WAY = 4
    UNEXPLAINED = 5


SENTENCES = {
    Missed.NOTHING: "",
    Missed.NO_BARRIER: "there is no light barrier",
    Missed.NO_PASSAGE: "the light barrier saw no catheter come and go",
    Missed.UNCLEAN: "the light barrier changed more than once a way: something else was in its "
    "beam",
    Missed.NOT_ON_THE_WAY: "the light barrier changed while the head was not on its way",
    Missed.UNEXPLAINED: "no width of the gap explains where the catheter passed the light barrier",
}


class Passage(NamedTuple):
    """The tip at the barrier, once inwards and once outwards: ways of the head from its start."""

    inwards_mm: Array
    """Head at the start, at each turn, and as the tip came into the beam; shape (n,)."""
    outwards_mm: Array
    """The same up to the instant at which the beam was free again."""


class Shift(NamedTuple):
    """Difference of a transmission from the one that was identified."""

    scale: float
    """Of all widths."""
    offset_mm: float
    """By how much the tip lies deeper."""


AS_IDENTIFIED = Shift(1.0, 0.0)
UNKNOWN = Shift(float("nan"), float("nan"))


def find_passage(
    mouth_clear: ArrayLike, head_mm: ArrayLike, period_s: float, latency_s: float = 0.0
) -> Passage | Missed:
    """The two passages in a recording of barrier and encoder, or why they cannot be used.

    mouth_clear: 0 or 1, shape (n,), from the head at rest after a retract to the catheter out
    again. head_mm: shape (n,). period_s: of the samples. latency_s: by which the barrier is later
    than the encoder. Usable is one clean edge each way: a beam that flickers tells of secretions.
    Raises InputError for records that are not finite rows of equal length.
    """
    clear, head = read_pair(("mouth_clear", "head_mm"), mouth_clear, head_mm, 3)
    free = clear > 0.5
    edges = np.flatnonzero(free[1:] != free[:-1]) + 1
    if edges.size < 2 or not (free[0] and free[-1]):
        return Missed.NO_PASSAGE
    if edges.size > 2:
        return Missed.UNCLEAN
    delay = round(latency_s / period_s)
    came, left = (max(int(edge) - delay, 1) for edge in edges)
    if not (_moved_mm(head, came) > 0.0 and _moved_mm(head, left) < 0.0):
        return Missed.NOT_ON_THE_WAY
    return Passage(_way_mm(head, came), _way_mm(head, left))


def _moved_mm(head: Array, tick: int) -> float:
    """Travel of the head around a tick."""
    before, after = max(tick - DIRECTION_TICKS, 0), min(tick + DIRECTION_TICKS, head.size - 1)
    return float(head[after] - head[before])


def _way_mm(head: Array, tick: int) -> Array:
    """Turns of the head from its start to the middle of a tick."""
    end = 0.5 * (head[tick - 1] + head[tick])
    way = np.append(head[:tick], end)
    return np.concatenate([way[:1], way[find_turns(way, SMALLEST_TURN_MM)], way[-1:]])


def play_tip_mm(model: PrandtlIshlinskii) -> TipModel:
    """The tip by plays, as identified: scale 1."""

    def tip_mm(scale: float, turns_mm: Array) -> float:
        scaled = prandtl_ishlinskii.scale_widths(model, scale)
        start = prandtl_ishlinskii.retracted_positions_mm(scaled, turns_mm[0])
        return float(prandtl_ishlinskii.simulate(scaled, turns_mm, start)[-1])

    return tip_mm


def lines_tip_mm(lines: PlayLines) -> TipModel:
    """The tip by plays with lines over them, as identified: scale 1."""

    def tip_mm(scale: float, turns_mm: Array) -> float:
        table = play_lines.tabulate(lines._replace(widths_mm=scale * lines.widths_mm))
        half_mm, lag_mm = 0.5 * scale * lines.widths_mm, lines.decay_mm
        positions = turns_mm[0] + half_mm
        for before_mm, after_mm in pairwise(turns_mm.tolist()):
            positions = np.clip(positions, after_mm - half_mm, after_mm + half_mm)
            lag_mm = float(play_lines.step_lag(table, lag_mm, after_mm - before_mm))
        return float(play_lines.output_mm(table, positions, lag_mm))

    return tip_mm


def scale_dahl(model: ModifiedDahl, scale: float) -> ModifiedDahl:
    """The same model, its gap and the travel in which it opens multiplied by ``scale``."""
    return model._replace(decay_per_mm=model.decay_per_mm / scale)


def dahl_tip_mm(model: ModifiedDahl) -> TipModel:
    """The tip by a modified Dahl model, as identified: scale 1."""

    def tip_mm(scale: float, turns_mm: Array) -> float:
        scaled = scale_dahl(model, max(scale, LEAST_SCALE))
        start = float(modified_dahl.saturation_mm(scaled))
        return float(modified_dahl.simulate(scaled, turns_mm, start)[-1])

    return tip_mm


def estimate(tip_mm: TipModel, seen: Passage, mouth_mm: float) -> Shift | Missed:
    """Difference of the transmission from its model, by both passages; not bounded.

    tip_mm: the model as it was identified. mouth_mm: depth of the barrier.
    """

    def apart_mm(scale: float) -> float:
        """Modelled tip depth on the way in less that on the way out; falls with the scale."""
        return tip_mm(scale, seen.inwards_mm) - tip_mm(scale, seen.outwards_mm)

    values = np.array([apart_mm(scale) for scale in SCALES])
    if values[0] <= 0.0:
        return Missed.UNEXPLAINED  # no gap at all is too much
    beyond = np.flatnonzero(values <= 0.0)
    if beyond.size == 0:
        return Missed.UNEXPLAINED
    first = int(beyond[0])
    scale = find_root(apart_mm, float(SCALES[first - 1]), float(SCALES[first]))
    both = [tip_mm(scale, way) for way in (seen.inwards_mm, seen.outwards_mm)]
    return Shift(scale, mouth_mm - 0.5 * sum(both))


def read(
    tip_mm: TipModel,
    mouth_clear: ArrayLike,
    head_mm: ArrayLike,
    mouth_mm: float,
    period_s: float,
    latency_s: float = 0.0,
) -> Shift | Missed:
    """Difference of the transmission in one recorded cycle: `find_passage`, then `estimate`.

    mouth_mm: depth of the barrier; infinite where there is none.
    """
    if not np.isfinite(mouth_mm):
        return Missed.NO_BARRIER
    seen = find_passage(mouth_clear, head_mm, period_s, latency_s)
    return seen if isinstance(seen, Missed) else estimate(tip_mm, seen, mouth_mm)


class ContactEpisode(NamedTuple):
    """One contact, in head travel; the latency of the switch is already taken off."""

    travel_mm: float
    """d: from the reversal to the opening of the switch."""
    pressed_mm: float
    """From the closing of the switch to the reversal."""
    steady: bool = True
    """The switch stayed closed but for its bounces: nothing moved against the tip."""


class ScaleLimits(NamedTuple):
    """Scales that are accepted, and what the switch needs to open."""

    least: float
    most: float
    release_mm: float
    """Tip travel from the force that closes the switch to the smaller one that opens it."""


BOUNCING_S = 0.02
"""For how long a closed switch is open while it bounces: twice the 10 ms that are assumed."""

MEASURING_ERROR = 0.03
"""Of a scale from one contact: on the twin up to .025, on a neonate with gaps x 0.7."""

TRUSTED = ScaleLimits(
    least=GAP_LEAST - MEASURING_ERROR,  # beyond this range of gaps, which the governor's bounds on
    most=GAP_MOST + MEASURING_ERROR,  # the tip allow for, no estimate of the tip is valid
    release_mm=0.037,  # 15 % of 0.08017 N against 0.32 N/mm of catheter and rubber in series
)


def find_contact(
    contact_closed: ArrayLike, head_mm: ArrayLike, period_s: float, latency_s: float
) -> ContactEpisode | None:
    """The contact in a recording of switch and encoder, or None where there is no usable one.

    contact_closed: 0 or 1, shape (n,), as read; a break of bounce is part of the contact. head_mm:
    shape (n,). period_s: of the samples. latency_s: of the switch's line. Usable is a contact that
    the head came upon on its way in and that ended on its way out.
    Raises InputError for records that are not finite rows of equal length.
    """
    closed, head = read_pair(("contact_closed", "head_mm"), contact_closed, head_mm, 3)
    ticks = np.flatnonzero(closed > 0.0)
    if ticks.size == 0 or ticks[-1] == closed.size - 1 or ticks[0] == 0:
        return None
    first, opened = int(ticks[0]), int(ticks[-1]) + 1
    turn = first + int(np.argmax(head[first:opened]))
    longest_break = int(np.diff(ticks).max(initial=1)) - 1
    delay = round(latency_s / period_s)
    # The head at the instants that a delayed line reports.
    closing_mm, opening_mm = (head[max(tick - delay, 0)] for tick in (first, opened))
    travel_mm, pressed_mm = head[turn] - opening_mm, head[turn] - closing_mm
    if not (travel_mm > 0.0 and pressed_mm >= 0.0):
        return None
    steady = longest_break * period_s <= BOUNCING_S
    return ContactEpisode(float(travel_mm), float(pressed_mm), steady)


def estimate_scale(model: PrandtlIshlinskii, seen: ContactEpisode, limits: ScaleLimits) -> float:
    """Scale of the model's widths that explains a contact; not bounded.

    model: as it was identified, scale 1. The plays must have been saturated inwards at contact.
    """
    gain = float(prandtl_ishlinskii.total_slope(model))
    shares = np.append(model.weights, model.slope) / gain
    widths = np.append(2.0 * model.thresholds_mm, 0.0)
    drawn_mm = seen.pressed_mm + limits.release_mm / gain

    def missing_mm(trial: float) -> float:
        """Excess of the tip travel by widths of this scale over the measured one; falls with it."""
        return float(shares @ np.maximum(seen.travel_mm - trial * widths, 0.0)) - drawn_mm

    if missing_mm(0.0) <= 0.0:
        return 0.0  # the tip followed the head at once: no gap at all
    widest = seen.travel_mm / float(widths[widths > 0.0].min())
    if missing_mm(widest) >= 0.0:
        return widest
    return find_root(missing_mm, 0.0, widest)
