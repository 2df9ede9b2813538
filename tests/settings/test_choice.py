import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel.errors import InputError
from opensuction.settings.validation import choose

KNOWN = {"none": 0, "direct-inverse": 1, "exact-inverse": 2}


def test_a_known_name_gives_its_value() -> None:
    assert choose("direct-inverse", KNOWN, "compensation") == 1


@pytest.mark.parametrize(
    ("name", "message"),
    [
        (
            "Direct-Invers",
            "unknown compensation 'Direct-Invers': did you mean 'direct-inverse' or "
            "'exact-inverse'? Known: none, direct-inverse, exact-inverse",
        ),
        ("pid", "unknown compensation 'pid'; known: none, direct-inverse, exact-inverse"),
        (None, "unknown compensation None; known: none, direct-inverse, exact-inverse"),
        (["none"], "unknown compensation a list; known: none, direct-inverse, exact-inverse"),
    ],
)
def test_another_name_is_answered_with_the_nearest_and_all_known(
    name: object, message: str
) -> None:
    with pytest.raises(InputError) as raised:
        choose(name, KNOWN, "compensation")
    assert str(raised.value) == message


def test_a_part_of_a_name_is_understood() -> None:
    with pytest.raises(InputError, match="did you mean 'exact-inverse'"):
        choose("exact", KNOWN, "compensation")


def test_names_that_are_too_many_are_not_all_in_the_line() -> None:
    known = {f"fault-{number}": number for number in range(73)}
    with pytest.raises(InputError) as raised:
        choose("leak", known, "fault", "'opensuction cycle --help'")
    assert str(raised.value) == "unknown fault 'leak'; all 73 are in 'opensuction cycle --help'"
    with pytest.raises(InputError) as raised:
        choose("lime", {**known, "line": 3}, "fault", "the list")
    message = "unknown fault 'lime': did you mean 'line'? All 74 are in the list"
    assert str(raised.value) == message


def test_names_that_fit_are_in_the_line_though_they_are_listed_elsewhere_too() -> None:
    with pytest.raises(InputError) as raised:
        choose("leak", {"one": 1, "two": 2}, "fault", "the list")
    assert str(raised.value) == "unknown fault 'leak'; known: one, two"


def test_a_choice_of_nothing_says_so() -> None:
    with pytest.raises(InputError, match="there are none"):
        choose("adult", {}, "patient")


@given(st.text().filter(lambda name: name not in KNOWN))
def test_any_other_text_gives_one_line(name: str) -> None:
    with pytest.raises(InputError) as raised:
        choose(name, KNOWN, "compensation")
    assert len(str(raised.value).splitlines()) == 1
