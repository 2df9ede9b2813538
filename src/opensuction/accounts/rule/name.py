"""The name of an account."""

import re
import unicodedata

from opensuction.kernel.errors import InputError
from opensuction.settings.wording import show

FORM = re.compile(r"[a-z][a-z0-9._-]{1,31}")
RESERVED = frozenset({"anybody", "nobody", "somebody", "schedule", "console", "command-line"})
"""Who stands in the records without an account."""


def normalise(typed: str) -> str:
    """A name as it was meant: without spaces around it, in small letters."""
    return unicodedata.normalize("NFC", typed).strip().casefold()


def can_be(name: str) -> bool:
    """True for a possible account name; no database is asked for any other."""
    return FORM.fullmatch(name) is not None


def check(name: str) -> None:
    """Raises InputError for what cannot be the name of a new account."""
    if not can_be(name):
        raise InputError(
            f"the name {show(name)} is none: 2 to 32 small letters, digits, '.', '_' and '-', a "
            "letter first"
        )
    if name in RESERVED:
        raise InputError(f"the name {show(name)} is kept for the records themselves")
