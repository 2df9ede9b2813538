import itertools
import json
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from opensuction.kernel.errors import InputError
from opensuction.safety.alarm import alarm_log
from opensuction.safety.alarm.alarm_log import AlarmEvent, Entry, Log
from opensuction.safety.alarm.alarm_state import NOTHING, SILENT
from opensuction.safety.condition import Condition
from opensuction.safety.condition_mask import encode
from tests.safety.annunciator import DT_S, Tick, histories, lasting, run, wrong

C = Condition


def written(history: list[Tick], capacity: int = 10_000) -> Log:
    """Log of a history that begins with power-up at 0 s."""
    log = alarm_log.start(capacity, 0.0)
    for index, row in enumerate(run(history)):
        log = alarm_log.note(log, index * DT_S, row.signals)
    return log


def test_a_latched_alarm_from_its_first_tick_to_its_reset() -> None:
    runaway = wrong(C.HEAD_RUNAWAY)
    history = [
        Tick(),
        runaway,
        runaway._replace(acknowledge=True),
        Tick(),
        Tick(reset=True),
    ]
    assert written(history).entries == (
        Entry(0.0, NOTHING, AlarmEvent.STARTED),
        Entry(0.5, C.HEAD_RUNAWAY, AlarmEvent.RAISED),
        Entry(1.0, C.HEAD_RUNAWAY, AlarmEvent.ACKNOWLEDGED),
        Entry(1.5, C.HEAD_RUNAWAY, AlarmEvent.LATCHED),
        Entry(2.0, C.HEAD_RUNAWAY, AlarmEvent.RESET),
    )


def test_an_alarm_that_ends_by_itself_a_pause_and_an_escalation() -> None:
    stopped = wrong(C.AUTOMATION_STOPPED)
    history = [
        *lasting(stopped, 120.5),
        stopped._replace(audio_pause=True),
        stopped,
        Tick(),
    ]
    assert written(history).entries[1:] == (
        Entry(0.0, C.AUTOMATION_STOPPED, AlarmEvent.RAISED),
        Entry(120.0, C.AUTOMATION_STOPPED, AlarmEvent.ESCALATED),
        Entry(120.5, NOTHING, AlarmEvent.PAUSED),
        Entry(121.5, C.AUTOMATION_STOPPED, AlarmEvent.ENDED),
        Entry(121.5, NOTHING, AlarmEvent.PAUSE_ENDED),
    )


def test_a_latched_alarm_that_begins_again_is_raised_and_not_reset() -> None:
    runaway = wrong(C.HEAD_RUNAWAY)
    events = [entry.event for entry in written([runaway, Tick(), runaway]).entries]
    assert events == [AlarmEvent.STARTED, AlarmEvent.RAISED, AlarmEvent.LATCHED, AlarmEvent.RAISED]


def test_within_a_tick_what_ended_comes_before_what_began() -> None:
    entries = written([wrong(C.SPO2_LOW), wrong(C.HEART_RATE_LOW, C.HEAD_RUNAWAY)]).entries[2:]
    assert entries == (
        Entry(DT_S, C.SPO2_LOW, AlarmEvent.ENDED),
        Entry(DT_S, C.HEAD_RUNAWAY, AlarmEvent.RAISED),
        Entry(DT_S, C.HEART_RATE_LOW, AlarmEvent.RAISED),
    )


def test_nothing_new_writes_nothing() -> None:
    log = written(lasting(wrong(C.SPO2_LOW), 50.0))
    assert len(log.entries) == 2
    assert log.time_s == 49.5
    assert log.lost == 0


@settings(max_examples=30)
@given(history=histories(), capacity=st.integers(1, 20))
def test_a_full_log_keeps_the_newest_and_counts_the_rest(
    history: list[Tick], capacity: int
) -> None:
    whole, short = written(history), written(history, capacity)
    assert len(short.entries) == min(capacity, len(whole.entries))
    assert short.entries == whole.entries[-capacity:]
    assert short.lost == len(whole.entries) - len(short.entries)


@pytest.mark.requirement("OS-R37")
@settings(max_examples=30)
@given(history=histories())
def test_the_log_tells_what_was_present_at_any_time(history: list[Tick]) -> None:
    log = written(history)
    present: set[int] = set()
    entries = iter(log.entries)
    entry = next(entries, None)
    for index, row in enumerate(run(history)):
        while entry is not None and entry.time_s <= index * DT_S:
            if entry.event == AlarmEvent.RAISED:
                present.add(entry.condition)
            elif entry.event in (AlarmEvent.ENDED, AlarmEvent.LATCHED):
                present.remove(entry.condition)
            entry = next(entries, None)
        assert present == row.present
    assert entry is None
    for one, other in itertools.pairwise(log.entries):
        assert (one.time_s, one.event) <= (other.time_s, other.event)


