"""Window of the contact switch: head travel and time in which it may, and must, have closed.

There is no tip sensor, only the deepest and the shallowest possible tip behind the gap
(`opensuction.safety.tip_bound`). Closed where even the deepest possible tip has nothing to touch,
the switch is stuck or bridged. Open where even the shallowest possible tip has passed the carina,
the carina was missed, or the switch cannot close; how far the switch can be trusted depends on
whether it has been seen to close and to open again.
"""

from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.kernel.duration import add_up
from opensuction.safety.limits import WindowLimits

IMPOSSIBLE_S = 0.6
"""How long contact must last where there is nothing to touch: bounces take 10 ms at most, a cough
that moves the trachea, or lays its wall on the tip, 0.4 s; assumed. The head is held so long."""
RELEASE_MM = 3.0
"""Way back from where contact began, after which it must be over: tissue and catheter give way
by 0.3 N / 0.16 N/mm = 1.9 mm, and the polymer creeps by 0.5 mm [computed]."""
NOWHERE_MM = -1.0e6
"""Nothing is touched: above every tip."""


class ContactWindow(NamedTuple):
    """Watch on the contact switch."""

    touched_mm: float
    """Least depth of the tip where the present contact began."""
    impossible_s: float
    """For how long in all there has been contact where there is nothing to touch: a switch that
    chatters adds up; time without takes as much off."""
    proven: bool
    """The switch has been seen to close where it may and to open again, since the last reset."""
    met_mm: float
    """Greatest least depth of the tip with contact beyond where it must have come."""


START = ContactWindow(NOWHERE_MM, impossible_s=0.0, proven=False, met_mm=NOWHERE_MM)
"""At power-up."""


@compiled
def step(
    limits: WindowLimits,
    state: ContactWindow,
    deepest_mm: float,
    shallowest_mm: float,
    touching: bool,
    touched: bool,
    dt_s: float,
) -> ContactWindow:
    """Bring it up to this tick.

    deepest_mm, shallowest_mm: possible tip positions. touching, touched: contact now and a tick
    ago, without its bounces.
    """
    begun_mm = state.touched_mm
    if not touching:
        begun_mm = NOWHERE_MM
    elif not touched:
        begun_mm = shallowest_mm
    impossible = touching and deepest_mm < max(limits.from_mm, begun_mm - RELEASE_MM)
    released = touched and not touching and state.impossible_s == 0.0
    met_mm = state.met_mm
    if shallowest_mm <= limits.by_mm:
        met_mm = NOWHERE_MM
    elif touching:
        met_mm = max(met_mm, shallowest_mm)
    return ContactWindow(
        touched_mm=begun_mm,
        impossible_s=add_up(state.impossible_s, impossible, 1.0, dt_s),
        proven=state.proven or (released and deepest_mm >= limits.from_mm),
        met_mm=met_mm,
    )


@compiled
def is_missed(
    limits: WindowLimits, state: ContactWindow, shallowest_mm: float, touching: bool
) -> bool:
    """True where contact must have come by now and has not.

    A carina that was met there is not missed by a tip that goes back from it.
    """
    return not touching and shallowest_mm > max(limits.by_mm, state.met_mm)


@compiled
def reset(state: ContactWindow) -> ContactWindow:
    """After a person's reset: the catheter may have been changed unseen."""
    return state._replace(impossible_s=0.0, proven=False, met_mm=NOWHERE_MM)
