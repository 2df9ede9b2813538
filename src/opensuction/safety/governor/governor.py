"""The governor: whatever procedure and control propose, it lets through less, never more.

It knows neither phase nor protocol nor compensator. It watches readings and what it let through
itself, and answers with the mildest reaction that keeps the limits:
pass < cap < hold < withdraw < torque off. Trips are latched until a person resets.
"""

import math
from typing import NamedTuple

from opensuction.kernel.bit_mask import flag
from opensuction.kernel.commands import Setpoints
from opensuction.kernel.compiled import compiled
from opensuction.kernel.readings import LARGEST, Readings
from opensuction.safety import tip_bound
from opensuction.safety.condition import Condition
from opensuction.safety.governor import limiter
from opensuction.safety.governor.limiter import ADVANCE_MM
from opensuction.safety.handling import Reaction
from opensuction.safety.limits import Limits
from opensuction.safety.watch import (
    contact_window,
    patient_watch,
    vacuum_signature,
    valve_axis,
    watch,
)
from opensuction.safety.watch.duration import extend
from opensuction.safety.watch.invalid_ticks import INVALID_TICKS, InvalidTicks
from opensuction.safety.watch.patient_watch import PatientWatch
from opensuction.safety.watch.watch import Durations, Watch

LATE_TICKS = 5
"""Consecutive late ticks of the host that are a fault."""
OVERSPEED_RATIO = 1.25
"""Measured head speed over its limit that no sound machine reaches: the limit is the no-load speed
of the fastest one, and the encoder's step adds 0.5 mm/s to the average [computed]."""
PERSISTENCE_S = 0.2
"""How long head or vacuum may be beyond a limit before it is a trip (a step response settles)."""
STALL_S = 0.1
"""How long the head reading may stand still while the servo must be moving it."""
JAM_S = 0.1
"""How long the head may meet more than friction; a stop against the gear's backlash rings less."""
OVERFORCE_S = 0.05
"""How long the drive may give more than its current limit; assumed."""
DISAGREE_S = 0.05
"""How long the head's two sensors may disagree; two messages of different age do for less."""
DISAGREE_SUCKING_S = 0.005
"""The same with the valve open: messages 1 ms apart are 0.06 mm apart at the fastest 62 mm/s, so
what disagrees for five ticks is no matter of age."""
RUNAWAY_MM = 1.0
"""Advance of the head against its command, beyond what it needs to brake: servo and backlash."""
RUNAWAY_SUCKING_MM = 0.3
"""And while the valve is not closed: only the servo's ripple, for no cycle turns inwards then; the
tip may advance by 0.5 mm."""
OVERSHOOT_MM = 1.0
"""How far beyond its cap a servo may carry the head before it is a trip."""
BLOCKED_S = 0.3
"""How long a forced withdrawal may pull on what holds it: a turn from full speed takes 0.2 s."""
LEAVING_MM_PER_S = 1.0
"""Measured speed outwards above which the head still comes out, however hard it goes."""
UNSEEN_S = 0.5
"""Time for turning round, beyond the way itself, of a withdrawal that cannot be seen."""
AWAY_MM = 5.0
"""Distance from the park position from which the head is on its way: a closed contact matters at
once. Before, the pre-use test names it."""


class GovernorState(NamedTuple):
    """What the governor remembers."""

    last: Setpoints
    """What it let through in the last tick."""
    valve_command_changed: bool
    """It commanded the valve otherwise than in the tick before."""
    watch: Watch
    patient: PatientWatch
    withdrawal_s: float
    """How long it has been forcing the head out."""
    blocked_s: float
    """How long the head has been held meanwhile."""
    unseen_s: float
    """How long its reading has said nothing meanwhile."""
    trips: int


class Verdict(NamedTuple):
    """What the governor did in a tick."""

    reaction: int
    trips: int
    patient: int
    """What is wrong with the patient now, whether a trip or not: the same numbers."""
    deepest_mm: float
    """Deepest tip position that is possible."""
    insertion_on: bool
    valve_on: bool


def start(limits: Limits, head_mm: float) -> GovernorState:
    """State at power-up with the head read at ``head_mm``; not a number: as deep as can be."""
    if not abs(head_mm) <= LARGEST:
        head_mm = float(tip_bound.head_cap_mm(limits.tip, limits.cap_mm))
    return GovernorState(
        last=Setpoints(
            head_mm=head_mm,
            head_mm_per_s=0.0,
            insertion_on=False,
            valve_open=False,
            pump_on=False,
            vacuum_mmhg=0.0,
        ),
        valve_command_changed=False,
        watch=watch.start(limits, head_mm),
        patient=patient_watch.UNSEEN,
        withdrawal_s=0.0,
        blocked_s=0.0,
        unseen_s=0.0,
        trips=0,
    )


