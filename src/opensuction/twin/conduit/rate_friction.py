"""Stretch behind the clearances whose friction depends on speed.

The catheter is stretched by what rubs on it; in steady motion by ``g(v) = k + (s - k)
exp(-(v/v_s)^2) + d v``: less once it slides (Stribeck), more the faster it slides (viscous film).
After a reversal it sticks until its stretch is gone, then slides more and more:
``dz = du`` while z is against the motion, ``dz = du (1 - |z| / g(v))`` once it is with it, solved
in closed form for a tick. So the tip never moves against the head, as it would by the same law with
bristles that also slide while they are bent back. A catheter that stands keeps its stretch. The lag
depends on speed, which no rate-independent model can follow.
Source: [Canudas-1995] for g(v); [Dupont-2002] for sticking before sliding.

A lag that bends into saturation: the Bouc-Wen memory as the twin steps it, a tick at a time.

Along one direction of travel the memory u, counted in that direction, obeys
``du/dd = A - k |u|^m``, k being B + D where u > 0 and D - B where u < 0. A tick's travel is short
(.02 to .06 mm), so that one step of Runge and Kutta's fourth order is exact to some 1e-9 mm; a
longer one is cut. Code of the twin's own: the models that identify and compensate solve the same
equation otherwise (`hysteresis.bouc_wen`).
Source: [paper] eqs. (5) and (6) in the standard form; [Wen-1976].
"""

import math
from typing import NamedTuple

from opensuction.kernel.compiled import compiled

LONGEST_MM = 0.05
"""Longest travel of one step of the integration."""


class BoucWenLag(NamedTuple):
    """Parameters of the lag."""

    gain: float
    """A: mm of memory per mm of head where the memory is zero."""
    outward: float
    """B + D, above 0: the bend where the memory grows away from zero."""
    homeward: float
    """D - B: the bend where it comes home."""
    exponent: float
    """m, at least 1."""
    share: float
    """mm by which the catheter runs ahead per mm of memory; below 0 where it lags."""


NO_LAG = BoucWenLag(gain=1.0, outward=1.0, homeward=0.0, exponent=1.0, share=0.0)


@compiled
def saturation_mm(lag: BoucWenLag) -> float:
    """Memory after a long advance, mm; minus that after a long retract."""
    return math.pow(lag.gain / lag.outward, 1.0 / lag.exponent)


@compiled
def _rate(lag: BoucWenLag, memory: float) -> float:
    bend = lag.outward if memory > 0.0 else lag.homeward
    return lag.gain - bend * math.pow(abs(memory), lag.exponent)


@compiled
def step_bouc_wen_lag(lag: BoucWenLag, memory_mm: float, move_mm: float) -> float:
    """The memory after a move of the head."""
    direction = 1.0 if move_mm > 0.0 else -1.0
    steps = math.ceil(abs(move_mm) / LONGEST_MM)
    if steps == 0:
        return memory_mm
    travel = abs(move_mm) / steps
    memory = direction * memory_mm
    for _ in range(steps):
        first = _rate(lag, memory)
        second = _rate(lag, memory + 0.5 * travel * first)
        third = _rate(lag, memory + 0.5 * travel * second)
        fourth = _rate(lag, memory + travel * third)
        memory += travel / 6.0 * (first + 2.0 * second + 2.0 * third + fourth)
    return direction * memory


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
