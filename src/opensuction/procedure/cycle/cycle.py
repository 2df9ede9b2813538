"""One suction cycle, tick by tick: which phase it is, and what that phase asks for.

Phases follow Fig. 2 of the paper: insertion to A, valve opens (A'), dwell with suction to B,
withdrawal with the valve open to C, valve closes (D).
"""

import math

from opensuction.control import motion_profile
from opensuction.kernel.codegen.unrolled import chooser
from opensuction.kernel.compiled import compiled
from opensuction.kernel.interface import Readings, Requests, is_number
from opensuction.kernel.vocabulary import RESTING, Phase
from opensuction.procedure.cycle import check, demand, progress, teaching, transition
from opensuction.procedure.cycle import plan as plans
from opensuction.procedure.cycle.check import CheckState
from opensuction.procedure.cycle.demand import Demand
from opensuction.procedure.cycle.plan import Excitation, Plan
from opensuction.procedure.cycle.progress import ControlFeedback, ProcedureState
from opensuction.procedure.cycle.teaching import TeachingState
from opensuction.procedure.cycle.transition import Event
from opensuction.procedure.suction import line_flow
from opensuction.procedure.suction.line_flow import BEGUN, NOTHING_SEEN, FlowSeen, Pace

DRAWN_SHARE = 0.9
"""Share of its set point to which an open line may fall while its pump rests: as the pre-use test
takes for a line that is ready. A 6 Fr catheter's flow takes half a second for that [computed]."""

VENTED_S = 0.1
"""How long the pump runs at least before the way in: what the pre-use test has left is let out by
then, and the reading, 20 ms behind, has forgotten it but for 1 mmHg [computed]."""
SUCKING = (Phase.OPENING, Phase.SUCTIONING, Phase.WITHDRAWING)
"""Phases with the valve open."""
FELT = (Phase.SUCTIONING, Phase.WITHDRAWING, Phase.ABORTING)
"""Phases in which an open valve closes on what touches the tip."""

_phase_limit_s = chooser(len(Phase))


def begin(plan: Plan, phase: Phase) -> ProcedureState:
    """State at the beginning of a phase, tip at its parked reference, nothing tested or taught."""
    return _enter(
        plan,
        int(phase),
        transition.STAY,
        plan.motion.park_mm,
        False,
        check.UNTESTED,
        teaching.UNTAUGHT,
    )


@compiled
def _enter(
    plan: Plan,
    phase: int,
    cause: int,
    reference_mm: float,
    valve_open: bool,
    tested: CheckState,
    taught: TeachingState,
) -> ProcedureState:
    return ProcedureState(
        phase=phase,
        cause=cause,
        phase_ticks=0,
        limit_s=_phase_limit_s(plan.limits_s, phase),
        start_mm=reference_mm,
        leg_ticks=0,
        end_mm=plans.backed_off_mm(plan.contact, reference_mm),
        touched_mm=reference_mm,
        reference_mm=reference_mm,
        reference_mm_per_s=0.0,
        arrived_ticks=0,
        open_ticks=progress.RELEASE_TICKS,
        held_ticks=0,
        nearer=False,
        valve_open=valve_open,
        line_ready=False,
        kept_ticks=0,
        flow=NOTHING_SEEN,
        pace=BEGUN,
        check=tested,
        teaching=taught,
    )


@compiled
def excite(excitation: Excitation, time_s: float) -> tuple[float, float]:
    """Head travel from rest (mm) and velocity (mm/s) of the identification excitation."""
    if time_s >= excitation.duration_s:
        return 0.0, 0.0
    rate = 2.0 * math.pi / excitation.period_s
    half = 0.5 * excitation.range_mm
    angle = rate * time_s
    return half * (1.0 - math.cos(angle)), half * rate * math.sin(angle)


@compiled
def _reference(plan: Plan, state: ProcedureState, time_s: float) -> tuple[float, float]:
    """Desired tip position and velocity ``time_s`` after the phase began."""
    motion = plan.motion
    if state.phase == Phase.INSERTING:
        return motion_profile.staged_at(plans.way_in(motion, state.start_mm), time_s)
    if state.phase == Phase.BACKING_OFF:
        way = plans.back_off(motion, state.start_mm, state.end_mm)
        return motion_profile.at(way, time_s)
    if state.phase == Phase.WITHDRAWING:
        way = plans.way_out(motion, state.start_mm, motion.withdrawal_mm_per_s)
        reference_mm, velocity = motion_profile.at(way, time_s)
        return reference_mm, state.pace.ratio * velocity
    if state.phase == Phase.ABORTING:
        return motion_profile.at(
            plans.way_out(motion, state.start_mm, motion.abort_mm_per_s), time_s
        )
    if state.phase == Phase.IDENTIFYING:
        moved_mm, velocity = excite(plan.excitation, time_s)
        return motion.park_mm + moved_mm, velocity
    return state.reference_mm, 0.0


