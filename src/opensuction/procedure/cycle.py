"""One suction cycle, tick by tick: which phase it is, and what that phase asks for.

Phases follow Fig. 2 of the paper: insertion to A, valve opens (A'), dwell with suction to B,
withdrawal with the valve open to C, valve closes (D).
"""

import math
from typing import NamedTuple

from opensuction.control import profile
from opensuction.kernel.compiled import compiled
from opensuction.kernel.phase import Phase
from opensuction.kernel.readings import Readings
from opensuction.kernel.requests import Requests
from opensuction.procedure import plan as plans
from opensuction.procedure import transition
from opensuction.procedure.plan import Excitation, Plan
from opensuction.procedure.transition import Event

OPEN_SHARE = 0.95
"""Share of the cam's stroke at which the valve counts as open: the servo leaves a static error."""
CLOSED_SHARE = 0.03
"""Share of the cam's stroke below which the valve counts as closed."""
VACUUM_READY_SHARE = 0.9
"""Share of the set point that the line must hold before a cycle begins."""
INWARDS = 1.0
OUTWARDS = -1.0


class ProcedureState(NamedTuple):
    """Where the cycle stands."""

    phase: int
    phase_ticks: int
    start_mm: float
    """Reference at the start of the phase."""
    reference_mm: float
    reference_mm_per_s: float
    arrived_ticks: int
    """Ticks since the reference reached the target."""
    valve_open: bool


class Surroundings(NamedTuple):
    """What the procedure learns from the rest of the controller."""

    head_command_mm: float
    """Last head command that was let through."""
    tripped: bool
    powerless: bool
    """The insertion drive's torque is off."""


class Demand(NamedTuple):
    """What the procedure asks of the control."""

    reference_mm: float
    """Desired tip position (y_r)."""
    reference_mm_per_s: float
    direction: float
    """Of the tip's next motion: +1 towards the carina, -1 back."""
    valve_open: bool
    pump_on: bool
    vacuum_mmhg: float


def parked() -> ProcedureState:
    """Ready for a cycle, tip at the reference 0."""
    return _enter(Phase.PARKED.value, 0.0, False)


@compiled
def _enter(phase: int, reference_mm: float, valve_open: bool) -> ProcedureState:
    return ProcedureState(
        phase=phase,
        phase_ticks=0,
        start_mm=reference_mm,
        reference_mm=reference_mm,
        reference_mm_per_s=0.0,
        arrived_ticks=0,
        valve_open=valve_open,
    )


@compiled
def excite(excitation: Excitation, time_s: float) -> tuple[float, float]:
    """Head position (mm) and velocity (mm/s) of the identification excitation."""
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
    if state.phase == Phase.INSERTING.value:
        return profile.at(plans.way_in(motion, state.start_mm), time_s)
    if state.phase == Phase.WITHDRAWING.value:
        return profile.at(plans.way_out(motion, state.start_mm, motion.withdrawal_mm_per_s), time_s)
    if state.phase == Phase.ABORTING.value:
        return profile.at(plans.way_out(motion, state.start_mm, motion.abort_mm_per_s), time_s)
    if state.phase == Phase.IDENTIFYING.value:
        return excite(plan.excitation, time_s)
    return state.reference_mm, 0.0


@compiled
def _bit(happened: bool, event: int) -> int:
    return 1 << event if happened else 0


@compiled
def _progress(
    plan: Plan, state: ProcedureState, readings: Readings, around: Surroundings, dt_s: float
) -> int:
    """Bit mask of what the cycle was waiting for and has happened."""
    time_s = state.phase_ticks * dt_s
    phase = state.phase
    distance = abs(around.head_command_mm - readings.head_mm)
    settled = distance <= plan.motion.settle_mm
    still = state.reference_mm_per_s == 0.0
    closed = abs(readings.cam_rad) <= CLOSED_SHARE * plan.cam_open_rad
    home = abs(readings.head_mm - plan.motion.park_head_mm) <= plan.motion.settle_mm + 0.5
    if phase == Phase.CHECKING.value:
        sound = (
            readings.head_valid
            and readings.cam_valid
            and readings.vacuum_valid
            and readings.contact_valid
            and not readings.contact_closed
        )
        ready = readings.line_vacuum_mmhg >= VACUUM_READY_SHARE * plan.vacuum_mmhg
        return _bit(sound and settled and home and closed and ready, Event.CHECK_PASSED.value)
    if phase == Phase.PRELOADING.value:
        return _bit(time_s >= plan.preload_s and settled, Event.PRELOADED.value)
    if phase == Phase.INSERTING.value:
        arrived = still and state.reference_mm == plan.motion.target_mm
        return _bit(arrived and settled, Event.TARGET_REACHED.value)
    if phase == Phase.OPENING.value:
        return _bit(readings.cam_rad >= OPEN_SHARE * plan.cam_open_rad, Event.VALVE_OPENED.value)
    if phase == Phase.SUCTIONING.value:
        elapsed = state.arrived_ticks * dt_s >= plan.dwell_s
        return _bit(elapsed, Event.DWELL_ELAPSED.value)
    if phase == Phase.WITHDRAWING.value:
        return _bit(still and state.reference_mm == 0.0 and settled, Event.WITHDRAWN.value)
    if phase == Phase.CLOSING.value:
        return _bit(closed, Event.VALVE_CLOSED.value)
    if phase == Phase.ABORTING.value:
        return _bit((home and closed) or around.powerless, Event.CLEARED.value)
    if phase == Phase.IDENTIFYING.value:
        return _bit(time_s >= plan.excitation.duration_s, Event.EXCITATION_ENDED.value)
    return 0


