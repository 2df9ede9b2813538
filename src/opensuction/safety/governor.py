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
from opensuction.safety import trip
from opensuction.safety.limits import Limits, TipInterval
from opensuction.safety.trip import Reaction, Trip

INVALID_TICKS = 5
"""Consecutive ticks without a valid reading that are a fault; fewer are ridden out."""
LATE_TICKS = 5
"""Consecutive late ticks of the host that are a fault."""
OVERSPEED_RATIO = 1.5
"""Measured head speed over its limit that is a runaway, not a transient of the servo."""
SPEED_WINDOW_S = 0.01
"""Time constant over which the measured head speed is averaged."""
PERSISTENCE_S = 0.2
"""How long head or vacuum may be beyond a limit before it is a trip (a step response settles)."""
ADVANCE_MM = 0.5
"""Net advance of the head that is allowed while the valve is not closed."""
ADVANCING_MM_PER_S = 3.0
"""Measured speed inwards above which the valve is kept from opening."""
CAM_CLOSED_RAD = 0.02
"""Cam angle (1.1 degrees) below which the valve's seal holds."""


class GovernorState(NamedTuple):
    """What the governor remembers."""

    head_mm: float
    """Last head command that it let through."""
    reading_mm: float
    """Last valid head reading."""
    speed_mm_per_s: float
    """Measured head speed, averaged."""
    interval: TipInterval
    anchor_mm: float
    """Least head reading since the valve left its seat."""
    valve_open: bool
    """Last valve command that it let through."""
    invalid_ticks: int
    late_ticks: int
    negative_pressure_s: float
    in_airway_s: float
    contact_s: float
    beyond_s: float
    """How long the head has been off its command."""
    overpressure_s: float
    withdrawal_s: float
    trips: int


class Verdict(NamedTuple):
    """What the governor did in a tick."""

    reaction: int
    trips: int
    deepest_mm: float
    """Deepest tip position that is possible."""
    insertion_on: bool
    valve_on: bool


def start(limits: Limits, head_mm: float) -> GovernorState:
    """State at power-up with the head read at ``head_mm``."""
    return GovernorState(
        head_mm=head_mm,
        reading_mm=head_mm,
        speed_mm_per_s=0.0,
        interval=bounds.anywhere(limits.tip, head_mm),
        anchor_mm=head_mm,
        valve_open=False,
        invalid_ticks=0,
        late_ticks=0,
        negative_pressure_s=0.0,
        in_airway_s=0.0,
        contact_s=0.0,
        beyond_s=0.0,
        overpressure_s=0.0,
        withdrawal_s=0.0,
        trips=0,
    )


@compiled
def _held(seconds: float, holds: bool, dt_s: float) -> float:
    """Time for which a condition has held without a break."""
    return seconds + dt_s if holds else 0.0


@compiled
def _valid(readings: Readings) -> bool:
    return readings.head_valid and math.isfinite(readings.head_mm)


@compiled
def observe(
    limits: Limits, state: GovernorState, readings: Readings, overrun: bool, dt_s: float
) -> GovernorState:
    """Bring everything that is measured up to this tick."""
    reading = readings.head_mm if _valid(readings) else state.reading_mm
    interval = bounds.follow(limits.tip, state.interval, reading)
    share = dt_s / (SPEED_WINDOW_S + dt_s)
    speed = state.speed_mm_per_s + share * (
        (reading - state.reading_mm) / dt_s - state.speed_mm_per_s
    )
    cam_off_seat = not (abs(readings.cam_rad) <= CAM_CLOSED_RAD)
    sucking = state.valve_open or cam_off_seat
    inside = bounds.deepest_mm(limits.tip, interval) > limits.outside_mm
    beyond = abs(state.head_mm - reading) > limits.following_mm
    over = readings.line_vacuum_mmhg > limits.vacuum_mmhg
    return GovernorState(
        head_mm=state.head_mm,
        reading_mm=reading,
        speed_mm_per_s=speed,
        interval=interval,
        anchor_mm=min(state.anchor_mm, reading) if sucking else reading,
        valve_open=state.valve_open,
        invalid_ticks=0 if _valid(readings) else state.invalid_ticks + 1,
        late_ticks=state.late_ticks + 1 if overrun else 0,
        negative_pressure_s=_held(state.negative_pressure_s, sucking, dt_s),
        in_airway_s=_held(state.in_airway_s, inside, dt_s),
        contact_s=_held(state.contact_s, readings.contact_closed, dt_s),
        beyond_s=_held(state.beyond_s, beyond, dt_s),
        overpressure_s=_held(state.overpressure_s, over, dt_s),
        withdrawal_s=state.withdrawal_s,
        trips=state.trips,
    )


@compiled
def _bit(happened: bool, code: int) -> int:
    return 1 << code if happened else 0


