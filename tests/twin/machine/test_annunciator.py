"""The annunciator: what the controller said last, and what reaches it without a controller."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.twin.machine import fail_safe
from opensuction.twin.machine.fail_safe import DARK, LATE_S, SILENCE_S, Annunciator, Lines

DT_S = 0.001
LATE_TICKS = round(LATE_S / DT_S)
WELL = Lines(heard=True, wanted=0, reset=False, alone=False, mains=True, lag_s=0.0)
SILENCE = WELL._replace(heard=False)


def shown(*ticks: Lines) -> Annunciator:
    state = DARK
    for lines in ticks:
        state = fail_safe.step_annunciator(state, lines, DT_S)
    return state


@given(st.integers(0, 2**53 - 1), st.integers(0, 2**53 - 1))
def test_it_shows_what_the_last_message_says(first: int, last: int) -> None:
    said = WELL._replace(wanted=first)
    assert shown(said) == fail_safe.repeat(first)
    assert shown(said, WELL._replace(wanted=last)) == fail_safe.repeat(last)
    assert shown(said, *[SILENCE._replace(wanted=last)] * 100) == fail_safe.repeat(first)


def test_the_watchdogs_sign_stays_until_a_person_resets_it() -> None:
    alone = SILENCE._replace(alone=True)
    assert not shown(SILENCE).watchdog_fired
    assert shown(alone, WELL, WELL).watchdog_fired
    assert not shown(alone, WELL._replace(reset=True)).watchdog_fired
    assert shown(alone, alone._replace(reset=True)).watchdog_fired


def test_lost_mains_show_at_once_and_for_as_long_as_they_are_lost() -> None:
    dead = SILENCE._replace(mains=False, alone=True)
    assert shown(dead).reserve_used
    assert not shown(dead, WELL).reserve_used


@pytest.mark.parametrize("ticks", range(3 * LATE_TICKS))
def test_commands_are_late_beyond_five_ticks(ticks: int) -> None:
    assert LATE_TICKS == 5
    late = WELL._replace(lag_s=ticks * DT_S)
    assert shown(late).message_late == (ticks > 5)
    assert shown(late, WELL).message_late == (ticks > 5)
    assert not shown(late, WELL._replace(reset=True)).message_late


def test_lateness_is_told_before_the_drives_act() -> None:
    assert 0.0 < LATE_S < SILENCE_S


def test_drives_that_act_alone_wait_for_no_command() -> None:
    assert not shown(SILENCE._replace(alone=True, mains=False, lag_s=1.0)).message_late
