"""A bus between controller and machine: messages take a while, not all as long; a few are lost.

How long a message takes is drawn evenly from latency less jitter to latency plus jitter, for each
message by itself, and independently of the others [assumed]. Messages are sent at any instant of
their tick, so that a latency of half a tick delays half of them by one. A later message may come
before an earlier one; whoever gets them takes the newest, and one that was overtaken is none. Who
gets none keeps the last: that a message was lost no flag tells.
"""

import math
from typing import NamedTuple

from opensuction.kernel import random_stream
from opensuction.kernel.compiled import compiled
from opensuction.kernel.errors import InputError
from opensuction.kernel.random_stream import RandomStream

LONGEST_S = 0.5
"""More is no bus."""
READINGS, COMMANDS = 1 << 40, 1 << 41
"""Ticks that no run has: from there on the blocks of a stream are the chance of the times that
messages take, one way and the other."""
LOSSES = 1 << 42
"""On top of these: the chance that they are lost."""


class Bus(NamedTuple):
    """Effect of a bus on messages, both ways alike."""

    latency_s: float
    """What a message takes in the mean."""
    jitter_s: float
    """It takes up to this more, or less."""
    lost_share: float
    """Share of the messages that never comes."""

    def check(self) -> None:
        """Refuse what no bus does; raises InputError."""
        if not 0.0 <= self.jitter_s <= self.latency_s <= LONGEST_S:
            raise InputError(
                f"a bus with a latency of {self.latency_s:g} s +- {self.jitter_s:g} s: should be "
                f"a latency of 0 to {LONGEST_S:g} s, and a jitter of no more than the latency"
            )
        if not 0.0 <= self.lost_share <= 1.0:
            raise InputError(f"a bus that loses {self.lost_share:g}: should be a share of 0 to 1")


PLAUSIBLE = Bus(latency_s=0.0005, jitter_s=0.0003, lost_share=0.001)
"""[assumed] A field bus in good order: half a period, and one message in a thousand is lost."""


class BusTicks(NamedTuple):
    """A bus in ticks: what a message takes, evenly from the least to the most, and its losses."""

    least_ticks: float
    most_ticks: float
    lost_share: float


def spread_of(bus: Bus, dt_s: float) -> BusTicks:
    """A bus in ticks."""
    least_s, most_s = bus.latency_s - bus.jitter_s, bus.latency_s + bus.jitter_s
    return BusTicks(least_s / dt_s, most_s / dt_s, bus.lost_share)


@compiled
def is_there(spread: BusTicks) -> bool:
    """True where there is a bus: a time, or a loss."""
    return spread.most_ticks > 0.0 or spread.lost_share > 0.0


@compiled
def oldest_ticks(spread: BusTicks) -> int:
    """After so many ticks a message has come that was not lost."""
    return math.floor(spread.most_ticks) + 1


@compiled
def taken_ticks(spread: BusTicks, source: RandomStream, way: int, tick: int) -> int:
    """After how many ticks a message comes that was sent in a tick. way: `READINGS`, `COMMANDS`."""
    if spread.most_ticks == 0.0:
        return 0
    first, within, _ = random_stream.uniform_pair(source._replace(counter=way + tick))
    taken = spread.least_ticks + (spread.most_ticks - spread.least_ticks) * first
    return math.floor(taken + within)


@compiled
def _is_lost(spread: BusTicks, source: RandomStream, way: int, tick: int) -> bool:
    """True where a message that was sent in a tick is lost."""
    if spread.lost_share == 0.0:
        return False
    first, _, _ = random_stream.uniform_pair(source._replace(counter=LOSSES + way + tick))
    return first < spread.lost_share


@compiled
def has_come(spread: BusTicks, source: RandomStream, way: int, tick: int, after: int) -> bool:
    """True where a message has come so many ticks after it was sent; see `taken_ticks`."""
    if taken_ticks(spread, source, way, tick) > after:
        return False
    return not _is_lost(spread, source, way, tick)
