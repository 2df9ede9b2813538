"""Readings and requests turned into the events of a tick."""

from typing import NamedTuple

from opensuction.kernel.arithmetic import flag
from opensuction.kernel.compiled import compiled
from opensuction.kernel.interface import Readings, Requests, is_number
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle import check, teaching
from opensuction.procedure.cycle import plan as plans
from opensuction.procedure.cycle.check import CheckItem, CheckSeen, CheckState
from opensuction.procedure.cycle.plan import ContactSearch, Motion, Plan
from opensuction.procedure.cycle.teaching import TeachingState
from opensuction.procedure.cycle.transition import Event
from opensuction.procedure.suction import line_flow
from opensuction.procedure.suction.line_flow import FlowSeen, Pace

OPEN_SHARE = 0.95
"""Share of the cam's stroke at which the valve counts as open: the servo leaves a static error."""
BEHIND_SHARE = 0.06
"""Share of the open angle that a closed cam may be behind its seat: the end stop 0.5 degrees, the
sensor's zero 0.6 and its noise [computed]."""
CLOSED_SHARE = 0.03
"""Share of the cam's stroke below which the valve counts as closed."""
HOME_MM = 0.5
"""Distance from the park position, beyond settling, at which the head still counts as parked."""
RESTING_MM_PER_S = 0.5
"""Commanded head speed below which a back-off is over; it rises by 0.2 mm/s in a tick."""


KEPT_S = 0.3
"""How long the resting line must have kept its vacuum before the tip goes in: a free 12 Fr catheter
takes all of it from 0.8 L meanwhile, and the gap takes longer [computed]."""
KEPT_MMHG = 3.0
"""By how much the vacuum of the way in may be off: what the pump's last ticks add is let out at
once, a sound line loses 2 % a second, and a sensor's offset is 1 mmHg; assumed."""
RELEASE_TICKS = 10
"""For how long an open switch may still be chattering: 10 ms, as the governor has it."""
HELD_S = 0.55
"""How long contact may last where the carina is not expected: a cough that moves the trachea
presses on the tip for less. The governor holds the head meanwhile, and counts for itself."""

LIFTED_S = 0.05
"""Contact without a break under suction from which the valve closes: a wrong reading is shorter,
and a tip that is drawn back is .5 mm off what stays where it is after less [design]."""


class ProcedureState(NamedTuple):
    """Phase of the cycle, how long it has lasted, and what it asks for."""

    phase: int
    cause: int
    """Event that led into the phase; `transition.STAY` at power-up."""
    phase_ticks: int
    limit_s: float
    """Longest duration of the phase."""
    start_mm: float
    """Reference at the start of the phase, or of the second part of a back-off."""
    leg_ticks: int
    """When in the phase that was."""
    end_mm: float
    """Where a back-off, or this part of it, ends."""
    touched_mm: float
    """Reference of a back-off when the contact switch was last closed."""
    reference_mm: float
    reference_mm_per_s: float
    arrived_ticks: int
    """Ticks since the reference reached the target."""
    open_ticks: int
    """Since the switch was last closed on the way in."""
    held_ticks: int
    """Ticks of contact where the carina is not expected; those without take their number off.
    Under suction and on the way out, those of contact without a break."""
    nearer: bool
    """Back-off: from a contact before the window, which the switch must show to be one."""
    valve_open: bool
    line_ready: bool
    """The line has had its vacuum in this cycle."""
    kept_ticks: int
    """For how long it has kept that of the way in, the pump at rest."""
    flow: FlowSeen
    """What the line tells of the mucus."""
    pace: Pace
    check: CheckState
    teaching: TeachingState


class ControlFeedback(NamedTuple):
    """Feedback of the rest of the controller to the procedure."""

    head_wanted_mm: float
    """Last head command of the compensation, before the governor."""
    head_wanted_mm_per_s: float
    tripped: bool
    powerless: bool
    """The insertion drive's torque is off."""
    locked_out: bool
    """The machine may not be reset."""
    contact_tip_mm: float
    """Tip reference that belongs to the measured head; used on contact."""
    tip_mm: float
    """Estimated tip, pushed in to the measured head; used on contact and to teach."""


