"""Trips that have a cause in this tick: all measurements and the proposal held against the limits.

The watch counts most of what may go wrong: ticks without a reading, durations. While none of these
has begun, none is compared with its limit.
"""

import math

from opensuction.kernel.arithmetic import flag
from opensuction.kernel.compiled import compiled
from opensuction.kernel.interface import Setpoints
from opensuction.safety import limits as limit_sets
from opensuction.safety.condition import Condition
from opensuction.safety.head.head_vote import HeadVote
from opensuction.safety.invalid_ticks import INVALID_TICKS, InvalidTicks
from opensuction.safety.limits import Limits
from opensuction.safety.watch import bus_watch, tip_force, vacuum_signature, valve_axis
from opensuction.safety.watch.bus_watch import BusWatch
from opensuction.safety.watch.watch_state import Durations, Watch

LATE_TICKS = 5
"""Consecutive late ticks of the host that are a fault."""
LATE_SHARE = 0.25
"""Share of late ticks, averaged over 0.1 s, that is one too: four in a row are 0.04 [design]."""
PERSISTENCE_S = 0.2
"""How long head or vacuum may be beyond a limit before it is a trip (a step response settles)."""
STALL_S = 0.1
"""How long the head reading may stand still while the servo must be moving it."""
JAM_S = 0.1
"""How long the head may meet more than friction; a stop against the gear's backlash rings less."""
OVERFORCE_S = 0.08
"""How long the drive may give more than its current limit: 60 ms are a sensor's; assumed."""
DISAGREE_S = 0.05
"""How long the head's two sensors may disagree; two messages of different age do for less."""
DISAGREE_SUCKING_S = 0.005
"""The same with the valve open: messages 1 ms apart are 0.06 mm apart at the fastest 62 mm/s, so
what disagrees for five ticks is no matter of age."""
ADRIFT_S = 1.2
"""How long both sensors may be away from the motor: after a contact's reversal, for which the
drive's current limit hides its speed, they are for up to 0.9 s [in-silico]."""
ABSENT_S = 0.05
REMAINING_S = 0.2
"""How long the light barrier may be without a catheter that must be in it, and with one that must
be out: secretions flicker; assumed."""
OVERSPEED_TICKS = 20
"""How long the head may be too fast: two time constants of the averaged speed; inwards it is a
runaway before, by its travel [design]."""
RUNAWAY_TICKS = 5
"""How long the head may be further in than its command explains: one sample decides nothing. At 17
mm/s, the speed that a reversed drive has reached by then, it goes 0.1 mm meanwhile [computed]."""
OVERSHOOT_MM = 1.0
"""How far beyond its cap a servo may carry the head before it is a trip."""
AWAY_MM = 5.0
"""Distance from the park position from which the head is on its way: a closed contact matters at
once. Before, the pre-use test names it."""


@compiled
def _is_possible(proposal: Setpoints) -> bool:
    return (
        math.isfinite(proposal.head_mm)
        and math.isfinite(proposal.head_mm_per_s)
        and math.isfinite(proposal.vacuum_mmhg)
        and proposal.vacuum_mmhg >= 0.0
    )


@compiled
def is_disagreeing(durations: Durations) -> bool:
    """True where motor and catheter head have not been at the same place for too long."""
    limit_s = DISAGREE_SUCKING_S if durations.sucking_s > 0.0 else DISAGREE_S
    return durations.disagreeing_s > limit_s


@compiled
def _is_elsewhere(durations: Durations) -> bool:
    """True where the catheter is not where both sensors of its head have it."""
    return durations.adrift_s > ADRIFT_S or durations.remaining_s > REMAINING_S


@compiled
def _judge_tip(limits: Limits, seen: Watch) -> int:
    """Mask of what the line of the tip's switch tells: cut on the way, the tip may be off.

    Where other sensors give nothing either, it is the bus; before, the pre-use test names it.
    """
    invalid = seen.invalid
    alone = invalid.contact >= INVALID_TICKS and invalid.cam + invalid.vacuum == 0
    away = seen.head_mm > limits.park_head_mm + AWAY_MM
    return flag(alone and away, Condition.TIP_DETACHED)


@compiled
def _judge_readings(invalid: InvalidTicks, vote: HeadVote, bus: BusWatch) -> int:
    """Mask of the sensors without a reading for too long, or with one that nothing bears out."""
    dead = bus_watch.is_dead(bus)
    missing = invalid.head + invalid.carriage + invalid.cam + invalid.vacuum + invalid.contact
    if missing == 0 and not (vote.encoder_out or vote.carriage_out or dead):
        return 0
    encoder = invalid.head >= INVALID_TICKS or vote.encoder_out or dead
    carriage = invalid.carriage >= INVALID_TICKS or vote.carriage_out
    return (
        flag(encoder, Condition.HEAD_READING_INVALID)
        | flag(carriage, Condition.CARRIAGE_READING_INVALID)
        | flag(invalid.cam >= INVALID_TICKS, Condition.CAM_READING_INVALID)
        | flag(invalid.vacuum >= INVALID_TICKS, Condition.VACUUM_READING_INVALID)
        | flag(invalid.contact >= INVALID_TICKS, Condition.CONTACT_READING_INVALID)
    )


