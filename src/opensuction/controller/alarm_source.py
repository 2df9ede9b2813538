"""Alarm conditions of the controller's own parts: phases, pre-use test, upkeep, host.

The governor's trips are conditions already. Here are those that no other part detects: the reason
of a stop, a recovery that is needed, the findings of the pre-use test, the age of the catheter, and
cycles that were due and did not start. Everything is a bit mask of `condition.Condition`.

A person's abort is no alarm: whoever pressed the button knows that the machine stops, and an alarm
that only says what was just done teaches people not to listen. A schedule whose time has come while
no cycle can start is an alarm all the same.
"""

import numpy as np

from opensuction.kernel.compiled import compiled
from opensuction.kernel.interface import Readings
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle import progress, schedule
from opensuction.procedure.cycle.check import VENTED_MMHG, CheckItem
from opensuction.procedure.cycle.interlocks import Interlocks, Service
from opensuction.procedure.cycle.lock_out import Refusal
from opensuction.procedure.cycle.plan import Plan
from opensuction.procedure.cycle.progress import ProcedureState
from opensuction.procedure.cycle.transition import Event
from opensuction.safety.condition import Condition

NONE = 0
"""No condition."""
STOPPED = 1 << Condition.AUTOMATION_STOPPED
RECOVERY = 1 << Condition.RECOVERY_NEEDED
CHECK_FAILED = 1 << Condition.CHECK_FAILED
CARINA_MISSED = 1 << Condition.CARINA_MISSED
NOT_WITHDRAWN = 1 << Condition.WITHDRAWAL_TIME
"""The governor has a trip of this number for a withdrawal of its own."""
VALVE_STUCK_OPEN = 1 << Condition.VALVE_STUCK_OPEN
VACUUM_LOST = 1 << Condition.VACUUM_LOST
PASS_LIMIT_REACHED = 1 << Condition.PASS_LIMIT_REACHED
LOCKED_OUT = 1 << Condition.LOCKED_OUT

ANSWER_S = 120.0
"""How long a cycle that is due may wait for an answer about pre-oxygenation before it is missed:
time to go to the bed and to give it [design]."""

ENDING_S = 3600.0
"""How long before a catheter's life is over a person is told: time to plan a change (assumed)."""

FOUND: dict[CheckItem, Condition] = {
    CheckItem.CONTACT_OPEN: Condition.CONTACT_STUCK_CLOSED,
    CheckItem.LINE_VENTED: Condition.PUMP_RUNAWAY,
    CheckItem.VALVE_OPENS: Condition.VALVE_STUCK_CLOSED,
    CheckItem.VALVE_CLOSES: Condition.VALVE_STUCK_OPEN,
    CheckItem.VACUUM_BUILDS: Condition.VACUUM_LOST,
    CheckItem.VACUUM_HOLDS: Condition.LINE_LEAKING,
}
"""What a failed item of the pre-use test says besides that the test failed; the others only name
themselves, and the governor tells what is wrong with a reading or the head."""

OF_ITEM = np.array(
    [1 << FOUND[i] if i in FOUND else NONE for i in sorted(CheckItem)], dtype=np.int64
)
"""``FOUND`` as masks for the compiled step, by item."""


@compiled
def _found(item: int, readings: Readings) -> int:
    """Conditions that a failed item of the pre-use test indicates."""
    vacuum = readings.line_vacuum_mmhg > VENTED_MMHG
    if item == CheckItem.VALVE_OPENS and vacuum:
        # The item wants the line vented too: with the pump off nothing may draw.
        return CHECK_FAILED | 1 << Condition.PUMP_RUNAWAY
    return CHECK_FAILED | int(OF_ITEM[item])


