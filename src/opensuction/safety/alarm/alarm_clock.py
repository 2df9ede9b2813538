"""The clocks of the alarms: how long a condition has held, and how long nobody has answered it.

Few conditions have a delay, and some rise in priority: each of these has a clock, a number of a
tuple. All others are signalled at once and stay as urgent as they are. The steps are written out,
a clock after the other: see `kernel.codegen.straight_line`.
"""

from collections.abc import Callable, Sequence
from typing import Annotated, NamedTuple

from annotated_types import Len

from opensuction.kernel.codegen import straight_line
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


def _stepper(
    head: str, each: Sequence[str], bits: Sequence[int], about: str
) -> Callable[..., Ticked]:
    """A function that goes through the clocks of some conditions. each: of clock i, condition c."""
    lines = [head, "    half_s = 0.5 * dt_s", "    found = 0"]
    for i, bit in enumerate(bits):
        values = {
            "i": i,
            "c": bit,
            "delay": HANDLINGS[bit].delay_s,
            "rise": HANDLINGS[bit].escalates_s,
        }
        lines += ["    " + line.format(**values) for line in each]
    clocks = straight_line.tuple_of(f"t{i}" for i in range(len(bits)))
    step: Callable[..., Ticked] = straight_line.define(
        [*lines, f"    return found, {clocks}"], about
    )
    return step


mature = _stepper(
    "def mature(held_s, unseen, waiting, dt_s):",
    [
        "t{i} = held_s[{i}]",
        "if unseen >> {c} & 1:",
        "    before = t{i} if waiting >> {c} & 1 else 0.0",
        "    t{i} = before + dt_s",
        # Half a tick: sums of ticks are not exact, and never late.
        "    if before + half_s >= {delay!r}:",
        "        found |= 1 << {c}",
    ],
    DELAYED,
    "delays of the alarms",
)
"""``mature(held_s, unseen, waiting, dt_s)``: those of the conditions of `DELAYED` that hold and are
not present yet (mask ``unseen``) whose delay is over, as a mask, and their clocks. waiting: mask of
those that waited a tick ago; the others begin anew."""

rise = _stepper(
    "def rise(unanswered_s, begun, running, dt_s):",
    [
        "t{i} = unanswered_s[{i}]",
        "if begun >> {c} & 1:",
        "    t{i} = 0.0",
        "elif running >> {c} & 1:",
        "    t{i} += dt_s",
        "    if t{i} + half_s >= {rise!r}:",
        "        found |= 1 << {c}",
    ],
    RISING,
    "escalation of the alarms",
)
"""``rise(unanswered_s, begun, running, dt_s)``: those of the conditions of `RISING` that nobody has
answered for their time, as a mask, and their clocks. begun: mask of the conditions that are shown
since this tick. running: of those whose time runs."""
