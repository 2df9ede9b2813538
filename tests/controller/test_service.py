"""Catheter change, catheter life and schedule on the twin."""

import numpy as np
import pytest

from opensuction.control.compensation import CompensationKind
from opensuction.controller import controller
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle import interlocks
from opensuction.procedure.cycle.interlocks import LIFE_S
from opensuction.procedure.cycle.lock_out import Refusal
from opensuction.procedure.cycle.schedule import ScheduleMode
from tests.controller.drive import (
    CHANGED,
    NOT_NEEDED,
    RESET,
    RETURN_TO_SERVICE,
    SERVICE,
    START,
    Fault,
    at_rest,
    during,
    phases,
    simulate,
)
from tests.controller.invariant import assert_held
from tests.controller.used_machine import aged, clocked

EXACT = CompensationKind.EXACT_INVERSE


@pytest.mark.requirement("OS-R22")
@pytest.mark.parametrize("left_s", [-1.0, 0.0, 20.0])
def test_a_catheter_at_its_end_starts_nothing_until_it_is_changed(left_s: float) -> None:
    buttons = {0.0: START, 1.0: SERVICE, 2.0: START, 2.5: CHANGED}
    buttons |= {3.0: RETURN_TO_SERVICE, 3.5: START}
    state, columns = simulate(EXACT, 4.0, buttons, start=aged(at_rest(EXACT)[1], LIFE_S - left_s))
    assert phases(columns) == [
        Phase.PARKED,
        Phase.OUT_OF_SERVICE,
        Phase.PARKED,
        Phase.CHECKING,
    ]
    assert state.controller.core.upkeep.catheter_age_s == pytest.approx(1.5, abs=0.01)
    assert state.controller.core.upkeep.refusal == Refusal.NONE


def test_out_of_service_everything_is_off_whatever_breaks() -> None:
    for fault in (Fault.HEAD_NAN, Fault.CONTACT_CLOSED, Fault.VACUUM_HIGH, Fault.OVERRUN):
        buttons = {0.0: SERVICE, 1.0: START, 5.0: RETURN_TO_SERVICE, 6.0: START}
        state, columns = simulate(EXACT, 7.0, buttons, during(fault, 0.5, 4.0))
        serviced = columns["phase"] == Phase.OUT_OF_SERVICE
        for name in ("insertion_on", "insertion_v", "valve_on", "valve_v", "pump_on"):
            assert not columns[f"commands.{name}"][serviced].any(), name
        assert np.ptp(columns["truth.head_mm"][serviced]) < 0.01
        # A person has ended it: what tripped meanwhile is acknowledged.
        assert phases(columns) == [Phase.OUT_OF_SERVICE, Phase.PARKED, Phase.CHECKING]
        assert state.controller.core.upkeep.refusal == Refusal.NONE


def test_service_begins_only_with_the_tip_out() -> None:
    _, columns = simulate(EXACT, 20.0, {0.0: START, 12.0: SERVICE})
    assert Phase.OUT_OF_SERVICE not in phases(columns)


def test_a_timed_cycle_begins_by_itself_and_the_next_an_interval_later() -> None:
    loop, start = clocked(at_rest(EXACT), ScheduleMode.TIMED, 3598.0)
    state, columns = simulate(EXACT, 50.0, {}, start=start, loop=loop)
    assert phases(columns)[:2] == [Phase.PARKED, Phase.CHECKING]
    assert phases(columns)[-2:] == [Phase.CLOSING, Phase.PARKED]
    assert columns["time_s"][np.argmax(columns["phase"] == Phase.CHECKING)] == pytest.approx(
        2.0, abs=0.01
    )
    assert state.controller.core.upkeep.schedule.since_cycle_s == pytest.approx(48.0, abs=0.01)
    assert_held(columns, loop)


def test_the_clock_starts_nothing_halted_out_of_service_or_with_a_spent_catheter() -> None:
    loop, start = clocked(at_rest(EXACT), ScheduleMode.TIMED, 3601.0)
    spent = start.controller.core.upkeep._replace(catheter_age_s=LIFE_S)
    old = start._replace(controller=controller.with_upkeep(start.controller, spent))
    state, columns = simulate(EXACT, 1.0, {}, start=old, loop=loop)
    assert phases(columns) == [Phase.PARKED]
    assert state.controller.core.upkeep.refusal == Refusal.CATHETER_LIFE_OVER
    _, columns = simulate(EXACT, 20.0, {0.0: SERVICE, 9.0: RETURN_TO_SERVICE}, start=start)
    # Without the schedule of the loop: a request for service comes before any clock.
    assert phases(columns) == [Phase.OUT_OF_SERVICE, Phase.PARKED]
    broken = during(Fault.CONTACT_CLOSED, 0.0, 8.0)
    _, columns = simulate(EXACT, 20.0, {15.0: RESET}, broken, start=start, loop=loop)
    assert phases(columns)[-2:] == [Phase.HALTED, Phase.PARKED]


def test_a_prompt_waits_for_a_person() -> None:
    loop, start = clocked(at_rest(EXACT), ScheduleMode.PROMPT, 3601.0)
    state, columns = simulate(EXACT, 2.0, {}, start=start, loop=loop)
    assert phases(columns) == [Phase.PARKED]
    service, kept = loop.controller.service, state.controller.core.upkeep
    assert interlocks.is_prompting(service, kept, int(Phase.PARKED))
    state, _ = simulate(EXACT, 1.0, {0.5: NOT_NEEDED}, start=state, loop=loop)
    assert not interlocks.is_prompting(service, state.controller.core.upkeep, int(Phase.PARKED))
