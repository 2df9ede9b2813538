"""Sets of conditions as bit masks: bit ``n`` is the condition of number ``n``. For compiled code.

Every mask here is derived from the rows of `condition`.
"""

from collections.abc import Callable, Iterable

from opensuction.kernel.compiled import compiled
from opensuction.safety.condition import Condition, row_of
from opensuction.safety.handling import Handling, Priority, Reaction

WORD = 53
"""Conditions that one mask can hold. Recordings store it as a double, which is exact below 2^53."""
EVERY_BIT = 2**WORD - 1

HANDLINGS = tuple(row_of(bit).handling for bit in range(WORD))
"""How the condition of each bit is handled."""


def _mask_where(chosen: Callable[[Handling], bool]) -> int:
    return sum(1 << bit for bit, handling in enumerate(HANDLINGS) if chosen(handling))


TRIPS = _mask_where(lambda handling: handling.reaction != Reaction.PASS)
WITHDRAWING = _mask_where(lambda handling: handling.reaction == Reaction.WITHDRAW)
RELEASING = _mask_where(lambda handling: handling.reaction == Reaction.TORQUE_OFF)
"""Masks of the trips by the reaction that they demand; none demands a milder one."""
CUTTING_VACUUM = _mask_where(lambda handling: handling.cuts_vacuum)

HIGHS = _mask_where(lambda handling: handling.priority == Priority.HIGH)
MEDIUMS = _mask_where(lambda handling: handling.priority == Priority.MEDIUM)
LOWS = _mask_where(lambda handling: handling.priority == Priority.LOW)
"""Masks of the conditions by priority."""
LATCHING = _mask_where(lambda handling: handling.latching)
PLANNED = _mask_where(lambda handling: handling.planned)


def encode(conditions: Iterable[int]) -> int:
    """Mask of some conditions."""
    return sum(1 << condition for condition in set(conditions))


def decode(mask: int) -> list[int]:
    """Numbers in a mask, in order; also those that no condition has."""
    return [bit for bit in range(WORD) if mask >> bit & 1]


def decode_trips(mask: int) -> list[Condition]:
    """Trips in a mask, in order of their numbers."""
    return [Condition(number) for number in decode(mask & TRIPS)]


@compiled
def strongest_reaction(trips: int) -> int:
    """Strongest reaction that a mask of trips demands."""
    reaction = 0  # an integer, as records hold it: compiled code would make it an enumeration
    if trips & RELEASING != 0:
        reaction = Reaction.TORQUE_OFF
    elif trips & WITHDRAWING != 0:
        reaction = Reaction.WITHDRAW
    return reaction


@compiled
def cuts_vacuum(trips: int) -> bool:
    """True where any trip in a mask demands that the vacuum be cut."""
    return trips & CUTTING_VACUUM != 0
