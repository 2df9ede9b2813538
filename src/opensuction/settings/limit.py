"""The range a field allows, read from its annotation and written out."""

from typing import Any, Final

from pydantic import TypeAdapter

WORDS: Final = {
    "minimum": "at least",
    "exclusiveMinimum": "above",
    "maximum": "at most",
    "exclusiveMaximum": "below",
}
"""Bounds of a number by their names in JSON Schema, in the order of a message."""


def trim(bound: Any) -> float:
    """Bound without a needless ``.0``, so that messages read 15 and not 15.0."""
    number = float(bound)
    return int(number) if number.is_integer() else number


def describe(annotation: Any) -> str:
    """Range that an annotation allows, as a message says it, without unit; "" for no limit.

    >>> from annotated_types import Interval
    >>> from typing import Annotated
    >>> describe(Annotated[float, Interval(gt=0, le=15)])
    'above 0 and at most 15'
    """
    schema = TypeAdapter[Any](annotation).json_schema()
    bounds = (f"{words} {trim(schema[key])}" for key, words in WORDS.items() if key in schema)
    return " and ".join(bounds)
