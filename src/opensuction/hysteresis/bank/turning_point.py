"""Turning points of the head, the memory of plays of any width: a bounded stack in a tuple.

Only those turns count that no later travel has gone beyond: the last reversals, each within the one
before. They are kept from the outermost to the last; the first is where a long retract ended. The
position of a play of any width follows from them, so that a tick hands on sixteen numbers however
many plays a model has. Where more turns lie within one another, the two innermost are dropped: the
smallest loop is forgotten.

Unused places repeat the last turn. An odd number of turns ends with one at the low end, so that the
head moves in from it; an even number with one at the high end.
Source: [Mayergoyz-1991] for the wiping-out property.
"""

import numpy as np

from opensuction.hysteresis.play_sum import PLAYS, Sixteen, padded
from opensuction.kernel.codegen.unrolled import unrolled
from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import Array

ROOM = PLAYS
"""How many turns are kept; as many numbers as the tuple of a compensation's plays has."""
FAR_MM = 1e6
"""A head that comes from so far away moves every play."""


@unrolled
def _unpack(turns: Sixteen, values: Array) -> None:
    """Put the numbers of a tuple into an array."""
    for k in range(ROOM):
        values[k] = turns[k]


@unrolled
def _pack(values: Array) -> Sixteen:
    """The tuple of the numbers in an array."""
    return tuple(values[k] for k in range(ROOM))


AFTER_ADVANCE: Sixteen = padded([-FAR_MM] * ROOM)
"""Of a head that came in over a long way, wherever it is now."""


@compiled
def after_retract(head_mm: float) -> Sixteen:
    """Of a head that came back over a long way to a position."""
    values = np.empty(ROOM)
    for k in range(ROOM):
        values[k] = head_mm
    return _pack(values)


@compiled
def list_turns(turns: Sixteen) -> tuple[Array, int]:
    """The turns, outermost first, and how many there are."""
    values = np.empty(ROOM)
    _unpack(turns, values)
    count = 1
    while count < ROOM and values[count] != values[count - 1]:
        count += 1
    return values, count


@compiled
def step(turns: Sixteen, head_mm: float, to_mm: float) -> Sixteen:
    """Turns once the head has moved monotonically from one position to another; exact.

    It is exact as long as no more than `ROOM` turns lie within one another.
    """
    if to_mm == head_mm:
        return turns
    values, count = list_turns(turns)
    is_inwards = count % 2 == 1
    if (to_mm > head_mm) != is_inwards:
        if (head_mm > values[count - 1]) == is_inwards and head_mm != values[count - 1]:
            if count == ROOM:
                count -= 2
            values[count] = head_mm
            count += 1
        else:  # it turns where it turned before: it goes on
            count -= 1
    if to_mm > head_mm:
        while count >= 3 and to_mm >= values[count - 2]:
            count -= 2
    else:
        while count >= 2 and to_mm <= values[count - 2]:
            count -= 2
        if count == 0:  # beyond where the long retract had ended
            values[0] = to_mm
            count = 1
    for k in range(count, ROOM):
        values[k] = values[count - 1]
    return _pack(values)
