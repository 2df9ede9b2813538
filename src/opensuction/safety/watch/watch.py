"""What the governor knows of the machine: the last readings, and for how long something has held.

Nothing here decides; `opensuction.safety.governor.governor` does.
"""

from typing import NamedTuple

from opensuction.kernel.commands import Setpoints
from opensuction.kernel.compiled import compiled
from opensuction.kernel.readings import Readings
from opensuction.kernel.record import make_zero
from opensuction.safety import tip_bound
from opensuction.safety.limits import Limits
from opensuction.safety.tip_bound import TipInterval
from opensuction.safety.watch import (
    advance_bound,
    contact_window,
    drive_force,
    invalid_ticks,
    vacuum_signature,
    valve_axis,
)
from opensuction.safety.watch.advance_bound import AdvanceBound
from opensuction.safety.watch.contact_window import ContactWindow
from opensuction.safety.watch.drive_force import DriveForce
from opensuction.safety.watch.duration import count, extend
from opensuction.safety.watch.invalid_ticks import INVALID_TICKS, NEVER_TICKS, InvalidTicks
from opensuction.safety.watch.vacuum_signature import LineWatch
from opensuction.safety.watch.valve_axis import ValveAxis

RELEASE_TICKS = 10
"""Consecutive ticks for which an open contact counts as released (10 ms): switches bounce."""
SPEED_WINDOW_S = 0.01
"""Time constant over which the measured head speed is averaged."""
APART_MM = 1.0
"""Distance between motor and catheter head that no sound gear has: play to either side up to 0.25
mm, half of the carriage sensor's step 0.1 mm, and the rest for wear; assumed."""
APART_SUCKING_MM = 0.35
"""The same with the valve open, where a head that goes in strips mucosa: play to either side 0.1
mm, half of the sensor's step, and 0.06 mm for messages 1 ms apart at 62 mm/s. With a frozen encoder
the head has gone in by 0.45 mm at most then (0.5 are allowed), with a reversed one by half."""
PARKED_MM = 3.0
"""Distance from the park position up to which the head is parked; the pre-use test needs 2."""


class Durations(NamedTuple):
    """For how long something has held without a break."""

    sucking_s: float
    """Valve not known to be closed."""
    inside_s: float
    """Tip possibly in the airway."""
    contact_s: float
    off_command_s: float
    """Head too far from its command."""
    stalled_s: float
    """Head reading frozen although the servo must be moving it."""
    overpressure_s: float
    jammed_s: float
    """Head held by more than friction."""
    overforce_s: float
    """Drive stronger than its current limit."""
    disagreeing_s: float
    """Motor and catheter head not at the same place."""


class Watch(NamedTuple):
    """Everything measured, up to this tick."""

    head_mm: float
    """Last valid reading, as all readings here."""
    speed_mm_per_s: float
    """Measured head speed, averaged."""
    tip: TipInterval
    suction_start_mm: float
    """Least head reading since the valve left its seat."""
    advance: AdvanceBound
    cam_rad: float
    parked_closed: bool
    """Head parked and valve closed: whatever vacuum there is, it stays in the line."""
    open_contact_ticks: int
    late_ticks: int
    invalid: InvalidTicks
    durations: Durations
    drive: DriveForce
    window: ContactWindow
    valve: ValveAxis
    line: LineWatch


NO_DURATIONS = make_zero(Durations)


def start(limits: Limits, head_mm: float, *, read: bool) -> Watch:
    """What is known at power-up with the head at ``head_mm``, as it was read or is assumed.

    Whoever was in control before may have left it on its way in, as fast as it is ever sent.
    """
    return make_zero(
        Watch,
        head_mm=head_mm,
        tip=tip_bound.assume_anywhere(limits.tip, head_mm),
        suction_start_mm=head_mm,
        advance=AdvanceBound(head_mm=head_mm, coast_mm_per_s=limits.leaving_mm_per_s),
        invalid=invalid_ticks.NONE._replace(head=0 if read else NEVER_TICKS),
        durations=NO_DURATIONS,
        drive=drive_force.REST,
        window=contact_window.START,
        valve=valve_axis.START,
        line=vacuum_signature.START,
    )


@compiled
def _is_disagreeing(readings: Readings, invalid: InvalidTicks, sucking: bool) -> bool:
    """Whether motor and catheter head are further apart than the gear's play lets them be."""
    off_mm = abs(readings.head_mm - readings.carriage_mm)
    apart_mm = APART_SUCKING_MM if sucking else APART_MM
    return invalid.head == 0 and invalid.carriage == 0 and off_mm > apart_mm


@compiled
def _is_parked_closed(limits: Limits, seen: Watch, last: Setpoints) -> bool:
    parked = seen.invalid.head == 0 and abs(seen.head_mm - limits.park_head_mm) <= PARKED_MM
    closed = seen.invalid.cam == 0 and valve_axis.is_closed(seen.cam_rad)
    return parked and closed and not last.valve_open