@compiled
def _is_possible(proposal: Setpoints) -> bool:
    return (
        math.isfinite(proposal.head_mm)
        and math.isfinite(proposal.head_mm_per_s)
        and math.isfinite(proposal.vacuum_mmhg)
        and proposal.vacuum_mmhg >= 0.0
    )


@compiled
def _is_disagreeing(durations: Durations) -> bool:
    """Whether motor and catheter head have not been at the same place for too long."""
    limit_s = DISAGREE_SUCKING_S if durations.sucking_s > 0.0 else DISAGREE_S
    return durations.disagreeing_s > limit_s


@compiled
def _judge_readings(invalid: InvalidTicks) -> int:
    """Bit mask of the sensors that have given no valid reading for too long."""
    if invalid.head + invalid.carriage + invalid.cam + invalid.vacuum + invalid.contact == 0:
        return 0
    return (
        flag(invalid.head >= INVALID_TICKS, Condition.HEAD_READING_INVALID)
        | flag(invalid.carriage >= INVALID_TICKS, Condition.CARRIAGE_READING_INVALID)
        | flag(invalid.cam >= INVALID_TICKS, Condition.CAM_READING_INVALID)
        | flag(invalid.vacuum >= INVALID_TICKS, Condition.VACUUM_READING_INVALID)
        | flag(invalid.contact >= INVALID_TICKS, Condition.CONTACT_READING_INVALID)
    )


@compiled
def _judge_durations(durations: Durations) -> int:
    """Bit mask of what has lasted for too long and on a sound machine hardly begins."""
    head_s = durations.off_command_s + durations.stalled_s + durations.disagreeing_s
    drive_s = durations.jammed_s + durations.overforce_s
    if head_s + drive_s + durations.overpressure_s == 0.0:
        return 0
    return (
        flag(_is_disagreeing(durations), Condition.HEAD_SENSORS_DISAGREE)
        | flag(durations.off_command_s > PERSISTENCE_S, Condition.HEAD_NOT_FOLLOWING)
        | flag(durations.stalled_s > STALL_S, Condition.HEAD_STALLED)
        | flag(durations.jammed_s > JAM_S, Condition.CATHETER_JAMMED)
        | flag(durations.overforce_s > OVERFORCE_S, Condition.DRIVE_OVERFORCE)
        | flag(durations.overpressure_s > PERSISTENCE_S, Condition.VACUUM_EXCEEDED)
    )


@compiled
def _judge_withdrawal(limits: Limits, state: GovernorState, head_mm: float) -> int:
    """Bit mask of what is wrong with a withdrawal that the governor forces."""
    if state.withdrawal_s == 0.0:
        return 0
    way_s = max(head_mm - limits.park_head_mm, 0.0) / limits.leaving_mm_per_s
    return (
        flag(state.withdrawal_s > limits.withdrawal_s, Condition.WITHDRAWAL_TIME)
        | flag(state.blocked_s > BLOCKED_S, Condition.WITHDRAWAL_BLOCKED)
        | flag(state.unseen_s > way_s + UNSEEN_S, Condition.WITHDRAWAL_UNSEEN)
    )


@compiled
def _judge_head(limits: Limits, seen: Watch) -> int:
    """Bit mask of what is wrong with where the head is and how it moves."""
    overspeed = abs(seen.speed_mm_per_s) > OVERSPEED_RATIO * limits.head_speed_mm_per_s
    highest = tip_bound.head_cap_mm(limits.tip, limits.cap_mm)
    runaway_mm = RUNAWAY_SUCKING_MM if seen.durations.sucking_s > 0.0 else RUNAWAY_MM
    return (
        flag(overspeed, Condition.HEAD_OVERSPEED)
        | flag(seen.head_mm - seen.advance.head_mm > runaway_mm, Condition.HEAD_RUNAWAY)
        | flag(seen.head_mm > highest + OVERSHOOT_MM, Condition.TIP_BEYOND_CAP)
    )


@compiled
def _judge_contact(limits: Limits, seen: Watch) -> int:
    """Bit mask of what is wrong with the contact switch, or with what it has touched."""
    touching = seen.durations.contact_s > 0.0
    if not touching:
        shallowest_mm = tip_bound.shallowest_mm(limits.tip, seen.tip)
        missed = contact_window.is_missed(limits.window, shallowest_mm, touching)
        return flag(missed, Condition.CARINA_MISSED) | flag(
            missed and not seen.window.proven, Condition.CONTACT_STUCK_OPEN
        )
    away = seen.head_mm > limits.park_head_mm + AWAY_MM
    allowed_s = contact_window.IMPOSSIBLE_S if away else limits.contact_s
    stuck = seen.window.impossible_s > allowed_s
    pressing = seen.durations.contact_s > limits.contact_s and seen.window.impossible_s == 0.0
    return flag(stuck, Condition.CONTACT_STUCK_CLOSED) | flag(pressing, Condition.CONTACT_TIME)


