"""Watch of the machine for the governor: the last readings, and the durations of what holds.

Nothing here decides; `opensuction.safety.governor.governor` does.
"""

import math

from opensuction.kernel.arithmetic import count_ticks, drop_tiny, extend_duration
from opensuction.kernel.compiled import compiled
from opensuction.kernel.interface import Readings, Setpoints
from opensuction.kernel.record import make_zero
from opensuction.safety import invalid_ticks
from opensuction.safety import limits as limit_sets
from opensuction.safety.head import drive_force, head_vote
from opensuction.safety.head.head_vote import HeadVote
from opensuction.safety.invalid_ticks import INVALID_TICKS
from opensuction.safety.limits import AdvanceBound, Limits
from opensuction.safety.watch import bus_watch, head_watch, tip_force, vacuum_signature, valve_axis
from opensuction.safety.watch.tip_force import ContactWindow, TipForce
from opensuction.safety.watch.vacuum_signature import LineFilter
from opensuction.safety.watch.watch_state import NO_DURATIONS, Durations, Watch

VENTED_MMHG = 1.0
"""Less vacuum may stand still: that of an open line does."""
RELEASE_TICKS = 10
"""Consecutive ticks for which an open contact counts as released (10 ms): switches bounce."""
LATE_S = 0.1
"""Time constant over which the share of late ticks is averaged."""
BARRIER_MM = 1.0
"""How far from the light barrier the tip must be for certain: its beam is as wide [assumed]."""
PARKED_MM = 3.0
"""Distance from the park position up to which the head is parked; the pre-use test needs 2."""


def start(limits: Limits, head_mm: float, *, read: bool) -> Watch:
    """Watch at power-up with the head at ``head_mm``, as it was read or is assumed.

    Whoever was in control before may have left it on its way in, as fast as it is ever sent.
    """
    return make_zero(
        Watch,
        head_mm=head_mm,
        tip=limit_sets.assume_anywhere(limits.tip, head_mm),
        suction_start_mm=head_mm,
        advance=AdvanceBound(head_mm=head_mm, coast_mm_per_s=limits.leaving_mm_per_s),
        vote=head_vote.start(head_mm, read=read),
        invalid=invalid_ticks.NONE,
        durations=NO_DURATIONS,
        drive=drive_force.REST,
        window=tip_force.WINDOW_START,
        pressed=tip_force.START,
        valve=valve_axis.START,
        bus=bus_watch.START,
        line=vacuum_signature.START,
        filter=vacuum_signature.FILTER_START,
    )


@compiled
def _is_parked_closed(limits: Limits, seen: Watch, last: Setpoints) -> bool:
    parked = seen.vote.unseen_ticks == 0 and abs(seen.head_mm - limits.park_head_mm) <= PARKED_MM
    closed = seen.invalid.cam == 0 and valve_axis.is_closed(seen.cam_rad)
    return parked and closed and not last.valve_open


@compiled
def _watch_suction(
    limits: Limits,
    before: Watch,
    seen: Watch,
    last: Setpoints,
    valve_command_changed: bool,
    dt_s: float,
) -> Watch:
    """Valve and line; a sensor that gives nothing is another fault, and tells nothing of them."""
    cam_rad, valve, line = seen.cam_rad, valve_axis.restart(before.valve), before.line
    if before.invalid.cam == 0:
        valve = valve_axis.step(
            limits.valve,
            before.valve,
            last.valve_open,
            valve_command_changed,
            cam_rad,
            dt_s,
        )
    if seen.invalid.vacuum == 0:
        line = vacuum_signature.step(
            limits.line,
            before.line,
            vacuum_signature.vacuum_mmhg(seen.filter),
            last.vacuum_mmhg,
            last.pump_on,
            last.valve_open and valve_axis.is_open(limits.valve, cam_rad),
            not last.valve_open and valve_axis.is_closed(cam_rad) and seen.invalid.cam == 0,
            dt_s,
        )
    return seen._replace(valve=valve, line=line)