@compiled
def happened(
    plan: Plan,
    state: ProcedureState,
    readings: Readings,
    requests: Requests,
    around: Surroundings,
    dt_s: float,
) -> int:
    """Bit mask of all events of this tick."""
    overdue = state.phase_ticks * dt_s > plans.phase_limit_s(plan.limits_s, state.phase)
    home = abs(readings.head_mm - plan.motion.park_head_mm) <= plan.motion.settle_mm + 0.5
    return (
        _progress(plan, state, readings, around, dt_s)
        | _bit(around.tripped, Event.TRIPPED.value)
        | _bit(requests.abort, Event.ABORT_REQUESTED.value)
        | _bit(overdue, Event.PHASE_OVERDUE.value)
        | _bit(requests.start, Event.START_REQUESTED.value)
        | _bit(requests.identify, Event.IDENTIFY_REQUESTED.value)
        | _bit(requests.reset and home, Event.RESET_REQUESTED.value)
        | _bit(requests.reset and not home, Event.RECOVERY_REQUESTED.value)
    )


@compiled
def _valve_wanted(phase: int, was_open: bool, still_inside: bool) -> bool:
    """The valve rule: open from A to C; an abort keeps it open on the way out if it was open."""
    if phase == Phase.ABORTING.value:
        return was_open and still_inside
    return (
        phase == Phase.OPENING.value
        or phase == Phase.SUCTIONING.value
        or phase == Phase.WITHDRAWING.value
    )


@compiled
def _direction(plan: Plan, phase: int, arrived_s: float) -> float:
    """Direction of the tip's next motion; it turns when the way back's gap is to be crossed."""
    if phase == Phase.PRELOADING.value or phase == Phase.INSERTING.value:
        return INWARDS
    if phase == Phase.OPENING.value or phase == Phase.SUCTIONING.value:
        return INWARDS if arrived_s < plan.dwell_s - plan.gap_lead_s else OUTWARDS
    return OUTWARDS


@compiled
def step(
    plan: Plan,
    state: ProcedureState,
    readings: Readings,
    requests: Requests,
    around: Surroundings,
    dt_s: float,
) -> tuple[ProcedureState, Demand]:
    """Advance the cycle by one tick; returns the new state and what it asks for."""
    events = happened(plan, state, readings, requests, around, dt_s)
    phase = transition.follow(state.phase, events)
    if phase != state.phase:
        arrived_ticks = state.arrived_ticks
        state = _enter(phase, state.reference_mm, state.valve_open)
        if phase == Phase.HALTED.value or phase == Phase.PARKED.value:
            state = _enter(phase, 0.0, False)
    else:
        arrived_ticks = state.arrived_ticks
    reference, velocity = _reference(plan, state, state.phase_ticks * dt_s)
    dwelling = (
        phase == Phase.INSERTING.value
        or phase == Phase.OPENING.value
        or phase == Phase.SUCTIONING.value
    )
    arrived = dwelling and reference == plan.motion.target_mm
    arrived_ticks = arrived_ticks + 1 if arrived else 0
    demand = Demand(
        reference_mm=reference,
        reference_mm_per_s=velocity,
        direction=_direction(plan, phase, arrived_ticks * dt_s),
        valve_open=_valve_wanted(phase, state.valve_open, reference > 0.0),
        pump_on=phase != Phase.PARKED.value
        and phase != Phase.HALTED.value
        and phase != Phase.IDENTIFYING.value,
        vacuum_mmhg=plan.vacuum_mmhg,
    )
    return (
        ProcedureState(
            phase=phase,
            phase_ticks=state.phase_ticks + 1,
            start_mm=state.start_mm,
            reference_mm=reference,
            reference_mm_per_s=velocity,
            arrived_ticks=arrived_ticks,
            valve_open=demand.valve_open,
        ),
        demand,
    )
