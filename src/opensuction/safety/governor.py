"""The governor: whatever procedure and control propose, it lets through less, never more.

It knows neither phase nor protocol nor compensator. It watches readings and what it let through
itself, and answers with the mildest reaction that keeps the limits:
pass < cap < hold < withdraw < torque off. Trips are latched until a person resets.
"""

import math
from typing import NamedTuple

from opensuction.kernel.commands import Setpoints
from opensuction.kernel.compiled import compiled
from opensuction.kernel.readings import Readings
from opensuction.safety import limits as bounds
from opensuction.safety import patient_watch, trip, watch
from opensuction.safety.limits import Limits
from opensuction.safety.patient_watch import PatientWatch
from opensuction.safety.trip import Reaction, Trip
from opensuction.safety.watch import INVALID_TICKS, Watch

LATE_TICKS = 5
"""Consecutive late ticks of the host that are a fault."""
OVERSPEED_RATIO = 1.5
"""Measured head speed over its limit that is a runaway, not a transient of the servo."""
PERSISTENCE_S = 0.2
"""How long head or vacuum may be beyond a limit before it is a trip (a step response settles)."""
STALL_S = 0.1
"""How long the head reading may stand still while the servo must be moving it."""
RUNAWAY_MM = 1.0
"""Advance of the head against its command; a stop from full speed overshoots by up to 0.7 mm."""
OVERSHOOT_MM = 1.0
"""How far beyond its cap a servo may carry the head before it is a trip."""
LEAD_SHARE = 0.5
"""Share of the following limit by which a withdrawal may lead the head."""
ADVANCE_MM = 0.5
"""Net advance of the head that is allowed while the valve is not closed."""
ADVANCING_MM_PER_S = 3.0
"""Measured speed inwards above which the head is advancing: the valve is kept from opening."""


class GovernorState(NamedTuple):
    """What the governor remembers."""

    head_mm: float
    """Last head command that it let through."""
    valve_open: bool
    """Last valve command that it let through."""
    watch: Watch
    patient: PatientWatch
    withdrawal_s: float
    """How long it has been forcing the head out."""
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
    if not math.isfinite(head_mm):
        head_mm = float(bounds.head_cap_mm(limits.tip, limits.cap_mm))
    return GovernorState(
        head_mm=head_mm,
        valve_open=False,
        watch=watch.start(limits, head_mm),
        patient=patient_watch.UNSEEN,
        withdrawal_s=0.0,
        trips=0,
    )


@compiled
def _bit(happened: bool, code: int) -> int:
    return 1 << code if happened else 0


@compiled
def _possible(proposal: Setpoints) -> bool:
    return (
        math.isfinite(proposal.head_mm)
        and math.isfinite(proposal.head_mm_per_s)
        and math.isfinite(proposal.vacuum_mmhg)
        and proposal.vacuum_mmhg >= 0.0
    )


@compiled
def _head_trips(limits: Limits, seen: Watch) -> int:
    """Bit mask of what is wrong with the insertion axis."""
    overspeed = abs(seen.speed_mm_per_s) > OVERSPEED_RATIO * limits.head_speed_mm_per_s
    highest = bounds.head_cap_mm(limits.tip, limits.cap_mm)
    return (
        _bit(seen.invalid.head >= INVALID_TICKS, Trip.HEAD_READING_INVALID.value)
        | _bit(overspeed, Trip.HEAD_OVERSPEED.value)
        | _bit(seen.lasting.beyond > PERSISTENCE_S, Trip.HEAD_NOT_FOLLOWING.value)
        | _bit(seen.lasting.stalled > STALL_S, Trip.HEAD_STALLED.value)
        | _bit(seen.head_mm - seen.turn_mm > RUNAWAY_MM, Trip.HEAD_RUNAWAY.value)
        | _bit(seen.head_mm > highest + OVERSHOOT_MM, Trip.TIP_BEYOND_CAP.value)
    )


@compiled
def judge(limits: Limits, state: GovernorState, seen: Watch, proposal: Setpoints) -> int:
    """Bit mask of all trips, old and new."""
    lasting = seen.lasting
    return (
        state.trips
        | _head_trips(limits, seen)
        | _bit(not _possible(proposal), Trip.PROPOSAL_INVALID.value)
        | _bit(seen.invalid.cam >= INVALID_TICKS, Trip.CAM_READING_INVALID.value)
        | _bit(seen.invalid.vacuum >= INVALID_TICKS, Trip.VACUUM_READING_INVALID.value)
        | _bit(seen.invalid.contact >= INVALID_TICKS, Trip.CONTACT_READING_INVALID.value)
        | _bit(lasting.overpressure > PERSISTENCE_S, Trip.VACUUM_EXCEEDED.value)
        | _bit(lasting.sucking > limits.negative_pressure_s, Trip.NEGATIVE_PRESSURE_TIME.value)
        | _bit(lasting.inside > limits.in_airway_s, Trip.IN_AIRWAY_TIME.value)
        | _bit(lasting.contact > limits.contact_s, Trip.CONTACT_TIME.value)
        | _bit(seen.late_ticks >= LATE_TICKS, Trip.LATE_TICKS.value)
        | _bit(state.withdrawal_s > limits.withdrawal_s, Trip.WITHDRAWAL_TIME.value)
    )


