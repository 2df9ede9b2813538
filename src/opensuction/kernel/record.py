"""Arrays in records, and a record whose fields are all 0."""

from functools import cache
from typing import Any, TypeVar, get_type_hints

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""Of doubles, the one kind that the core computes with; each docstring says of what shape."""

_fields_of = cache(get_type_hints)  # which takes longer than all the rest

Record = TypeVar("Record", bound=tuple[Any, ...])


def make_zero(record_type: type[Record], **given: Any) -> Record:
    """A record with 0 and false in all fields but those given; of records among them likewise.

    record_type: a NamedTuple of numbers, flags and such NamedTuples. Raises TypeError for another
    type in a field that is not given.
    """
    for name, kind in _fields_of(record_type).items():
        if name not in given:
            is_record = hasattr(kind, "_fields")
            if not is_record and kind not in (float, int, bool):
                raise TypeError(f"{record_type.__name__}.{name} is {kind}: there is no 0 of it")
            given[name] = make_zero(kind) if is_record else kind()
    return record_type(**given)
