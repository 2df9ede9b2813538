"""Records that hold unknowns in every field."""

from collections.abc import Callable, Mapping
from typing import Any, get_args, get_origin, get_type_hints

import z3

from tools.proof.arithmetic import Doubles
from tools.proof.logic import MASK_BITS, UNREAD

MASKS = frozenset({"trips", "conditions", "causes", "dealt", "held", "reasons", "patient"})
"""Fields that are bit masks; other whole numbers are counts and enumerations."""


def free(
    doubles: Doubles,
    kind: Any,
    name: str,
    number: Callable[[str], Any] | None = None,
    given: Mapping[str, Any] | None = None,
) -> Any:
    """An unknown of a type: a record of unknowns for a record.

    number: makes the doubles of it, by their names; without it any double whatever. given: what is
    known of it, by name. Raises NotImplementedError for a type that the core does not hold.
    """
    if given and name in given:
        return given[name]
    if hasattr(kind, "_fields"):
        hints = get_type_hints(kind)
        return kind(
            *(free(doubles, hints[one], f"{name}.{one}", number, given) for one in kind._fields)
        )
    if get_origin(kind) is tuple:
        if Ellipsis in get_args(kind):
            return UNREAD
        parts = enumerate(get_args(kind))
        return tuple(free(doubles, one, f"{name}.{i}", number, given) for i, one in parts)
    if kind is float:
        return number(name) if number is not None else doubles.free(name)
    if kind is bool:
        return z3.Bool(name)
    if kind is int:
        is_mask = name.rsplit(".", 1)[-1] in MASKS
        return z3.BitVec(name, MASK_BITS) if is_mask else z3.Int(name)
    raise NotImplementedError(f"{name} is of {kind}")
