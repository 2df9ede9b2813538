"""One of several things, picked by the name a person typed."""

from collections.abc import Mapping
from typing import TypeVar

from opensuction.kernel.errors import InputError
from opensuction.settings.wording import one_line, show, unknown

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
