"""Rules for new passwords: long, and not easily guessed. No kinds of characters are prescribed.

Source: [NIST-800-63B] rev. 4, 3.1.1.2: at least 15 characters where nothing else is asked for, at
least 64 allowed, no rules on kinds of characters, none of the commonest, nothing of the name.

Common parts of passwords: frequent words, and runs of neighbouring keys.

The words are those that lists of leaked passwords have in common, and those that a hospital uses
for this machine. [assumed]
"""

import unicodedata
from functools import cache

from opensuction.kernel.errors import InputError

_LISTED = """
abc123 access admin administrator alexander amanda andrea andrew angel anthony apple april
arsenal ashley august austin autumn babygirl bailey banana barcelona baseball basketball batman
bedside blahblah bonjour buster butterfly calvin catheter change changeit changeme charlie
cheese chelsea chocolate clinic clinician computer cookie daniel december default demo diamond
doctor dragon easter engineer england family february flower football forever freedom friday
friend geheim ginger google guest hallo hammer hannah happy harley health heather hello hockey
hospital hunter iloveyou inspiron intensive internet january jasmine jennifer jessica jordan
joshua july june justin killer letmein liverpool login london lovely maggie manager march
martin master matrix matthew maverick medical medicine melissa mercedes michael michelle mickey
midnight minecraft monday monkey monster morgan mustang mylove naruto nicole night november
nurse nursing observer october office oliver orange panther parola pass passe passord passwd
passwort password patient patrick peanut pepper phoenix physician please pokemon porsche
princess private pussy rabbit ranger robert root samantha saturday scooter secret security
senha september server service shadow silver slipknot soccer spring star starwars start student
suction summer sunday sunshine superman support system taylor temp tennis test testing thomas
thunder thursday tigger trachea tracheal trustno trustnoone tuesday user vacuum ventilator ward
wednesday welcome whatever wilkommen willkommen william winter wizard yankees yellow
"""
WORDS = frozenset(_LISTED.split())
RUNS = (
    "abcdefghijklmnopqrstuvwxyz",
    "01234567890",
    "qwertyuiop",
    "qwertzuiop",
    "azertyuiop",
    "asdfghjkl",
    "qsdfghjklm",
    "zxcvbnm",
    "yxcvbnm",
    "1q2w3e4r5t6y7u8i9o0p",
    "qazwsxedcrfvtgbyhnujmikolp",
    "1qaz2wsx3edc4rfv5tgb6yhn7ujm8ik9ol0p",
)
"""In either direction."""
SHORTEST_RUN = 3

LOOKALIKES = str.maketrans("013457@$!€", "oieastasie")
"""What is written for a letter."""


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