@compiled
def _watch_head(
    limits: Limits, before: Watch, seen: Watch, last: Setpoints, current_a: float, dt_s: float
) -> Watch:
    """Speed, force and advance of the head, and where the tip can be behind it.

    Of the forces nothing is known without torque, nor right after a head reading was missing.
    """
    head_mm, unseen = seen.head_mm, before.invalid.head >= INVALID_TICKS
    share = dt_s / (SPEED_WINDOW_S + dt_s)
    speed = (head_mm - before.head_mm) / (dt_s * (1 + before.invalid.head))  # mean over a dropout
    gained = share * (speed - before.speed_mm_per_s)
    drive = drive_force.REST
    if last.insertion_on and before.invalid.head == 0:
        drive = drive_force.step(limits.drive, before.drive, current_a, gained, share, dt_s)
    return seen._replace(
        speed_mm_per_s=before.speed_mm_per_s + gained,
        tip=tip_bound.follow(limits.tip, before.tip, head_mm),
        advance=advance_bound.step(
            limits.braking_mm_per_s2, before.advance, last, head_mm, unseen, dt_s
        ),
        drive=drive,
    )


@compiled
def _watch_suction(
    limits: Limits,
    before: Watch,
    seen: Watch,
    last: Setpoints,
    valve_command_changed: bool,
    readings: Readings,
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
            before.cam_rad,
            dt_s,
        )
    if seen.invalid.vacuum == 0:
        line = vacuum_signature.step(
            limits.line,
            before.line,
            readings.line_vacuum_mmhg,
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
    """What contact tells of switch and carina."""
    return contact_window.step(
        limits.window,
        before.window,
        tip_bound.deepest_mm(limits.tip, seen.tip),
        tip_bound.shallowest_mm(limits.tip, seen.tip),
        touching,
        before.durations.contact_s > 0.0,
        dt_s,
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
    inside = tip_bound.deepest_mm(limits.tip, seen.tip) > limits.outside_mm
    stalled = seen.head_mm == before.head_mm and off_mm > limits.stalled_mm
    highest = limits.line.parked_closed_mmhg if seen.parked_closed else limits.vacuum_mmhg
    jammed = abs(seen.drive.resistance_n) > limits.drive.jam_n
    overforce = abs(seen.drive.force_n) > limits.drive.force_n
    return Durations(
        sucking_s=extend(durations.sucking_s, sucking, dt_s),
        inside_s=extend(durations.inside_s, inside, dt_s),
        contact_s=extend(durations.contact_s, touching, dt_s),
        off_command_s=extend(durations.off_command_s, off_mm > limits.following_mm, dt_s),
        stalled_s=extend(durations.stalled_s, stalled, dt_s),
        overpressure_s=extend(durations.overpressure_s, seen.line.vacuum_mmhg > highest, dt_s),
        jammed_s=extend(durations.jammed_s, jammed, dt_s),
        overforce_s=extend(durations.overforce_s, overforce, dt_s),
        disagreeing_s=extend(durations.disagreeing_s, disagreeing, dt_s),
    )


@compiled
def step(
    limits: Limits,
    before: Watch,
    last: Setpoints,
    valve_command_changed: bool,
    readings: Readings,
    overrun: bool,
    dt_s: float,
) -> Watch:
    """Bring everything that is measured up to this tick.

    last: what was let through in the last tick. valve_command_changed: it commanded the valve
    otherwise than the tick before it.
    """
    invalid = invalid_ticks.step(before.invalid, readings)
    head_mm = before.head_mm if invalid.head > 0 else readings.head_mm
    cam_rad = before.cam_rad if invalid.cam > 0 else readings.cam_rad
    unclosed = abs(cam_rad) > valve_axis.CLOSED_RAD or invalid.cam >= INVALID_TICKS
    sucking = last.valve_open or unclosed
    open_ticks = count(before.open_contact_ticks, not readings.contact_closed)
    touched = before.durations.contact_s > 0.0
    touching = open_ticks == 0 or (touched and open_ticks < RELEASE_TICKS)
    seen = before._replace(
        head_mm=head_mm,
        suction_start_mm=min(before.suction_start_mm, head_mm) if sucking else head_mm,
        cam_rad=cam_rad,
        open_contact_ticks=open_ticks,
        late_ticks=count(before.late_ticks, overrun),
        invalid=invalid,
    )
    seen = seen._replace(parked_closed=_is_parked_closed(limits, seen, last))
    seen = _watch_head(limits, before, seen, last, readings.insertion_current_a, dt_s)
    seen = _watch_suction(limits, before, seen, last, valve_command_changed, readings, dt_s)
    seen = seen._replace(window=_watch_contact(limits, before, seen, touching, dt_s))
    disagreeing = _is_disagreeing(readings, invalid, sucking)
    return seen._replace(
        durations=_extend_durations(
            limits, before, seen, last, sucking, touching, disagreeing, dt_s
        )
    )


@compiled
def reset(limits: Limits, watch: Watch) -> Watch:
    """Forget what a person has acknowledged; what can still be seen to hold goes on counting.

    How the head came here may have gone unseen, so the tip is taken to be as deep as it can be.
    """
    kept = watch.durations
    return watch._replace(
        tip=tip_bound.assume_anywhere(limits.tip, watch.head_mm),
        advance=AdvanceBound(head_mm=watch.head_mm, coast_mm_per_s=0.0),
        parked_closed=False,
        durations=NO_DURATIONS._replace(sucking_s=kept.sucking_s, contact_s=kept.contact_s),
        drive=drive_force.REST,
        window=contact_window.reset(watch.window),
        valve=valve_axis.restart(watch.valve),
        line=vacuum_signature.reset(watch.line),
    )
