"""Waiting times after failed sign-ins hold, also where the clock is set back."""

from datetime import timedelta

import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.accounts.rule import sign_in_rule
from opensuction.accounts.rule.sign_in_rule import ACCOUNT, DEVICE, ORIGIN, BackOff
from opensuction.records.account_rows import Attempt
from tests.records.example import NOON

RULES = st.sampled_from([ACCOUNT, ORIGIN, DEVICE])


def fail(rule: BackOff, times: int) -> list[float]:
    """The waits that follow failures, each made as soon as it may be."""
    attempt, now, waits = None, NOON, []
    for _ in range(times):
        attempt = sign_in_rule.charge(attempt, now)
        waits.append(sign_in_rule.wait_s(rule, attempt, now))
        now += timedelta(seconds=waits[-1])
    return waits


def test_waits_grow_to_their_longest() -> None:
    assert fail(ACCOUNT, 11) == [0, 0, 0, 0, 30, 60, 120, 240, 480, 900, 900]
    assert fail(ORIGIN, 25)[19:] == [5, 10, 20, 40, 60, 60]


def test_a_guesser_gets_some_hundred_tries_a_day() -> None:
    waits = fail(ACCOUNT, 200)
    day_s = timedelta(days=1).total_seconds()
    tries = next(count for count in range(200) if sum(waits[:count]) > day_s)
    assert tries < 110


def test_failures_are_forgotten_after_a_day_of_none() -> None:
    attempt = Attempt(50, NOON)
    later = NOON + sign_in_rule.MEMORY
    assert sign_in_rule.wait_s(ACCOUNT, attempt, later) == 0.0
    assert sign_in_rule.charge(attempt, later).failures == 1
    assert sign_in_rule.charge(attempt, later - timedelta(seconds=1)).failures == 51


def test_who_succeeds_takes_the_own_attempt_back_and_no_other() -> None:
    attempt = sign_in_rule.refund(Attempt(7, NOON), NOON)
    assert attempt == Attempt(6, NOON)
    assert sign_in_rule.refund(Attempt(1, NOON), NOON) is None
    assert sign_in_rule.refund(None, NOON) is None


@pytest.mark.parametrize("days", [1, 400])
def test_a_clock_set_back_is_found(days: int) -> None:
    attempt = Attempt(9, NOON)
    assert sign_in_rule.is_of_the_future(attempt, NOON - timedelta(days=days))
    assert not sign_in_rule.is_of_the_future(attempt, NOON)


@given(
    rule=RULES,
    failures=st.integers(0, 2**31 - 1),
    seconds=st.floats(-1e9, 1e9),
)
def test_nobody_waits_longer_than_the_longest(rule: BackOff, failures: int, seconds: float) -> None:
    now = NOON + timedelta(seconds=seconds)
    wait_s = sign_in_rule.wait_s(rule, Attempt(failures, NOON), now)
    assert 0.0 <= wait_s <= rule.longest_s
    assert wait_s == 0.0 or failures >= rule.free
