"""A hash of what the machine's library functions give: equal hashes promise equal bits.

Sums and products are the same everywhere, for IEEE 754 says every bit of them. Of ``exp`` or
``pow`` it does not: a library takes another way where the processor has other instructions, and 264
of 400,000 results of ``exp`` then differ in their last bit [computed]. A recording names the
fingerprint that it was made under, so that a replay knows what it may expect.
"""

import hashlib
import math
from functools import cache

import numpy as np

from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import Array

FUNCTIONS = (
    "sqrt",
    "exp",
    "expm1",
    "log",
    "log1p",
    "log2",
    "pow",
    "sin",
    "cos",
    "tan",
    "acos",
    "atan2",
    "tanh",
)
"""What the core calls, and its nearest relatives; a test holds it against the core's sources."""
POINTS = 20_000
"""Of each. One result in 1,500 that differs is overlooked once in 600,000 comparisons."""
STEP = 0.6180339887498949
"""Golden ratio's fraction: its multiples are spread over 0 to 1 without a pattern."""
OTHER_STEP = 0.4142135623730951
"""That of the root of two, for functions of two numbers."""
LARGEST = 30.0
"""Arguments of exponentials and angles: from minus this to this."""


@compiled
def _fill(table: Array) -> None:
    """Results at fixed points, a row for each of `FUNCTIONS`. table: written."""
    for i in range(table.shape[1]):
        turned = (i + 1) * STEP
        part = turned - math.floor(turned)
        turned = (i + 1) * OTHER_STEP
        other = turned - math.floor(turned)
        wide = (2.0 * part - 1.0) * LARGEST
        table[0, i] = math.sqrt(part * LARGEST)
        table[1, i] = math.exp(wide)
        table[2, i] = math.expm1(wide * other)
        table[3, i] = math.log(part * LARGEST + STEP * other)
        table[4, i] = math.log1p(part * other)
        table[5, i] = math.log2(part * LARGEST + STEP)
        table[6, i] = math.pow(part * LARGEST, 3.0 * other)
        table[7, i] = math.sin(wide)
        table[8, i] = math.cos(wide)
        table[9, i] = math.tan(part)
        table[10, i] = math.acos(2.0 * part - 1.0)
        table[11, i] = math.atan2(wide, 2.0 * other - 1.0)
        table[12, i] = math.tanh(3.0 * (2.0 * part - 1.0))


@cache
def fingerprint() -> str:
    """16 hexadecimal digits, by compiled code as the core is."""
    table = np.zeros((len(FUNCTIONS), POINTS))
    _fill(table)
    return hashlib.sha256(table.tobytes()).hexdigest()[:16]
