"""What the governor knows of the machine: what was read, and for how long something has held.

Nothing here decides; `opensuction.safety.governor.governor` does.
"""

from typing import NamedTuple

from opensuction.kernel.commands import Setpoints
from opensuction.kernel.compiled import compiled
from opensuction.kernel.readings import Readings, is_number
from opensuction.safety import limits as bounds
from opensuction.safety.limits import Limits
from opensuction.safety.watch import contact_window, drive_force, vacuum_signature, valve_axis
from opensuction.safety.watch.contact_window import ContactWindow
from opensuction.safety.watch.drive_force import DriveForce
from opensuction.safety.watch.vacuum_signature import LineWatch
from opensuction.safety.watch.valve_axis import ValveAxis

INVALID_TICKS = 5
"""Consecutive ticks without a valid reading that are a fault; fewer are ridden out."""
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


class InvalidTicks(NamedTuple):
    """Consecutive ticks without a valid reading."""

    head: int
    carriage: int
    cam: int
    vacuum: int
    contact: int


class Lasting(NamedTuple):
    """For how long without a break, s."""

    sucking: float
    """Valve not known to be closed."""
    inside: float
    """Tip possibly in the airway."""
    contact: float
    beyond: float
    """Head too far from its command."""
    stalled: float
    """Head reading frozen although the servo must be moving it."""
    overpressure: float
    jammed: float
    """Head held by more than friction."""
    overforce: float
    """Drive stronger than its current limit."""
    disagreeing: float
    """Motor and catheter head not at the same place."""


