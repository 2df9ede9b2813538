"""A pause of the sound: how long, what breaks it, and the reminder of what is silent."""

import pytest

from opensuction.kernel.errors import InputError
from opensuction.safety.alarm import alarm, alarm_state
from opensuction.safety.alarm.alarm_state import LONGEST_PAUSE_S, RELEASED, SILENT, Buttons
from opensuction.safety.condition import Condition
from opensuction.safety.condition_mask import encode
from opensuction.safety.handling import Priority
from tests.safety.annunciator import (
    DT_S,
    QUIET,
    SETTINGS,
    SPO2,
    Tick,
    lasting,
    press,
    run,
    step,
    wrong,
)

C = Condition


@pytest.mark.requirement("OS-R32")
def test_an_audio_pause_silences_and_counts_down() -> None:
    rows = run([SPO2, press(SPO2, "audio_pause"), *lasting(SPO2, 130.0)])
    silent = [row for row in rows if row.signals.audible == Priority.NONE]
    assert len(silent) * DT_S == LONGEST_PAUSE_S
    left = [row.signals.pause_left_s for row in silent]
    assert left[0] == LONGEST_PAUSE_S
    assert left == sorted(left, reverse=True)
    assert left[-1] == DT_S
    assert all(row.signals.priority == Priority.HIGH for row in rows)
    assert rows[-1].signals.audible == Priority.HIGH
    assert rows[-1].signals.pause_left_s == 0.0


def test_the_first_alarm_after_a_quiet_time_may_be_paused_at_once() -> None:
    rows = run([*lasting(QUIET, 5.0), SPO2, press(SPO2, "audio_pause")])
    assert rows[-2].signals.audible == Priority.HIGH
    assert rows[-1].signals.audible == Priority.NONE


def test_a_pause_of_a_millisecond_controller_is_not_a_tick_too_long() -> None:
    rows = run([SPO2, press(SPO2, "audio_pause")], dt_s=0.001)
    silent = sum(row.signals.audible == Priority.NONE for row in rows)
    state, conditions = rows[-1].state, encode(set(SPO2.conditions))
    for _ in range(121000):
        state, signals = step(SETTINGS, state, conditions, False, RELEASED, 0.001)
        silent += signals.audible == Priority.NONE
    assert silent == 120000


def test_a_shorter_pause_may_be_set_and_a_longer_one_not() -> None:
    for pause_s, reminder_s in ((0.0, 60.0), (120.5, 60.0), (float("nan"), 60.0), (120.0, 0.0)):
        with pytest.raises(InputError, match=r"must be above 0 and at most 120 s"):
            alarm_state.check_settings(pause_s, reminder_s)
    with pytest.raises(InputError, match="reminder interval is 121 s"):
        alarm_state.check_settings(120.0, 121.0)
    short = alarm_state.check_settings(30.0, 60.0)
    state, _ = alarm.step(short, alarm_state.START, encode({C.SPO2_LOW}), False, RELEASED, DT_S)
    pause = Buttons(acknowledge=False, audio_pause=True, reset=False)
    _, signals = alarm.step(short, state, encode({C.SPO2_LOW}), False, pause, DT_S)
    assert signals.pause_left_s == 30.0


def test_a_pause_of_half_a_second_is_one() -> None:
    assert alarm_state.check_settings(0.5, 0.5) == alarm_state.AlarmSettings(
        pause_s=0.5, reminder_s=0.5
    )


def test_settings_that_were_not_validated_still_cannot_pause_for_longer() -> None:
    long = SETTINGS._replace(pause_s=1e6)
    state, _ = alarm.step(long, alarm_state.START, encode({C.SPO2_LOW}), False, RELEASED, DT_S)
    pause = Buttons(acknowledge=False, audio_pause=True, reset=False)
    _, signals = alarm.step(long, state, encode({C.SPO2_LOW}), False, pause, DT_S)
    assert signals.pause_left_s == LONGEST_PAUSE_S


@pytest.mark.parametrize("dt_s", [0.5, 0.1, 0.001])
def test_pressing_again_ends_the_pause_and_a_whole_burst_sounds_before_the_next(
    dt_s: float,
) -> None:
    pressed = press(SPO2, "audio_pause")
    heard = round(4.0 / dt_s)  # a whole burst of the highest priority
    for waited, granted in ((2, False), (heard - 1, False), (heard, True), (heard + 1, True)):
        rows = run([SPO2, pressed, SPO2, pressed, *[SPO2] * (waited - 1), pressed, SPO2], dt_s)
        audible = [bool(row.signals.audible) for row in rows]
        assert audible[:3] == [True, False, False]
        assert all(audible[3:-2])
        assert audible[-2:] == [not granted] * 2