@compiled
def is_home(motion: Motion, readings: Readings) -> bool:
    """True where the head is known to be at its park position."""
    distance = abs(readings.head_mm - motion.park_head_mm)
    return readings.head_valid and distance <= motion.settle_mm + HOME_MM


@compiled
def is_out(motion: Motion, readings: Readings) -> bool:
    """True where the head is known to be home or behind it: the catheter is out."""
    behind = readings.head_valid and readings.head_mm <= motion.park_head_mm
    return behind or is_home(motion, readings)


@compiled
def is_contact(readings: Readings) -> bool:
    """True while the switch says that the tip touches something."""
    return readings.contact_valid and readings.contact_closed


@compiled
def is_free(plan: Plan, readings: Readings) -> bool:
    """True where the tip may suck as it stands: it touches nothing, or shall suck what it touches.

    So it does on a bench, and by contact where a protocol draws nothing back.
    """
    meant = plan.bench_only or (plan.contact.enabled and plan.contact.backoff_mm == 0.0)
    return meant or not is_contact(readings)


@compiled
def feel(state: ProcedureState, free: bool) -> ProcedureState:
    """Count ticks of contact without a break. free: the tip touches nothing."""
    return state._replace(held_ticks=0 if free else state.held_ticks + 1)


@compiled
def is_lifted(state: ProcedureState, dt_s: float) -> bool:
    """True where a carina has come to the tip, which would draw it in."""
    return state.held_ticks * dt_s >= LIFTED_S


@compiled
def is_off(search: ContactSearch, state: ProcedureState) -> bool:
    """True once a back-off is complete, and far enough from where the switch opened."""
    least_mm = plans.LEAST_OFF_SHARE * search.backoff_mm
    return state.reference_mm <= min(state.end_mm, state.touched_mm - least_mm)


@compiled
def is_stuck(search: ContactSearch, state: ProcedureState) -> bool:
    """Tell whether the switch has stayed closed, or chatters, while the tip was drawn back.

    Before the window that is no carina which has come nearer.
    """
    most_mm = plans.OPENED_SHARE * search.backoff_mm
    return state.nearer and state.touched_mm <= state.start_mm - most_mm


@compiled
def is_expected(search: ContactSearch, tip_mm: float) -> bool:
    """True where the estimated tip is at a depth where the carina can be."""
    return tip_mm >= search.window_start_mm


@compiled
def hold(
    search: ContactSearch, state: ProcedureState, tip_mm: float, readings: Readings
) -> ProcedureState:
    """Count contact on the way in: a switch that chatters is closed."""
    open_ticks = 0 if is_contact(readings) else min(state.open_ticks + 1, RELEASE_TICKS)
    touching = open_ticks < RELEASE_TICKS
    if search.enabled and touching and not is_expected(search, tip_mm):
        return state._replace(open_ticks=open_ticks, held_ticks=state.held_ticks + 1)
    return state._replace(open_ticks=open_ticks, held_ticks=max(state.held_ticks - 1, 0))


@compiled
def _contact_event(
    search: ContactSearch,
    tip_mm: float,
    arrived: bool,
    readings: Readings,
    held_ticks: int,
    dt_s: float,
) -> int:
    """Contact, and whether the estimated tip and the switch agree that it can be the carina.

    A steady one before the window can be, and drawing back from it tells.
    """
    if is_contact(readings):
        expected = is_expected(search, tip_mm)
        steady = not expected and held_ticks * dt_s >= HELD_S
        nearer = steady and tip_mm >= search.nearest_mm
        return flag(expected or nearer, Event.CONTACTED) | flag(
            steady and not nearer, Event.CONTACT_MISPLACED
        )
    return flag(arrived, Event.CONTACT_MISPLACED)