@compiled
def _narrow_head(
    limits: Limits, command_mm: float, seen: Watch, wanted_mm: float, held: bool, dt_s: float
) -> tuple[float, float]:
    """Head command that may be let through (mm), and the velocity that belongs to it (mm/s).

    command_mm: the last one. held: the valve is not closed. A stop takes effect at once: the
    command drops to where the head is, however far it was ahead. Motion is bounded in speed.
    """
    highest = bounds.head_cap_mm(limits.tip, limits.cap_mm)
    if held:
        highest = min(highest, seen.anchor_mm + ADVANCE_MM)
    if seen.lasting.contact > 0.0:
        highest = min(highest, seen.head_mm, command_mm)
    origin = min(command_mm, max(seen.head_mm, highest))
    wanted_mm = min(wanted_mm, highest)
    reach = limits.head_speed_mm_per_s * dt_s
    head = min(max(wanted_mm, origin - reach), origin + reach)
    return head, (head - origin) / dt_s


@compiled
def _withdrawn(limits: Limits, command_mm: float, seen: Watch, dt_s: float) -> tuple[float, float]:
    """Head command and velocity on the way out, from where the head is or was told to be."""
    origin = min(command_mm, seen.head_mm)
    reach = limits.head_speed_mm_per_s * dt_s
    # Never further ahead than the servo needs: a head slower than its limit still follows.
    lowest = max(origin - reach, seen.head_mm - LEAD_SHARE * limits.following_mm)
    head = min(max(limits.park_head_mm, lowest), origin)
    return head, (head - origin) / dt_s


@compiled
def _narrow(
    limits: Limits, state: GovernorState, seen: Watch, proposal: Setpoints, trips: int, dt_s: float
) -> tuple[Setpoints, int]:
    """Setpoints that may be let through, and the reaction that this is."""
    reaction = trip.reaction(trips)
    cut = trip.cuts_vacuum(trips)
    advancing = seen.speed_mm_per_s > ADVANCING_MM_PER_S
    valve_open = proposal.valve_open and not cut and (state.valve_open or not advancing)
    held = valve_open or seen.lasting.sucking > 0.0
    vacuum = 0.0 if cut else min(proposal.vacuum_mmhg, limits.vacuum_mmhg)
    released = not proposal.insertion_on and reaction != Reaction.WITHDRAW.value
    driven = reaction != Reaction.TORQUE_OFF.value and not released
    if not driven:
        head, velocity = seen.head_mm, 0.0  # a start begins from where it is
        changed = valve_open != proposal.valve_open or vacuum != proposal.vacuum_mmhg
        if released and reaction == Reaction.PASS.value and changed:
            reaction = Reaction.CAP.value
    elif reaction == Reaction.WITHDRAW.value:
        head, velocity = _withdrawn(limits, state.head_mm, seen, dt_s)
    else:
        head, velocity = _narrow_head(limits, state.head_mm, seen, proposal.head_mm, held, dt_s)
        stopped = held or seen.lasting.contact > 0.0
        if stopped and head < proposal.head_mm:
            reaction = Reaction.HOLD.value
        elif (
            head != proposal.head_mm
            or valve_open != proposal.valve_open
            or vacuum != proposal.vacuum_mmhg
        ):
            reaction = Reaction.CAP.value
    allowed = Setpoints(
        head_mm=head,
        head_mm_per_s=velocity,
        insertion_on=driven,
        valve_open=valve_open,
        pump_on=proposal.pump_on and not cut,
        vacuum_mmhg=vacuum,
    )
    return allowed, reaction


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
    seen = watch.observe(
        limits, state.watch, state.head_mm, state.valve_open, readings, overrun, dt_s
    )
    patient = patient_watch.step(
        limits.patient, state.patient, readings.monitor, seen.lasting.sucking > 0.0, dt_s
    )
    inside = seen.lasting.inside > 0.0
    trips = judge(limits, state, seen, proposal) | patient_watch.trips(
        patient.conditions, inside, inside and state.watch.lasting.inside == 0.0
    )
    allowed, reaction = _narrow(limits, state, seen, proposal, trips, dt_s)
    verdict = Verdict(
        reaction=reaction,
        trips=trips,
        patient=patient.conditions,
        deepest_mm=bounds.deepest_mm(limits.tip, seen.foremost_mm),
        insertion_on=allowed.insertion_on,
        valve_on=not trips >> Trip.CAM_READING_INVALID.value & 1,
    )
    forced = reaction == Reaction.WITHDRAW.value and (
        seen.head_mm > limits.park_head_mm + ADVANCE_MM
    )
    following = GovernorState(
        head_mm=allowed.head_mm,
        valve_open=allowed.valve_open,
        watch=seen,
        patient=patient,
        withdrawal_s=state.withdrawal_s + dt_s if forced else 0.0,
        trips=trips,
    )
    return following, allowed, verdict


@compiled
def reset(limits: Limits, state: GovernorState) -> GovernorState:
    """Clear what is latched; a cause that is still there trips again at once.

    A command that was ahead of the head begins again from where the head is.
    """
    return GovernorState(
        head_mm=min(state.head_mm, state.watch.head_mm),
        valve_open=state.valve_open,
        watch=watch.acknowledged(limits, state.watch),
        patient=state.patient,
        withdrawal_s=0.0,
        trips=0,
    )
