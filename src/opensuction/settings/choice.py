"""One of several things, picked by the name a person typed."""

from collections.abc import Mapping
from typing import TypeVar

from opensuction.kernel.errors import InputError
from opensuction.settings.wording import one_line, remedy, shown

Value = TypeVar("Value")


def choose(name: object, known: Mapping[str, Value], what: str) -> Value:
    """The value that ``known`` holds under ``name``.

    what: the kind of thing in words, such as ``compensation``; it opens the message.
    Raises `InputError` for a name that is not known, with the nearest and all known names.
    """
    if isinstance(name, str) and name in known:
        return known[name]
    raise InputError(one_line(f"unknown {what} {shown(name)}; {remedy(name, known)}"))