@compiled
def _insertion_event(
    plan: Plan,
    state: ProcedureState,
    readings: Readings,
    feedback: ControlFeedback,
    settled: bool,
    dt_s: float,
) -> int:
    """Event that a phase between the start of insertion and the end of suction waits for."""
    phase = state.phase
    still = state.reference_mm_per_s == 0.0
    if phase == Phase.INSERTING:
        arrived = still and state.reference_mm == plan.motion.target_mm and settled
        if plan.contact.enabled:
            held = state.held_ticks
            return _contact_event(plan.contact, feedback.tip_mm, arrived, readings, held, dt_s)
        return flag(arrived, Event.TARGET_REACHED)
    if phase == Phase.BACKING_OFF:
        # The reference is there first: the head has the gap to cross before the tip moves.
        there = still and is_off(plan.contact, state)
        resting = abs(feedback.head_wanted_mm_per_s) < RESTING_MM_PER_S
        return flag(there and resting and settled, Event.BACKED_OFF) | flag(
            is_stuck(plan.contact, state), Event.CONTACT_MISPLACED
        )
    if phase == Phase.OPENING:
        return flag(_is_opened(plan, readings), Event.VALVE_OPENED)
    if phase == Phase.SUCTIONING:
        elapsed = state.arrived_ticks * dt_s >= plan.dwell_s
        nothing_came = line_flow.is_over(plan.pace, state.pace, dt_s)
        return flag(elapsed, Event.DWELL_ELAPSED) | flag(nothing_came, Event.NOTHING_CAME)
    return 0


@compiled
def is_closed(plan: Plan, readings: Readings) -> bool:
    """True where the valve is known to be closed."""
    share = readings.cam_rad / plan.cam_open_rad
    return readings.cam_valid and -BEHIND_SHARE <= share <= CLOSED_SHARE


@compiled
def is_built(plan: Plan, readings: Readings) -> bool:
    """True where the line has the vacuum of suction; a bench waits for none."""
    if plan.bench_only:
        return True
    return readings.vacuum_valid and readings.line_vacuum_mmhg >= plan.check.ready_mmhg


@compiled
def is_kept(plan: Plan, readings: Readings) -> bool:
    """True where the line has the vacuum of the way in."""
    off_mmhg = abs(readings.line_vacuum_mmhg - plan.way_in_mmhg)
    return readings.vacuum_valid and off_mmhg <= KEPT_MMHG


@compiled
def _is_opened(plan: Plan, readings: Readings) -> bool:
    return readings.cam_valid and readings.cam_rad >= OPEN_SHARE * plan.cam_open_rad


@compiled
def _is_settled(plan: Plan, readings: Readings, feedback: ControlFeedback) -> bool:
    distance = abs(feedback.head_wanted_mm - readings.head_mm)
    return readings.head_valid and distance <= plan.motion.settle_mm


@compiled
def step_check(
    plan: Plan, state: CheckState, readings: Readings, feedback: ControlFeedback, dt_s: float
) -> CheckState:
    """Advance the pre-use test by one tick."""
    seen = CheckSeen(
        home=is_home(plan.motion, readings),
        settled=_is_settled(plan, readings, feedback),
        off_park_mm=readings.head_mm - plan.motion.park_head_mm,
        settle_mm=plan.motion.settle_mm,
        opened=_is_opened(plan, readings),
        closed=is_closed(plan, readings),
    )
    return check.step(plan.check, state, readings, seen, dt_s)


@compiled
def step_teaching(
    plan: Plan,
    state: TeachingState,
    readings: Readings,
    requests: Requests,
    feedback: ControlFeedback,
) -> TeachingState:
    """Advance teaching by one tick."""
    return teaching.step(
        plan.plausible,
        state,
        requests.confirm and not requests.abort,
        requests.home,
        readings.head_valid and is_number(readings.head_mm),
        readings.head_mm - plan.motion.park_head_mm,
        is_home(plan.motion, readings),
        feedback.tip_mm,
    )


