"""Rules for new passwords: long, and not easily guessed. No kinds of characters are prescribed.

Source: [NIST-800-63B] rev. 4, 3.1.1.2: at least 15 characters where nothing else is asked for, at
least 64 allowed, no rules on kinds of characters, none of the commonest, nothing of the name.
"""

import unicodedata
from functools import cache

from opensuction.accounts.rule.common_password import LOOKALIKES, RUNS, SHORTEST_RUN, WORDS
from opensuction.kernel.errors import InputError

SHORTEST = 15
"""Characters. Source: [NIST-800-63B]."""
LONGEST = 128
LONGEST_TYPED = 8 * LONGEST
"""Characters that are looked at: a letter may be typed as several."""
LEAST_OWN = 5
"""Characters that belong to nothing common. [assumed]"""
LEAST_DIFFERENT = 6
"""Different characters. [assumed]"""
LONGEST_PIECE = 7
"""Characters of what is only repeated. [assumed]"""
SHORTEST_NAME = 3
"""Letters of a name that must not be in it; shorter ones are in many words."""
PRODUCT = "opensuction"
YEARS = range(1900, 2100)
HINT = "take several words that do not belong together"


def normalise(password: str) -> str:
    """As it is hashed: the same letters typed on another keyboard are the same password.

    What is far too long is cut: nobody's time is taken by it, and no password is so long.
    """
    return unicodedata.normalize("NFC", password[:LONGEST_TYPED])


def check(password: str, name: str) -> None:
    """Raises InputError, without the password in it, for one that is not taken.

    name: of its account.
    """
    meant = normalise(password)
    count = len(meant) if len(password) <= LONGEST_TYPED else len(password)
    if not SHORTEST <= count <= LONGEST:
        raise InputError(
            f"the password has {count} characters; {SHORTEST} to {LONGEST} are taken; {HINT}"
        )
    if not meant.isprintable():
        raise InputError("the password has characters that cannot be typed everywhere")
    plain = meant.casefold()
    for part in (name.casefold(), PRODUCT):
        if len(part) >= SHORTEST_NAME and (part in plain or part[::-1] in plain):
            raise InputError(f"the password holds '{part}', which is tried first; {HINT}")
    if len(set(plain)) < LEAST_DIFFERENT:
        raise InputError(
            f"the password has fewer than {LEAST_DIFFERENT} different characters; {HINT}"
        )
    period = (plain + plain).find(plain, 1)
    if period < len(plain) and period <= LONGEST_PIECE:
        raise InputError(f"the password is a short piece repeated; {HINT}")
    if min(_count_own(plain), _count_own(plain.translate(LOOKALIKES))) < LEAST_OWN:
        raise InputError(f"the password is made of what is tried first; {HINT}")


def _count_own(text: str) -> int:
    """Characters that no common word, run, year or repetition covers, at least so many."""
    least = [0] * (len(text) + 1)
    for end in range(1, len(text) + 1):
        letter = text[end - 1]
        least[end] = least[end - 1] + (1 if letter.isalnum() else 0)
        for start in range(max(0, end - _longest()), end):
            if least[start] < least[end] and _is_common(text[start:end]):
                least[end] = least[start]
    return least[-1]


@cache
def _longest() -> int:
    return max(map(len, (*WORDS, *RUNS)))


def _is_common(piece: str) -> bool:
    if piece in WORDS:
        return True
    if len(piece) < SHORTEST_RUN:
        return False
    if len(set(piece)) == 1:
        return True
    if piece.isascii() and piece.isdecimal() and len(piece) == 4 and int(piece) in YEARS:
        return True
    return any(piece in run or piece[::-1] in run for run in RUNS)