@pytest.mark.requirement("OS-R37")
@settings(max_examples=30)
@given(history=histories())
def test_a_log_survives_storage(history: list[Tick]) -> None:
    log = written(history, capacity=50)
    back = alarm_log.load(json.loads(json.dumps(alarm_log.store(log))))
    assert back._replace(last=log.last) == log


def test_a_log_that_is_just_full_survives_storage() -> None:
    log = written([wrong(C.SPO2_LOW), Tick()], capacity=3)
    assert len(log.entries) == log.capacity
    assert alarm_log.load(alarm_log.store(log)).entries == log.entries


def test_the_last_second_of_a_pause_is_still_a_pause() -> None:
    paused = wrong(C.SPO2_LOW)._replace(audio_pause=True)
    history = [wrong(C.SPO2_LOW), paused, *lasting(wrong(C.SPO2_LOW), 130.0)]
    assert written(history).entries[-1] == Entry(120.5, NOTHING, AlarmEvent.PAUSE_ENDED)


def test_after_power_up_what_still_holds_is_raised_once_more() -> None:
    log = alarm_log.load(alarm_log.store(written([wrong(C.SPO2_LOW)])))
    log = alarm_log.restart(log, 30.0)
    again = SILENT._replace(present=encode({C.SPO2_LOW}))
    log = alarm_log.note(log, 31.0, again)
    assert log.entries[-2:] == (
        Entry(30.0, NOTHING, AlarmEvent.STARTED),
        Entry(31.0, C.SPO2_LOW, AlarmEvent.RAISED),
    )


def test_a_power_up_forgets_the_signals_of_before() -> None:
    log = alarm_log.restart(written([wrong(C.SPO2_LOW)]), 30.0)
    assert log.last == SILENT
    assert log.time_s == 30.0


@pytest.mark.parametrize("time_s", [0.9, float("nan")])
def test_time_does_not_run_backwards(time_s: float) -> None:
    log = alarm_log.note(alarm_log.start(5, 0.0), 1.0, SILENT)
    assert alarm_log.note(log, 1.0, SILENT).time_s == 1.0
    with pytest.raises(ValueError, match="cannot go on"):
        alarm_log.note(log, time_s, SILENT)
    with pytest.raises(ValueError, match="cannot go on"):
        alarm_log.restart(log, time_s)


@pytest.mark.parametrize("capacity", [0, -3])
def test_a_log_without_room_is_refused(capacity: int) -> None:
    with pytest.raises(InputError, match=f"capacity is {capacity} entries; it must be at least 1"):
        alarm_log.start(capacity, 0.0)
    assert alarm_log.start(1, 0.0).capacity == 1


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"version": 2}, "version is 2; this software reads 1"),
        ({"version": None}, "version is None"),
        ({"entries": [[0.0, int(C.SPO2_LOW), "BURNT"]]}, "cannot be read"),
        ({"entries": [[0.0, int(C.SPO2_LOW)]]}, "cannot be read"),
        ({"capacity": "many"}, "cannot be read"),
        (
            {"entries": [[1.0, int(C.SPO2_LOW), "RAISED"], [0.5, int(C.SPO2_LOW), "ENDED"]]},
            "out of order",
        ),
        ({"time_s": -1.0}, "out of order"),
        ({"lost": -1}, "holds 2 of 10 entries and has lost -1"),
        ({"capacity": 1}, "holds 2 of 1 entries"),
    ],
)
def test_a_damaged_log_is_refused_in_one_line(change: dict[str, Any], message: str) -> None:
    data = {**alarm_log.store(written([wrong(C.SPO2_LOW)], capacity=10)), **change}
    with pytest.raises(InputError, match=message) as refused:
        alarm_log.load(data)
    assert "\n" not in str(refused.value)


def test_a_log_without_a_field_is_refused() -> None:
    data = alarm_log.store(written([Tick()]))
    del data["lost"]
    with pytest.raises(InputError, match="lost"):
        alarm_log.load(data)


def test_numbers_of_stored_events_keep_their_meaning() -> None:
    assert [event.name for event in AlarmEvent] == [
        "STARTED",
        "ENDED",
        "LATCHED",
        "RESET",
        "RAISED",
        "ESCALATED",
        "ACKNOWLEDGED",
        "PAUSED",
        "PAUSE_ENDED",
    ]
    assert [int(event) for event in AlarmEvent] == list(range(9))