@compiled
def _overdue(plan: Plan, phase: int, readings: Readings) -> int:
    """Conditions that an overdue phase indicates."""
    closed = progress.is_closed(plan, readings)
    waits = phase == Phase.PRELOADING and not plan.bench_only
    if waits and not progress.is_kept(plan, readings):
        return VACUUM_LOST
    if phase == Phase.OPENING and closed and not progress.is_built(plan, readings):
        return VACUUM_LOST
    if phase == Phase.OPENING and closed and not progress.is_free(plan, readings):
        return 1 << Condition.CONTACT_TIME
    if phase in (Phase.PRELOADING, Phase.INSERTING, Phase.BACKING_OFF):
        return 1 << Condition.HEAD_NOT_FOLLOWING  # it was kept from getting where it was sent
    if phase == Phase.OPENING:
        return 1 << Condition.VALVE_STUCK_CLOSED
    if phase == Phase.CLOSING:
        return VALVE_STUCK_OPEN
    if phase == Phase.ABORTING:
        stuck = NONE if closed else VALVE_STUCK_OPEN
        out = progress.is_out(plan.motion, readings)
        return stuck if out else stuck | NOT_WITHDRAWN
    if phase == Phase.CHECKING:
        return CHECK_FAILED
    return NONE


@compiled
def reasons(
    plan: Plan, before: int, procedure: ProcedureState, held: int, readings: Readings
) -> int:
    """Reasons why the machine is on its way out or halted; held until a person restarts its work.

    before: last phase. held: the reasons so far. A reset that begins a recovery has dealt with
    them; that automation has stopped stays until the machine is parked.
    """
    phase, cause = procedure.phase, procedure.cause
    if phase not in (Phase.ABORTING, Phase.HALTED):
        return NONE
    if phase == before:
        return held
    if cause == Event.RECOVERY_REQUESTED:
        return STOPPED
    if cause == Event.SERVICE_ENDED_AWAY:
        return RECOVERY
    if cause == Event.TRIPPED:
        return held | STOPPED
    if cause == Event.PHASE_OVERDUE:
        return held | STOPPED | _overdue(plan, before, readings)
    if cause == Event.CHECK_FAILED:
        return STOPPED | _found(procedure.check.failed, readings)
    if cause == Event.CONTACT_MISPLACED:
        # Out of a back-off it is the switch, which may chatter.
        stuck = readings.contact_closed or before == Phase.BACKING_OFF
        return STOPPED | (1 << Condition.CONTACT_STUCK_CLOSED if stuck else CARINA_MISSED)
    return held  # a person's abort, and the end of any


@compiled
def _is_missed(service: Service, upkeep: Interlocks, phase: int, refused: int) -> bool:
    """True where a cycle, or a look at the patient, is due and the machine cannot serve it."""
    waiting = phase in (Phase.PARKED, Phase.HALTED)
    chosen, since = service.schedule, upkeep.schedule
    if refused == Refusal.OXYGEN_UNANSWERED:
        # It waits for a person, who may be on the way; who only looks need not answer.
        late = since._replace(since_cycle_s=since.since_cycle_s - ANSWER_S)
        return waiting and schedule.starts(chosen, late)
    due = schedule.starts(chosen, since) or schedule.prompts(chosen, since)
    return waiting and due and refused != Refusal.NONE


@compiled
def conditions(
    service: Service, upkeep: Interlocks, phase: int, refused: int, held: int, trips: int, host: int
) -> int:
    """All conditions of a tick.

    refused: why a start would be. held: `reasons`. trips: the governor's. host: what the process
    around the core reports.
    """
    found = held | trips | host
    if phase == Phase.HALTED and trips != 0:
        found |= STOPPED  # also where a person had aborted before
    if _is_missed(service, upkeep, phase, refused):
        found |= STOPPED
    if upkeep.episode.exceeded:
        found |= PASS_LIMIT_REACHED
    if upkeep.lock.locked:
        found |= LOCKED_OUT
    if upkeep.catheter_age_s >= service.life_s:
        found |= 1 << Condition.CATHETER_LIFE_OVER
    elif upkeep.catheter_age_s >= service.life_s - max(ENDING_S, service.cycle_s):
        found |= 1 << Condition.CATHETER_LIFE_ENDING
    return found
