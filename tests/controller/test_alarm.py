"""Alarms of the whole controller on the twin: what people are told, and what they can do about it.

The fault is a head encoder that fails on the way in: a high alarm that ends with a reset.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from opensuction.control.compensation import CompensationKind
from opensuction.controller import controller
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle import schedule
from opensuction.procedure.cycle.interlocks import LIFE_S
from opensuction.procedure.cycle.schedule import ScheduleMode, ScheduleState
from opensuction.safety import condition_mask
from opensuction.safety.alarm.alarm_log import Episode, list_episodes
from opensuction.safety.alarm.alarm_state import LONGEST_PAUSE_S
from opensuction.safety.condition import Condition
from opensuction.safety.condition_mask import decode
from opensuction.safety.handling import Priority
from opensuction.simulation import outcome, trace
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.trace import Columns
from opensuction.twin import preset
from tests.controller.drive import (
    ABORT,
    ACKNOWLEDGE,
    AUDIO_PAUSE,
    CHANGED,
    RESET,
    RETURN_TO_SERVICE,
    SERVICE,
    START,
    Fault,
    at_rest,
    during,
    phases,
    rig,
    simulate,
)
from tests.controller.used_machine import aged

C = Condition
EXACT = CompensationKind.EXACT_INVERSE
FAULT_S = 9.0
ENDED_S = 20.0
BROKEN = during(Fault.HEAD_NAN, FAULT_S, ENDED_S)


def masks(columns: Columns, name: str) -> NDArray[np.int64]:
    return columns[name].astype(np.int64)


def told(columns: Columns) -> list[Episode]:
    """Alarms of a run."""
    return list(list_episodes(outcome.log(columns)))


def conditions(columns: Columns) -> set[Condition]:
    return {Condition(alarm.condition) for alarm in told(columns)}


def between(columns: Columns, name: str, from_s: float, to_s: float) -> NDArray[np.float64]:
    return columns[name][round(from_s / DT_S) : round(to_s / DT_S)]


def assert_trips_are_alarms(columns: Columns) -> None:
    """Every trip is a present alarm in its own tick, but for what planned work brings about."""
    trips, present = masks(columns, "verdict.trips"), masks(columns, "signals.present")
    serviced = columns["phase"] == Phase.OUT_OF_SERVICE
    meant = np.where(serviced, trips & ~np.int64(condition_mask.PLANNED), trips)
    np.testing.assert_array_equal(present & meant, meant)


def assert_heard(columns: Columns) -> None:
    """What is high and not acknowledged sounds as high, unless an audio pause runs."""
    shown = masks(columns, "signals.present") | masks(columns, "signals.latched")
    unanswered = shown & ~masks(columns, "signals.acknowledged")
    urgent = unanswered & np.int64(condition_mask.HIGHS) != 0
    paused = columns["signals.pause_left_s"] > 0.0
    assert np.all(columns["signals.audible"][urgent & ~paused] == Priority.HIGH)
    assert np.all(columns["signals.priority"][shown != 0] > Priority.NONE)
    assert columns["signals.pause_left_s"].max() <= LONGEST_PAUSE_S


@pytest.mark.parametrize("kind", CompensationKind)
def test_a_healthy_cycle_raises_none(kind: CompensationKind) -> None:
    _, columns = simulate(kind, 50.0, {0.0: START})
    assert phases(columns)[-1] == Phase.PARKED
    assert told(columns) == []
    assert not columns["signals.priority"].any()


@pytest.mark.parametrize(
    ("fault", "start_s"),
    [
        (Fault.HEAD_FLAGGED, 9.0),
        (Fault.HEAD_FROZEN, 12.0),
        (Fault.CAM_NAN, 18.0),
        (Fault.VACUUM_HIGH, 21.0),
        (Fault.CONTACT_FLAGGED, 9.0),
        (Fault.OVERRUN, 21.0),
        (Fault.DRIVE_INWARDS, 9.0),
    ],
)
def test_a_trip_is_an_alarm_in_the_same_tick(fault: Fault, start_s: float) -> None:
    _, columns = simulate(EXACT, 40.0, {0.0: START}, during(fault, start_s, 1e6))
    tripped = masks(columns, "verdict.trips")
    assert tripped.any()
    first = int(np.argmax(tripped != 0))
    assert decode(int(masks(columns, "signals.present")[first])) == decode(int(tripped[first]))
    assert columns["signals.audible"][first] >= Priority.MEDIUM
    assert C.AUTOMATION_STOPPED in conditions(columns)
    assert_trips_are_alarms(columns)
    assert_heard(columns)


@pytest.mark.parametrize(
    ("fault", "start_s", "meant"),
    [
        (Fault.CONTACT_CLOSED, 0.0, {C.CHECK_FAILED, C.CONTACT_STUCK_CLOSED}),
        # A cam that does not move is a trip before the item's time is up.
        (Fault.VALVE_OPEN, 0.0, {C.VALVE_STUCK_CLOSED}),
        (Fault.VALVE_OPEN, 2.7, {C.VALVE_STUCK_OPEN}),
        (Fault.PUMP_DEAD, 0.0, {C.CHECK_FAILED, C.VACUUM_LOST}),
    ],
)
def test_a_failed_check_says_what_it_found(
    fault: Fault, start_s: float, meant: set[Condition]
) -> None:
    _, columns = simulate(EXACT, 30.0, {0.0: START, 28.0: RESET}, during(fault, start_s, 27.0))
    own = {code for code in conditions(columns) if code >= C.AUTOMATION_STOPPED}
    assert own == {C.AUTOMATION_STOPPED} | meant
    assert phases(columns)[-1] == Phase.PARKED
    assert all(alarm.ended_s == pytest.approx(28.0) for alarm in told(columns))
    assert columns["signals.priority"][-1] == Priority.NONE


def test_a_reset_ends_the_alarms_of_what_is_over() -> None:
    buttons = {0.0: START, 10.0: RESET, 30.0: RESET, 50.0: RESET}
    _, columns = simulate(EXACT, 52.0, buttons, BROKEN)
    assert phases(columns)[-1] == Phase.PARKED
    # Pressed while the encoder is still broken, it trips again at once.
    assert between(columns, "signals.priority", 9.1, 29.9).min() == Priority.HIGH
    assert C.HEAD_READING_INVALID in conditions(columns)
    assert columns["signals.priority"][-1] == Priority.NONE
    assert not columns["signals.latched"][-1]
    assert_trips_are_alarms(columns)
    assert_heard(columns)


def test_acknowledged_is_silent_with_a_reminder_and_stays_visible() -> None:
    _, columns = simulate(EXACT, 160.0, {0.0: START, 15.0: ACKNOWLEDGE}, BROKEN)
    assert between(columns, "signals.audible", FAULT_S + 0.1, 15.0).min() == Priority.HIGH
    assert not between(columns, "signals.audible", 15.0, 160.0).any()
    assert between(columns, "signals.priority", 15.0, 160.0).min() == Priority.HIGH
    reminded_s = columns["time_s"][columns["signals.reminder"] > 0.0]
    assert reminded_s == pytest.approx([75.0, 135.0], abs=0.01)
    answered = [alarm.acknowledged_s for alarm in told(columns)]
    assert answered == pytest.approx([15.0] * len(answered))


def test_an_audio_pause_lasts_120_s_whoever_presses_what_else() -> None:
    buttons = {0.0: START, 15.0: AUDIO_PAUSE, 60.0: START, 61.0: ABORT, 62.0: CHANGED}
    _, columns = simulate(EXACT, 150.0, buttons, BROKEN)
    silent_s = columns["time_s"][(columns["signals.audible"] == 0.0) & (columns["time_s"] > 10.0)]
    assert silent_s[0] == pytest.approx(15.0)
    assert silent_s[-1] == pytest.approx(15.0 + LONGEST_PAUSE_S, abs=0.01)
    assert between(columns, "signals.priority", 15.0, 150.0).min() == Priority.HIGH
    assert_heard(columns)


def test_a_persons_abort_is_no_alarm() -> None:
    _, columns = simulate(EXACT, 25.0, {0.0: START, 15.0: ABORT})
    assert phases(columns)[-2:] == [Phase.ABORTING, Phase.HALTED]
    assert told(columns) == []


def test_a_cycle_that_is_due_after_an_abort_is_missed_aloud() -> None:
    loop, start = at_rest(EXACT)
    hourly = schedule.schedule(ScheduleMode.TIMED, 3600.0)
    service = loop.controller.service._replace(schedule=hourly)
    timed = loop._replace(controller=loop.controller._replace(service=service))
    aborted, columns = simulate(EXACT, 25.0, {0.0: START, 15.0: ABORT}, start=start, loop=timed)
    assert told(columns) == []
    kept = aborted.controller.core.upkeep._replace(schedule=ScheduleState(3599.0, 3599.0))
    later = aborted._replace(controller=controller.with_upkeep(aborted.controller, kept))
    _, columns = simulate(EXACT, 2.0, {1.5: RESET}, start=later, loop=timed)
    assert [(alarm.condition, alarm.priority) for alarm in told(columns)] == [
        (C.AUTOMATION_STOPPED, Priority.MEDIUM)
    ]
    assert told(columns)[0].started_s == pytest.approx(1.0, abs=0.01)
    assert told(columns)[0].ended_s == pytest.approx(1.5, abs=0.01)


def test_planned_work_raises_none_and_returning_to_service_clears_what_was_left() -> None:
    for fault in (Fault.HEAD_NAN, Fault.CAM_NAN, Fault.CONTACT_FLAGGED, Fault.VACUUM_FLAGGED):
        buttons = {0.0: SERVICE, 5.0: CHANGED, 6.0: RETURN_TO_SERVICE}
        _, columns = simulate(
            EXACT, 7.0, buttons, during(fault, 0.5, 5.5), start=aged(at_rest(EXACT)[1], LIFE_S)
        )
        assert columns["verdict.trips"].any()
        assert told(columns) == [], fault


def test_what_a_person_left_sounding_waits_latched_until_the_work_is_done() -> None:
    buttons = {0.0: START, 25.0: SERVICE, 30.0: RETURN_TO_SERVICE}
    broken = during(Fault.CAM_NAN, 3.0, 27.0)
    _, columns = simulate(EXACT, 31.0, buttons, broken)
    assert phases(columns)[-3:] == [Phase.HALTED, Phase.OUT_OF_SERVICE, Phase.PARKED]
    alarms = {C(alarm.condition): alarm for alarm in told(columns)}
    assert alarms[C.CAM_READING_INVALID].latched
    assert alarms[C.CAM_READING_INVALID].ended_s == pytest.approx(30.0)
    assert alarms[C.AUTOMATION_STOPPED].ended_s == pytest.approx(25.0)


def test_a_spent_catheter_is_an_alarm_until_it_is_changed() -> None:
    buttons = {2.0: SERVICE, 3.0: CHANGED, 4.0: RETURN_TO_SERVICE}
    _, columns = simulate(EXACT, 5.0, buttons, start=aged(at_rest(EXACT)[1], LIFE_S - 1.0))
    alarms = told(columns)
    assert [alarm.condition for alarm in alarms] == [C.CATHETER_LIFE_ENDING, C.CATHETER_LIFE_OVER]
    assert [alarm.started_s for alarm in alarms] == pytest.approx([0.0, 1.0], abs=0.01)
    assert alarms[1].ended_s == pytest.approx(2.0)


def test_power_up_away_from_home_needs_a_recovery_aloud() -> None:
    loop, _ = at_rest(EXACT)
    inside = preset.park(rig().machine, rig().values, 60.0, seed=1, run=2)
    start = trace.power_up(loop, inside, 0.0)
    _, columns = simulate(EXACT, 1.0, {}, start=start)
    assert [alarm.condition for alarm in told(columns)] == [C.RECOVERY_NEEDED]
    assert columns["signals.audible"].min() == Priority.HIGH


BUTTONS = (START, ABORT, RESET, SERVICE, RETURN_TO_SERVICE, ACKNOWLEDGE, AUDIO_PAUSE)


@settings(max_examples=15)
@given(
    fault=st.sampled_from([f for f in Fault if f != Fault.NONE]),
    start_s=st.floats(0.0, 35.0),
    lasts_s=st.sampled_from((0.01, 1.0, 20.0, 200.0)),
    pressed=st.dictionaries(st.floats(0.0, 59.0), st.sampled_from(BUTTONS), max_size=12),
)
def test_no_button_silences_a_high_alarm_but_acknowledge_and_a_pause(
    fault: Fault, start_s: float, lasts_s: float, pressed: dict[float, int]
) -> None:
    when = during(fault, start_s, start_s + lasts_s)
    _, columns = simulate(EXACT, 60.0, {0.0: START} | pressed, when)
    assert_trips_are_alarms(columns)
    assert_heard(columns)
