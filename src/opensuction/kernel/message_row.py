"""Numbers of a table's rows at fixed places of messages, each message as long as the others.

A message is bytes that describe it, with numbers in between: 8 bytes each, least significant first,
or one byte for a flag. A place need not be a multiple of 8.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import Array

Bytes = npt.NDArray[np.uint8]
Words = npt.NDArray[np.uint64]

FLOAT, INT, BOOL = 0, 1, 2
"""Kinds of numbers: as they are, as a whole number with its sign, and as a flag."""
WORD = 8
"""Bytes of a number that is no flag."""
# A word's bytes one by one at places without a sign: so the compiler makes one load or store of
# them, and a table of few rows takes half of the time.
_1, _2, _3, _4, _5, _6, _7 = (np.uint64(byte) for byte in range(1, WORD))
_BITS_1, _BITS_2, _BITS_3, _BITS_4, _BITS_5, _BITS_6, _BITS_7 = (
    np.uint64(8 * byte) for byte in range(1, WORD)
)


class Places(NamedTuple):
    """Places of a row's numbers in its message."""

    at: Words
    """First byte of each column's number."""
    kind: npt.NDArray[np.int64]
    """`FLOAT`, `INT` or `BOOL` of each column."""


@compiled
def write(places: Places, table: Array, words: Words, rows: Bytes) -> None:
    """Put the numbers of a table into messages.

    table: shape (rows, columns). words: the bits of the same numbers, in the same shape. rows:
    written; shape (rows, bytes of a message).
    """
    for row in range(table.shape[0]):
        for column in range(table.shape[1]):
            at, kind = places.at[column], places.kind[column]
            if kind == BOOL:
                rows[row, at] = 1 if table[row, column] != 0.0 else 0
                continue
            word = words[row, column]
            if kind == INT:
                word = np.uint64(np.int64(table[row, column]))
            rows[row, at] = np.uint8(word)
            rows[row, at + _1] = np.uint8(word >> _BITS_1)
            rows[row, at + _2] = np.uint8(word >> _BITS_2)
            rows[row, at + _3] = np.uint8(word >> _BITS_3)
            rows[row, at + _4] = np.uint8(word >> _BITS_4)
            rows[row, at + _5] = np.uint8(word >> _BITS_5)
            rows[row, at + _6] = np.uint8(word >> _BITS_6)
            rows[row, at + _7] = np.uint8(word >> _BITS_7)


@compiled
def read(places: Places, rows: Bytes, table: Array, words: Words) -> None:
    """Take the numbers of messages out of them again.

    rows: shape (rows, bytes of a message). table: written; shape (rows, columns). words: the same
    memory, as the bits of its numbers.
    """
    for row in range(table.shape[0]):
        for column in range(table.shape[1]):
            at, kind = places.at[column], places.kind[column]
            if kind == BOOL:
                table[row, column] = float(rows[row, at])
                continue
            word = (
                np.uint64(rows[row, at])
                | (np.uint64(rows[row, at + _1]) << _BITS_1)
                | (np.uint64(rows[row, at + _2]) << _BITS_2)
                | (np.uint64(rows[row, at + _3]) << _BITS_3)
                | (np.uint64(rows[row, at + _4]) << _BITS_4)
                | (np.uint64(rows[row, at + _5]) << _BITS_5)
                | (np.uint64(rows[row, at + _6]) << _BITS_6)
                | (np.uint64(rows[row, at + _7]) << _BITS_7)
            )
            if kind == INT:
                table[row, column] = float(np.int64(word))
            else:
                words[row, column] = word


@compiled
def is_described(template: Bytes, is_number: npt.NDArray[np.bool_], row: Bytes) -> bool:
    """True where all bytes of a message that belong to no number are as in the template."""
    for byte in range(template.size):
        if not is_number[byte] and row[byte] != template[byte]:
            return False
    return True
