"""Course of a fault in time: permanent, for one tick, in turns, or in steps of its own.

A fault of a sensor or of the link has its duration among its parameters, and each tick asks whether
it is present. A fault of machine or patient has a course, which a run follows in steps: the twin's
tick knows nothing of it.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

from opensuction.twin.fault.reading_fault import Spell


class FaultOnset(NamedTuple):
    """Strength of a fault of the link or of a sensor, and the tick at which it begins."""

    strength: float
    tick: int
    dt_s: float

    @property
    def ticks(self) -> int:
        """A strength in seconds, in ticks."""
        return round(self.strength / self.dt_s)


def for_good(onset: FaultOnset) -> Spell:
    """It does not go away."""
    return Spell(onset.tick)


def for_a_tick(onset: FaultOnset) -> Spell:
    """One sample is wrong."""
    return Spell(onset.tick, there=1)


def by_turns(onset: FaultOnset) -> Spell:
    """It is there for its strength in seconds, away for as long, and so on."""
    return Spell(onset.tick, onset.ticks, 2 * onset.ticks)


def lasting(seconds: float) -> Callable[[FaultOnset], Spell]:
    """It is there for so long, once."""
    return lambda onset: Spell(onset.tick, round(seconds / onset.dt_s))


def by_turns_of(seconds: float) -> Callable[[FaultOnset], Spell]:
    """It is there for so long, away for as long, and so on."""
    return lambda onset: by_turns(onset._replace(strength=seconds))


class Course(NamedTuple):
    """Course of a fault of machine or patient in time; a run follows it in steps."""

    step_s: Callable[[float], float]
    """Time between two changes, from the strength."""
    share: Callable[[float, float], float]
    """Share of the strength that acts, from the strength and the time since the instant; 0: none
    of the fault is there."""
    lasts_s: float
    """When it is over."""


BY_TURNS = Course(
    step_s=lambda turn_s: turn_s,
    share=lambda turn_s, since_s: 1.0 - round(since_s / turn_s) % 2,
    lasts_s=math.inf,
)
"""There for its strength in seconds, away for as long, and so on."""
