"""What the governor knows of the machine: what was read, and for how long something has held.

Nothing here decides; `opensuction.safety.governor` does.
"""

import math
from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.kernel.readings import Readings
from opensuction.safety import limits as bounds
from opensuction.safety.limits import Limits

INVALID_TICKS = 5
"""Consecutive ticks without a valid reading that are a fault; fewer are ridden out."""
RELEASE_TICKS = 10
"""Consecutive ticks for which an open contact counts as released (10 ms): switches bounce."""
SPEED_WINDOW_S = 0.01
"""Time constant over which the measured head speed is averaged."""
CAM_CLOSED_RAD = 0.02
"""Cam angle (1.1 degrees) below which the valve's seal holds."""


class InvalidTicks(NamedTuple):
    """Consecutive ticks without a valid reading."""

    head: int
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
    turn_mm: float
    """How far in the head may be: raised by its command, lowered again by its reading."""
    cam_rad: float
    open_contact_ticks: int
    late_ticks: int
    invalid: InvalidTicks
    lasting: Lasting


def start(limits: Limits, head_mm: float) -> Watch:
    """What is known at power-up with the head read at ``head_mm``."""
    return Watch(
        head_mm=head_mm,
        speed_mm_per_s=0.0,
        foremost_mm=bounds.anywhere(limits.tip, head_mm),
        anchor_mm=head_mm,
        turn_mm=head_mm,
        cam_rad=0.0,
        open_contact_ticks=0,
        late_ticks=0,
        invalid=InvalidTicks(head=0, cam=0, vacuum=0, contact=0),
        lasting=Lasting(0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
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
        head=_count(invalid.head, not (readings.head_valid and math.isfinite(readings.head_mm))),
        cam=_count(invalid.cam, not (readings.cam_valid and math.isfinite(readings.cam_rad))),
        vacuum=_count(
            invalid.vacuum,
            not (readings.vacuum_valid and math.isfinite(readings.line_vacuum_mmhg)),
        ),
        contact=_count(invalid.contact, not readings.contact_valid),
    )


@compiled
def observe(
    limits: Limits,
    watch: Watch,
    command_mm: float,
    valve_open: bool,
    readings: Readings,
    overrun: bool,
    dt_s: float,
) -> Watch:
    """Bring everything that is measured up to this tick.

    command_mm, valve_open: what was let through in the last tick.
    """
    invalid = _invalid(watch.invalid, readings)
    head = watch.head_mm if invalid.head > 0 else readings.head_mm
    cam = watch.cam_rad if invalid.cam > 0 else readings.cam_rad
    share = dt_s / (SPEED_WINDOW_S + dt_s)
    speed = (head - watch.head_mm) / (dt_s * (1 + watch.invalid.head))  # its mean over a dropout
    sucking = valve_open or abs(cam) > CAM_CLOSED_RAD or invalid.cam >= INVALID_TICKS
    foremost = bounds.follow(limits.tip, watch.foremost_mm, head)
    open_ticks = _count(watch.open_contact_ticks, not readings.contact_closed)
    touching = open_ticks == 0 or (watch.lasting.contact > 0.0 and open_ticks < RELEASE_TICKS)
    off_mm = abs(command_mm - head)
    blind = watch.invalid.head >= INVALID_TICKS
    lasting = watch.lasting
    over = lasting.overpressure > 0.0
    if invalid.vacuum == 0:
        over = readings.line_vacuum_mmhg > limits.vacuum_mmhg
    return Watch(
        head_mm=head,
        speed_mm_per_s=watch.speed_mm_per_s + share * (speed - watch.speed_mm_per_s),
        foremost_mm=foremost,
        anchor_mm=min(watch.anchor_mm, head) if sucking else head,
        turn_mm=head if blind else min(max(watch.turn_mm, command_mm), head),
        cam_rad=cam,
        open_contact_ticks=open_ticks,
        late_ticks=_count(watch.late_ticks, overrun),
        invalid=invalid,
        lasting=Lasting(
            sucking=_time(lasting.sucking, sucking, dt_s),
            inside=_time(
                lasting.inside, bounds.deepest_mm(limits.tip, foremost) > limits.outside_mm, dt_s
            ),
            contact=_time(lasting.contact, touching, dt_s),
            beyond=_time(lasting.beyond, off_mm > limits.following_mm, dt_s),
            stalled=_time(
                lasting.stalled, head == watch.head_mm and off_mm > limits.stalled_mm, dt_s
            ),
            overpressure=_time(lasting.overpressure, over, dt_s),
        ),
    )


@compiled
def acknowledged(limits: Limits, watch: Watch) -> Watch:
    """Forget what a person has acknowledged; what can still be seen to hold goes on counting.

    How the head came here may have gone unseen, so the tip is taken to be as deep as it can be.
    """
    return Watch(
        head_mm=watch.head_mm,
        speed_mm_per_s=watch.speed_mm_per_s,
        foremost_mm=bounds.anywhere(limits.tip, watch.head_mm),
        anchor_mm=watch.anchor_mm,
        turn_mm=watch.head_mm,
        cam_rad=watch.cam_rad,
        open_contact_ticks=watch.open_contact_ticks,
        late_ticks=watch.late_ticks,
        invalid=watch.invalid,
        lasting=Lasting(
            sucking=watch.lasting.sucking,
            inside=0.0,
            contact=watch.lasting.contact,
            beyond=0.0,
            stalled=0.0,
            overpressure=0.0,
        ),
    )