@compiled
def _watch_contact(
    limits: Limits, before: Watch, seen: Watch, touching: bool, dt_s: float
) -> ContactWindow:
    """Watch contact, for the switch and the carina."""
    return tip_force.step_window(
        limits.window,
        before.window,
        limit_sets.deepest_mm(limits.tip, seen.tip),
        limit_sets.shallowest_mm(limits.tip, seen.tip),
        touching,
        before.durations.contact_s > 0.0,
        dt_s,
    )


@compiled
def _watch_force(
    limits: Limits, before: Watch, seen: Watch, touching: bool, dt_s: float
) -> TipForce:
    """Watch the tip's force by the drive; by travel there is no carina where the tip goes."""
    deepest_mm = limit_sets.deepest_mm(limits.tip, seen.tip)
    may_touch = limits.window.by_mm < math.inf and deepest_mm >= limits.window.from_mm
    return tip_force.step(
        before.pressed, seen.drive, seen.speed_mm_per_s, touching, may_touch, dt_s
    )


@compiled
def _extend_durations(
    limits: Limits,
    before: Watch,
    seen: Watch,
    last: Setpoints,
    sucking: bool,
    touching: bool,
    disagreeing: bool,
    dt_s: float,
) -> Durations:
    durations, off_mm = before.durations, abs(last.head_mm - seen.head_mm)
    inside = limit_sets.deepest_mm(limits.tip, seen.tip) > limits.outside_mm
    stalled = seen.head_mm == before.head_mm and off_mm > limits.stalled_mm
    highest = limits.line.parked_closed_mmhg if seen.parked_closed else limits.vacuum_mmhg
    drive = seen.drive
    jam_n = limits.drive.jam_n + drive_force.unsure_n(drive)
    jammed = drive_force.is_above(drive, drive.resistance_n, jam_n)
    overforce = drive_force.is_above(drive, drive.force_n, limits.drive.force_n)
    return Durations(
        sucking_s=extend_duration(durations.sucking_s, sucking, dt_s),
        inside_s=extend_duration(durations.inside_s, inside, dt_s),
        contact_s=extend_duration(durations.contact_s, touching, dt_s),
        driven_contact_s=extend_duration(
            durations.driven_contact_s, touching and last.insertion_on, dt_s
        ),
        off_command_s=extend_duration(durations.off_command_s, off_mm > limits.following_mm, dt_s),
        stalled_s=extend_duration(durations.stalled_s, stalled, dt_s),
        overpressure_s=extend_duration(
            durations.overpressure_s, seen.line.vacuum_mmhg > highest, dt_s
        ),
        jammed_s=extend_duration(durations.jammed_s, jammed, dt_s),
        overforce_s=extend_duration(durations.overforce_s, overforce, dt_s),
        disagreeing_s=extend_duration(durations.disagreeing_s, disagreeing, dt_s),
        adrift_s=extend_duration(durations.adrift_s, head_watch.is_adrift(seen.vote), dt_s),
        absent_s=durations.absent_s,
        remaining_s=durations.remaining_s,
    )


@compiled
def _watch_mouth(
    limits: Limits, seen: Watch, durations: Durations, clear: bool, dt_s: float
) -> Durations:
    """Durations with those of the light barrier. clear: it sees no catheter."""
    known = seen.vote.unseen_ticks == 0 and limits.mouth_mm < math.inf
    deepest_mm = limit_sets.deepest_mm(limits.tip, seen.tip)
    shallowest_mm = limit_sets.shallowest_mm(limits.tip, seen.tip)
    absent = known and clear and shallowest_mm > limits.mouth_mm + BARRIER_MM
    remaining = known and not clear and deepest_mm < limits.mouth_mm - BARRIER_MM
    return durations._replace(
        absent_s=extend_duration(durations.absent_s, absent, dt_s),
        remaining_s=extend_duration(durations.remaining_s, remaining, dt_s),
    )


@compiled
def filter_line(before: Watch, last: Setpoints, readings: Readings, dt_s: float) -> LineFilter:
    """Filter the vacuum reading of this tick. last: what was let through in the last tick."""
    vented = not last.pump_on and last.vacuum_mmhg == 0.0
    return vacuum_signature.step_filter(before.filter, readings, vented, dt_s)


