"""Records of results from plain data with gaps, for made-up results in tests."""

from collections.abc import Mapping
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

from opensuction.result.plain import FLAT

Record = TypeVar("Record")
EMPTY: dict[Any, Any] = {bool: False, str: "", int: 0, float: 0.0}
"""Of a field that is not given and cannot be None."""


def record_of(kind: type[Record], data: Mapping[str, Any]) -> Record:
    """A record from its JSON object; a field that is not there is None, or as empty as it may be.

    Raises KeyError for a key that no field has.
    """
    known: set[str] = set()
    found = _record(kind, data, known)
    if set(data) - known:
        raise KeyError(f"{kind.__name__} has no {sorted(set(data) - known)}")
    return found


def _record(kind: type[Record], data: Mapping[str, Any], known: set[str]) -> Record:
    fields = {}
    for name, hint in get_type_hints(kind, include_extras=True).items():
        if get_origin(hint) is Annotated and get_args(hint)[1] == FLAT:
            inner = next(one for one in get_args(get_args(hint)[0]) if one is not NoneType)
            names = set(get_type_hints(inner))
            fields[name] = _record(inner, data, known) if names & set(data) else None
            known |= names
            continue
        known.add(name)
        fields[name] = _value(hint, data.get(name))
    return kind(**fields)


def _value(hint: Any, value: Any) -> Any:
    if get_origin(hint) is Annotated:
        hint = get_args(hint)[0]
    if get_origin(hint) in (Union, UnionType):
        if value is None:
            return None
        (hint,) = [one for one in get_args(hint) if one is not NoneType][:1]
    if hasattr(hint, "_fields"):
        return value if isinstance(value, hint) else record_of(hint, value or {})
    if get_origin(hint) is tuple:
        return tuple(_value(get_args(hint)[0], one) for one in value or ())
    if value is None:
        return "" if get_origin(hint) is Literal else EMPTY.get(hint)
    return value