@compiled
def _phase_event(
    plan: Plan,
    state: ProcedureState,
    checked: CheckState,
    readings: Readings,
    feedback: ControlFeedback,
    home: bool,
    dt_s: float,
) -> int:
    """Bit mask of the event that the phase waits for, once it has come; else 0."""
    time_s = state.phase_ticks * dt_s
    phase = state.phase
    settled = _is_settled(plan, readings, feedback)
    closed = is_closed(plan, readings)
    if phase == Phase.CHECKING:
        passed = checked.item == CheckItem.NONE
        return flag(checked.failed != CheckItem.NONE, Event.CHECK_FAILED) | flag(
            passed and settled and home and closed, Event.CHECK_PASSED
        )
    if phase == Phase.PRELOADING:
        kept = plan.bench_only or (closed and state.kept_ticks * dt_s >= KEPT_S)
        return flag(time_s >= plan.preload_s and settled and kept, Event.PRELOADED)
    if phase == Phase.WITHDRAWING:
        still = state.reference_mm_per_s == 0.0
        parked = still and state.reference_mm == plan.motion.park_mm
        return flag(parked and settled, Event.WITHDRAWN)
    if phase == Phase.CLOSING:
        return flag(closed, Event.VALVE_CLOSED)
    if phase == Phase.ABORTING:
        resting = abs(feedback.head_wanted_mm - plan.motion.park_head_mm) <= plan.motion.settle_mm
        # A forced withdrawal may coast past home, and no trip lets the head go in again.
        there = home or (feedback.tripped and is_out(plan.motion, readings))
        return flag((there and resting and closed) or feedback.powerless, Event.CLEARED)
    if phase == Phase.IDENTIFYING:
        return flag(time_s >= plan.excitation.duration_s, Event.EXCITATION_ENDED)
    if phase == Phase.TEACHING:
        over = teaching.is_over(state.teaching, dt_s)
        return flag(over, Event.TEACHING_ENDED)
    return _insertion_event(plan, state, readings, feedback, settled, dt_s)


@compiled
def _request_events(requests: Requests, home: bool, bench_only: bool, locked_out: bool) -> int:
    """Bit mask of what people ask for; whoever aborts means nothing else with it.

    A machine that is locked out can be taken out of service wherever its head is: the hand that
    draws the catheter out needs everything off, and an encoder that is dead is never home.
    """
    if requests.abort:
        return 1 << Event.ABORT_REQUESTED
    return (
        flag(requests.start, Event.START_REQUESTED)
        | flag(requests.identify and bench_only, Event.IDENTIFY_REQUESTED)
        | flag(requests.teach and home, Event.TEACH_REQUESTED)
        | flag(requests.reset and home, Event.RESET_REQUESTED)
        | flag(requests.reset and not home, Event.RECOVERY_REQUESTED)
        | flag(requests.service and (home or locked_out), Event.SERVICE_REQUESTED)
        | flag(requests.return_to_service and home, Event.SERVICE_ENDED)
        | flag(requests.return_to_service and not home, Event.SERVICE_ENDED_AWAY)
    )


@compiled
def events(
    plan: Plan,
    state: ProcedureState,
    checked: CheckState,
    readings: Readings,
    requests: Requests,
    feedback: ControlFeedback,
    dt_s: float,
) -> int:
    """Bit mask of all events of this tick. checked: the pre-use test after this tick."""
    home = is_home(plan.motion, readings)
    return (
        _phase_event(plan, state, checked, readings, feedback, home, dt_s)
        | flag(feedback.tripped, Event.TRIPPED)
        | flag(state.phase_ticks * dt_s > state.limit_s, Event.PHASE_OVERDUE)
        # Time that the way out was given and has not spent on mucus excuses nothing.
        | flag(state.phase_ticks * dt_s > state.limit_s - state.pace.spare_s, Event.PHASE_OVERDUE)
        | _request_events(requests, home, plan.bench_only, feedback.locked_out)
    )
