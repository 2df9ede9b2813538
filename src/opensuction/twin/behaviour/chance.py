"""Random events at a rate that may change all the time.

An exponential number is drawn once for each event, and the rate reduces it; when nothing is left
the event comes. So a rate that rises and falls gives the right number of events, and no random
number is drawn in between.
"""

import math
from typing import NamedTuple

from opensuction.kernel import random_stream
from opensuction.kernel.compiled import compiled
from opensuction.kernel.random_stream import RandomStream


class Chance(NamedTuple):
    """Expected events until the next one, and the source of its random numbers."""

    left: float
    """Expected number of events until it comes."""
    share: float
    """A uniform number in (0, 1) for whoever asks what the coming event is like."""
    stream: RandomStream


@compiled
def draw(source: RandomStream) -> Chance:
    """The next event."""
    first, share, later = random_stream.uniform_pair(source)
    return Chance(left=-math.log(first), share=share, stream=later)


@compiled
def wear(chance: Chance, rate_per_s: float, dt_s: float) -> Chance:
    """The same after a step at a rate; the event has come where `is_due`."""
    return chance._replace(left=chance.left - rate_per_s * dt_s)


@compiled
def is_due(chance: Chance) -> bool:
    """True once the event has come; `draw` then gives the next one."""
    return chance.left <= 0.0


@compiled
def between(low: float, high: float, share: float) -> float:
    """The number that lies at a share of the way from one to another."""
    return low + (high - low) * share