NOTHING = Lasting(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
"""Nothing has held."""


class Turn(NamedTuple):
    """How far in the head may be, and how fast it may still go there."""

    head_mm: float
    """Raised by its command and what it needs to brake from it, lowered again by its reading."""
    coast_mm_per_s: float
    """Speed inwards that a head may still have that was told to stop."""


class Watch(NamedTuple):
    """Everything measured, up to this tick."""

    head_mm: float
    """Last valid reading, as all readings here."""
    speed_mm_per_s: float
    """Measured head speed, averaged."""
    foremost_mm: float
    """Foremost position behind the gap: see `limits.follow`."""
    anchor_mm: float
    """Least head reading since the valve left its seat."""
    turn: Turn
    cam_rad: float
    sealed: bool
    """Head parked and valve closed: whatever vacuum there is, it stays in the line."""
    open_contact_ticks: int
    late_ticks: int
    invalid: InvalidTicks
    lasting: Lasting
    drive: DriveForce
    window: ContactWindow
    valve: ValveAxis
    line: LineWatch


def start(limits: Limits, head_mm: float) -> Watch:
    """What is known at power-up with the head read at ``head_mm``."""
    return Watch(
        head_mm=head_mm,
        speed_mm_per_s=0.0,
        foremost_mm=bounds.anywhere(limits.tip, head_mm),
        anchor_mm=head_mm,
        turn=Turn(head_mm=head_mm, coast_mm_per_s=0.0),
        cam_rad=0.0,
        sealed=False,
        open_contact_ticks=0,
        late_ticks=0,
        invalid=InvalidTicks(head=0, carriage=0, cam=0, vacuum=0, contact=0),
        lasting=NOTHING,
        drive=drive_force.REST,
        window=contact_window.start(limits.tip, head_mm),
        valve=valve_axis.START,
        line=vacuum_signature.START,
    )


@compiled
def _count(ticks: int, counts: bool) -> int:
    return ticks + 1 if counts else 0


@compiled
def _time(seconds: float, holds: bool, dt_s: float) -> float:
    return seconds + dt_s if holds else 0.0


@compiled
def _invalid(invalid: InvalidTicks, readings: Readings) -> InvalidTicks:
    return InvalidTicks(
        head=_count(invalid.head, not (readings.head_valid and is_number(readings.head_mm))),
        carriage=_count(
            invalid.carriage,
            not (readings.carriage_valid and is_number(readings.carriage_mm)),
        ),
        cam=_count(invalid.cam, not (readings.cam_valid and is_number(readings.cam_rad))),
        vacuum=_count(
            invalid.vacuum,
            not (readings.vacuum_valid and is_number(readings.line_vacuum_mmhg)),
        ),
        contact=_count(invalid.contact, not readings.contact_valid),
    )


@compiled
def _disagree(readings: Readings, invalid: InvalidTicks, sucking: bool) -> bool:
    """Whether motor and catheter head are further apart than the gear's play lets them be."""
    off_mm = abs(readings.head_mm - readings.carriage_mm)
    apart_mm = APART_SUCKING_MM if sucking else APART_MM
    return invalid.head == 0 and invalid.carriage == 0 and off_mm > apart_mm


@compiled
def _driven(
    limits: Limits,
    watch: Watch,
    last: Setpoints,
    current_a: float,
    gained_mm_per_s: float,
    share: float,
    dt_s: float,
) -> DriveForce:
    """Forces at the head; nothing is known of them without torque or without an encoder."""
    if not last.insertion_on or watch.invalid.head > 0:
        return DriveForce(force_n=0.0, resistance_n=0.0)
    return drive_force.step(limits.drive, watch.drive, current_a, gained_mm_per_s, share, dt_s)


@compiled
def _turn(limits: Limits, watch: Watch, last: Setpoints, head_mm: float, dt_s: float) -> Turn:
    """How far in the head may be; where it moved unseen, where it is seen again."""
    braked = watch.turn.coast_mm_per_s - limits.braking_mm_per_s2 * dt_s
    coast = max(braked, last.head_mm_per_s, 0.0)
    allowed_mm = max(watch.turn.head_mm + coast * dt_s, last.head_mm)
    blind = watch.invalid.head >= INVALID_TICKS
    return Turn(head_mm=head_mm if blind else min(allowed_mm, head_mm), coast_mm_per_s=coast)


@compiled
def _turned(
    limits: Limits, watch: Watch, last: Setpoints, turned: bool, cam: float, dt_s: float
) -> ValveAxis:
    """The valve's axis; an encoder that gives nothing is another fault."""
    if watch.invalid.cam > 0:
        return ValveAxis(away_s=0.0, still_s=0.0, resting=watch.valve.resting)
    return valve_axis.step(
        limits.valve, watch.valve, last.valve_open, turned, cam, watch.cam_rad, dt_s
    )


@compiled
def _line(
    limits: Limits,
    watch: Watch,
    last: Setpoints,
    readings: Readings,
    invalid: InvalidTicks,
    dt_s: float,
) -> LineWatch:
    """The line; a sensor that gives nothing is another fault."""
    if invalid.vacuum > 0:
        return watch.line
    cam = watch.cam_rad if invalid.cam > 0 else readings.cam_rad
    return vacuum_signature.step(
        limits.line,
        watch.line,
        readings.line_vacuum_mmhg,
        last.vacuum_mmhg,
        last.pump_on,
        last.valve_open and valve_axis.is_open(limits.valve, cam),
        not last.valve_open and valve_axis.is_closed(cam) and invalid.cam == 0,
        dt_s,
    )


class _Now(NamedTuple):
    """What is so in this tick and may be so for a time only."""

    head_mm: float
    sucking: bool
    deepest_mm: float
    touching: bool
    vacuum_mmhg: float
    sealed: bool
    disagreeing: bool


@compiled
def _lasting(
    limits: Limits, watch: Watch, last: Setpoints, now: _Now, drive: DriveForce, dt_s: float
) -> Lasting:
    """For how long it has been so."""
    lasting, off_mm = watch.lasting, abs(last.head_mm - now.head_mm)
    stalled = now.head_mm == watch.head_mm and off_mm > limits.stalled_mm
    highest = limits.line.sealed_mmhg if now.sealed else limits.vacuum_mmhg
    jammed = abs(drive.resistance_n) > limits.drive.jam_n
    overforce = abs(drive.force_n) > limits.drive.force_n
    return Lasting(
        sucking=_time(lasting.sucking, now.sucking, dt_s),
        inside=_time(lasting.inside, now.deepest_mm > limits.outside_mm, dt_s),
        contact=_time(lasting.contact, now.touching, dt_s),
        beyond=_time(lasting.beyond, off_mm > limits.following_mm, dt_s),
        stalled=_time(lasting.stalled, stalled, dt_s),
        overpressure=_time(lasting.overpressure, now.vacuum_mmhg > highest, dt_s),
        jammed=_time(lasting.jammed, jammed, dt_s),
        overforce=_time(lasting.overforce, overforce, dt_s),
        disagreeing=_time(lasting.disagreeing, now.disagreeing, dt_s),
    )


@compiled
def observe(
    limits: Limits,
    watch: Watch,
    last: Setpoints,
    turned: bool,
    readings: Readings,
    overrun: bool,
    dt_s: float,
) -> Watch:
    """Bring everything that is measured up to this tick.

    last: what was let through in the last tick. turned: it told the valve otherwise than before.
    """
    invalid = _invalid(watch.invalid, readings)
    head = watch.head_mm if invalid.head > 0 else readings.head_mm
    cam = watch.cam_rad if invalid.cam > 0 else readings.cam_rad
    share = dt_s / (SPEED_WINDOW_S + dt_s)
    speed = (head - watch.head_mm) / (dt_s * (1 + watch.invalid.head))  # its mean over a dropout
    gained = share * (speed - watch.speed_mm_per_s)
    closed = valve_axis.is_closed(cam) and invalid.cam == 0
    sucking = last.valve_open or abs(cam) > valve_axis.CLOSED_RAD or invalid.cam >= INVALID_TICKS
    foremost = bounds.follow(limits.tip, watch.foremost_mm, head)
    deepest = bounds.deepest_mm(limits.tip, foremost)
    before = watch.lasting.contact
    open_ticks = _count(watch.open_contact_ticks, not readings.contact_closed)
    touching = open_ticks == 0 or (before > 0.0 and open_ticks < RELEASE_TICKS)
    parked = invalid.head == 0 and abs(head - limits.park_head_mm) <= PARKED_MM
    sealed = parked and closed and not last.valve_open
    vacuum = watch.line.vacuum_mmhg if invalid.vacuum > 0 else readings.line_vacuum_mmhg
    disagree = _disagree(readings, invalid, sucking)
    now = _Now(head, sucking, deepest, touching, vacuum, sealed, disagree)
    drive = _driven(limits, watch, last, readings.insertion_current_a, gained, share, dt_s)
    return Watch(
        head_mm=head,
        speed_mm_per_s=watch.speed_mm_per_s + gained,
        foremost_mm=foremost,
        anchor_mm=min(watch.anchor_mm, head) if sucking else head,
        turn=_turn(limits, watch, last, head, dt_s),
        cam_rad=cam,
        sealed=sealed,
        open_contact_ticks=open_ticks,
        late_ticks=_count(watch.late_ticks, overrun),
        invalid=invalid,
        lasting=_lasting(limits, watch, last, now, drive, dt_s),
        drive=drive,
        window=contact_window.step(
            limits.tip,
            limits.window,
            watch.window,
            head,
            deepest,
            touching,
            before > 0.0,
            dt_s,
        ),
        valve=_turned(limits, watch, last, turned, cam, dt_s),
        line=_line(limits, watch, last, readings, invalid, dt_s),
    )


@compiled
def acknowledged(limits: Limits, watch: Watch) -> Watch:
    """Forget what a person has acknowledged; what can still be seen to hold goes on counting.

    How the head came here may have gone unseen, so the tip is taken to be as deep as it can be.
    """
    return watch._replace(
        foremost_mm=bounds.anywhere(limits.tip, watch.head_mm),
        turn=Turn(head_mm=watch.head_mm, coast_mm_per_s=0.0),
        sealed=False,
        lasting=NOTHING._replace(sucking=watch.lasting.sucking, contact=watch.lasting.contact),
        drive=drive_force.REST,
        window=contact_window.unseen(limits.tip, watch.window, watch.head_mm),
        valve=watch.valve._replace(away_s=0.0, still_s=0.0),
        line=vacuum_signature.afresh(watch.line),
    )
