"""Properties of the alarms that hold whatever happens and whatever is pressed."""

import inspect
import itertools
import typing

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from opensuction.safety.alarm import alarm
from opensuction.safety.alarm.alarm_state import AUDIBLE_S, LONGEST_PAUSE_S, Buttons
from opensuction.safety.condition import Condition
from opensuction.safety.condition_mask import encode
from opensuction.safety.handling import Priority
from tests.safety.annunciator import DT_S, Row, Tick, histories, lasting, run

EXAMPLES = settings(max_examples=30)


def lasted(rows: list[Row], last: int, condition: Condition) -> float:
    """For how long before this tick the condition has held without a break, s."""
    begun = last
    while begun > 0 and condition in rows[begun - 1].tick.conditions:
        begun -= 1
    return (last - begun) * DT_S


@pytest.mark.requirement("OS-R30")
@EXAMPLES
@given(history=histories())
def test_a_condition_past_its_delay_is_shown_with_at_least_its_priority(
    history: list[Tick],
) -> None:
    rows = run(history)
    for index, row in enumerate(rows):
        for condition in row.tick.conditions:
            handling = condition.row.handling
            if lasted(rows, index, condition) >= handling.delay_s:
                assert condition in row.present
                assert row.signals.priority >= handling.priority
        assert row.present <= row.tick.conditions


@EXAMPLES
@given(history=histories())
def test_a_high_condition_is_silent_only_if_acknowledged_or_paused(history: list[Tick]) -> None:
    for row in run(history):
        unanswered = row.shown - row.acknowledged
        loudest = max((code.row.handling.priority for code in unanswered), default=Priority.NONE)
        if row.signals.pause_left_s == 0.0:
            assert row.signals.audible >= loudest
        else:
            assert row.signals.audible == Priority.NONE
        assert (row.signals.audible > 0) <= bool(unanswered)


@pytest.mark.requirement("OS-R33")
@EXAMPLES
@given(history=histories())
def test_nothing_is_acknowledged_that_began_after_the_last_press(history: list[Tick]) -> None:
    rows = run(history)
    before: set[Condition] = set()
    for previous, row in itertools.pairwise([rows[0], *rows]):
        pressed = row.tick.acknowledge and not previous.tick.acknowledge
        began = row.present - previous.present
        grown = row.acknowledged - before
        assert not grown or pressed
        assert row.acknowledged & began == set()
        assert row.acknowledged <= row.shown
        before = row.acknowledged


@EXAMPLES
@given(history=histories())
def test_no_press_pauses_for_longer_than_allowed_nor_again_before_a_burst_was_heard(
    history: list[Tick],
) -> None:
    rows = run(history)
    silent_s = 0.0
    heard_s = AUDIBLE_S
    for row in rows:
        if row.signals.pause_left_s > 0.0:
            # What it silences was heard for a burst since the last pause, or is new since.
            assert silent_s > 0.0 or heard_s >= AUDIBLE_S
            silent_s += DT_S
            heard_s = 0.0
            assert silent_s <= LONGEST_PAUSE_S
        else:
            silent_s = 0.0
            quiet = row.signals.audible == Priority.NONE
            heard_s = AUDIBLE_S if quiet else heard_s + DT_S
        assert 0.0 <= row.signals.pause_left_s <= LONGEST_PAUSE_S


@pytest.mark.requirement("OS-R32")
@EXAMPLES
@given(history=histories(), held=st.sampled_from(["none", "pause", "all"]))
def test_a_new_high_condition_is_heard_in_its_first_tick_whatever_is_pressed(
    history: list[Tick], held: str
) -> None:
    new = Condition.SPO2_LOW
    before = [tick._replace(conditions=tick.conditions - {new}) for tick in history]
    last = before[-1]
    press = Tick(
        last.conditions | {new},
        acknowledge=held == "all",
        audio_pause=held != "none",
        reset=held == "all",
    )
    row = run([*before, press])[-1]
    assert row.signals.audible == Priority.HIGH
    assert new not in row.acknowledged


@EXAMPLES
@given(history=histories(), later=st.integers(0, 3))
def test_latched_ones_stay_until_a_person_resets(history: list[Tick], later: int) -> None:
    nobody = [tick._replace(reset=False) for tick in history]
    latching: set[Condition] = set()
    rows = run([*nobody, *lasting(Tick(), 100.0 * later)])
    for row in rows:
        latching |= {code for code in row.present if code.row.handling.latching}
        assert latching <= row.shown
    after = run([Tick(reset=True)], state=rows[-1].state)[-1]
    assert after.shown == set()


@EXAMPLES
@given(history=histories())
def test_an_alarm_is_never_lowered_while_it_lasts(history: list[Tick]) -> None:
    rows = run(history)
    for before, after in itertools.pairwise(rows):
        kept = before.signals.escalated & encode(after.shown)
        assert after.signals.escalated & kept == kept
        raised = after.signals.escalated & ~before.signals.escalated
        assert raised & encode(after.acknowledged) == 0
        assert all(code.row.handling.escalates_s > 0.0 for code in Condition if raised >> code & 1)


@EXAMPLES
@given(history=histories(planned=True))
def test_planned_work_hides_only_what_it_brings_about(history: list[Tick]) -> None:
    for row in run(history):
        if row.tick.planned_work:
            assert not any(code.row.handling.planned for code in row.present)


@EXAMPLES
@given(history=histories(planned=True))
def test_the_same_history_gives_the_same_alarms(history: list[Tick]) -> None:
    first = [row.signals for row in run(history)]
    assert [row.signals for row in run(history)] == first


@EXAMPLES
@given(history=histories(), split=st.integers(0, 50))
def test_the_state_passed_in_is_not_changed(history: list[Tick], split: int) -> None:
    # A replay that starts anywhere from a stored state sees the same alarms.
    split = min(split, len(history) - 1)
    early = run(history[: split + 1])
    once = [row.signals for row in run(history[split + 1 :], state=early[-1].state)]
    again = [row.signals for row in run(history[split + 1 :], state=early[-1].state)]
    whole = [row.signals for row in run(history)]
    assert once == again == whole[split + 1 :]


@pytest.mark.requirement("OS-R34")
@EXAMPLES
@given(history=histories())
def test_a_lost_console_changes_no_other_alarm(history: list[Tick]) -> None:
    """Nobody presses anything on a console that is gone; all else sounds as before."""
    gone = Condition.CONSOLE_LOST
    nobody = [Tick(tick.conditions - {gone}) for tick in history]
    alive = run(nobody)
    dead = run([Tick(tick.conditions | {gone}) for tick in nobody])
    for with_console, without in zip(alive, dead, strict=True):
        assert without.shown - {gone} == with_console.shown
        assert without.signals.audible >= with_console.signals.audible
        assert without.signals.escalated & ~(1 << gone) == with_console.signals.escalated


def test_the_step_is_given_nothing_of_a_console_but_its_buttons() -> None:
    given_to = set(inspect.signature(getattr(alarm.step, "py_func", alarm.step)).parameters)
    assert given_to == {"settings", "state", "conditions", "planned_work", "buttons", "dt_s"}
    assert set(typing.get_type_hints(Buttons)) == {"acknowledge", "audio_pause", "reset"}
