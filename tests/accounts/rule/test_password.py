"""Rules of passwords: those that are accepted, and the message for each that is not."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.accounts import session
from opensuction.accounts.rule import password
from opensuction.kernel.errors import InputError
from tests.accounts.example import PASSWORDS

REFUSED = {
    "": "has 0 characters",
    "velvet tractor": "has 14 characters; 15 to 128",
    "x7" * 65: "has 130 characters",
    "nine walnuts under ice " * 100: "has 2300 characters",
    "Password1234567": "tried first",
    "passwordpassword": "tried first",
    "P@ssw0rd!P@ssw0rd!": "tried first",
    "Welcome2026!!!!!": "tried first",
    "qwertyuiop123456": "tried first",
    "1q2w3e4r5t6y7u8i": "tried first",
    "zyxwvutsrqponmlk": "tried first",
    "Summer2026Winter2025": "tried first",
    "letmein letmein letmein": "tried first",
    "dragon-monkey-shadow": "tried first",
    "aaaaaaaaaaaaaaaa": "fewer than 6 different",
    "xqk7xqk7xqk7xqk7xqk7": "fewer than 6 different",
    "xq7vbtmxq7vbtmxq7vbtm": "a short piece repeated",
    "anna.meyer walks home": "holds 'anna.meyer'",
    "my REYEM.ANNA spelt back": "holds 'anna.meyer'",
    "OpenSuction is my thing": "holds 'opensuction'",
    "velvet tractor\thums": "cannot be typed",
    "velvet tractor \ud800hums": "cannot be typed",
}


@pytest.mark.parametrize("given", REFUSED)
def test_what_is_tried_first_is_refused_in_a_line(given: str) -> None:
    with pytest.raises(InputError, match=REFUSED[given]) as refused:
        password.check(given, "anna.meyer")
    said = str(refused.value)
    assert len(said.splitlines()) == 1
    assert not given or given not in said


@pytest.mark.parametrize(
    "given",
    [
        *PASSWORDS.values(),
        "velvet  tractor",
        "žluťoučký kůň běží",
        "hospital food is never warm enough",
        "x" * 10 + "tRk9?vB2#mQ",
        "速度計算機械電池水道氷河郵便局長塩",
    ],
)
def test_a_long_one_of_one_s_own_is_taken_whatever_its_letters(given: str) -> None:
    password.check(given, "anna.meyer")


def test_those_that_are_made_here_are_taken() -> None:
    for _ in range(200):
        password.check(session.make_one_time_password(), "anna")


def test_a_short_name_is_in_many_words() -> None:
    password.check("nine walnuts under ice", "un")


def test_the_same_letters_are_the_same_password() -> None:
    assert password.normalise("u\u0308ber") == password.normalise("\u00fcber")


@given(st.text(st.characters(codec=None, exclude_categories=[]), max_size=200), st.text(max_size=9))
def test_any_text_is_taken_or_refused_in_a_line_that_does_not_repeat_it(
    given: str, name: str
) -> None:
    try:
        password.check(given, name)
    except InputError as refused:
        said = str(refused)
        assert len(said) < 200
        assert len(given) < 15 or given not in said
    else:
        assert 15 <= len(password.normalise(given)) <= 128
        assert given.isprintable()
