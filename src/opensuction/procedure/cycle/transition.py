"""Phases and transitions: one table, the only place that says what follows what.

Events are ranked; of those that happened in a tick the first that the table knows for the
current phase is taken, one transition a tick. The documentation draws its diagram from here.
"""

from enum import IntEnum

import numpy as np

from opensuction.kernel.compiled import compiled
from opensuction.kernel.vocabulary import CYCLE, Phase


class Event(IntEnum):
    """Event of a cycle, most urgent first."""

    TRIPPED = 0
    """The governor found a limit broken or a reading it cannot trust."""
    ABORT_REQUESTED = 1
    """A person wants it to stop."""
    PHASE_OVERDUE = 2
    """The phase lasted longer than the plan allows."""
    CONTACT_MISPLACED = 3
    """Contact before the expected window that drawing back does not end, or that is too near to be
    the carina; or none until the window's end."""
    CHECK_FAILED = 4
    """An item of the pre-use test failed."""
    CHECK_PASSED = 5
    PRELOADED = 6
    CONTACTED = 7
    """The tip touched something within the expected window, or steadily a little before it."""
    BACKED_OFF = 8
    TARGET_REACHED = 9
    VALVE_OPENED = 10
    DWELL_ELAPSED = 11
    WITHDRAWN = 12
    VALVE_CLOSED = 13
    CLEARED = 14
    """Out of the airway with the valve closed, or nothing left that may move."""
    EXCITATION_ENDED = 15
    TEACHING_ENDED = 16
    """The head is home again after a person had moved it."""
    START_REQUESTED = 17
    IDENTIFY_REQUESTED = 18
    TEACH_REQUESTED = 19
    RESET_REQUESTED = 20
    """A person acknowledges a halt with the head at its park position."""
    RECOVERY_REQUESTED = 21
    """The same with the head elsewhere: out first."""
    SERVICE_REQUESTED = 22
    """A person wants to change or clean something, with the head at its park position; where the
    machine is locked out, wherever the head is."""
    SERVICE_ENDED = 23
    """Hands are off, and the head is at its park position."""
    SERVICE_ENDED_AWAY = 24
    """Hands are off, but somebody has moved the head, or it cannot be read."""
    NOTHING_CAME = 25
    """Nothing but gas has come for the stated time. Last, for recordings hold the numbers; nothing
    that the dwell knows is less urgent."""


P = Phase
E = Event

NORMAL: dict[tuple[Phase, Event], Phase] = {
    (P.PARKED, E.START_REQUESTED): P.CHECKING,
    (P.CHECKING, E.CHECK_PASSED): P.PRELOADING,
    (P.PRELOADING, E.PRELOADED): P.INSERTING,
    (P.INSERTING, E.TARGET_REACHED): P.OPENING,
    (P.INSERTING, E.CONTACTED): P.BACKING_OFF,
    (P.BACKING_OFF, E.BACKED_OFF): P.OPENING,
    (P.OPENING, E.VALVE_OPENED): P.SUCTIONING,
    (P.SUCTIONING, E.DWELL_ELAPSED): P.WITHDRAWING,
    (P.SUCTIONING, E.NOTHING_CAME): P.WITHDRAWING,
    (P.WITHDRAWING, E.WITHDRAWN): P.CLOSING,
    (P.CLOSING, E.VALVE_CLOSED): P.PARKED,
    (P.PARKED, E.IDENTIFY_REQUESTED): P.IDENTIFYING,
    (P.IDENTIFYING, E.EXCITATION_ENDED): P.PARKED,
    (P.PARKED, E.TEACH_REQUESTED): P.TEACHING,
    (P.TEACHING, E.TEACHING_ENDED): P.PARKED,
    (P.ABORTING, E.CLEARED): P.HALTED,
    (P.HALTED, E.RESET_REQUESTED): P.PARKED,
    (P.HALTED, E.RECOVERY_REQUESTED): P.ABORTING,
    (P.PARKED, E.SERVICE_REQUESTED): P.OUT_OF_SERVICE,
    (P.HALTED, E.SERVICE_REQUESTED): P.OUT_OF_SERVICE,
    (P.OUT_OF_SERVICE, E.SERVICE_ENDED): P.PARKED,
    (P.OUT_OF_SERVICE, E.SERVICE_ENDED_AWAY): P.HALTED,
}

ACTIVE = (*CYCLE, P.IDENTIFYING, P.TEACHING)
"""Phases in which the machine does something that can be broken off."""

BROKEN_OFF: dict[tuple[Phase, Event], Phase] = {
    **{
        (phase, event): P.ABORTING
        for phase in ACTIVE
        for event in (E.TRIPPED, E.ABORT_REQUESTED, E.PHASE_OVERDUE)
    },
    (P.INSERTING, E.CONTACT_MISPLACED): P.ABORTING,
    (P.BACKING_OFF, E.CONTACT_MISPLACED): P.ABORTING,
    (P.CHECKING, E.CHECK_FAILED): P.ABORTING,
    (P.PARKED, E.TRIPPED): P.HALTED,
    (P.ABORTING, E.PHASE_OVERDUE): P.HALTED,
}

TRANSITIONS: dict[tuple[Phase, Event], Phase] = {**NORMAL, **BROKEN_OFF}
"""Where each event leads from each phase; a pair that is not here changes nothing."""

STAY = -1


TABLE = np.full((len(Phase), len(Event)), STAY, dtype=np.int64)
TABLE[tuple(zip(*TRANSITIONS, strict=True))] = list(TRANSITIONS.values())
"""``TRANSITIONS`` as an array for the compiled step, shape (phases, events)."""


@compiled
def cause(phase: int, events: int) -> int:
    """The highest-ranked event of a tick that the table knows for a phase; `STAY` for none.

    events: bit mask, bit ``event`` set for each event of this tick.
    """
    if events == 0:
        return STAY
    for event in range(TABLE.shape[1]):
        if events >> event & 1 and TABLE[phase, event] != STAY:
            return event
    return STAY


@compiled
def follow(phase: int, events: int) -> int:
    """Phase after one tick: where its `cause` leads, or the same phase."""
    event = cause(phase, events)
    return phase if event == STAY else int(TABLE[phase, event])
