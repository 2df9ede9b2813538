"""Interpolation of an emulated drive between two targets, and how it brakes and holds.

In the cyclic modes a host gives a target with each SYNC; the drive reaches it at the end of the
interpolation period (0x60C2), so that it moves evenly whatever the host's rate is. A target that
does not come leaves the set point where it is.
"""

import math
from typing import Final, NamedTuple


class SetPoint(NamedTuple):
    """Set point, in mm or rad."""

    position: float
    velocity: float
    """Unit/s, of the last tick."""
    goal: float
    ticks: int
    """Until it is reached; 0: it is, or the speed limit keeps it away."""


class Bounds(NamedTuple):
    """Limits of a set point."""

    lowest: float
    highest: float
    most_per_s: float


class Barrier(NamedTuple):
    """Positions that an input forbids to pass, from where the axis was when it closed."""

    lower: float
    upper: float


OPEN = Barrier(-math.inf, math.inf)


def close(before: Barrier, position: float, lower: bool, upper: bool) -> Barrier:
    """Barriers a tick on. lower, upper: the inputs that forbid motion down and up are closed."""
    return Barrier(
        (position if before.lower == -math.inf else before.lower) if lower else -math.inf,
        (position if before.upper == math.inf else before.upper) if upper else math.inf,
    )


def within(bounds: Bounds, barrier: Barrier) -> Bounds:
    """Bounds, barriers among them."""
    return bounds._replace(
        lowest=max(bounds.lowest, barrier.lower), highest=min(bounds.highest, barrier.upper)
    )


def hold(position: float) -> SetPoint:
    """Stay at a position."""
    return SetPoint(position, 0.0, position, 0)


def aim(before: SetPoint, goal: float, ticks: int) -> SetPoint:
    """Reach a goal evenly within some ticks."""
    return before._replace(goal=goal, ticks=max(ticks, 1))


def follow(before: SetPoint, bounds: Bounds, dt_s: float) -> SetPoint:
    """The set point a tick on, on the way to its goal."""
    ticks = max(before.ticks, 1)
    reach = bounds.most_per_s * dt_s
    move = (before.goal - before.position) / ticks
    moved = before.position + min(max(move, -reach), reach)
    # What stands beyond a bound comes back as fast as it may, and goes no further.
    lowest = min(bounds.lowest, before.position + reach)
    highest = max(bounds.highest, before.position - reach)
    position = min(max(moved, lowest), highest)
    return before._replace(
        position=position, velocity=(position - before.position) / dt_s, ticks=ticks - 1
    )


def brake(before: SetPoint, per_s2: float, dt_s: float) -> SetPoint:
    """The set point a tick on, with a deceleration of so many units/s2; 0: it stands at once."""
    speed = max(abs(before.velocity) - per_s2 * dt_s, 0.0) if per_s2 > 0.0 else 0.0
    velocity = math.copysign(speed, before.velocity)
    position = before.position + velocity * dt_s
    return SetPoint(position, velocity, position, 0)


OFFSET_PERIODS: Final = 2
"""So long a velocity offset counts after it has come."""
_ANY_SPEED: Final = Bounds(-math.inf, math.inf, math.inf)


class VelocityOffset(NamedTuple):
    """Speed of the set point as the host gives it (0x60B1), in place of the set point's own."""

    speed: SetPoint
    ticks: int
    """For so many more it counts."""


NO_OFFSET: Final = VelocityOffset(hold(0.0), 0)


def aim_offset(before: VelocityOffset, per_s: float, ticks: int) -> VelocityOffset:
    """Reach a speed evenly within some ticks, a period of the host's."""
    return VelocityOffset(aim(before.speed, per_s, ticks), OFFSET_PERIODS * ticks)


def follow_offset(before: VelocityOffset, dt_s: float) -> VelocityOffset:
    """The offset a tick on."""
    return VelocityOffset(follow(before.speed, _ANY_SPEED, dt_s), max(before.ticks - 1, 0))


def offset_now(offset: VelocityOffset, most: float, lower: bool, upper: bool) -> float:
    """Speed that counts; none where the host falls silent, or into an input that stops.

    most: of the drive. lower, upper: inputs forbid motion to lower and to higher positions.
    """
    speed = min(max(offset.speed.position, -most), most)
    into = (lower and speed < 0.0) or (upper and speed > 0.0)
    return 0.0 if into or not offset.ticks else speed