@compiled
def _judge_durations(durations: Durations) -> int:
    """Mask of what has lasted for too long and on a sound machine hardly begins."""
    head_s = durations.off_command_s + durations.stalled_s + durations.disagreeing_s
    drive_s = durations.jammed_s + durations.overforce_s
    tip_s = durations.adrift_s + durations.absent_s + durations.remaining_s
    if head_s + drive_s + tip_s + durations.overpressure_s == 0.0:
        return 0
    return (
        flag(is_disagreeing(durations) or _is_elsewhere(durations), Condition.HEAD_SENSORS_DISAGREE)
        | flag(durations.absent_s > ABSENT_S, Condition.TIP_DETACHED)
        | flag(durations.off_command_s > PERSISTENCE_S, Condition.HEAD_NOT_FOLLOWING)
        | flag(durations.stalled_s > STALL_S, Condition.HEAD_STALLED)
        | flag(durations.jammed_s > JAM_S, Condition.CATHETER_JAMMED)
        | flag(durations.overforce_s > OVERFORCE_S, Condition.DRIVE_OVERFORCE)
        | flag(durations.overpressure_s > PERSISTENCE_S, Condition.VACUUM_EXCEEDED)
    )


@compiled
def _judge_head(limits: Limits, seen: Watch) -> int:
    """Mask of what is wrong with where the head is and how it moves."""
    highest = limit_sets.head_cap_mm(limits.tip, limits.cap_mm)
    return (
        flag(seen.overspeed_ticks >= OVERSPEED_TICKS, Condition.HEAD_OVERSPEED)
        | flag(seen.runaway_ticks >= RUNAWAY_TICKS, Condition.HEAD_RUNAWAY)
        | flag(seen.head_mm > highest + OVERSHOOT_MM, Condition.TIP_BEYOND_CAP)
    )


@compiled
def _judge_contact(limits: Limits, seen: Watch) -> int:
    """Mask of what is wrong with the contact switch, or with what it has touched."""
    contact_s, impossible_s = seen.durations.contact_s, seen.window.impossible_s
    shallowest_mm = limit_sets.shallowest_mm(limits.tip, seen.tip)
    missed = tip_force.is_missed(limits.window, seen.window, shallowest_mm, contact_s > 0.0)
    unseen = (missed and not seen.window.proven) or tip_force.is_pressing(seen.pressed)
    trips = flag(missed, Condition.CARINA_MISSED) | flag(unseen, Condition.CONTACT_STUCK_OPEN)
    if contact_s + impossible_s == 0.0:
        return trips
    away = seen.head_mm > limits.park_head_mm + AWAY_MM
    allowed_s = tip_force.IMPOSSIBLE_S if away else limits.contact_s
    driven_s = seen.durations.driven_contact_s
    long = contact_s > limits.contact_s or driven_s > limits.driven_contact_s
    stuck = impossible_s > allowed_s or (long and away and impossible_s > 0.0)
    return (
        trips
        | flag(stuck, Condition.CONTACT_STUCK_CLOSED)
        | flag(long and impossible_s == 0.0, Condition.CONTACT_TIME)
    )


@compiled
def _judge_suction(limits: Limits, seen: Watch, opened: bool) -> int:
    """Mask of what is wrong with valve, pump and line."""
    stuck = valve_axis.is_stuck(limits.valve, seen.valve)
    sucking_s = seen.durations.sucking_s
    return (
        vacuum_signature.judge(limits.line, seen.line, seen.parked_closed)
        | flag(sucking_s > limits.negative_pressure_s, Condition.NEGATIVE_PRESSURE_TIME)
        | flag(stuck and opened, Condition.VALVE_STUCK_CLOSED)
        | flag(stuck and not opened, Condition.VALVE_STUCK_OPEN)
    )


@compiled
def judge(limits: Limits, seen: Watch, proposal: Setpoints, opened: bool) -> int:
    """Mask of the trips for which there is a cause in this tick.

    opened: the valve is commanded to be open.
    """
    return (
        _judge_readings(seen.invalid, seen.vote, seen.bus)
        | _judge_durations(seen.durations)
        | _judge_head(limits, seen)
        | _judge_tip(limits, seen)
        | _judge_contact(limits, seen)
        | _judge_suction(limits, seen, opened)
        | flag(not _is_possible(proposal), Condition.PROPOSAL_INVALID)
        | flag(seen.durations.inside_s > limits.in_airway_s, Condition.IN_AIRWAY_TIME)
        | flag(seen.late_ticks >= LATE_TICKS or seen.late_share > LATE_SHARE, Condition.LATE_TICKS)
    )
