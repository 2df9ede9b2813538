"""Validation of a mapping, as a file or a form gives it, into a settings record.

A record type is a `NamedTuple` whose fields are numbers with a range, ``Annotated[float,
Interval(ge=0, le=15)]``, other scalars, enumerations (written by the name of the member, in lower
case with hyphens), again such records (sections) or any number of them (arrays of sections:
``tuple[Record, ...]``). Leaves are checked by pydantic; the walk
through keys and sections is done here, because a settings file is by name, complete and never by
position. There are no defaults: a missing key is an error, whatever the record type says.

One of several things, picked by the name a person typed.

The range a field allows, read from its annotation and written out.
"""

from collections.abc import Mapping
from enum import Enum
from functools import cache
from typing import (
    TYPE_CHECKING,
    Annotated,
    Any,
    Final,
    NamedTuple,
    TypeVar,
    cast,
    get_args,
    get_origin,
    get_type_hints,
)

from opensuction.kernel.errors import InputError
from opensuction.kernel.unit import unit_of
from opensuction.kernel.vocabulary import by_name
from opensuction.settings.wording import join_key, one_line, refuse, show, unknown

# Loaded with the first record that is checked: a fit of arrays checks none.
if TYPE_CHECKING:
    from pydantic import TypeAdapter, ValidationError
    from pydantic_core import ErrorDetails

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
    from pydantic import TypeAdapter

    schema = TypeAdapter[Any](annotation).json_schema()
    bounds = (f"{words} {trim(schema[key])}" for key, words in WORDS.items() if key in schema)
    return " and ".join(bounds)


Value = TypeVar("Value")


def choose(name: object, known: Mapping[str, Value], what: str, listed: str | None = None) -> Value:
    """The value that ``known`` holds under ``name``.

    what: the kind of thing in words, such as ``compensation``; it opens the message.
    listed: where the names are listed, for those that are too many for one line.
    Raises `InputError` for a name that is not known, with the nearest and all known names.
    """
    if isinstance(name, str) and name in known:
        return known[name]
    raise InputError(one_line(unknown(f"{what} {show(name)}", name, known, listed)))


Record = TypeVar("Record", bound=tuple[Any, ...])

INT64: Final = 2**63
"""Integers of the compiled core are below this, and not below its negative."""

KINDS: Final[dict[Any, str]] = {
    bool: "true or false",
    float: "a number",
    int: "a whole number",
    str: "a text in quotes",
    list[float]: "a list of numbers",
    list[str]: "a list of texts in quotes",
    str | list[str]: "a text in quotes or a list of them",
}
"""What a message asks for, by the type of the field."""


class _Field(NamedTuple):
    """One field of a record type, with what is needed to check and to explain it."""

    name: str
    hint: Any
    """The type with its annotations."""
    type: Any
    """The bare type, without them."""
    adapter: "TypeAdapter[Any] | None"
    """None for sections, arrays of sections and enumerations."""


def validate(record_type: type[Record], mapping: object, where: object) -> Record:
    """A record of ``record_type`` from the keys and sections of ``mapping``; nothing is guessed.

    where: names the source in messages, usually the path of a file.
    Whole numbers are taken for float fields and become floats; no other type is converted. A
    section may also be given as a record of its type, as ``_asdict()`` leaves it.
    Raises `InputError` of one line for the first problem, and counts the others: not a mapping,
    an unknown or missing key, a wrong type, a number that is not finite or out of its range.
    """
    problems: list[str] = []
    values = _section(record_type, mapping, "", problems)
    if problems:
        others = len(problems) - 1
        more = f" (and {others} more problem{'s' if others > 1 else ''})" if others else ""
        raise refuse(where, f"{problems[0]}{more}")
    return cast(Record, values)


def to_mapping(record: Any) -> Any:
    """Keys and sections of a record, as `validate` takes them; a list stays a list."""
    if isinstance(record, tuple):
        if hasattr(record, "_asdict"):
            return to_mapping(record._asdict())
        return [to_mapping(entry) for entry in record]
    if isinstance(record, Mapping):
        return {key: to_mapping(value) for key, value in record.items()}
    return record


@cache
def _fields(record_type: Any) -> tuple[_Field, ...]:
    """Fields of a record type in their order."""
    hints = get_type_hints(record_type, include_extras=True)
    return tuple(_field(name, hints[name]) for name in record_type._fields)


def _field(name: str, hint: Any) -> _Field:
    from pydantic import ConfigDict, TypeAdapter

    bare = get_args(hint)[0] if get_origin(hint) is Annotated else hint
    if _is_record(bare) or _is_enumeration(bare) or _is_array(bare):
        return _Field(name, hint, bare, None)
    adapter = TypeAdapter[Any](hint, config=ConfigDict(strict=True, allow_inf_nan=False))
    return _Field(name, hint, bare, adapter)


def _is_record(candidate: Any) -> bool:
    return isinstance(candidate, type) and hasattr(candidate, "_fields")