@compiled
def _judge_suction(limits: Limits, opened: bool, seen: Watch) -> int:
    """Bit mask of what is wrong with valve, pump and line. opened: what the valve is told."""
    stuck = valve_axis.is_stuck(limits.valve, seen.valve)
    sucking_s = seen.durations.sucking_s
    return (
        vacuum_signature.judge(limits.line, seen.line, seen.parked_closed)
        | flag(sucking_s > limits.negative_pressure_s, Condition.NEGATIVE_PRESSURE_TIME)
        | flag(stuck and opened, Condition.VALVE_STUCK_CLOSED)
        | flag(stuck and not opened, Condition.VALVE_STUCK_OPEN)
    )


@compiled
def judge(limits: Limits, state: GovernorState, seen: Watch, proposal: Setpoints) -> int:
    """Bit mask of all trips, old and new."""
    return (
        state.trips
        | _judge_readings(seen.invalid)
        | _judge_durations(seen.durations)
        | _judge_withdrawal(limits, state, seen.head_mm)
        | _judge_head(limits, seen)
        | _judge_contact(limits, seen)
        | _judge_suction(limits, state.last.valve_open, seen)
        | flag(not _is_possible(proposal), Condition.PROPOSAL_INVALID)
        | flag(seen.durations.inside_s > limits.in_airway_s, Condition.IN_AIRWAY_TIME)
        | flag(seen.late_ticks >= LATE_TICKS, Condition.LATE_TICKS)
    )


@compiled
def _is_valve_driven(trips: int, opened: bool, resting: bool) -> bool:
    """Whether the valve's motor is trusted: else its spring closes it.

    opened: what the valve is told. A valve that has come home is left to its spring: an encoder
    that errs later cannot have the motor open it.
    """
    untrusted = (
        1 << Condition.CAM_READING_INVALID
        | 1 << Condition.VALVE_STUCK_OPEN
        | 1 << Condition.VALVE_STUCK_CLOSED
    )
    return trips & untrusted == 0 and (opened or not resting)


@compiled
def step(
    limits: Limits,
    state: GovernorState,
    proposal: Setpoints,
    readings: Readings,
    overrun: bool,
    dt_s: float,
) -> tuple[GovernorState, Setpoints, Verdict]:
    """Let a proposal through as far as the limits allow.

    Returns the new state, the setpoints for the servos and what was done about them.
    """
    seen = watch.step(
        limits, state.watch, state.last, state.valve_command_changed, readings, overrun, dt_s
    )
    patient = patient_watch.step(
        limits.patient, state.patient, readings.monitor, seen.durations.sucking_s > 0.0, dt_s
    )
    inside = seen.durations.inside_s > 0.0
    trips = judge(limits, state, seen, proposal) | patient_watch.select_trips(
        patient.conditions, inside, inside and state.watch.durations.inside_s == 0.0
    )
    allowed, reaction = limiter.narrow(limits, state.last, seen, proposal, trips, dt_s)
    verdict = Verdict(
        reaction=reaction,
        trips=trips,
        patient=patient.conditions,
        deepest_mm=tip_bound.deepest_mm(limits.tip, seen.tip),
        insertion_on=allowed.insertion_on,
        valve_on=_is_valve_driven(trips, allowed.valve_open, seen.valve.resting),
    )
    # A motor that is home while the head is not has withdrawn nothing: a hand must.
    out = seen.head_mm <= limits.park_head_mm + ADVANCE_MM
    forced = reaction == Reaction.WITHDRAW and (not out or _is_disagreeing(seen.durations))
    held = forced and seen.durations.jammed_s > 0.0 and seen.speed_mm_per_s > -LEAVING_MM_PER_S
    unseen = forced and (seen.invalid.head > 0 or seen.durations.stalled_s > STALL_S)
    following = GovernorState(
        last=allowed,
        valve_command_changed=allowed.valve_open != state.last.valve_open,
        watch=seen,
        patient=patient,
        withdrawal_s=extend(state.withdrawal_s, forced, dt_s),
        blocked_s=extend(state.blocked_s, held, dt_s),
        unseen_s=extend(state.unseen_s, unseen, dt_s),
        trips=trips,
    )
    return following, allowed, verdict


@compiled
def reset(limits: Limits, state: GovernorState) -> GovernorState:
    """Clear what is latched; a cause that is still there trips again at once.

    A command that was ahead of the head begins again from where the head is.
    """
    head_mm = min(state.last.head_mm, state.watch.head_mm)
    return state._replace(
        last=state.last._replace(head_mm=head_mm, head_mm_per_s=0.0),
        valve_command_changed=False,
        watch=watch.reset(limits, state.watch),
        withdrawal_s=0.0,
        blocked_s=0.0,
        unseen_s=0.0,
        trips=0,
    )