@pytest.mark.parametrize(
    ("first", "second", "breaks"),
    [
        (C.AUTOMATION_STOPPED, C.SPO2_LOW, True),
        (C.CATHETER_LIFE_ENDING, C.AUTOMATION_STOPPED, True),
        (C.AUTOMATION_STOPPED, C.CHECK_FAILED, False),
        (C.SPO2_LOW, C.AUTOMATION_STOPPED, False),
        (C.SPO2_LOW, C.HEART_RATE_LOW, True),
    ],
)
def test_a_pause_is_broken_by_what_is_more_urgent_and_by_every_high_one(
    first: Condition, second: Condition, breaks: bool
) -> None:
    rows = run([wrong(first), press(wrong(first), "audio_pause"), *[wrong(first, second)] * 3])
    assert [bool(row.signals.audible) for row in rows[2:]] == [breaks] * 3
    assert (rows[-1].signals.pause_left_s == 0.0) == breaks


def test_what_a_pause_silenced_later_counts_for_breaking_it() -> None:
    low, medium = C.CATHETER_LIFE_ENDING, C.AUTOMATION_STOPPED
    both = wrong(low, medium)
    # Paused at medium; the medium one ends; another medium one begins: still paused.
    rows = run([both, press(both, "audio_pause"), wrong(low), wrong(low, C.CHECK_FAILED)])
    assert rows[-1].signals.audible == Priority.NONE


def test_a_pause_ends_with_its_cause() -> None:
    rows = run([SPO2, press(SPO2, "audio_pause"), QUIET, SPO2])
    assert rows[-1].signals.audible == Priority.HIGH
    acknowledged = press(SPO2, "acknowledge")
    rows = run([SPO2, press(SPO2, "audio_pause"), acknowledged])
    assert rows[-1].signals.pause_left_s == 0.0


@pytest.mark.parametrize("dt_s", [0.5, 0.001])
def test_what_begins_after_an_answered_alarm_may_be_paused_at_once(dt_s: float) -> None:
    both = wrong(C.SPO2_LOW, C.HEART_RATE_LOW)
    pressed = [press(SPO2, "audio_pause"), press(SPO2, "acknowledge")]
    rows = run([SPO2, *pressed, both, press(both, "audio_pause")], dt_s)
    assert rows[-2].signals.audible == Priority.HIGH
    assert rows[-1].signals.audible == Priority.NONE


def test_a_pause_cannot_be_taken_in_advance_or_by_a_stuck_button() -> None:
    rows = run([press(QUIET, "audio_pause"), QUIET, SPO2])
    assert rows[-1].signals.audible == Priority.HIGH
    rows = run([press(SPO2, "audio_pause"), SPO2])
    assert rows[0].signals.audible == rows[1].signals.audible == Priority.HIGH
    stuck = lasting(press(SPO2, "audio_pause"), 400.0)
    silent = sum(row.signals.audible == Priority.NONE for row in run([SPO2, *stuck]))
    assert silent * DT_S == LONGEST_PAUSE_S


@pytest.mark.parametrize("condition", [C.SPO2_LOW, C.PROPOSAL_INVALID, C.CATHETER_LIFE_ENDING])
def test_a_reminder_sounds_while_something_shown_is_silent(condition: Condition) -> None:
    tick = wrong(condition)
    before = run([tick, press(tick, "acknowledge"), Tick(reset=True), QUIET])[-1].state
    silenced = [tick, press(tick, "acknowledge"), *lasting(tick, 200.0)]
    rows = run(silenced, state=before)
    times = [index * DT_S for index, row in enumerate(rows) if row.signals.reminder]
    assert times == [60.0, 120.0, 180.0]
    paused = [tick, press(tick, "audio_pause"), *lasting(tick, 300.0)]
    times = [index * DT_S for index, row in enumerate(run(paused)) if row.signals.reminder]
    assert times == [60.0, 120.0]


def test_nothing_shown_needs_no_reminder() -> None:
    waiting = [wrong(C.CONSOLE_LOST), wrong(C.RECORDER_LOST)] * 200
    assert {row.signals for row in run(waiting)} == {SILENT}


def test_an_audible_alarm_needs_no_reminder() -> None:
    assert not any(row.signals.reminder for row in run(lasting(SPO2, 200.0)))
    broken = [SPO2, press(SPO2, "acknowledge"), *lasting(SPO2, 50.0)]
    louder = wrong(C.SPO2_LOW, C.HEART_RATE_LOW)
    rows = run([*broken, louder, press(louder, "acknowledge"), *lasting(louder, 50.0)])
    assert not any(row.signals.reminder for row in rows)


@pytest.mark.parametrize(("left_s", "after_s"), [(0.75, 0.25), (0.7, 0.0), (1.5, 1.0)])
def test_a_pause_lasts_to_its_last_half_tick(left_s: float, after_s: float) -> None:
    paused = run([SPO2, press(SPO2, "audio_pause")])[-1].state
    assert paused.owed_s == 0.0
    row = run([SPO2], state=paused._replace(pause_left_s=left_s))[0]
    assert row.signals.pause_left_s == after_s


@pytest.mark.parametrize(("owed_s", "granted"), [(0.75, False), (0.7, True)])
def test_another_pause_comes_when_less_than_half_a_tick_is_owed(
    owed_s: float, granted: bool
) -> None:
    sounding = run([SPO2])[-1].state._replace(owed_s=owed_s)
    row = run([press(SPO2, "audio_pause")], state=sounding)[0]
    assert (row.signals.pause_left_s > 0.0) == granted
