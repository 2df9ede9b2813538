"""Speed of the insertion motor from its voltage and its current: a head sensor of its own.

Volts less the drop of the current in the winding are the back-EMF, which is proportional to speed.
"""

from opensuction.kernel.compiled import compiled
from opensuction.safety.limits import DriveLimits

SATURATED_SHARE = 0.55
"""Share of the drive's highest force from which its current limit, not its voltage, rules: of the
limit that is a fault, which is 1.3 times its own; the limit may be 7 % lower, the force for an
ampere 10 % more, and the current sensor read 4 % less [computed]."""


@compiled
def is_limited(limits: DriveLimits, current_a: float) -> bool:
    """True where the drive's current limit rules, so that its voltage says nothing of its speed."""
    return abs(limits.newton_per_a * current_a) >= SATURATED_SHARE * limits.force_n


@compiled
def turn(
    limits: DriveLimits,
    before_mm_per_s: float,
    driven_v: float,
    current_a: float,
    measured_mm_per_s: float,
    dt_s: float,
) -> float:
    """Speed of the motor after volts were put on it.

    While the drive's current limit rules, its voltage says nothing: then it gains speed as such a
    drive can at least and at most, and within that as fast as was measured of the head.
    """
    fastest = limits.mm_per_s_per_v * limits.supply_v
    least = limits.gaining_least_mm_per_s2 * dt_s
    most = limits.gaining_most_mm_per_s2 * dt_s
    gained = measured_mm_per_s - before_mm_per_s
    if not is_limited(limits, current_a):
        speed = limits.mm_per_s_per_v * (driven_v - limits.volts_per_a * current_a)
        gained = min(max(speed - before_mm_per_s, -most), most)
    elif current_a > 0.0:
        gained = min(max(gained, least), most)
    else:
        gained = max(min(gained, -least), -most)
    return min(max(before_mm_per_s + gained, -fastest), fastest)
