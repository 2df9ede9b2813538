"""The pre-use test on the twin: what is broken is named before anything enters the patient."""

import numpy as np
import pytest

from opensuction.control.compensation import CompensationKind
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle.check import ORDER, CheckItem
from opensuction.procedure.cycle.transition import Event
from opensuction.safety.condition import Condition
from opensuction.simulation.trace import Columns, phase_spans
from tests.controller.drive import (
    ABORT,
    RESET,
    START,
    Fault,
    at_rest,
    during,
    phases,
    simulate,
)
from tests.controller.invariant import assert_held, trips

EXACT = CompensationKind.EXACT_INVERSE


def failed(columns: Columns) -> CheckItem:
    """The item that failed; nothing went on."""
    assert phases(columns) == [Phase.CHECKING, Phase.ABORTING, Phase.HALTED]
    return CheckItem(int(columns["check_failed"][-1]))


def cause(columns: Columns) -> Event:
    return Event(int(columns["cause"][np.argmax(columns["phase"] == Phase.ABORTING)]))


@pytest.mark.parametrize("kind", CompensationKind)
def test_the_check_moves_no_tip_and_draws_nothing(kind: CompensationKind) -> None:
    loop, _ = at_rest(kind)
    _, columns = simulate(kind, 9.0, {0.0: START})
    testing = columns["phase"] == Phase.CHECKING
    items = columns["check_item"][testing]
    assert [CheckItem(int(i)) for i in dict.fromkeys(items) if i] == list(ORDER)
    assert np.ptp(columns["truth.tip_mm"][testing]) < 0.01
    assert columns["truth.tip_vacuum_mmhg"][testing].max() == 0.0
    head = columns["readings.head_mm"][testing]
    assert head.max() - head[0] == pytest.approx(loop.controller.plan.check.jog_mm, abs=0.25)
    assert columns["truth.valve_open_ratio"][testing].max() > 0.9
    span = phase_spans(columns)[0]
    assert 5.2 < span.end_s - span.start_s < 6.2  # a stroke of 2 s, and the spring's


@pytest.mark.requirement("OS-R20")
@pytest.mark.parametrize(
    ("fault", "start_s", "item"),
    [
        (Fault.CONTACT_CLOSED, 0.0, CheckItem.CONTACT_OPEN),
        (Fault.VALVE_OPEN, 0.0, CheckItem.VALVE_OPENS),
        (Fault.VALVE_OPEN, 2.0, CheckItem.VALVE_OPENS),
        (Fault.CAM_FROZEN, 0.5, CheckItem.VALVE_OPENS),
        (Fault.VALVE_OPEN, 2.7, CheckItem.VALVE_CLOSES),
        (Fault.PUMP_DEAD, 0.0, CheckItem.VACUUM_BUILDS),
    ],
    ids=lambda value: getattr(value, "name", value),
)
def test_what_is_broken_is_named(fault: Fault, start_s: float, item: CheckItem) -> None:
    loop, _ = at_rest(EXACT)
    # A valve that cannot close keeps the abort waiting until that is overdue.
    _, columns = simulate(EXACT, 40.0, {0.0: START}, during(fault, start_s))
    assert failed(columns) == item
    # Nobody mends it: the governor notices a closed contact later, and a cam that stands at once.
    seen = trips(columns)
    cam = {
        Condition.VALVE_STUCK_OPEN,
        Condition.VALVE_STUCK_CLOSED,
        Condition.NEGATIVE_PRESSURE_TIME,
    }
    assert cause(columns) == (Event.TRIPPED if seen & cam else Event.CHECK_FAILED)
    assert seen <= {Condition.CONTACT_TIME} | cam
    assert_held(columns, loop, fault)


@pytest.mark.parametrize("fault", [Fault.HEAD_JAMMED, Fault.HEAD_FROZEN])
def test_a_motor_that_does_not_answer_is_named_by_the_item_it_broke_off(fault: Fault) -> None:
    _, columns = simulate(EXACT, 20.0, {0.0: START}, during(fault, 0.1))
    assert failed(columns) == CheckItem.HEAD_ADVANCES
    assert cause(columns) == Event.TRIPPED


@pytest.mark.requirement("OS-R20")
@pytest.mark.parametrize("times", [2.0, 4.0])
def test_a_leak_is_found_from_twice_what_a_sound_line_loses(times: float) -> None:
    loop, start = at_rest(EXACT)
    line = loop.machine.line
    leak = times * 1.5 * line.leak_ml_per_s_per_mmhg
    leaking = loop._replace(
        machine=loop.machine._replace(line=line._replace(leak_ml_per_s_per_mmhg=leak))
    )
    _, columns = simulate(EXACT, 20.0, {0.0: START}, start=start, loop=leaking)
    assert failed(columns) == CheckItem.VACUUM_HOLDS


@pytest.mark.requirement("OS-R20")
def test_the_valve_closes_by_its_spring_alone_and_one_without_is_found() -> None:
    loop, start = at_rest(EXACT)
    _, sound = simulate(EXACT, 9.0, {0.0: START})
    closing = sound["check_item"] == CheckItem.VALVE_CLOSES
    assert not sound["commands.valve_on"][closing].any()
    assert sound["truth.valve_open_ratio"][closing][0] > 0.9
    assert sound["truth.valve_open_ratio"][closing][-1] == 0.0
    valve = loop.machine.valve._replace(spring_preload_v=0.0, spring_v_per_rad=0.0)
    broken = loop._replace(machine=loop.machine._replace(valve=valve))
    _, columns = simulate(EXACT, 40.0, {0.0: START}, start=start, loop=broken)
    assert failed(columns) == CheckItem.VALVE_CLOSES
    assert Phase.PRELOADING not in phases(columns)


def test_a_stop_is_no_failure_and_the_next_test_begins_anew() -> None:
    _, columns = simulate(EXACT, 30.0, {0.0: START, 3.0: ABORT, 10.0: RESET, 11.0: START})
    assert not columns["check_failed"].any()
    assert phases(columns)[:5] == [
        Phase.CHECKING,
        Phase.ABORTING,
        Phase.HALTED,
        Phase.PARKED,
        Phase.CHECKING,
    ]
    assert Phase.PRELOADING in phases(columns)


def test_what_failed_stays_named_until_the_next_test() -> None:
    buttons = {0.0: START, 12.0: RESET, 13.0: START}
    _, columns = simulate(EXACT, 25.0, buttons, during(Fault.PUMP_DEAD, 0.0, 12.0))
    named = columns["check_failed"]
    assert named[11_900] == named[12_900] == CheckItem.VACUUM_BUILDS
    assert named[13_100] == CheckItem.NONE
    assert Phase.PRELOADING in phases(columns)