@compiled
def step(
    limits: Limits,
    before: Watch,
    last: Setpoints,
    valve_command_changed: bool,
    readings: Readings,
    vote: HeadVote,
    overrun: bool,
    dt_s: float,
) -> Watch:
    """Bring everything that is measured up to this tick.

    last: what was let through in the last tick. valve_command_changed: it commanded the valve
    otherwise than the tick before it. vote: where the head is in this tick.
    """
    invalid = invalid_ticks.step(before.invalid, readings)
    head_mm = vote.head_mm
    cam_rad = before.cam_rad if invalid.cam > 0 else readings.cam_rad
    unclosed = not valve_axis.is_closed(cam_rad) or invalid.cam >= INVALID_TICKS
    sucking = last.valve_open or unclosed
    open_ticks = count_ticks(before.open_contact_ticks, not readings.contact_closed)
    touched = before.durations.contact_s > 0.0
    touching = open_ticks == 0 or (touched and open_ticks < RELEASE_TICKS)
    # A bus that repeats its last message: a line that holds vacuum loses some in every tick.
    same_head = vote.encoder_mm == before.vote.encoder_mm
    same_line = readings.line_vacuum_mmhg == before.filter.raw_mmhg
    same = same_head and same_line and vote.carriage_mm == before.vote.carriage_mm
    stale = same and cam_rad == before.cam_rad and readings.line_vacuum_mmhg > VENTED_MMHG
    change_mmhg = readings.line_vacuum_mmhg - before.filter.raw_mmhg
    seen = before._replace(
        head_mm=head_mm,
        bus=bus_watch.step(before.bus, change_mmhg, stale, dt_s),
        suction_start_mm=min(before.suction_start_mm, head_mm) if sucking else head_mm,
        cam_rad=cam_rad,
        open_contact_ticks=open_ticks,
        late_ticks=count_ticks(before.late_ticks, overrun),
        late_share=drop_tiny(
            before.late_share
            + ((1.0 if overrun else 0.0) - before.late_share) * (dt_s / (LATE_S + dt_s))
        ),
        vote=vote,
        filter=filter_line(before, last, readings, dt_s),
        invalid=invalid,
    )
    seen = seen._replace(parked_closed=_is_parked_closed(limits, seen, last))
    seen = head_watch.move(limits, before, seen, last, readings.insertion_current_a, sucking, dt_s)
    seen = _watch_suction(limits, before, seen, last, valve_command_changed, dt_s)
    seen = seen._replace(
        window=_watch_contact(limits, before, seen, touching, dt_s),
        pressed=_watch_force(limits, before, seen, touching, dt_s),
    )
    disagreeing = head_watch.is_disagreeing(readings, vote, invalid, sucking)
    durations = _extend_durations(limits, before, seen, last, sucking, touching, disagreeing, dt_s)
    return seen._replace(
        durations=_watch_mouth(limits, seen, durations, readings.mouth_clear, dt_s)
    )


@compiled
def turn(seen: Watch) -> Watch:
    """The insertion drive has been turned round: the head may brake from the speed that it has."""
    coast_mm_per_s = max(seen.speed_mm_per_s, 0.0)
    return seen._replace(
        advance=AdvanceBound(head_mm=seen.head_mm, coast_mm_per_s=coast_mm_per_s),
        runaway_ticks=0,
        drive=drive_force.rest(seen.drive),
    )


@compiled
def reset(limits: Limits, watch: Watch) -> Watch:
    """Forget what a person has acknowledged; what can still be seen to hold goes on counting.

    How the head came here may have gone unseen, so the tip is taken to be as deep as it can be.
    """
    kept = watch.durations
    return watch._replace(
        tip=limit_sets.assume_anywhere(limits.tip, watch.head_mm),
        advance=AdvanceBound(head_mm=watch.head_mm, coast_mm_per_s=0.0),
        parked_closed=False,
        runaway_ticks=0,
        overspeed_ticks=0,
        durations=NO_DURATIONS._replace(
            sucking_s=kept.sucking_s,
            contact_s=kept.contact_s,
            driven_contact_s=kept.driven_contact_s,
        ),
        vote=head_vote.reset(watch.vote),
        drive=drive_force.rest(watch.drive),
        window=tip_force.reset(watch.window),
        pressed=tip_force.START,
        valve=valve_axis.restart(watch.valve),
        line=vacuum_signature.reset(watch.line),
    )
