from opensuction.safety.alarm import alarm_log
from opensuction.safety.alarm.alarm_log import AlarmEvent, Entry, Episode, Log, list_episodes
from opensuction.safety.alarm.alarm_state import NOTHING
from opensuction.safety.condition import Condition
from opensuction.safety.handling import Priority
from tests.safety.annunciator import DT_S, Tick, lasting, run, wrong

C = Condition
STALLED = wrong(C.HEAD_STALLED)
STOPPED = wrong(C.AUTOMATION_STOPPED)
QUIET = Tick()


def logged(history: list[Tick]) -> Log:
    """Log of some ticks, the first at 0 s."""
    log = alarm_log.start(1000, 0.0)
    for index, row in enumerate(run(history)):
        log = alarm_log.note(log, index * DT_S, row.signals)
    return log


def test_nothing_raised_is_no_alarm() -> None:
    assert list_episodes(logged([QUIET] * 3)) == ()


def test_an_alarm_is_told_from_its_beginning_to_its_end() -> None:
    ended = logged([QUIET, STOPPED, STOPPED, QUIET])
    assert list_episodes(ended) == (
        Episode(C.AUTOMATION_STOPPED, Priority.MEDIUM, DT_S, 3 * DT_S, False, None),
    )
    assert list_episodes(logged([QUIET, STOPPED]))[0].ended_s is None


def test_what_latches_ends_with_the_reset() -> None:
    reset = Tick(reset=True)
    found = list_episodes(logged([STALLED, QUIET, QUIET, reset]))
    assert found == (Episode(C.HEAD_STALLED, Priority.HIGH, 0.0, 3 * DT_S, True, None),)


def test_what_begins_again_while_it_is_shown_is_the_same_alarm() -> None:
    found = list_episodes(logged([STALLED, QUIET, STALLED, STALLED]))
    assert len(found) == 1
    assert found[0].ended_s is None
    # Over and begun again, it is another.
    assert len(list_episodes(logged([STOPPED, QUIET, STOPPED]))) == 2


def test_the_first_answer_and_the_highest_priority_are_kept() -> None:
    press = Tick(STOPPED.conditions, acknowledge=True)
    found = list_episodes(logged([*lasting(STOPPED, 130.0), press, STOPPED, press]))
    assert found[0].priority == Priority.HIGH
    assert found[0].acknowledged_s == 130.0


def test_a_power_up_ends_what_was_shown() -> None:
    log = alarm_log.restart(logged([STALLED, STALLED]), 9.0)
    assert list_episodes(log)[0].ended_s == 9.0


def test_an_end_without_its_beginning_is_left_out_and_an_unknown_condition_is_high() -> None:
    log = logged([QUIET])
    entries = (
        Entry(1.0, int(C.SPO2_LOW), AlarmEvent.ENDED),
        Entry(2.0, NOTHING, AlarmEvent.PAUSED),
        Entry(3.0, 17, AlarmEvent.RAISED),
    )
    found = list_episodes(log._replace(entries=entries))
    assert [(alarm.condition, alarm.priority) for alarm in found] == [(17, Priority.HIGH)]


def told(condition: Condition, *events: AlarmEvent) -> Episode:
    """The one alarm of a log with these events, a second apart."""
    entries = tuple(Entry(float(i), int(condition), event) for i, event in enumerate(events))
    (alarm,) = list_episodes(logged([QUIET])._replace(entries=entries))
    return alarm


def test_an_alarm_that_nobody_answers_rises_by_one_step_at_a_time_to_high() -> None:
    low = next(code for code in C if code.row.handling.priority == Priority.LOW)
    assert told(low, AlarmEvent.RAISED).priority == Priority.LOW
    assert told(low, AlarmEvent.RAISED, AlarmEvent.ESCALATED).priority == Priority.MEDIUM
    twice = told(low, AlarmEvent.RAISED, AlarmEvent.ESCALATED, AlarmEvent.ESCALATED)
    assert twice.priority == Priority.HIGH
    high = told(C.HEAD_STALLED, AlarmEvent.RAISED, AlarmEvent.ESCALATED)
    assert high.priority == Priority.HIGH


def test_only_an_answer_is_one_and_the_first_counts() -> None:
    again = told(C.HEAD_STALLED, AlarmEvent.RAISED, AlarmEvent.LATCHED, AlarmEvent.RAISED)
    assert again.acknowledged_s is None
    twice = told(
        C.HEAD_STALLED, AlarmEvent.RAISED, AlarmEvent.ACKNOWLEDGED, AlarmEvent.ACKNOWLEDGED
    )
    assert twice.acknowledged_s == 1.0
