"""The range a field allows, read from its annotation and written out with its unit."""

from collections.abc import Iterable, Iterator
from typing import Annotated, Any, NamedTuple, get_args, get_origin

from annotated_types import Ge, GroupedMetadata, Gt, Le, Lt
from pydantic.fields import FieldInfo


class Limit(NamedTuple):
    """Range of a number; None where a side is open-ended."""

    lower: float | None
    lower_is_allowed: bool
    upper: float | None
    upper_is_allowed: bool


def _constraints(metadata: Iterable[Any]) -> Iterator[Any]:
    """Single constraints in an annotation: groups and pydantic fields taken apart."""
    for entry in metadata:
        if isinstance(entry, FieldInfo):
            yield from _constraints(entry.metadata)
        elif isinstance(entry, GroupedMetadata):
            yield from _constraints(entry)
        else:
            yield entry


def trim(bound: Any) -> float:
    """Bound without a needless ``.0``, so that messages read 15 and not 15.0."""
    number = float(bound)
    return int(number) if number.is_integer() else number


def limit_of(annotation: Any) -> Limit:
    """Range that an annotation such as ``Annotated[float, Interval(ge=0, le=15)]`` allows.

    Of several bounds on one side the last is taken.
    """
    limit = Limit(None, True, None, True)
    if get_origin(annotation) is not Annotated:
        return limit
    for entry in _constraints(get_args(annotation)[1:]):
        match entry:
            case Ge(bound):
                limit = limit._replace(lower=trim(bound), lower_is_allowed=True)
            case Gt(bound):
                limit = limit._replace(lower=trim(bound), lower_is_allowed=False)
            case Le(bound):
                limit = limit._replace(upper=trim(bound), upper_is_allowed=True)
            case Lt(bound):
                limit = limit._replace(upper=trim(bound), upper_is_allowed=False)
    return limit


def describe(limit: Limit) -> str:
    """Range as a message says it, without unit; "" where there is no limit.

    >>> describe(Limit(0, False, 15, True))
    'above 0 and at most 15'
    """
    parts = []
    if limit.lower is not None:
        parts.append(f"{'at least' if limit.lower_is_allowed else 'above'} {limit.lower}")
    if limit.upper is not None:
        parts.append(f"{'at most' if limit.upper_is_allowed else 'below'} {limit.upper}")
    return " and ".join(parts)
