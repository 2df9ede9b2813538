"""What the insertion motor's current says of the force that resists the head.

The current is the force at the head. What of it does not accelerate the moving mass works against
friction, the catheter and whatever holds it. Speed and current go through the same average, so that
a start or a stop leaves no trace; contact of the tip (0.3 N) is less than friction varies, so only
a jam shows.
"""

from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.kernel.readings import is_number
from opensuction.safety.limits import DriveLimits

SETTLING_S = 0.03
"""Time constant of the resistance: an encoder step of 5 um on 16.4 kg is then 0.2 N [computed]."""
MM_PER_M = 1000.0


class DriveForce(NamedTuple):
    """Forces at the head, N, positive inwards; zeros while the drive is off."""

    force_n: float
    """Of the motor, averaged as the speed is."""
    resistance_n: float
    """What it works against: friction and load."""


REST = DriveForce(force_n=0.0, resistance_n=0.0)


@compiled
def step(
    limits: DriveLimits,
    state: DriveForce,
    current_a: float,
    gained_mm_per_s: float,
    share: float,
    dt_s: float,
) -> DriveForce:
    """Bring both up to this tick.

    gained_mm_per_s: change of the averaged speed. share: of a new value in that average.
    ``r' = (F - r - m v') / T``, with the change of speed taken whole, so that no noise adds up.
    """
    current = current_a if is_number(current_a) else 0.0
    force = state.force_n + share * (limits.newton_per_a * current - state.force_n)
    inertia = limits.moving_mass_kg * gained_mm_per_s / MM_PER_M / SETTLING_S
    resistance = state.resistance_n + (force - state.resistance_n) * dt_s / SETTLING_S - inertia
    return DriveForce(force_n=force, resistance_n=resistance)
