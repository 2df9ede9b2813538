"""Counter-based random numbers that live in the state: replay and parallel runs are exact.

Threefry-2x32 with 20 rounds on 32-bit words, carried in 64-bit integers so that the same source
gives the same bits compiled and as plain Python.
Source: [Salmon-2011].
"""

import math
from typing import NamedTuple

from opensuction.kernel.compiled import compiled

MASK = 0xFFFFFFFF
PARITY = 0x1BD11BDA
TWO_PI = 2.0 * math.pi
UNIT = 1.0 / 4294967296.0


class RandomStream(NamedTuple):
    """A stream of random numbers: its key and the next block to be drawn."""

    key_0: int
    key_1: int
    counter: int


def stream(seed: int, purpose: int) -> RandomStream:
    """Stream for one seed and one purpose; different purposes never overlap.

    seed: any non-negative integer below 2**32. purpose: small integer naming the use.
    """
    return RandomStream(key_0=seed & MASK, key_1=purpose & MASK, counter=0)


@compiled
def _rotate(word: int, bits: int) -> int:
    return ((word << bits) | (word >> (32 - bits))) & MASK


@compiled
def _four_rounds(x: int, y: int, r0: int, r1: int, r2: int, r3: int) -> tuple[int, int]:
    x = (x + y) & MASK
    y = _rotate(y, r0) ^ x
    x = (x + y) & MASK
    y = _rotate(y, r1) ^ x
    x = (x + y) & MASK
    y = _rotate(y, r2) ^ x
    x = (x + y) & MASK
    y = _rotate(y, r3) ^ x
    return x, y


@compiled
def threefry(key_0: int, key_1: int, block_0: int, block_1: int) -> tuple[int, int]:
    """Two random 32-bit words for a key and a block number (Threefry-2x32-20)."""
    key_2 = (PARITY ^ key_0 ^ key_1) & MASK
    x = (block_0 + key_0) & MASK
    y = (block_1 + key_1) & MASK
    x, y = _four_rounds(x, y, 13, 15, 26, 6)
    x = (x + key_1) & MASK
    y = (y + key_2 + 1) & MASK
    x, y = _four_rounds(x, y, 17, 29, 16, 24)
    x = (x + key_2) & MASK
    y = (y + key_0 + 2) & MASK
    x, y = _four_rounds(x, y, 13, 15, 26, 6)
    x = (x + key_0) & MASK
    y = (y + key_1 + 3) & MASK
    x, y = _four_rounds(x, y, 17, 29, 16, 24)
    x = (x + key_1) & MASK
    y = (y + key_2 + 4) & MASK
    x, y = _four_rounds(x, y, 13, 15, 26, 6)
    x = (x + key_2) & MASK
    y = (y + key_0 + 5) & MASK
    return x, y


@compiled
def word_pair(source: RandomStream) -> tuple[int, int, RandomStream]:
    """Two independent random 32-bit words and the advanced stream."""
    x, y = threefry(
        source.key_0, source.key_1, source.counter & MASK, (source.counter >> 32) & MASK
    )
    return x, y, RandomStream(source.key_0, source.key_1, source.counter + 1)


@compiled
def uniform_pair(source: RandomStream) -> tuple[float, float, RandomStream]:
    """Two independent uniform numbers in (0, 1) and the advanced stream."""
    x, y, advanced = word_pair(source)
    return (x + 0.5) * UNIT, (y + 0.5) * UNIT, advanced


@compiled
def normal_pair(source: RandomStream) -> tuple[float, float, RandomStream]:
    """Two independent standard normal numbers and the advanced stream (Box-Muller)."""
    u, v, advanced = uniform_pair(source)
    radius = math.sqrt(-2.0 * math.log(u))
    return radius * math.cos(TWO_PI * v), radius * math.sin(TWO_PI * v), advanced
