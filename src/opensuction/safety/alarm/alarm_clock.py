"""The clocks of the alarms: how long a condition has held, and how long nobody has answered it.

Few conditions have a delay, and some rise in priority: each of these has a clock, a number of a
tuple. All others are signalled at once and stay as urgent as they are. The loops are written
out for the compiled core: see `kernel.codegen.unrolled`.
"""

from typing import Annotated, NamedTuple

from annotated_types import Len

from opensuction.kernel.codegen.unrolled import unrolled
from opensuction.safety.condition_mask import HANDLINGS

DELAYED = tuple(bit for bit, handling in enumerate(HANDLINGS) if handling.delay_s > 0.0)
"""Conditions that must hold for a time before they are alarms."""
RISING = tuple(bit for bit, handling in enumerate(HANDLINGS) if handling.escalates_s > 0.0)
"""Conditions that rise by one priority where nobody answers them."""
DELAYED_MASK = sum(1 << bit for bit in DELAYED)
RISING_MASK = sum(1 << bit for bit in RISING)


Seconds = tuple[float, ...]


class Clocks(NamedTuple):
    """Time without a break, s, as far as it is of use."""

    held_s: Annotated[Seconds, Len(len(DELAYED), len(DELAYED))]
    """Of the conditions of `DELAYED`, in their order, as long as they wait."""
    unanswered_s: Annotated[Seconds, Len(len(RISING), len(RISING))]
    """Of the conditions of `RISING`, in their order, as long as they are shown."""


START = Clocks(held_s=(0.0,) * len(DELAYED), unanswered_s=(0.0,) * len(RISING))
"""At power-up."""

Ticked = tuple[int, Seconds]
"""A mask of conditions, and their clocks."""


_DELAYS = tuple((bit, HANDLINGS[bit].delay_s) for bit in DELAYED)
_RISES = tuple((bit, HANDLINGS[bit].escalates_s) for bit in RISING)


@unrolled
def mature(held_s: Seconds, unseen: int, waiting: int, dt_s: float) -> Ticked:
    """Delays that are over.

    unseen: mask of those that hold and are not present yet. waiting: mask of those that waited a
    tick ago; the others begin anew. Returns the conditions of `DELAYED` among the unseen whose
    delay is over, as a mask, and their clocks.
    """
    half_s = 0.5 * dt_s  # sums of ticks are not exact, and never late
    before_s = tuple(held_s[i] if waiting >> bit & 1 else 0.0 for i, bit in enumerate(DELAYED))
    found = 0
    for i, (bit, delay_s) in enumerate(_DELAYS):
        if unseen >> bit & 1 and before_s[i] + half_s >= delay_s:
            found |= 1 << bit
    clocks_s = tuple(
        before_s[i] + dt_s if unseen >> bit & 1 else held_s[i] for i, bit in enumerate(DELAYED)
    )
    return found, clocks_s


@unrolled
def rise(unanswered_s: Seconds, begun: int, running: int, dt_s: float) -> Ticked:
    """Conditions that nobody has answered for their time.

    begun: mask of the conditions that are shown since this tick. running: of those whose time runs.
    Returns those of the conditions of `RISING`, as a mask, and their clocks.
    """
    half_s = 0.5 * dt_s
    clocks_s = tuple(
        0.0
        if begun >> bit & 1
        else (unanswered_s[i] + dt_s if running >> bit & 1 else unanswered_s[i])
        for i, bit in enumerate(RISING)
    )
    found = 0
    for i, (bit, rise_s) in enumerate(_RISES):
        if (running & ~begun) >> bit & 1 and clocks_s[i] + half_s >= rise_s:
            found |= 1 << bit
    return found, clocks_s
