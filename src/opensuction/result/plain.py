"""Plain data: what JSON can say, and how a record becomes it."""

import math
from collections.abc import Mapping
from functools import cache
from typing import Annotated, Any, TypeVar, get_args, get_origin, get_type_hints

Json = dict[str, Any]
Record = TypeVar("Record", bound=tuple[Any, ...])

FLAT = "flat"
"""Of a field, by `Annotated`: the fields of its record, or the entries of its mapping, stand in the
object around it, and take the place of what stands there under the same name; None: none do."""
IF_KNOWN = "if known"
"""Of a field, by `Annotated`: None is left out of the object instead of standing as ``null``."""
IF_FINITE = "if finite"
"""Of a number, by `Annotated`: it may be not finite, which stands as ``null``."""


@cache
def _marks(record: type) -> dict[str, str]:
    """Marked fields of a record, each with its mark."""
    found = {}
    for name, hint in get_type_hints(record, include_extras=True).items():
        if get_origin(hint) is Annotated and get_args(hint)[1] in (FLAT, IF_KNOWN):
            found[name] = get_args(hint)[1]
    return found


def to_json(record: tuple[Any, ...]) -> Json:
    """A record as the object that JSON shows: its fields by name, records within it likewise.

    record: a NamedTuple of text, numbers, flags, mappings, sequences and such NamedTuples. A number
    that is not finite is None.
    """
    found: Json = {}
    marks = _marks(type(record))
    for name, value in record._asdict().items():  # type: ignore[attr-defined]
        mark = marks.get(name)
        if mark is not None and value is None:
            continue
        if mark == FLAT:
            found |= _plain(value)
        else:
            found[name] = _plain(value)
    return found


def _plain(value: Any) -> Any:
    if hasattr(value, "_fields"):
        return to_json(value)
    if isinstance(value, Mapping):
        return {key: _plain(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(inner) for inner in value]
    return _finite(value)


def measured(record: Record) -> Record:
    """The same record with every number that is not finite as None, in records within it too."""
    return record.__class__._make(_measured(value) for value in record)  # type: ignore[attr-defined,no-any-return]


def _measured(value: Any) -> Any:
    if hasattr(value, "_fields"):
        return measured(value)
    if isinstance(value, Mapping):
        return {key: _measured(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return type(value)(_measured(inner) for inner in value)
    return _finite(value)


def without_nan(data: Json) -> Json:
    """The same data with every number that is not finite as None: JSON has no NaN."""
    return {key: _plain(value) for key, value in data.items()}


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def flatten(entries: Mapping[str, Any], prefix: str = "") -> list[tuple[str, Any]]:
    """Leaves of nested mappings as (dotted name, value), in order.

    >>> flatten({"model": {"slope": 0.97}, "rmse_mm": 0.84})
    [('model.slope', 0.97), ('rmse_mm', 0.84)]
    """
    leaves: list[tuple[str, Any]] = []
    for key, entry in entries.items():
        name = f"{prefix}{key}"
        if isinstance(entry, Mapping):
            leaves.extend(flatten(entry, f"{name}."))
        else:
            leaves.append((name, entry))
    return leaves
