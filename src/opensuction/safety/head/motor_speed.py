"""How fast the insertion motor turns, by its volts and its current: a head sensor of its own.

Volts less what the current takes in the winding are the back-EMF, which is proportional to speed.
"""

from opensuction.kernel.compiled import compiled
from opensuction.safety.limits import DriveLimits

SATURATED_SHARE = 0.8
"""Share of the drive's highest force from which its current limit, not its voltage, rules: of the
limit that is a fault, which is 1.2 times its own [computed]."""


@compiled
def turn(
    limits: DriveLimits, before_mm_per_s: float, driven_v: float, current_a: float, dt_s: float
) -> float:
    """Speed of the motor after volts were put on it.

    While the drive's current limit rules, its voltage says nothing: then the speed is what the
    least acceleration of such a drive makes of it.
    """
    fastest = limits.mm_per_s_per_v * limits.supply_v
    if abs(limits.newton_per_a * current_a) >= SATURATED_SHARE * limits.force_n:
        gained = limits.gaining_mm_per_s2 * dt_s
        speed = before_mm_per_s + (gained if current_a > 0.0 else -gained)
    else:
        speed = limits.mm_per_s_per_v * (driven_v - limits.volts_per_a * current_a)
    return min(max(speed, -fastest), fastest)
