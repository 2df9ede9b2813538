import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.safety.alarm import alarm, alarm_clock, alarm_state
from opensuction.safety.alarm.alarm_state import LONGEST_PAUSE_S, NOTHING, RELEASED, SILENT
from opensuction.safety.condition import Condition
from opensuction.safety.condition_mask import WORD, encode
from opensuction.safety.handling import Priority
from tests.safety.annunciator import DT_S, QUIET, SETTINGS, SPO2, lasting, press, run, wrong

C = Condition
STOPPED = wrong(C.AUTOMATION_STOPPED)
RUNAWAY = wrong(C.HEAD_RUNAWAY)


def test_nothing_wrong_says_nothing() -> None:
    assert {row.signals for row in run(lasting(QUIET, 5.0))} == {SILENT}


def test_a_condition_without_a_delay_sounds_in_its_first_tick() -> None:
    row = run([SPO2])[0]
    assert row.present == {C.SPO2_LOW}
    assert row.signals.priority == row.signals.audible == Priority.HIGH
    assert row.signals.first == C.SPO2_LOW
    assert row.signals.latched == row.signals.acknowledged == row.signals.escalated == 0


@pytest.mark.requirement("OS-R30")
def test_every_condition_sounds_with_its_own_priority() -> None:
    for condition in Condition:
        last = run(lasting(wrong(condition), 4.0))[-1].signals
        assert last.audible == last.priority == condition.row.handling.priority, condition
        assert last.first == condition


def test_a_bit_that_no_condition_has_is_a_high_alarm() -> None:
    state, signals = alarm.step(SETTINGS, alarm_state.START, 1 << 17, False, RELEASED, DT_S)
    assert signals.audible == Priority.HIGH
    assert signals.first == 17
    _, later = alarm.step(SETTINGS, state, 0, True, RELEASED, DT_S)
    assert later.latched == 1 << 17


def test_bits_beyond_the_word_do_not_disturb() -> None:
    _, signals = alarm.step(SETTINGS, alarm_state.START, 1 << 60, False, RELEASED, DT_S)
    assert signals == SILENT


def test_a_delayed_condition_waits_for_its_delay_and_not_longer() -> None:
    # Ticks of 1 ms, as in the controller: console lost for 2 s.
    rows = run([wrong(C.CONSOLE_LOST)] * 2002, dt_s=0.001)
    sounding = [index for index, row in enumerate(rows) if row.signals.audible]
    assert sounding[0] == 2000
    assert len(sounding) == 2


def test_a_condition_that_breaks_off_begins_its_delay_anew() -> None:
    almost = lasting(wrong(C.CONSOLE_LOST), 2.0)
    rows = run([*almost, QUIET, *almost, QUIET, *almost])
    assert not any(row.signals.audible for row in rows)
    # And another condition all the while does not lend it its time.
    rows = run([*almost, SPO2, *almost])
    assert all(C.CONSOLE_LOST not in row.present for row in rows)


def test_a_present_condition_is_not_delayed_again_by_another_that_waits() -> None:
    both = wrong(C.SPO2_LOW, C.CONSOLE_LOST)
    rows = run([SPO2, *lasting(both, 2.5)])
    assert all(C.SPO2_LOW in row.present for row in rows)
    assert rows[-1].present == {C.SPO2_LOW, C.CONSOLE_LOST}


def test_what_does_not_latch_ends_with_its_condition() -> None:
    assert run([SPO2, QUIET])[-1].signals == SILENT


@pytest.mark.requirement("OS-R31")
def test_what_latches_sounds_until_a_person_resets() -> None:
    rows = run([RUNAWAY, *lasting(QUIET, 300.0), press(QUIET, "reset"), QUIET])
    for row in rows[1:-2]:
        assert row.signals.present == 0
        assert row.signals.latched == encode({C.HEAD_RUNAWAY})
        assert row.signals.priority == row.signals.audible == Priority.HIGH
        assert row.signals.first == C.HEAD_RUNAWAY
    assert rows[-2].signals == rows[-1].signals == SILENT


@pytest.mark.requirement("OS-R31")
def test_a_reset_clears_nothing_that_still_holds() -> None:
    rows = run([RUNAWAY, press(RUNAWAY, "reset"), RUNAWAY, QUIET])
    assert rows[2].present == {C.HEAD_RUNAWAY}
    assert rows[3].signals.latched == encode({C.HEAD_RUNAWAY})


def test_a_reset_in_the_tick_in_which_the_cause_ends_clears_it() -> None:
    # The governor forgets its trips on the same press.
    assert run([RUNAWAY, press(QUIET, "reset")])[-1].signals == SILENT


def test_a_button_held_down_resets_once() -> None:
    held = press(QUIET, "reset")
    rows = run([press(RUNAWAY, "reset"), held, held])
    assert rows[-1].signals.latched == encode({C.HEAD_RUNAWAY})


