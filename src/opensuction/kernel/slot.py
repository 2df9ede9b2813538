"""Slots of a ring that one process writes and others read without a lock.

A slot is its number, a row, a checksum and the number again. Whoever reads while it is being
written, or after a crash in the middle of it, finds numbers or checksum that do not agree.
"""

import numpy as np
import numpy.typing as npt

from opensuction.kernel.compiled import compiled

Words = npt.NDArray[np.uint64]

AROUND = 3
"""Words of a slot beside its row: number, checksum, number."""
PRIME = np.uint64(0x00000100000001B3)
"""Of the FNV hash."""
ROTATED = np.uint64(29)
KEPT = np.uint64(35)
NEWEST = 5
"""Word of a ring's header with the number of its newest row."""
EMPTY = np.uint64(0)
"""Number of a slot that is being written; rows are numbered from 1."""


@compiled
def _sum(slot: Words, number: np.uint64) -> np.uint64:
    """Checksum of a slot's row, in which its number counts; each bit of each word changes it."""
    total = number
    for i in range(1, slot.size - 2):
        total = (total ^ slot[i]) * PRIME
        total = (total << ROTATED) | (total >> KEPT)
    return total


@compiled
def write(slots: Words, number: np.uint64, row: Words) -> None:
    """Put a row into its slot.

    slots: shape (slots, columns + 3). number: from 1 on. row: the bits of its numbers, one word
    each.
    """
    slot = slots[number % np.uint64(slots.shape[0])]
    last = slot.size - 1
    slot[0] = EMPTY
    slot[last] = EMPTY
    for i in range(row.size):
        slot[1 + i] = row[i]
    slot[last - 1] = _sum(slot, number)
    slot[last] = number
    slot[0] = number


@compiled
def holds(slot: Words, number: np.uint64) -> bool:
    """True where a slot holds the row of that number, whole."""
    last = slot.size - 1
    same = slot[0] == number and slot[last] == number
    return bool(same and slot[last - 1] == _sum(slot, number))


@compiled
def read(slots: Words, number: np.uint64, row: Words) -> bool:
    """Copy the row of a number; false where its slot holds another one, or not all of it.

    It is looked at after it was copied: a slot may be written meanwhile.
    """
    slot = slots[number % np.uint64(slots.shape[0])]
    copied = slot.copy()
    for i in range(row.size):
        row[i] = copied[1 + i]
    return holds(copied, number)


@compiled
def read_newest(slots: Words, newest: int, most: int, row: Words) -> int:
    """Copy the newest row that is whole; its number, 0 where there is none.

    newest: number of the newest that there is. most: how many are tried, backwards from it.
    """
    for number in range(newest, max(newest - most, 0), -1):
        if read(slots, np.uint64(number), row):
            return number
    return 0


@compiled
def read_many(slots: Words, number: np.uint64, rows: Words) -> int:
    """Copy rows from a number on, until one is not there; how many there were."""
    for count in range(rows.shape[0]):
        if not read(slots, number + np.uint64(count), rows[count]):
            return count
    return int(rows.shape[0])


@compiled
def find_newest(slots: Words) -> np.uint64:
    """Number of the newest whole row; 0 where there is none. Looks at every slot."""
    newest = EMPTY
    for i in range(slots.shape[0]):
        number = slots[i][0]
        if number > newest and holds(slots[i], number):
            newest = number
    return newest
