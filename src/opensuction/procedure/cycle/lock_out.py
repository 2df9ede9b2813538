"""Lock-out of a machine that trips for the same reason again and again.

A reset says that the cause has been dealt with. After three resets with the same cause and no whole
cycle between it has not been: each reset would pull at what holds the catheter once more. The
machine then has to be taken out of service and put back (docs/decisions/0017).

Reasons for which a start or a reset is refused, as numbers in the core and words outside.
"""

import math
from enum import IntEnum
from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.kernel.vocabulary import Phase
from opensuction.safety.condition import Condition
from opensuction.safety.condition_mask import LATCHING, TRIPS, encode


class Refusal(IntEnum):
    """Reason why a start or a reset was refused. The numbers are in recordings: never renumber."""

    NONE = 0
    CATHETER_LIFE_OVER = 1
    CATHETER_LIFE_ENDS = 2
    """It would end within the cycle."""
    OUT_OF_SERVICE = 3
    HALTED = 4
    NOT_TAUGHT = 5
    """The plan is one that a travel length is taught with."""
    MONITOR_LINK_LOST = 6
    PATIENT_UNSAFE = 7
    """The monitor shows a value out of its limits."""
    PASS_LIMIT = 8
    """A person must look at the patient first."""
    RESTING = 9
    """The last pass is too short a time ago; `say` has the seconds left."""
    OXYGEN_UNANSWERED = 10
    """Pre-oxygenation is neither confirmed nor skipped."""
    LOCKED_OUT = 11
    """The machine must be taken out of service first."""


SENTENCES: dict[Refusal, str] = {
    Refusal.NONE: "nothing was refused",
    Refusal.CATHETER_LIFE_OVER: "the catheter has been used for 24 h: change it",
    Refusal.CATHETER_LIFE_ENDS: "the catheter's 24 h would end within the cycle: change it",
    Refusal.OUT_OF_SERVICE: "the machine is out of service",
    Refusal.HALTED: "the machine is halted: deal with the cause and reset it",
    Refusal.NOT_TAUGHT: "no travel length has been set",
    Refusal.MONITOR_LINK_LOST: "the patient monitor cannot be read: check its cables",
    Refusal.PATIENT_UNSAFE: "the patient monitor shows a value out of its limits: look at the "
    "patient first",
    Refusal.PASS_LIMIT: "as many passes as may follow each other have been made: look at the "
    "patient and say so",
    Refusal.RESTING: "the patient rests after the last pass",
    Refusal.OXYGEN_UNANSWERED: "pre-oxygenation has not been answered: give it and confirm, or "
    "skip it",
    Refusal.LOCKED_OUT: "the machine is locked out after resets with the same cause: take it out "
    "of service, find the cause, return it to service",
}
"""For people; `say` adds the seconds that are left of a rest."""


def say(refused: Refusal, rest_left_s: float) -> str:
    """Reason why a start or a reset was refused, in words, with the seconds left of a rest."""
    if refused == Refusal.RESTING:
        return f"{SENTENCES[refused]}: another {math.ceil(rest_left_s)} s"
    return SENTENCES[refused]


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