@compiled
def _way_time_s(plan: Plan, state: ProcedureState, dt_s: float) -> float:
    """Time for which the reference has been on its way, at its planned speed.

    A back-off crosses the gap first, and the way out is slower where mucus comes.
    """
    time_s = (state.phase_ticks - state.leg_ticks) * dt_s
    if state.phase == Phase.BACKING_OFF and state.leg_ticks == 0:
        return time_s - plans.back_off_wait_s(plan)
    if state.phase == Phase.WITHDRAWING:
        return time_s - state.pace.late_s
    return time_s


@compiled
def _follow_switch(plan: Plan, state: ProcedureState, readings: Readings) -> ProcedureState:
    """A back-off after another tick; it goes on where the switch opened late, or has not yet."""
    if progress.is_contact(readings):
        state = state._replace(touched_mm=state.reference_mm)
    ended = state.phase_ticks > 0 and state.reference_mm <= state.end_mm
    if not ended or progress.is_off(plan.contact, state):
        return state
    return state._replace(
        start_mm=state.reference_mm,
        leg_ticks=state.phase_ticks,
        end_mm=state.touched_mm - plans.LEAST_OFF_SHARE * plan.contact.backoff_mm,
    )


@compiled
def _valve_wanted(phase: int, was_open: bool, home: bool, ready: bool, lifted: bool) -> bool:
    """The valve rule: open from A to C; an abort keeps it open on the way out if it was open.

    ready: the line has the vacuum of suction, and the tip touches nothing that it would draw in;
    the valve waits for that. lifted: a carina has come to the tip; the valve closes as long as it
    stays there, and on the way out for good. The pre-use test strokes it too: see
    `check.is_stroking`.
    """
    if phase == Phase.OPENING:
        return was_open or ready
    if phase == Phase.ABORTING:
        return was_open and not (home or lifted)
    if phase == Phase.WITHDRAWING:
        return was_open and not lifted
    return phase == Phase.SUCTIONING and not lifted


@compiled
def _is_ready(plan: Plan, phase: int, was_ready: bool, readings: Readings, time_s: float) -> bool:
    """True once the line has had its vacuum since the pump was started, and the pump rests.

    On the way in it has little, and the pump rests until the tip is where it shall suck: a valve
    that lets gas through then shows as a fall of the vacuum, and draws with no more than that. Only
    there does the pump build the vacuum of suction, behind the closed valve. Where a thin
    catheter's flow would not show beside a running pump, it rests with the valve open, too, until a
    part of the vacuum has been drawn.
    """
    vacuum = readings.line_vacuum_mmhg if readings.vacuum_valid else 0.0
    if phase in SUCKING:
        least_mmhg = DRAWN_SHARE * plan.vacuum_mmhg if was_ready else plan.vacuum_mmhg
        return plan.pump_rests_open and vacuum >= least_mmhg
    vented = phase != Phase.PRELOADING or time_s >= VENTED_S
    filled = vented and vacuum >= DRAWN_SHARE * plan.way_in_mmhg
    return phase in demand.WAY_IN and (was_ready or filled)


@compiled
def _is_building(phase: int, valve_open: bool) -> bool:
    """True while the tip waits for the vacuum of suction, behind the closed valve."""
    return phase == Phase.OPENING and not valve_open


@compiled
def _extend_limit(plan: Plan, state: ProcedureState, dt_s: float) -> float:
    """Longest duration of a phase that builds the vacuum, which has its time on top.

    As far as it has been needed, and no longer than such a pump may take.
    """
    if state.phase_ticks * dt_s < plan.build_most_s:
        return state.limit_s + dt_s
    return state.limit_s


@compiled
def _next_check(state: ProcedureState, checked: CheckState, phase: int, cause: int) -> CheckState:
    """State of the pre-use test at the beginning of a phase."""
    if phase == Phase.CHECKING:
        return check.begin()
    if state.phase == Phase.CHECKING:
        broken = cause in (Event.TRIPPED, Event.PHASE_OVERDUE)
        return check.end(checked, broken)
    return checked


@compiled
def _change_phase(
    plan: Plan,
    state: ProcedureState,
    checked: CheckState,
    taught: TeachingState,
    events: int,
    phase: int,
    contact_mm: float,
) -> ProcedureState:
    """State at the beginning of another phase. contact_mm: tip reference at contact."""
    resting = phase in RESTING
    reference_mm = plan.motion.park_mm if resting else state.reference_mm
    if phase == Phase.BACKING_OFF:
        reference_mm = contact_mm
    cause = transition.cause(state.phase, events)
    checked = _next_check(state, checked, phase, cause)
    was_open = state.valve_open and state.phase != Phase.CHECKING
    if phase == Phase.TEACHING:
        taught = teaching.UNTAUGHT
    return _enter(plan, phase, cause, reference_mm, was_open and not resting, checked, taught)


@compiled
def _see_flow(
    plan: Plan, state: ProcedureState, phase: int, readings: Readings, dt_s: float
) -> FlowSeen:
    """Flow of mucus by the vacuum in the line, while the valve is open in a cycle.

    state: as the tick began. phase: as it goes on.
    """
    if plan.flow.window_s == 0.0 or phase not in SUCKING or not state.valve_open:
        return NOTHING_SEEN
    valid = readings.vacuum_valid and is_number(readings.line_vacuum_mmhg)
    pumping = not state.line_ready
    return line_flow.step(plan.flow, state.flow, readings.line_vacuum_mmhg, valid, pumping, dt_s)


