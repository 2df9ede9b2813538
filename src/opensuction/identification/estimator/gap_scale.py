"""The gap measured without a tip sensor: by how much the play widths have changed, from contact.

At the carina the switch stays closed on reversal until the tip has drawn back by what it was
pressed in. With the identified weights p_j (shares) and full widths w_j, the head's travel d from
reversal to opening then satisfies ``sum_j p_j max(d - s w_j, 0) = delta/k`` for the scale s of the
widths. The plain travel would be biased: the narrow plays open the switch first.
Source: [calc-gap-scale].
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from opensuction.hysteresis import prandtl_ishlinskii
from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii
from opensuction.identification.record import read_pair
from opensuction.safety.tip_bound import GAP_LEAST, GAP_MOST


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
    return float(brentq(missing_mm, 0.0, widest))
