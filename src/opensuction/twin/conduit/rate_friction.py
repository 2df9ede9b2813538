"""Stretch behind the clearances whose friction depends on speed.

The catheter is stretched by what rubs on it; in steady motion by ``g(v) = k + (s - k)
exp(-(v/v_s)^2) + d v``: less once it slides (Stribeck), more the faster it slides (viscous film).
After a reversal it sticks until its stretch is gone, then slides more and more:
``dz = du`` while z is against the motion, ``dz = du (1 - |z| / g(v))`` once it is with it, solved
in closed form for a tick. So the tip never moves against the head, as it would by the same law with
bristles that also slide while they are bent back. A catheter that stands keeps its stretch. The lag
depends on speed, which no rate-independent model can follow.
Source: [Canudas-1995] for g(v); [Dupont-2002] for sticking before sliding.
"""

import math
from typing import NamedTuple

from opensuction.kernel.compiled import compiled


class RateFriction(NamedTuple):
    """Parameters of the friction, as the stretch that it makes."""

    static_mm: float
    """Stretch in slowest motion, one way; above 0."""
    kinetic_mm: float
    """Stretch once it slides, without the film; above 0."""
    stribeck_mm_per_s: float
    """Speed at which it begins to slide, above 0."""
    film_s: float
    """mm of stretch per mm/s of speed."""


NO_FRICTION = RateFriction(1.0, 1.0, 1.0, 0.0)


@compiled
def steady_mm(friction: RateFriction, speed_mm_per_s: float) -> float:
    """Stretch in steady motion, one way; speed_mm_per_s at least 0."""
    ratio = speed_mm_per_s / friction.stribeck_mm_per_s
    sticking = (friction.static_mm - friction.kinetic_mm) * math.exp(-ratio * ratio)
    return friction.kinetic_mm + sticking + friction.film_s * speed_mm_per_s


@compiled
def step(
    friction: RateFriction, stretch_mm: float, move_mm: float, ratio: float, dt_s: float
) -> float:
    """The stretch after a move of what is before it within a tick; positive on the way in.

    ratio: of the stretch to what the parameters say, the conduit being laid otherwise.
    """
    if move_mm == 0.0:
        return stretch_mm
    direction = math.copysign(1.0, move_mm)
    level_mm = ratio * steady_mm(friction, abs(move_mm) / dt_s)
    along_mm, travel = direction * stretch_mm, abs(move_mm)
    if along_mm < 0.0:
        sticking = min(travel, -along_mm)
        along_mm += sticking
        travel -= sticking
    return direction * (level_mm + (along_mm - level_mm) * math.exp(-travel / level_mm))