@compiled
def _keep_pace(
    plan: Plan, now: Pace, phase: int, seen: FlowSeen, free: bool, dwell_left_s: float, dt_s: float
) -> Pace:
    """Pace of suction after another tick in a phase. free: the tip touches nothing."""
    if phase == Phase.SUCTIONING:
        now = line_flow.listen(plan.pace, now, line_flow.is_nothing_coming(seen, dt_s))
        return line_flow.turn(plan.pace, now, line_flow.left_s(plan.pace, now, dwell_left_s, dt_s))
    if phase == Phase.WITHDRAWING:
        comes = free and line_flow.is_coming(seen, dt_s)
        return line_flow.go_on(plan.pace, now, comes, dt_s)
    return now


@compiled
def _is_there(plan: Plan, phase: int, reference_mm: float) -> bool:
    """True where the reference stands at the target."""
    if phase == Phase.INSERTING:
        return reference_mm == plan.motion.target_mm
    return phase in (Phase.OPENING, Phase.SUCTIONING)


@compiled
def _ask_valve(
    plan: Plan,
    state: ProcedureState,
    phase: int,
    readings: Readings,
    checked: CheckState,
    free: bool,
    dt_s: float,
) -> tuple[ProcedureState, bool]:
    """State with its contact counted, and whether the valve shall be open.

    free: the tip touches nothing.
    """
    if phase == Phase.CHECKING:
        return state, check.is_stroking(checked.item)
    if phase in FELT:
        state = progress.feel(state, free)
    home = progress.is_home(plan.motion, readings)
    ready = free and progress.is_built(plan, readings)
    lifted = progress.is_lifted(state, dt_s)
    return state, _valve_wanted(phase, state.valve_open, home, ready, lifted)


@compiled
def step(
    plan: Plan,
    state: ProcedureState,
    readings: Readings,
    requests: Requests,
    feedback: ControlFeedback,
    dt_s: float,
) -> tuple[ProcedureState, Demand]:
    """Advance the cycle by one tick; returns the new state and what it asks for."""
    checked, taught = state.check, state.teaching
    if state.phase == Phase.CHECKING:
        checked = progress.step_check(plan, checked, readings, feedback, dt_s)
    if state.phase == Phase.TEACHING:
        taught = progress.step_teaching(plan, taught, readings, requests, feedback)
    events = progress.events(plan, state, checked, readings, requests, feedback, dt_s)
    phase = transition.follow(state.phase, events)
    arrived_ticks, line_ready = state.arrived_ticks, state.line_ready
    seen = _see_flow(plan, state, phase, readings, dt_s)
    dwell_left_s = plan.dwell_s - (arrived_ticks + 1) * dt_s
    if phase != state.phase:
        state = _change_phase(plan, state, checked, taught, events, phase, feedback.contact_tip_mm)
        checked, taught = state.check, state.teaching
        line_ready = line_ready and phase != Phase.OPENING
        if phase == Phase.WITHDRAWING:
            begun = line_flow.leave(plan.pace, dwell_left_s)
            state = state._replace(pace=begun, limit_s=state.limit_s + begun.spare_s)
        if phase == Phase.BACKING_OFF:
            nearer = not progress.is_expected(plan.contact, feedback.tip_mm)
            state = state._replace(nearer=nearer)
    free = progress.is_free(plan, readings)
    now_pace = _keep_pace(plan, state.pace, phase, seen, free, dwell_left_s, dt_s)
    state = state._replace(pace=now_pace)
    if phase == Phase.INSERTING:
        state = progress.hold(plan.contact, state, feedback.tip_mm, readings)
    if phase == Phase.BACKING_OFF:
        state = _follow_switch(plan, state, readings)
    time_s = state.phase_ticks * dt_s
    reference, velocity = _reference(plan, state, _way_time_s(plan, state, dt_s))
    state, valve_open = _ask_valve(plan, state, phase, readings, checked, free, dt_s)
    line_ready = _is_ready(plan, phase, line_ready, readings, time_s)
    kept = phase == Phase.PRELOADING and line_ready and progress.is_kept(plan, readings)
    building = _is_building(phase, valve_open)
    passed_ticks = arrived_ticks if building else arrived_ticks + 1
    now = state._replace(
        phase=phase,
        phase_ticks=state.phase_ticks + 1,
        reference_mm=reference,
        reference_mm_per_s=velocity,
        limit_s=_extend_limit(plan, state, dt_s) if building else state.limit_s,
        arrived_ticks=passed_ticks if _is_there(plan, phase, reference) else 0,
        valve_open=valve_open,
        line_ready=line_ready,
        kept_ticks=state.kept_ticks + 1 if kept else 0,
        flow=seen,
        check=checked,
        teaching=taught,
    )
    return now, demand.ask(plan, now, time_s, dt_s)
