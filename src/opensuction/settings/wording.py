"""How values, keys and names appear in messages: short, quoted, and on one line."""

import difflib
import re
from collections.abc import Iterable, Mapping
from typing import Final

LONGEST: Final = 60
"""Characters of a value that a message repeats; enough to recognise it."""

NEAREST: Final = 3
"""How many similar names a message offers."""

ENOUGH_ALIKE: Final = 0.6
"""Similarity from which a known name is offered; the default of ``difflib``."""

_BARE_KEY: Final = re.compile(r"[A-Za-z0-9_-]+")


def one_line(text: str) -> str:
    """Text with line breaks and other invisible characters written as escapes."""
    return "".join(
        letter if letter.isprintable() else letter.encode("unicode_escape").decode()
        for letter in text
    )


def shown(value: object) -> str:
    """Value as a message repeats it: text in quotes, sections and lists by their kind.

    >>> [shown(value) for value in (20.0, "fast", True, {"a": 1})]
    ['20.0', "'fast'", 'true', 'a section']
    """
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, Mapping):
        return "a section"
    if isinstance(value, list | tuple):
        return "a list"
    try:
        text = repr(value)
    except ValueError:  # an integer with more digits than Python writes out
        return "a number with thousands of digits"
    return one_line(text if len(text) <= LONGEST else text[: LONGEST - 3] + "...")


def dotted(section: str, key: object) -> str:
    """Key inside a section as TOML writes it: ``cycle.dwell_s``; odd keys are quoted."""
    text = key if isinstance(key, str) and _BARE_KEY.fullmatch(key) else shown(key)
    return f"{section}.{text}" if section else text


def nearest(name: str, known: Iterable[str]) -> list[str]:
    """Known names similar to ``name``, most similar first; case does not count."""
    by_folded = {entry.casefold(): entry for entry in known}
    # Long enough for any name a person types; a pasted file must not take seconds to compare.
    folded = name[:LONGEST].casefold()
    found = difflib.get_close_matches(folded, by_folded, n=NEAREST, cutoff=ENOUGH_ALIKE)
    return [by_folded[entry] for entry in found]


def remedy(name: object, known: Iterable[str]) -> str:
    """What to write instead of an unknown name: the nearest names, then all of them."""
    names = list(known)
    alike = nearest(name, names) if isinstance(name, str) else []
    every = f"known: {', '.join(names)}" if names else "there are none"
    return f"nearest: {', '.join(alike)}; {every}" if alike else every