def test_acknowledged_is_silent_but_shown_until_it_ends() -> None:
    rows = run([SPO2, press(SPO2, "acknowledge"), *lasting(SPO2, 30.0), QUIET, SPO2])
    for row in rows[1:-2]:
        assert row.acknowledged == row.present == {C.SPO2_LOW}
        assert row.signals.priority == Priority.HIGH
        assert row.signals.audible == Priority.NONE
        assert row.signals.first == C.SPO2_LOW
    assert rows[-2].signals == SILENT
    assert rows[-1].signals.audible == Priority.HIGH


def test_another_condition_sounds_although_the_first_is_acknowledged() -> None:
    both = wrong(C.SPO2_LOW, C.AUTOMATION_STOPPED)
    rows = run([SPO2, press(SPO2, "acknowledge"), both])
    assert rows[-1].acknowledged == {C.SPO2_LOW}
    assert rows[-1].signals.audible == Priority.MEDIUM
    assert rows[-1].signals.priority == Priority.HIGH


def test_an_acknowledged_latched_condition_sounds_when_it_begins_again() -> None:
    rows = run([RUNAWAY, press(RUNAWAY, "acknowledge"), QUIET, RUNAWAY])
    assert rows[-2].acknowledged == {C.HEAD_RUNAWAY}
    assert rows[-2].signals.audible == Priority.NONE
    assert rows[-1].acknowledged == set()
    assert rows[-1].signals.audible == Priority.HIGH


def test_what_begins_in_the_tick_of_the_press_was_not_acknowledged() -> None:
    rows = run([SPO2, press(wrong(C.SPO2_LOW, C.HEART_RATE_LOW), "acknowledge")])
    assert rows[-1].acknowledged == {C.SPO2_LOW}
    assert rows[-1].signals.audible == Priority.HIGH


def test_a_stuck_button_acknowledges_nothing_later() -> None:
    stuck = press(QUIET, "acknowledge")
    rows = run([stuck, *lasting(press(SPO2, "acknowledge"), 10.0)])
    assert all(row.signals.audible == Priority.HIGH for row in rows[1:])


def test_what_is_shown_first_is_urgent_then_unanswered_then_present() -> None:
    medium = wrong(C.AUTOMATION_STOPPED)
    assert run([wrong(C.AUTOMATION_STOPPED, C.SPO2_LOW)])[-1].signals.first == C.SPO2_LOW
    low = wrong(C.AUTOMATION_STOPPED, C.CATHETER_LIFE_ENDING)
    assert run([low])[-1].signals.first == C.AUTOMATION_STOPPED
    # Of equal priority: acknowledged after unanswered ...
    rows = run([medium, press(medium, "acknowledge"), wrong(C.AUTOMATION_STOPPED, C.CHECK_FAILED)])
    assert rows[-1].signals.first == C.CHECK_FAILED
    # ... and ended after present,
    rows = run([wrong(C.VACUUM_EXCEEDED), wrong(C.SPO2_LOW)])
    assert rows[-1].signals.first == C.SPO2_LOW
    # but an acknowledged high one before an unanswered medium one.
    rows = run([SPO2, press(SPO2, "acknowledge"), wrong(C.SPO2_LOW, C.CHECK_FAILED)])
    assert rows[-1].signals.first == C.SPO2_LOW
    # Of two that differ in nothing, the first of the table, steadily.
    rows = run([wrong(C.SPO2_LOW, C.HEART_RATE_LOW)] * 3)
    assert {row.signals.first for row in rows} == {C.SPO2_LOW}


@pytest.mark.requirement("OS-R36")
def test_a_medium_alarm_that_nobody_answers_becomes_high_after_two_minutes() -> None:
    rows = run(lasting(STOPPED, 130.0))
    times = [index * DT_S for index, row in enumerate(rows) if row.signals.escalated]
    assert times[0] == 120.0
    assert times[-1] == 129.5
    for row in rows:
        raised = bool(row.signals.escalated)
        assert row.signals.priority == (Priority.HIGH if raised else Priority.MEDIUM)
        assert row.signals.audible == row.signals.priority


def test_a_low_alarm_becomes_medium_and_no_more() -> None:
    ending = wrong(C.CATHETER_LIFE_ENDING)
    rows = run(lasting(ending, 3 * 3600.0, dt_s=30.0), dt_s=30.0)
    assert rows[119].signals.audible == Priority.LOW
    assert rows[120].signals.audible == Priority.MEDIUM
    assert rows[-1].signals.audible == Priority.MEDIUM


def test_an_answer_stops_the_clock_and_what_was_raised_stays_raised() -> None:
    answered = [*lasting(STOPPED, 100.0), press(STOPPED, "acknowledge"), *lasting(STOPPED, 300.0)]
    assert not any(row.signals.escalated for row in run(answered))
    late = [*lasting(STOPPED, 121.0), press(STOPPED, "acknowledge"), *lasting(STOPPED, 300.0)]
    rows = run(late)
    assert rows[-1].signals.priority == Priority.HIGH
    assert rows[-1].signals.audible == Priority.NONE