def _is_array(candidate: Any) -> bool:
    """True for a tuple of any number of records."""
    kinds = get_args(candidate) if get_origin(candidate) is tuple else ()
    return len(kinds) == 2 and kinds[1] is Ellipsis and _is_record(kinds[0])


def _is_enumeration(candidate: Any) -> bool:
    return isinstance(candidate, type) and issubclass(candidate, Enum)


def _section(record_type: Any, given: object, section: str, problems: list[str]) -> Any:
    """Record of one section, or None after adding what is wrong to ``problems``.

    Unknown keys come first: a misspelt key is also a missing one, and its message is the better.
    """
    names = record_type._fields
    if isinstance(given, record_type):
        given = dict(zip(names, given, strict=True))
    if not isinstance(given, Mapping):
        what = f"{section} is {show(given)}" if section else f"found {show(given)}"
        problems.append(f"{what}, not a section; keys of the section: {', '.join(names)}")
        return None
    found_before = len(problems)
    for key in given:
        if key not in names:
            problems.append(unknown(f"key {join_key(section, key)}", key, names))
    values: dict[str, Any] = {}
    for field in _fields(record_type):
        key = join_key(section, field.name)
        if field.name in given:
            values[field.name] = _value(field, given[field.name], key, problems)
        else:
            problems.append(f"{key} is missing; {_wanted(field)}")
    return record_type(**values) if len(problems) == found_before else None


def _value(field: _Field, given: object, key: str, problems: list[str]) -> Any:
    """Checked value of one field; anything after adding what is wrong to ``problems``."""
    if _is_record(field.type):
        return _section(field.type, given, key, problems)
    if _is_array(field.type):
        return _array(field, given, key, problems)
    if field.adapter is None:
        return _member(field, given, key, problems)
    from pydantic import ValidationError

    try:
        value = field.adapter.validate_python(given)
    except ValidationError as error:
        problems.append(f"{key} is {_complaint(field, given, error)}; {_wanted(field)}")
        return None
    if field.type is int and not -INT64 <= value < INT64:
        problems.append(f"{key} is {show(given)}, more than 64 bits hold; {_wanted(field)}")
    return value


def _array(field: _Field, given: object, key: str, problems: list[str]) -> Any:
    """Records of an array of sections; an entry in a message is counted from 1."""
    if not isinstance(given, (list, tuple)) or hasattr(given, "_fields"):
        problems.append(f"{key} is {show(given)}, not a list of sections; {_wanted(field)}")
        return None
    kind = get_args(field.type)[0]
    entries = enumerate(given, 1)
    return tuple(_section(kind, one, f"{key}[{number}]", problems) for number, one in entries)


def _member(field: _Field, given: object, key: str, problems: list[str]) -> Any:
    """Member of an enumeration, given as itself or by its written name."""
    if isinstance(given, field.type):
        return given
    try:
        return choose(given, by_name(field.type), key)
    except InputError as error:
        problems.append(str(error))
        return None


def _complaint(field: _Field, given: object, error: "ValidationError") -> str:
    """Description of a bad value, with the limit it breaks; of a list, of its first bad entry."""
    details = error.errors(include_url=False, include_input=False)[0]
    kind, unit = field.type, unit_of(field.name)
    match details["loc"]:
        case (int(place),) if isinstance(given, list):
            wrong = _deviation(details, given[place], get_args(kind)[0], unit)
            return f"a list whose entry {place + 1} is {wrong}"
    return _deviation(details, given, kind, unit)


def _deviation(details: "ErrorDetails", given: object, kind: Any, unit: str) -> str:
    """Deviation of one value from the kind that it should be of."""
    match details["type"]:
        case "greater_than" | "greater_than_equal" | "less_than" | "less_than_equal":
            bound = trim(next(iter(details["ctx"].values())))
            relation = (
                "below the limit" if details["type"].startswith("greater") else "above the limit"
            )
            relation = "exactly the limit" if given == bound else relation
            number, limit = (f"{value} {unit}".rstrip() for value in (show(given), bound))
            return f"{number}, {relation} of {limit}"
        case "finite_number":
            return f"{show(given)}, not a finite number"
        case name if name.endswith("_type"):
            return f"{show(given)}, not {KINDS.get(kind, 'what belongs there')}"
        case _:
            message = str(details["msg"])
            return f"{show(given)}: {message[:1].lower()}{message[1:]}"


def _wanted(field: _Field) -> str:
    """The remedy: what the field takes, with its unit and range."""
    if _is_record(field.type):
        return f"give a section with the keys {', '.join(field.type._fields)}"
    if _is_array(field.type):
        keys = ", ".join(get_args(field.type)[0]._fields)
        return f"give a list of sections with the keys {keys}"
    if _is_enumeration(field.type):
        return f"give one of {', '.join(by_name(field.type))}"
    kind = KINDS.get(field.type, "a value")
    unit = unit_of(field.name)
    limits = describe(field.hint)
    amount = f"{kind} in {unit}" if unit and field.type in (int, float, list[float]) else kind
    return f"give {amount}, {limits}" if limits else f"give {amount}"
