"""The governor: whatever procedure and control propose, it lets through less, never more.

It knows neither phase nor protocol nor compensator. It watches readings and what it let through
itself, and answers with the mildest reaction that keeps the limits:
pass < cap < hold < withdraw < torque off. Trips are latched until a person resets.

A withdrawal that the governor forces: for how long, and whether the head comes.
"""

from typing import NamedTuple

from opensuction.kernel.arithmetic import count_ticks, extend_duration, flag
from opensuction.kernel.compiled import compiled
from opensuction.kernel.interface import LARGEST, Readings, Setpoints
from opensuction.kernel.record import make_zero
from opensuction.safety import limits as limit_sets
from opensuction.safety.condition import Condition
from opensuction.safety.governor import judgement, limiter
from opensuction.safety.governor.judgement import STALL_S
from opensuction.safety.governor.limiter import ADVANCE_MM
from opensuction.safety.handling import Reaction
from opensuction.safety.head import drive_force, head_vote
from opensuction.safety.head.head_vote import HeadVote
from opensuction.safety.limits import Limits, head_cap_mm
from opensuction.safety.watch import bus_watch, patient_watch, vacuum_signature, watch
from opensuction.safety.watch.patient_watch import PatientWatch
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
def step_withdrawal(
    state: ForcedWithdrawal, seen: Watch, forced: bool, dt_s: float
) -> ForcedWithdrawal:
    """Bring it up to this tick."""
    if not forced:
        return NONE._replace(whole_s=state.whole_s)
    leaving = seen.speed_mm_per_s <= -LEAVING_MM_PER_S
    held = seen.durations.jammed_s > 0.0 and not leaving
    unseen = _is_unseen(seen)
    return ForcedWithdrawal(
        forced_s=state.forced_s + dt_s,
        blocked_s=extend_duration(state.blocked_s, held and not bus_watch.is_stale(seen.bus), dt_s),
        unseen_s=extend_duration(state.unseen_s, unseen, dt_s),
        waiting_s=extend_duration(state.waiting_s, unseen or not leaving, dt_s),
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
    way_mm = max(head_cap_mm(limits.tip, limits.cap_mm) - limits.park_head_mm, 0.0)
    return way_mm / LEAVING_MM_PER_S + limits.withdrawal_s + WAITING_S


@compiled
def judge_withdrawal(limits: Limits, state: ForcedWithdrawal, seen: Watch) -> int:
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


RUNAWAY = 1 << Condition.HEAD_RUNAWAY
NOT_FOLLOWING = 1 << Condition.HEAD_NOT_FOLLOWING
DISAGREEING = 1 << Condition.HEAD_SENSORS_DISAGREE
TURNED_TICKS = 5
"""How soon a drive that is told the opposite must pull: its current follows at once, averaged over
10 ms; at 17 mm/s the head goes 0.1 mm meanwhile [computed]."""
SWINGING_S = 0.1
"""For how long after a withdrawal has begun what the head does may still be what it did before:
readings up to .06 s old are told as a head whose sensors disagree with its motor [in-silico]."""
ANSWERED_TICKS = 20
"""Until when that is looked at: later it pushes where it brakes at home, as any drive does."""


class GovernorState(NamedTuple):
    """State of the governor."""

    last: Setpoints
    """What it let through in the last tick."""
    valve_command_changed: bool
    """It commanded the valve otherwise than in the tick before."""
    watch: Watch
    patient: PatientWatch
    withdrawal: ForcedWithdrawal
    turned_ticks: int
    """For how long the insertion drive has been told the opposite; 0: it is not."""
    trips: int


class Verdict(NamedTuple):
    """Verdict of the governor in a tick."""

    reaction: int
    trips: int
    patient: int
    """What is wrong with the patient now, whether a trip or not: the same numbers."""
    deepest_mm: float
    """Deepest tip position that is possible."""
    insertion_on: bool
    turned: bool
    """The volts of the insertion drive shall be the other way round."""
    valve_on: bool


def start(limits: Limits, head_mm: float) -> GovernorState:
    """State at power-up with the head read at ``head_mm``; not a number: as deep as can be."""
    read = abs(head_mm) <= LARGEST
    if not read:
        head_mm = float(limit_sets.head_cap_mm(limits.tip, limits.cap_mm))
    return GovernorState(
        last=make_zero(Setpoints, head_mm=head_mm),
        valve_command_changed=False,
        watch=watch.start(limits, head_mm, read=read),
        patient=patient_watch.UNSEEN,
        withdrawal=NONE,
        turned_ticks=0,
        trips=0,
    )


@compiled
def judge(limits: Limits, state: GovernorState, seen: Watch, proposal: Setpoints) -> int:
    """Mask of all trips, old and new, but for those that the patient's monitor shows."""
    return (
        state.trips
        | judgement.judge(limits, seen, proposal, state.last.valve_open)
        | judge_withdrawal(limits, state.withdrawal, seen)
    )


@compiled
def _is_valve_driven(trips: int, opened: bool, resting: bool) -> bool:
    """True where the valve's motor is trusted: else its spring closes it.

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
def _is_turning(state: GovernorState, seen: Watch, trips: int) -> bool:
    """True where the head begins to run away because its motor's wires are swapped.

    Three say so: both sensors that it runs away, and the current that the motor pushes against its
    volts. Then telling it the opposite brings it out. One that goes on pushing is let go, such as
    an amplifier that gives its full voltage whatever it is told.
    """
    began = trips & ~state.trips & RUNAWAY != 0
    return began and drive_force.is_against(seen.drive)


@compiled
def _is_coasting(state: GovernorState, seen: Watch, trips: int) -> bool:
    """True where the head only seems to run away: nothing pushes it, it coasts, or is being slowed.

    So it is where a loose contact parts motor and amplifier for a moment: the head goes on, or
    lags, catches up and goes too far. There is nothing to let go: it is told to come out, and does.
    Should it be pushed after all, it runs away anew.
    """
    began = trips & ~state.trips & RUNAWAY != 0
    return began and drive_force.is_yielding(seen.drive)


@compiled
def _is_swinging(state: GovernorState, seen: Watch, trips: int) -> bool:
    """True where a head that seems to run away was driven in before it was told to come out.

    Both its sensors were found to differ from the motor: they may be late, and the servo on them
    swings. From then on it only pulls; if the head goes on inwards it runs away anew.
    """
    began = trips & ~state.trips & RUNAWAY != 0
    doubtful = state.trips & DISAGREEING != 0 and seen.durations.disagreeing_s == 0.0
    return began and doubtful and state.withdrawal.forced_s < SWINGING_S


@compiled
def _is_obeying(state: GovernorState, seen: Watch) -> bool:
    """True where a drive that is told the opposite does so: it pulls, and the head comes."""
    answering = TURNED_TICKS <= state.turned_ticks <= ANSWERED_TICKS
    pushing = answering and seen.drive.force_n > drive_force.AGAINST_N
    again = pushing or seen.runaway_ticks >= judgement.RUNAWAY_TICKS
    return state.turned_ticks > 0 and not again


@compiled
def _answer(trips: int, turned: bool) -> int:
    """The trips that are reacted to: a drive that has been turned round withdraws."""
    if turned and trips & RUNAWAY != 0:
        return trips & ~RUNAWAY | NOT_FOLLOWING
    return trips


@compiled
def _look_at_drive(state: GovernorState, seen: Watch, trips: int) -> tuple[Watch, int, bool]:
    """Judge a runaway by the motor's current: watch and trips then, and true where it is turned."""
    coasting = _is_coasting(state, seen, trips) or _is_swinging(state, seen, trips)
    if coasting:
        trips = trips & ~RUNAWAY | NOT_FOLLOWING
    turning = _is_turning(state, seen, trips)
    if turning or coasting:
        seen = watch.turn(seen)
    return seen, trips, turning or _is_obeying(state, seen)


@compiled
def locate(
    limits: Limits, state: GovernorState, readings: Readings, driven_v: float, dt_s: float
) -> HeadVote:
    """Position of the head in this tick: procedure and control go by it, too.

    driven_v: volts that the insertion motor had in the last tick.
    """
    seen = state.watch
    current_a = readings.insertion_current_a - seen.drive.offset_a
    vote = head_vote.step(
        limits.drive,
        seen.vote,
        readings._replace(insertion_current_a=current_a),
        state.last.insertion_on,
        driven_v,
        seen.speed_mm_per_s,
        judgement.is_disagreeing(seen.durations),
        dt_s,
    )
    return head_vote.learn(vote, seen.vote, readings, limits.park_head_mm, dt_s)


@compiled
def line_vacuum_mmhg(state: GovernorState, readings: Readings, dt_s: float) -> float:
    """Vacuum in the line in this tick, without the sensor's noise and offset: the procedure's."""
    return vacuum_signature.vacuum_mmhg(watch.filter_line(state.watch, state.last, readings, dt_s))


@compiled
def step(
    limits: Limits,
    state: GovernorState,
    proposal: Setpoints,
    readings: Readings,
    vote: HeadVote,
    overrun: bool,
    dt_s: float,
) -> tuple[GovernorState, Setpoints, Verdict]:
    """Let a proposal through as far as the limits allow.

    vote: of `locate`.
    Returns the new state, the setpoints for the servos and what was done about them.
    """
    seen = watch.step(
        limits,
        state.watch,
        state.last,
        state.valve_command_changed,
        readings,
        vote,
        overrun,
        dt_s,
    )
    patient = patient_watch.step(
        limits.patient, state.patient, readings.monitor, seen.durations.sucking_s > 0.0, dt_s
    )
    inside = seen.durations.inside_s > 0.0
    entering = inside and state.watch.durations.inside_s == 0.0
    found = judge(limits, state, seen, proposal) | patient_watch.select_trips(
        patient.conditions, inside, entering
    )
    seen, trips, turned = _look_at_drive(state, seen, found)
    answered = _answer(trips, turned)
    allowed, reaction = limiter.narrow(limits, state.last, seen, proposal, answered, dt_s)
    verdict = Verdict(
        reaction=reaction,
        trips=trips,
        patient=patient.conditions,
        deepest_mm=limit_sets.deepest_mm(limits.tip, seen.tip),
        insertion_on=allowed.insertion_on,
        turned=turned,
        valve_on=_is_valve_driven(trips, allowed.valve_open, seen.valve.resting),
    )
    # A motor that is home while the head is not has withdrawn nothing: a hand must.
    out = seen.head_mm <= limits.park_head_mm + ADVANCE_MM
    forced = reaction == Reaction.WITHDRAW and (not out or judgement.is_disagreeing(seen.durations))
    following = GovernorState(
        last=allowed,
        valve_command_changed=allowed.valve_open != state.last.valve_open,
        watch=seen,
        patient=patient,
        withdrawal=step_withdrawal(state.withdrawal, seen, forced, dt_s),
        turned_ticks=count_ticks(state.turned_ticks, turned),
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
        withdrawal=NONE,
        turned_ticks=0,
        trips=0,
    )
