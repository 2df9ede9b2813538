"""Records of the core as C structs: a header with their fields, and their values as bytes.

The layout of a record is a numpy dtype, aligned as C aligns. The header's structs and the bytes of
a record both come from it, and the C compiler checks it: the header asserts each size and offset.
"""

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, NamedTuple, get_args, get_origin, get_type_hints

import numpy as np
import numpy.typing as npt
from annotated_types import Len

SCALARS: dict[Any, tuple[str, type[np.generic]]] = {
    float: ("double", np.float64),
    int: ("int64_t", np.int64),
    bool: ("bool", np.bool_),
}
"""Type of a field in C and in numpy."""
INCLUDES = ("stdbool.h", "stddef.h", "stdint.h")


class Field(NamedTuple):
    """A field of a struct."""

    name: str
    c_type: str
    dtype: np.dtype[Any]
    shape: tuple[int, ...]
    """Empty for a single value, (n,) for a tuple of n."""
    record_type: type | None
    """Of a nested record."""

    @property
    def declaration(self) -> str:
        """Its line in a struct."""
        return f"{self.c_type} {self.name}{''.join(f'[{n}]' for n in self.shape)};"


def list_fields(record_type: type) -> list[Field]:
    """Fields of a NamedTuple of numbers, flags, tuples of them and such NamedTuples.

    Raises TypeError, with the field's name, for anything else.
    """
    hints = get_type_hints(record_type, include_extras=True)
    return [_field(f"{record_type.__name__}.{name}", hint) for name, hint in hints.items()]


def _field(path: str, hint: Any) -> Field:
    name = path.partition(".")[2]
    marks: tuple[Any, ...] = ()
    if get_origin(hint) is Annotated:
        hint, *rest = get_args(hint)
        marks = tuple(rest)
    if hasattr(hint, "_fields"):
        return Field(name, hint.__name__, layout(hint), (), hint)
    shape: tuple[int, ...] = ()
    if get_origin(hint) is tuple:
        hint, shape = _tuple(path, get_args(hint), marks)
    if hint not in SCALARS:
        raise TypeError(f"{path} is {hint}: should be float, int, bool, a tuple or a record")
    c_type, scalar = SCALARS[hint]
    return Field(name, c_type, np.dtype(scalar), shape, None)


def _tuple(path: str, inner: tuple[Any, ...], marks: tuple[Any, ...]) -> tuple[Any, tuple[int]]:
    """Type and number of a tuple's values."""
    if inner[-1] is not Ellipsis and len(set(inner)) == 1:
        return inner[0], (len(inner),)
    lengths = {(mark.min_length, mark.max_length) for mark in marks if isinstance(mark, Len)}
    least, most = lengths.pop() if len(lengths) == 1 else (0, None)
    if inner[-1] is not Ellipsis or least != most:
        raise TypeError(f"{path} is a tuple of {inner}: should be of one type and fixed length")
    return inner[0], (least,)


def layout(record_type: type) -> np.dtype[Any]:
    """Offsets and types of a record's fields, as C lays them out."""
    members = [(field.name, field.dtype, field.shape) for field in list_fields(record_type)]
    return np.dtype(members, align=True)


def pack(record: tuple[Any, ...]) -> npt.NDArray[Any]:
    """The bytes of a record: an array of shape () that C takes as a pointer to its struct."""
    return np.array(record, dtype=layout(type(record)))


def _nested_first(record_type: type) -> Iterator[type]:
    for field in list_fields(record_type):
        if field.record_type is not None:
            yield from _nested_first(field.record_type)
    yield record_type


def _struct(record_type: type) -> Iterator[str]:
    """Lines of a struct and of the assertions about its layout."""
    name, dtype = record_type.__name__, layout(record_type)
    offsets: Mapping[str, tuple[Any, ...]] = dtype.fields or {}
    yield "typedef struct {"
    for field in list_fields(record_type):
        yield f"    {field.declaration}"
    yield f"}} {name};"
    yield f'_Static_assert(sizeof({name}) == {dtype.itemsize}, "size of {name}");'
    for field in list_fields(record_type):
        offset = offsets[field.name][1]
        path = f"{name}.{field.name}"
        yield f'_Static_assert(offsetof({name}, {field.name}) == {offset}, "offset of {path}");'


def _literal(value: float) -> str:
    """A constant in C: a whole number stays one, a double is told bit for bit."""
    return str(int(value)) if isinstance(value, int) else value.hex()


def write_header(record_types: tuple[type, ...], constants: Mapping[str, float]) -> str:
    """Text of a C header: the structs of records, nested ones included, and named constants."""
    lines = [f"#include <{name}>" for name in INCLUDES]
    for name, value in constants.items():
        lines.append(f"#define {name} {_literal(value)}")
    needed = dict.fromkeys(one for kind in record_types for one in _nested_first(kind))
    for record_type in needed:
        lines += _struct(record_type)
    return "\n".join(lines) + "\n"
