"""Where the contact switch may close, and where it must have closed, by head travel and time.

There is no tip sensor, only how deep the tip can be at most and at least behind the gap. Closed
where even the deepest possible tip has nothing to touch, the switch is stuck or bridged. Open
where even the least deep possible tip has passed the carina, the carina was missed, or the switch
cannot close; whether it has been seen to close and to open again tells how far it can be trusted.
"""

from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.safety.limits import TipBounds, WindowLimits

IMPOSSIBLE_S = 0.05
"""How long contact must last where there is nothing to touch: bounces take 10 ms at most."""
RELEASE_MM = 3.0
"""Way back from where contact began, after which it must be over: tissue and catheter give way
by 0.3 N / 0.16 N/mm = 1.9 mm, and the polymer creeps by 0.5 mm [computed]."""
NOWHERE_MM = -1.0e6
"""Nothing is touched: above every tip."""


class ContactWindow(NamedTuple):
    """What is known of tip and switch."""

    rearmost_mm: float
    """Rearmost position behind the gap: see `follow`."""
    touched_mm: float
    """Least depth of the tip where the present contact began."""
    impossible_s: float
    """For how long contact has lasted where there is nothing to touch."""
    proven: bool
    """The switch has been seen to close where it may and to open again, since the last reset."""


def start(bounds: TipBounds, head_mm: float) -> ContactWindow:
    """At power-up: the tip may be behind any gap."""
    return ContactWindow(
        rearmost_mm=anywhere(bounds, head_mm),
        touched_mm=NOWHERE_MM,
        impossible_s=0.0,
        proven=False,
    )


@compiled
def anywhere(bounds: TipBounds, head_mm: float) -> float:
    """Rearmost position when nothing is known of how the head came here: as after an advance."""
    return head_mm - 0.5 * bounds.wide_mm


@compiled
def follow(bounds: TipBounds, rearmost_mm: float, head_mm: float) -> float:
    """Rearmost position behind the gap: the mirror image of `limits.follow`."""
    pushed_mm = max(rearmost_mm, head_mm - 0.5 * bounds.wide_mm)
    return min(pushed_mm, head_mm + 0.5 * bounds.narrow_mm)


@compiled
def step(
    bounds: TipBounds,
    limits: WindowLimits,
    state: ContactWindow,
    head_mm: float,
    deepest_mm: float,
    touching: bool,
    touched: bool,
    dt_s: float,
) -> ContactWindow:
    """Bring it up to this tick.

    deepest_mm: deepest possible tip. touching, touched: contact now and a tick ago, bounces ridden
    out.
    """
    rearmost = follow(bounds, state.rearmost_mm, head_mm)
    begun_mm = state.touched_mm
    if not touching:
        begun_mm = NOWHERE_MM
    elif not touched:
        begun_mm = bounds.gain * rearmost + bounds.offset_mm
    nothing = deepest_mm < max(limits.from_mm, begun_mm - RELEASE_MM)
    released = touched and not touching and state.impossible_s == 0.0
    return ContactWindow(
        rearmost_mm=rearmost,
        touched_mm=begun_mm,
        impossible_s=state.impossible_s + dt_s if touching and nothing else 0.0,
        proven=state.proven or (released and deepest_mm >= limits.from_mm),
    )


@compiled
def least_mm(bounds: TipBounds, state: ContactWindow) -> float:
    """Least deep tip position that is possible."""
    return bounds.gain * state.rearmost_mm + bounds.offset_mm


@compiled
def is_missed(
    bounds: TipBounds, limits: WindowLimits, state: ContactWindow, touching: bool
) -> bool:
    """Whether contact must have come by now and has not."""
    return not touching and least_mm(bounds, state) > limits.by_mm


@compiled
def unseen(bounds: TipBounds, state: ContactWindow, head_mm: float) -> ContactWindow:
    """After a reset: the head may have been moved, and the catheter changed, unseen."""
    return state._replace(rearmost_mm=anywhere(bounds, head_mm), impossible_s=0.0, proven=False)
