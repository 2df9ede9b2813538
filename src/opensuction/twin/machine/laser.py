"""Laser displacement sensor on the tip: bench only, for identification and scoring.

The controller never reads it.
"""

from typing import NamedTuple

from opensuction.kernel import random_stream
from opensuction.kernel.compiled import compiled
from opensuction.kernel.random_stream import RandomStream


class Laser(NamedTuple):
    """Noise of one reading of the tip position (sensor, target and set-up together)."""

    noise_mm: float


class LaserState(NamedTuple):
    """Last reading, the second of a pair of random numbers, and the stream."""

    reading_mm: float
    spare: float
    has_spare: bool
    stream: RandomStream


@compiled
def step(laser: Laser, state: LaserState, tip_mm: float) -> LaserState:
    """Read the tip once."""
    if state.has_spare:
        return LaserState(tip_mm + laser.noise_mm * state.spare, 0.0, False, state.stream)
    first, second, stream = random_stream.normal_pair(state.stream)
    return LaserState(tip_mm + laser.noise_mm * first, second, True, stream)
