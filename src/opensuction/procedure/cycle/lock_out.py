"""Lock-out of a machine that trips for the same reason again and again.

A reset says that the cause has been dealt with. After three resets with the same cause and no whole
cycle between it has not been: each reset would pull at what holds the catheter once more. The
machine then has to be taken out of service and put back (docs/decisions/0017).
"""

from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.kernel.phase import Phase
from opensuction.safety.condition import Condition
from opensuction.safety.condition_mask import LATCHING, TRIPS, encode

MOST_RESETS = 3
"""Resets with the same cause [design]: enough for a cough, a bite and a mistake."""
REPEATING = TRIPS & LATCHING
"""Causes that count: the machine's own trips latch, those that the patient's monitor shows do not;
they are no fault of the machine, and passes are limited anyway."""
MOVING = encode(
    (
        Condition.HEAD_SENSORS_DISAGREE,
        Condition.HEAD_OVERSPEED,
        Condition.HEAD_NOT_FOLLOWING,
        Condition.HEAD_STALLED,
        Condition.HEAD_RUNAWAY,
        Condition.DRIVE_OVERFORCE,
        Condition.CATHETER_JAMMED,
        Condition.IN_AIRWAY_TIME,
        Condition.WITHDRAWAL_TIME,
        Condition.WITHDRAWAL_BLOCKED,
        Condition.WITHDRAWAL_UNSEEN,
    )
)
"""Names that one jam can have, pull by pull: the same cause."""


class LockOut(NamedTuple):
    """Resets since the last whole cycle, or since the machine was serviced, with their causes."""

    causes: int
    """Mask of the trips of the stop that lasts now."""
    dealt: int
    """Mask of those that persons have said to have dealt with."""
    resets: int
    """Resets with the same cause."""
    recovered: bool
    """A reset has drawn at the catheter since the head was last home."""
    locked: bool


NONE = LockOut(causes=0, dealt=0, resets=0, recovered=False, locked=False)
"""Nothing has been reset."""


@compiled
def lets_reset(state: LockOut, home: bool) -> bool:
    """True where a halted machine may be reset. home: the head is known to be at its park position.

    Locked out, it may not; but for one recovery where none has been tried since the head was last
    home: a catheter that could still come out is not left inside for the sake of a count.
    """
    return not state.locked or not (home or state.recovered)


@compiled
def _alike(trips: int) -> int:
    """The trips that count, with all names that the same cause can have."""
    counted = trips & REPEATING
    return counted | MOVING if counted & MOVING != 0 else counted


@compiled
def step(state: LockOut, before: int, phase: int, reset: bool, trips: int) -> LockOut:
    """One tick. before, phase: last and present phase.

    reset: a person's, in this tick, of a halted machine, and granted. trips: mask of what is wrong
    after this tick.
    """
    whole = before == Phase.CLOSING and phase == Phase.PARKED
    serviced = before == Phase.OUT_OF_SERVICE and phase != Phase.OUT_OF_SERVICE
    if whole or serviced:
        return NONE
    causes, dealt, resets = state.causes, state.dealt, state.resets
    recovered = state.recovered and phase != Phase.PARKED
    if reset:
        # Another cause is added to those known and counts from its second time on.
        if causes != 0 and (resets == 0 or causes & dealt != 0):
            resets += 1
        dealt, causes = dealt | causes, 0
        recovered = recovered or phase == Phase.ABORTING
    if phase in (Phase.ABORTING, Phase.HALTED):
        causes |= _alike(trips)
    return LockOut(
        causes=causes,
        dealt=dealt,
        resets=resets,
        recovered=recovered,
        locked=state.locked or (resets >= MOST_RESETS and causes & dealt != 0),
    )
