"""A withdrawal that the governor forces: for how long, and whether the head comes."""

from typing import NamedTuple

from opensuction.kernel.bit_mask import flag
from opensuction.kernel.compiled import compiled
from opensuction.kernel.duration import extend
from opensuction.kernel.record import make_zero
from opensuction.safety import tip_bound
from opensuction.safety.condition import Condition
from opensuction.safety.governor.judgement import STALL_S
from opensuction.safety.limits import Limits
from opensuction.safety.watch import bus_watch
from opensuction.safety.watch.watch_state import Watch

BLOCKED_S = 0.3
"""How long it may pull on what holds it: a reversal from full speed takes 0.2 s."""
LEAVING_MM_PER_S = 1.0
"""Measured speed outwards from which the head still comes out, however much resists it."""
WAITING_S = 4.0
"""How long a withdrawal that has had its time is waited for, that a loose contact may close: less
than a hand that has been called takes to come [design]."""
UNSEEN_S = 0.5
"""Time for the reversal, beyond the way itself, of a withdrawal that cannot be seen."""


class ForcedWithdrawal(NamedTuple):
    """Durations of a forced withdrawal: without a break, but for the last."""

    forced_s: float
    """The governor forces the head out."""
    blocked_s: float
    """And something holds it meanwhile."""
    unseen_s: float
    """And its reading says nothing meanwhile."""
    waiting_s: float
    """And it is not seen to come."""
    whole_s: float
    """The governor forces the head out: all of it together, until a person resets."""


NONE = make_zero(ForcedWithdrawal)


@compiled
def _is_unseen(seen: Watch) -> bool:
    """True where the head's reading says nothing: none, the same for ever, or one sensor alone.

    A head that both its sensors have standing still is seen: it is held, or its motor is gone.
    """
    lost = seen.invalid.head + seen.invalid.carriage > 0
    alone = lost or seen.vote.encoder_out or seen.vote.carriage_out
    stalled = seen.durations.stalled_s > STALL_S
    return seen.vote.unseen_ticks > 0 or (stalled and alone) or bus_watch.is_stale(seen.bus)


@compiled
def step(state: ForcedWithdrawal, seen: Watch, forced: bool, dt_s: float) -> ForcedWithdrawal:
    """Bring it up to this tick."""
    if not forced:
        return NONE._replace(whole_s=state.whole_s)
    leaving = seen.speed_mm_per_s <= -LEAVING_MM_PER_S
    held = seen.durations.jammed_s > 0.0 and not leaving
    unseen = _is_unseen(seen)
    return ForcedWithdrawal(
        forced_s=state.forced_s + dt_s,
        blocked_s=extend(state.blocked_s, held and not bus_watch.is_stale(seen.bus), dt_s),
        unseen_s=extend(state.unseen_s, unseen, dt_s),
        waiting_s=extend(state.waiting_s, unseen or not leaving, dt_s),
        whole_s=state.whole_s + dt_s,
    )


@compiled
def longest_s(limits: Limits) -> float:
    """Time after which it ends, whatever the sensors say: until then any head that comes is home.

    The way from the cap at the slowest speed that counts as coming; the time in which a sound drive
    comes from there; as long as a loose contact is waited for. An adult's 182 mm take 182 s at
    1 mm/s and are given 192 s, a neonate's 80 mm 89 s; a sound drive takes 4 s [computed]. A head
    that is out so long has come by less than 1 mm/s all in all, or its sensors do not tell.
    """
    way_mm = max(tip_bound.head_cap_mm(limits.tip, limits.cap_mm) - limits.park_head_mm, 0.0)
    return way_mm / LEAVING_MM_PER_S + limits.withdrawal_s + WAITING_S


@compiled
def judge(limits: Limits, state: ForcedWithdrawal, seen: Watch) -> int:
    """Mask of what is wrong with it: a head that is seen to come, late or again, goes on.

    But not for ever: two sensors that err alike may say for ever that it comes.
    """
    if state.forced_s + state.blocked_s + state.unseen_s + state.whole_s == 0.0:
        return 0
    way_s = max(seen.head_mm - limits.park_head_mm, 0.0) / limits.leaving_mm_per_s
    unseen = state.unseen_s > way_s + UNSEEN_S and _is_unseen(seen)
    late = state.forced_s > limits.withdrawal_s and state.waiting_s > WAITING_S
    late = late or state.whole_s > longest_s(limits)
    return (
        flag(late, Condition.WITHDRAWAL_TIME)
        | flag(state.blocked_s > BLOCKED_S, Condition.WITHDRAWAL_BLOCKED)
        | flag(unseen, Condition.WITHDRAWAL_UNSEEN)
    )
