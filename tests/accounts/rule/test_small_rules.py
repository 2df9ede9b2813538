"""Names, addresses and lifetimes."""

from datetime import timedelta

import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.accounts.rule import sign_in_rule
from opensuction.kernel.errors import InputError
from opensuction.records.account_rows import Bearer
from tests.records.example import NOON

BEARER = Bearer("0" * 64, "session", "anna", None, NOON, NOON, NOON + sign_in_rule.ABSOLUTE)


def test_a_session_ends_when_nobody_uses_it_and_after_a_shift() -> None:
    assert not sign_in_rule.has_ended(BEARER, NOON + sign_in_rule.IDLE - timedelta(seconds=1))
    assert sign_in_rule.has_ended(BEARER, NOON + sign_in_rule.IDLE)
    late = BEARER._replace(seen_at=NOON + sign_in_rule.ABSOLUTE - timedelta(seconds=2))
    assert not sign_in_rule.has_ended(late, late.expires_at - timedelta(seconds=1))
    assert sign_in_rule.has_ended(late, late.expires_at)
    assert sign_in_rule.ends_at(late) == late.expires_at
    assert sign_in_rule.ends_at(BEARER) == NOON + sign_in_rule.IDLE


def test_a_clock_set_back_ends_a_session_and_a_small_step_does_not() -> None:
    assert not sign_in_rule.has_ended(BEARER, NOON - timedelta(seconds=2))
    assert sign_in_rule.has_ended(BEARER, NOON - timedelta(hours=5))


@pytest.mark.parametrize(
    ("address", "counted"),
    [
        ("10.0.0.7", "10.0.0.7"),
        ("::ffff:10.0.0.7", "10.0.0.7"),
        ("::1", "::1"),
        ("2001:db8:1:2:3:4:5:6", "2001:db8:1:2::/64"),
        ("2001:db8:1:2:ffff::1", "2001:db8:1:2::/64"),
        ("fe80::1%eth0", "fe80::/64"),
        ("", "nowhere"),
        ("bed 7\n", "bed 7\\n"),
    ],
)
def test_an_address_is_counted_as_whoever_has_it(address: str, counted: str) -> None:
    assert sign_in_rule.normalise_origin(address) == counted


@given(st.text(st.characters(codec=None, exclude_categories=[]), max_size=99))
def test_any_origin_can_be_put_on_record(given: str) -> None:
    counted = sign_in_rule.normalise_origin(given)
    assert 1 <= len(counted) <= 45
    assert counted.isprintable()


@pytest.mark.parametrize("good", ["anna", "a1", "anna.meyer-2_x"])
def test_a_name_that_can_be(good: str) -> None:
    sign_in_rule.check(good)
    assert sign_in_rule.normalise_name(f"  {good.upper()} ") == good


@pytest.mark.parametrize(
    "bad", ["", "a", "Anna", "1anna", "anna meyer", "änna", "a" * 33, "somebody", "command-line"]
)
def test_a_name_that_cannot_be_is_one_line(bad: str) -> None:
    with pytest.raises(InputError, match=r"the name ") as refused:
        sign_in_rule.check(bad)
    assert len(str(refused.value).splitlines()) == 1