@compiled
def judge(limits: Limits, state: GovernorState, proposal: Setpoints, readings: Readings) -> int:
    """Bit mask of all trips, old and new."""
    proposal_valid = (
        math.isfinite(proposal.head_mm)
        and math.isfinite(proposal.head_mm_per_s)
        and math.isfinite(proposal.vacuum_mmhg)
    )
    vacuum_valid = readings.vacuum_valid and math.isfinite(readings.line_vacuum_mmhg)
    cam_valid = readings.cam_valid and math.isfinite(readings.cam_rad)
    overspeed = abs(state.speed_mm_per_s) > OVERSPEED_RATIO * limits.head_speed_mm_per_s
    return (
        state.trips
        | _bit(not proposal_valid, Trip.PROPOSAL_INVALID.value)
        | _bit(state.invalid_ticks >= INVALID_TICKS, Trip.HEAD_READING_INVALID.value)
        | _bit(overspeed, Trip.HEAD_OVERSPEED.value)
        | _bit(state.beyond_s > PERSISTENCE_S, Trip.HEAD_NOT_FOLLOWING.value)
        | _bit(not cam_valid, Trip.CAM_READING_INVALID.value)
        | _bit(not vacuum_valid, Trip.VACUUM_READING_INVALID.value)
        | _bit(state.overpressure_s > PERSISTENCE_S, Trip.VACUUM_EXCEEDED.value)
        | _bit(
            state.negative_pressure_s > limits.negative_pressure_s,
            Trip.NEGATIVE_PRESSURE_TIME.value,
        )
        | _bit(state.in_airway_s > limits.in_airway_s, Trip.IN_AIRWAY_TIME.value)
        | _bit(state.contact_s > limits.contact_s, Trip.CONTACT_TIME.value)
        | _bit(not readings.contact_valid, Trip.CONTACT_READING_INVALID.value)
        | _bit(state.late_ticks >= LATE_TICKS, Trip.LATE_TICKS.value)
        | _bit(state.withdrawal_s > limits.withdrawal_s, Trip.WITHDRAWAL_TIME.value)
    )


@compiled
def _narrow_head(
    limits: Limits, state: GovernorState, wanted_mm: float, reaction: int, held: bool, dt_s: float
) -> float:
    """Head command that may be let through."""
    if reaction == Reaction.TORQUE_OFF.value:
        return state.reading_mm  # nothing is driven; a later start begins from where the head is
    if reaction == Reaction.WITHDRAW.value:
        wanted_mm = min(limits.park_head_mm, state.head_mm)
    if held:
        wanted_mm = min(wanted_mm, max(state.anchor_mm + ADVANCE_MM, limits.park_head_mm))
    if state.contact_s > 0.0:
        wanted_mm = min(wanted_mm, state.reading_mm)
    wanted_mm = min(wanted_mm, bounds.head_cap_mm(limits.tip, limits.cap_mm))
    reach = limits.head_speed_mm_per_s * dt_s
    return min(max(wanted_mm, state.head_mm - reach), state.head_mm + reach)


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
    seen = observe(limits, state, readings, overrun, dt_s)
    trips = judge(limits, seen, proposal, readings)
    reaction = trip.reaction(trips)
    cut = trip.cuts_vacuum(trips)
    advancing = seen.speed_mm_per_s > ADVANCING_MM_PER_S
    valve_open = proposal.valve_open and not cut and (state.valve_open or not advancing)
    held = valve_open or seen.negative_pressure_s > 0.0
    wanted = proposal.head_mm if math.isfinite(proposal.head_mm) else seen.reading_mm
    head = _narrow_head(limits, seen, wanted, reaction, held, dt_s)
    capped = head != wanted or valve_open != proposal.valve_open
    if reaction == Reaction.PASS.value and capped:
        stopped = seen.contact_s > 0.0 or (held and head < wanted)
        reaction = Reaction.HOLD.value if stopped else Reaction.CAP.value
    velocity = proposal.head_mm_per_s if head == wanted else (head - seen.head_mm) / dt_s
    vacuum = proposal.vacuum_mmhg if math.isfinite(proposal.vacuum_mmhg) else 0.0
    allowed = Setpoints(
        head_mm=head,
        head_mm_per_s=velocity,
        valve_open=valve_open,
        pump_on=proposal.pump_on and not cut,
        vacuum_mmhg=min(vacuum, limits.vacuum_mmhg),
    )
    verdict = Verdict(
        reaction=reaction,
        trips=trips,
        deepest_mm=bounds.deepest_mm(limits.tip, seen.interval),
        insertion_on=reaction != Reaction.TORQUE_OFF.value,
        valve_on=not trips >> Trip.CAM_READING_INVALID.value & 1,
    )
    return _remember(limits, seen, allowed, reaction, trips, dt_s), allowed, verdict


@compiled
def _remember(
    limits: Limits, seen: GovernorState, allowed: Setpoints, reaction: int, trips: int, dt_s: float
) -> GovernorState:
    forced = reaction == Reaction.WITHDRAW.value and (
        seen.reading_mm > limits.park_head_mm + ADVANCE_MM
    )
    return GovernorState(
        head_mm=allowed.head_mm,
        reading_mm=seen.reading_mm,
        speed_mm_per_s=seen.speed_mm_per_s,
        interval=seen.interval,
        anchor_mm=seen.anchor_mm,
        valve_open=allowed.valve_open,
        invalid_ticks=seen.invalid_ticks,
        late_ticks=seen.late_ticks,
        negative_pressure_s=seen.negative_pressure_s,
        in_airway_s=seen.in_airway_s,
        contact_s=seen.contact_s,
        beyond_s=seen.beyond_s,
        overpressure_s=seen.overpressure_s,
        withdrawal_s=_held(seen.withdrawal_s, forced, dt_s),
        trips=trips,
    )


@compiled
def reset(state: GovernorState) -> GovernorState:
    """Clear what is latched; a cause that is still there trips again in the next tick."""
    return GovernorState(
        head_mm=state.head_mm,
        reading_mm=state.reading_mm,
        speed_mm_per_s=state.speed_mm_per_s,
        interval=state.interval,
        anchor_mm=state.anchor_mm,
        valve_open=state.valve_open,
        invalid_ticks=0,
        late_ticks=0,
        negative_pressure_s=state.negative_pressure_s,
        in_airway_s=0.0,
        contact_s=state.contact_s,
        beyond_s=0.0,
        overpressure_s=0.0,
        withdrawal_s=0.0,
        trips=0,
    )
