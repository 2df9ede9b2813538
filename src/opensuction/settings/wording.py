"""Wording of values, keys and names in messages: short, quoted, and on one line."""

import difflib
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from datetime import date, time
from typing import Final

from opensuction.kernel.errors import InputError

LONGEST: Final = 60
"""Characters of a value that a message repeats; enough to recognise it."""

NEAREST: Final = 3
"""How many similar names a message offers."""

ENOUGH_ALIKE: Final = 0.6
"""Similarity from which a known name is offered; the default of ``difflib``."""

SHORTEST_PART: Final = 3
"""Letters from which a part of a known name points to it."""

LONGEST_LINE: Final = 160
"""Characters up to which a message names all that is known where another place lists them too."""

_BARE_KEY: Final = re.compile(r"[A-Za-z0-9_-]+")


def one_line(text: str, encoding: str = "utf-8") -> str:
    r"""Text with line breaks and other invisible characters written as escapes.

    encoding: of who reads it; letters that it lacks are escaped, too.

    >>> print(one_line("a\x1b[31m\udcff\n"), one_line("5 µm", "ascii"))
    a\x1b[31m\udcff\n 5 \xb5m
    """
    shown = "".join(
        letter if letter.isprintable() else letter.encode("unicode_escape").decode()
        for letter in text
    )
    return shown.encode(encoding, "backslashreplace").decode(encoding)


def refuse(where: object, problem: str) -> InputError:
    """The error, on one line, for a problem that a file or another source has."""
    return InputError(one_line(f"{where}: {problem}"))


@contextmanager
def name_source(where: object) -> Iterator[None]:
    """A refusal in here names its source, as that of `refuse`, where it does not yet."""
    try:
        yield
    except InputError as refused:
        message = str(refused)
        raise refused if message.startswith(f"{where}: ") else refuse(where, message) from None


def show(value: object) -> str:
    """Value as a message repeats it: text in quotes, sections and lists by their kind.

    >>> [show(value) for value in (20.0, "fast", True, {"a": 1})]
    ['20.0', "'fast'", 'true', 'a section']
    """
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, Mapping):
        return "a section"
    if isinstance(value, list | tuple):
        return "a list"
    if isinstance(value, date | time):
        return value.isoformat()
    try:
        text = repr(value)
    except ValueError:  # an integer with more digits than Python writes out
        return "a number with thousands of digits"
    return one_line(text if len(text) <= LONGEST else text[: LONGEST - 3] + "...")


def join_key(section: str, key: object) -> str:
    """Key inside a section as TOML writes it: ``cycle.dwell_s``; odd keys are quoted."""
    text = key if isinstance(key, str) and _BARE_KEY.fullmatch(key) else show(key)
    return f"{section}.{text}" if section else text


def nearest(name: str, known: Iterable[str]) -> list[str]:
    """Known names similar to ``name``, most similar first, then those that hold it as a part.

    Case does not count.
    """
    by_folded = {entry.casefold(): entry for entry in known}
    # Long enough for any name a person types; a pasted file must not take seconds to compare.
    folded = name[:LONGEST].casefold()
    found = difflib.get_close_matches(folded, by_folded, n=NEAREST, cutoff=ENOUGH_ALIKE)
    if len(folded) >= SHORTEST_PART:
        found += [entry for entry in by_folded if folded in entry and entry not in found]
    return [by_folded[entry] for entry in found[:NEAREST]]


def one_of(names: Sequence[str]) -> str:
    """Names to choose from, quoted: ``'a', 'b' or 'c'``."""
    quoted = [f"'{name}'" for name in names]
    return " or ".join([", ".join(quoted[:-1]), quoted[-1]] if quoted[1:] else quoted)


def unknown(what: str, name: object, known: Iterable[str], listed: str | None = None) -> str:
    """Refusal of a name that is not known, with the nearest ones.

    what: as it opens the message, with the name where that is wanted: ``protocol 'papr'``.
    listed: where the names are listed, should they be too many for one line; None: named here.
    """
    names = list(known)
    alike = nearest(name, names) if isinstance(name, str) else []
    opening = f"unknown {what}: did you mean {one_of(alike)}? " if alike else f"unknown {what}; "
    every = f"known: {', '.join(names)}" if names else "there are none"
    if listed and len(opening) + len(every) > LONGEST_LINE:
        every = f"all {len(names)} are in {listed}"
    return opening + (every[0].upper() + every[1:] if alike else every)
