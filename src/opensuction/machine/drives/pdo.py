"""Process data objects of an emulated node, as its dictionary has them mapped (CiA 301, 7.5.2).

A mapping is written as the standard has it: the PDO is switched off (bit 31 of its identifier), the
number of objects set to 0, then the objects, their number, and the PDO is on again. Whatever does
not fit is refused with the standard's code.
"""

import struct
from collections.abc import Mapping
from typing import Final, NamedTuple

from canopen.objectdictionary import ObjectDictionary, ODVariable
from canopen.objectdictionary.datatypes import SIGNED_TYPES
from canopen.sdo.exceptions import SdoAbortedError

from opensuction.machine.canopen.objects import Communication

Key = tuple[int, int]
"""Index and subindex."""
Values = dict[Key, int]

OFF: Final = 1 << 31
"""Bit of a PDO's identifier: there is none."""
_ID_MASK: Final = 0x7FF
SYNCHRONOUS: Final = 240
"""Up to this transmission type a PDO goes by SYNC; 254 and 255 act at once."""
AT_ONCE: Final = (254, 255)
_MOST_OBJECTS, _MOST_BITS = 8, 64
_LETTER: Final = {8: "b", 16: "h", 32: "i", 64: "q"}

NO_OBJECT, NOT_MAPPABLE, TOO_LONG = 0x06020000, 0x06040041, 0x06040042
WRONG_VALUE, WRONG_STATE, NO_SUBINDEX = 0x06090030, 0x08000022, 0x06090011
"""Codes by which an SDO is refused (CiA 301, table 22)."""


class Pdo(NamedTuple):
    """A PDO that is switched on."""

    can_id: int
    kind: int
    """Transmission type."""
    keys: tuple[Key, ...]
    layout: struct.Struct


def _variable(dictionary: ObjectDictionary, index: int, subindex: int) -> ODVariable:
    """The object that an entry names. Raises SdoAbortedError."""
    found = dictionary.get_variable(index, subindex)
    if found is None:
        raise SdoAbortedError(NO_OBJECT)
    return found


def _letter(variable: ODVariable, bits: int) -> str:
    letter = _LETTER[bits]
    return letter if variable.data_type in SIGNED_TYPES else letter.upper()


def read(values: Mapping[Key, int], dictionary: ObjectDictionary, number: int, sends: bool) -> Pdo:
    """A PDO as it is mapped. number: from 0. sends: a TPDO. Raises SdoAbortedError."""
    communication = (Communication.TPDO if sends else Communication.RPDO) + number
    mapping = (Communication.TPDO_MAP if sends else Communication.RPDO_MAP) + number
    keys, letters = [], "<"
    for place in range(values[mapping, 0]):
        entry = values[mapping, place + 1]
        index, subindex, bits = entry >> 16, entry >> 8 & 0xFF, entry & 0xFF
        variable = _variable(dictionary, index, subindex)
        access = variable.writable if not sends else variable.readable
        if not variable.pdo_mappable or not access or bits != len(variable):
            raise SdoAbortedError(NOT_MAPPABLE)
        keys.append((index, subindex))
        letters += _letter(variable, bits)
    layout = struct.Struct(letters)
    if layout.size * 8 > _MOST_BITS:
        raise SdoAbortedError(TOO_LONG)
    can_id, kind = values[communication, 1], values[communication, 2]
    return Pdo(can_id & _ID_MASK, kind, tuple(keys), layout)


def is_on(values: Mapping[Key, int], number: int, sends: bool) -> bool:
    """True for a PDO that is switched on."""
    communication = (Communication.TPDO if sends else Communication.RPDO) + number
    return not values[communication, 1] & OFF


def all_on(values: Values, dictionary: ObjectDictionary, sends: bool) -> list[Pdo]:
    """All PDOs of a node that are switched on, in their order."""
    base = Communication.TPDO if sends else Communication.RPDO
    numbers = [index - base for index, sub in values if base <= index < base + 8 and sub == 1]
    return [
        read(values, dictionary, number, sends)
        for number in sorted(numbers)
        if is_on(values, number, sends)
    ]


def check_write(values: Values, dictionary: ObjectDictionary, key: Key, value: int) -> None:
    """Refuse what a PDO's parameter cannot be set to; raises SdoAbortedError."""
    index, subindex = key
    for base, mapping, sends in (
        (Communication.RPDO, Communication.RPDO_MAP, False),
        (Communication.TPDO, Communication.TPDO_MAP, True),
    ):
        if base <= index < base + 8 and subindex == 2:
            _check_kind(value, sends)
        elif mapping <= index < mapping + 8:
            _check_mapping(values, dictionary, index - mapping, sends, key, value)


def _check_kind(kind: int, sends: bool) -> None:
    allowed = kind <= SYNCHRONOUS if sends else kind <= SYNCHRONOUS or kind in AT_ONCE
    if not allowed or kind == 0:
        raise SdoAbortedError(WRONG_VALUE)


def _check_mapping(
    values: Values, dictionary: ObjectDictionary, number: int, sends: bool, key: Key, value: int
) -> None:
    index, subindex = key
    if is_on(values, number, sends) or (subindex and values[index, 0]):
        raise SdoAbortedError(WRONG_STATE)
    if subindex == 0:
        if value > _MOST_OBJECTS:
            raise SdoAbortedError(TOO_LONG)
        read({**values, key: value}, dictionary, number, sends)
    elif value:
        one = {**values, (index, 0): 1, (index, 1): value}
        read(one, dictionary, number, sends)