def test_a_pause_stops_the_clock_only_as_long_as_it_lasts() -> None:
    rows = run([*lasting(STOPPED, 100.0), press(STOPPED, "audio_pause"), *lasting(STOPPED, 200.0)])
    escalated = [index * DT_S for index, row in enumerate(rows) if row.signals.escalated]
    assert escalated[0] == 120.0 + LONGEST_PAUSE_S


@pytest.mark.parametrize("condition", [C(bit) for bit in alarm_clock.RISING])
def test_each_condition_that_rises_has_a_time_of_its_own(condition: Condition) -> None:
    other = C.CHECK_FAILED if condition != C.CHECK_FAILED else C.VACUUM_LOST
    ticks = round(condition.row.handling.escalates_s / 10.0)
    rows = run([*[wrong(other)] * 3, *[wrong(other, condition)] * (ticks + 1)], dt_s=10.0)
    first = {
        code: next(i for i, row in enumerate(rows) if row.signals.escalated >> code & 1)
        for code in (condition, other)
    }
    assert first == {condition: 3 + ticks, other: 12}


def test_escalation_begins_anew_with_the_condition() -> None:
    rows = run([*lasting(STOPPED, 130.0), QUIET, *lasting(STOPPED, 100.0)])
    assert rows[260].signals == SILENT
    assert all(row.signals.escalated == 0 for row in rows[260:])
    rows = run([*lasting(STOPPED, 100.0), QUIET, *lasting(STOPPED, 100.0)])
    assert all(row.signals.escalated == 0 for row in rows)


def test_a_latched_alarm_goes_on_escalating_when_its_condition_flickers() -> None:
    invalid = wrong(C.CAM_READING_INVALID)
    rows = run([invalid, QUIET] * 120)
    assert rows[239].signals.escalated == 0
    assert run([invalid, QUIET] * 130)[-1].signals.priority == Priority.HIGH


@pytest.mark.requirement("OS-R35")
def test_planned_work_raises_no_alarm_but_silences_no_patient() -> None:
    brought_about = wrong(C.AUTOMATION_STOPPED, C.CATHETER_LIFE_OVER, C.CHECK_FAILED)
    work = brought_about._replace(planned_work=True)
    assert {row.signals for row in run(lasting(work, 600.0))} == {SILENT}
    patient = work._replace(conditions=work.conditions | {C.SPO2_LOW})
    assert run([work, patient])[-1].present == {C.SPO2_LOW}
    # What the work left behind is an alarm as soon as it is over.
    assert run([work, wrong(C.VACUUM_LOST), *[wrong(C.VACUUM_LOST)] * 2])[-1].present == {
        C.VACUUM_LOST
    }


def test_most_urgent_of_nothing_is_none() -> None:
    assert alarm.most_urgent(0, 0) == Priority.NONE
    assert SILENT.first == NOTHING
    assert NOTHING not in range(WORD)
    assert not any(RELEASED)


@given(dt_s=st.sampled_from((0.001, 0.01, 0.1)))
def test_the_length_of_a_tick_changes_no_delay(dt_s: float) -> None:
    rows = run(lasting(wrong(C.CONSOLE_LOST), 2.1, dt_s), dt_s)
    first = next(index for index, row in enumerate(rows) if row.signals.audible)
    assert first * dt_s == pytest.approx(2.0)


def test_at_power_up_nothing_is_known_shown_pressed_or_paused() -> None:
    state = alarm_state.START
    assert not any(state.clocks.held_s + state.clocks.unanswered_s + state.pressed)
    others = set(state._fields) - {"clocks", "pressed"}
    assert {name for name in others if getattr(state, name) != 0} == set()


def test_at_rest_nothing_is_left_of_what_was() -> None:
    rest = alarm_state.START
    before = rest._replace(
        acknowledged=2, escalated=2, pause_left_s=1.0, paused_priority=3, owed_s=1.0, silent_s=1.0
    )
    after = run([QUIET], state=before)[0].state
    assert after == rest


def test_a_press_is_remembered_where_nothing_is_wrong() -> None:
    pressed = RELEASED._replace(acknowledge=True)
    state, signals = alarm.step(SETTINGS, alarm_state.START, 0, False, pressed, DT_S)
    assert (state, signals) == (alarm_state.START._replace(pressed=pressed), SILENT)
    # Held down, it does not answer what begins meanwhile; a press in its first tick does not either
    _, signals = alarm.step(SETTINGS, state, encode({C.SPO2_LOW}), False, pressed, DT_S)
    assert signals.acknowledged == 0


def test_half_a_tick_before_its_time_is_in_time() -> None:
    assert run([wrong(C.CONSOLE_LOST)], dt_s=4.0)[0].signals.audible  # after 2 s
    invalid = wrong(C.CAM_READING_INVALID)
    assert run([invalid, invalid], dt_s=80.0)[1].signals.escalated  # after 120 s
    assert run([SPO2, press(SPO2, "acknowledge")], dt_s=40.0)[1].signals.reminder  # after 60 s
