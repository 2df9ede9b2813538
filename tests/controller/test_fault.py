"""One thing breaks in a running cycle: what notices, how soon, and where it ends.

Faults begin at several instants of the cycle (6.1 preload, 6.6 to 16 insertion, 17 valve opening,
20 suction, 25.1 gap of the way back, 26 to 35 withdrawal) and last until 51 s; then people reset
twice and start again.
"""

from typing import Any

import numpy as np
import pytest

from opensuction.control.compensation import CompensationKind
from opensuction.kernel.vocabulary import Phase
from opensuction.safety.condition import Condition
from opensuction.simulation.trace import Columns
from tests.controller.drive import (
    RESET,
    START,
    Fault,
    at_rest,
    during,
    phases,
    simulate,
)
from tests.controller.invariant import assert_held, trip_s, trips

EXACT = CompensationKind.EXACT_INVERSE
INSTANTS = (6.1, 6.25, 8.1, 16.1, 17.1, 20.1, 25.1, 26.1, 35.1)
ENDED_S = 51.0

BETWEEN = (8.1, 20.1, 26.1)
"""In the midst of a phase: for the long runs."""

at_any_time = pytest.mark.parametrize(
    "start_s",
    [pytest.param(one, marks=pytest.mark.soak if one in BETWEEN else ()) for one in INSTANTS],
)
WAYS = [
    *((EXACT, start_s) for start_s in INSTANTS),
    *((CompensationKind.NONE, start_s) for start_s in (9.7, 29.7)),
    *((CompensationKind.DIRECT_INVERSE, start_s) for start_s in (9.7, 24.3)),
]
every_way = pytest.mark.parametrize(("kind", "start_s"), WAYS)


def cycle(fault: Fault, start_s: float, kind: CompensationKind = EXACT) -> Columns:
    """A cycle with a fault, resets at 52 and 68 s, and a start at 69 s."""
    buttons = {0.0: START, 52.0: RESET, 68.0: RESET, 69.0: START}
    return simulate(kind, 109.0, buttons, during(fault, start_s, ENDED_S))[1]


def at(columns: Columns, time_s: float, name: str) -> float:
    """A column at an instant."""
    return float(columns[name][round(time_s * 1000.0)])


def is_out(columns: Columns, time_s: float) -> bool:
    """Whether the tip is where it was before the cycle, but for creep and settling."""
    return at(columns, time_s, "truth.tip_mm") < float(columns["truth.tip_mm"][0]) + 0.6


def assert_recovers(columns: Columns) -> None:
    """With the cause gone, resets park it and another cycle completes."""
    end = phases(columns)[-8:]
    assert end[0] == Phase.CHECKING
    assert end[-2:] == [Phase.CLOSING, Phase.PARKED]


def assert_withdrawn(columns: Columns, trip_at_s: float) -> None:
    """From the trip on the tip only comes out, and is out in time, with the valve closed."""
    # 90 mm and the gap at 17 mm/s.
    assert is_out(columns, trip_at_s + 8.0)
    # Where suction may go on until then the valve closes afterwards.
    suction = Condition.CONTACT_READING_INVALID in trips(columns)
    assert at(columns, trip_at_s + (10.0 if suction else 2.5), "truth.valve_open_ratio") == 0.0
    after = (columns["time_s"] > trip_at_s + 0.1) & (columns["time_s"] < ENDED_S)
    assert np.diff(columns["truth.tip_mm"][after]).max() < 1e-3  # creep
    assert suction or not columns["commands.pump_on"][after].any()


SEEN_AT_ONCE = {
    Fault.CAM_FLAGGED: (Condition.CAM_READING_INVALID, 0.004),
    Fault.CAM_NAN: (Condition.CAM_READING_INVALID, 0.004),
    Fault.VACUUM_FLAGGED: (Condition.VACUUM_READING_INVALID, 0.004),
    Fault.VACUUM_HIGH: (Condition.VACUUM_EXCEEDED, 0.203),  # and the filter
    Fault.CONTACT_FLAGGED: (Condition.CONTACT_READING_INVALID, 0.004),
    Fault.CONTACT_CLOSED: (Condition.CONTACT_TIME, 2.0),
    Fault.CONTACT_BOUNCING: (Condition.CONTACT_TIME, 2.0),
    Fault.OVERRUN: (Condition.LATE_TICKS, 0.004),
}
"""Faults that are answered by a withdrawal, the trip and how long it takes (s)."""
FOLLOWED_BY = {
    Fault.CAM_FLAGGED: Condition.NEGATIVE_PRESSURE_TIME,  # an unreadable valve counts as open
    Fault.CAM_NAN: Condition.NEGATIVE_PRESSURE_TIME,
    Fault.VACUUM_HIGH: Condition.PUMP_RUNAWAY,  # 400 mmHg that stay with the pump off
    Fault.CONTACT_FLAGGED: Condition.TIP_DETACHED,  # its line may have gone with the tip
    Fault.CONTACT_CLOSED: Condition.CONTACT_STUCK_CLOSED,  # closed well before where it closed
    Fault.CONTACT_BOUNCING: Condition.CONTACT_STUCK_CLOSED,
}
"""What may be seen later of the same fault, while the withdrawal goes on."""


def ways_of_faults() -> list[Any]:
    """Every third way of each fault in turn; the others are for the long runs."""
    return [
        pytest.param(
            fault,
            kind,
            start_s,
            marks=() if (i + j) % 3 == 0 else pytest.mark.soak,
            id=f"{fault.name}-{kind.name}-{start_s}",
        )
        for i, fault in enumerate(SEEN_AT_ONCE)
        for j, (kind, start_s) in enumerate(WAYS)
    ]


@pytest.mark.parametrize(("fault", "kind", "start_s"), ways_of_faults())
def test_what_is_seen_is_withdrawn_from(
    fault: Fault, kind: CompensationKind, start_s: float
) -> None:
    code, detection_s = SEEN_AT_ONCE[fault]
    columns = cycle(fault, start_s, kind)
    follows = FOLLOWED_BY.get(fault, code)
    first = code if code in trips(columns) else follows
    noticed_s = trip_s(columns, first)
    if first == code:
        assert noticed_s == pytest.approx(start_s + detection_s, abs=0.0035)
    else:
        # On the way out a switch that is stuck gives itself away no later than by its time.
        assert first == Condition.CONTACT_STUCK_CLOSED
        assert start_s > 24.7
        assert start_s < noticed_s <= start_s + detection_s + 0.0035
    assert trips(columns) <= {first, follows}
    assert trip_s(columns, first) == min(trip_s(columns, seen) for seen in trips(columns))
    assert_held(columns, at_rest(kind)[0], fault)
    assert_withdrawn(columns, noticed_s)
    assert_recovers(columns)


@at_any_time
def test_a_head_that_cannot_be_seen_is_drawn_out_and_then_let_go(start_s: float) -> None:
    fault = Fault.HEAD_BLIND
    columns = cycle(fault, start_s)
    assert trip_s(columns, Condition.HEAD_READING_INVALID) == pytest.approx(
        start_s + 0.004, abs=1e-6
    )
    assert_held(columns, at_rest(EXACT)[0], fault)
    # 112 mm at 17 mm/s and 0.5 s; a head that was parked need not move.
    limits = at_rest(EXACT)[0].controller.limits
    way_s = max(at(columns, start_s - 0.001, "readings.head_mm") - limits.park_head_mm, 0.0) / 17.0
    still = (columns["time_s"] > start_s + way_s + 1.5) & (columns["time_s"] < ENDED_S)
    assert is_out(columns, start_s + way_s + 1.5)
    assert np.ptp(columns["truth.head_mm"][still]) == 0.0
    if way_s > 0.1:
        assert Condition.WITHDRAWAL_UNSEEN in trips(columns)
        assert not columns["commands.insertion_on"][still].any()
    closed = still & (columns["time_s"] > start_s + 2.5)  # a stroke takes 2 s
    assert columns["truth.valve_open_ratio"][closed].max() == 0.0
    assert columns["truth.tip_vacuum_mmhg"][closed].max() == 0.0
    assert_recovers(columns)


@pytest.mark.parametrize(
    ("fault", "start_s"),
    [
        pytest.param(
            fault,
            start_s,
            marks=() if (i + j) % 2 == 0 else pytest.mark.soak,
            id=f"{fault.name}-{start_s}",
        )
        for i, fault in enumerate((Fault.HEAD_FLAGGED, Fault.HEAD_NAN))
        for j, start_s in enumerate(INSTANTS)
    ],
)
def test_without_its_encoder_the_head_comes_out_by_the_other_sensor(
    fault: Fault, start_s: float
) -> None:
    columns = cycle(fault, start_s)
    lost_s = trip_s(columns, Condition.HEAD_READING_INVALID)
    assert lost_s == pytest.approx(start_s + 0.004, abs=1e-6)
    assert_held(columns, at_rest(EXACT)[0], fault)
    assert_withdrawn(columns, lost_s)
    assert Condition.WITHDRAWAL_UNSEEN not in trips(columns)
    assert Condition.HEAD_RUNAWAY not in trips(columns)
    # Home within what the other sensor tells, and there it stays.
    home = (columns["time_s"] > lost_s + 9.0) & (columns["time_s"] < ENDED_S)
    park_mm = at_rest(EXACT)[0].controller.limits.park_head_mm
    assert np.abs(columns["truth.head_mm"][home] - park_mm).max() < 0.6
    assert_recovers(columns)


@pytest.mark.requirement("OS-R02")
@every_way
def test_a_frozen_encoder_never_takes_the_tip_past_its_cap(
    kind: CompensationKind, start_s: float
) -> None:
    columns = cycle(Fault.HEAD_FROZEN, start_s, kind)
    assert_held(columns, at_rest(kind)[0], Fault.HEAD_FROZEN)
    # It stands still, or it is no longer where the other sensor is: whichever comes first.
    signs = trips(columns) & {Condition.HEAD_STALLED, Condition.HEAD_SENSORS_DISAGREE}
    noticed_s = min(trip_s(columns, code) for code in signs)
    moving = at(columns, start_s - 0.01, "commands.head_mm") != at(
        columns, start_s, "commands.head_mm"
    )
    if moving:
        # At 9 mm/s 0.11 mm of distance, the settling of a slow profile, and 0.1 s.
        assert noticed_s - start_s < 0.25
    # Unseen the head has gone on: by half a millimetre, or what the servo's last error drives.
    assert is_out(columns, noticed_s + 8.0)
    assert at(columns, noticed_s + 8.0, "truth.valve_open_ratio") == 0.0


@pytest.mark.requirement("OS-R09")
@at_any_time
def test_a_jam_is_noticed_when_the_head_should_move_and_let_go_in_the_end(start_s: float) -> None:
    columns = cycle(Fault.HEAD_JAMMED, start_s)
    assert_held(columns, at_rest(EXACT)[0], Fault.HEAD_JAMMED)
    noticed_s = trip_s(columns, Condition.HEAD_STALLED)
    gap_s = 24.7  # in the dwell nothing moves until the gap of the way back is crossed
    assert noticed_s < (gap_s if 16.0 < start_s < gap_s else start_s) + 0.25
    assert at(columns, noticed_s + 3.0, "truth.valve_open_ratio") == 0.0
    if at(columns, start_s, "readings.head_mm") > 0.0:
        # Both sensors have it standing still, and no current says that anything holds it: a motor
        # without force may come back, within the time of a withdrawal.
        limit_s = at_rest(EXACT)[0].controller.limits.withdrawal_s
        let_go = trips(columns) & {Condition.WITHDRAWAL_BLOCKED, Condition.WITHDRAWAL_TIME}
        assert min(trip_s(columns, code) for code in let_go) < noticed_s + limit_s + 0.01
        assert Condition.WITHDRAWAL_UNSEEN not in trips(columns)
    assert_recovers(columns)


@pytest.mark.requirement("OS-R10")
@at_any_time
def test_a_drive_that_runs_inwards_loses_its_torque_within_two_millimetres(
    start_s: float,
) -> None:
    columns = cycle(Fault.DRIVE_INWARDS, start_s)
    assert_held(columns, at_rest(EXACT)[0], Fault.DRIVE_INWARDS)
    let_go_s = trip_s(columns, Condition.HEAD_RUNAWAY)
    broken = (columns["time_s"] >= start_s) & (columns["time_s"] <= let_go_s)
    # It is a runaway only beyond what it was told, and beyond where it had come back to.
    told = columns["commands.head_mm"][broken].max()
    allowed = max(told, at(columns, start_s, "truth.head_mm"))
    let_go = at(columns, let_go_s, "truth.head_mm")
    assert let_go - allowed < 1.1  # and the gear's backlash
    # The shorted motor brakes: what no governor can take back.
    assert at(columns, let_go_s + 2.0, "truth.head_mm") - let_go < 0.7
    assert_recovers(columns)


@pytest.mark.requirement("OS-R29")
@pytest.mark.parametrize("start_s", [16.8, 18.2, 19.7, 25.7, 34.7])
def test_a_valve_stuck_open_ends_outside_without_vacuum(start_s: float) -> None:
    columns = cycle(Fault.VALVE_OPEN, start_s)
    assert_held(columns, at_rest(EXACT)[0], Fault.VALVE_OPEN)
    assert at(columns, 50.0, "truth.valve_open_ratio") > 0.0
    assert at(columns, 50.0, "truth.tip_mm") < 1.0
    assert at(columns, 50.0, "truth.tip_vacuum_mmhg") < 1.0
    inside = (columns["truth.tip_mm"] > 1.0) & (columns["truth.tip_vacuum_mmhg"] > 1.0)
    budget_s = at_rest(EXACT)[0].controller.limits.negative_pressure_s
    assert np.count_nonzero(inside & (columns["time_s"] < ENDED_S)) / 1000.0 < budget_s
    assert_recovers(columns)


@pytest.mark.requirement("OS-R29")
@pytest.mark.parametrize("start_s", [5.7, 9.7, 15.7])
def test_a_valve_stuck_closed_breaks_the_cycle_off(start_s: float) -> None:
    columns = cycle(Fault.VALVE_OPEN, start_s)
    assert phases(columns)[:6] == [
        Phase.CHECKING,
        Phase.PRELOADING,
        Phase.INSERTING,
        Phase.OPENING,
        Phase.ABORTING,
        Phase.HALTED,
    ]
    assert_held(columns, at_rest(EXACT)[0], Fault.VALVE_OPEN)
    assert_recovers(columns)


@pytest.mark.parametrize("start_s", [0.2, 9.7, 16.7, 19.7, 29.7])
def test_a_frozen_cam_ends_outside_without_vacuum(start_s: float) -> None:
    columns = cycle(Fault.CAM_FROZEN, start_s)
    assert_held(columns, at_rest(EXACT)[0], Fault.CAM_FROZEN)
    assert at(columns, 50.0, "truth.tip_mm") < 1.0
    assert at(columns, 50.0, "truth.tip_vacuum_mmhg") < 1.0
    assert phases(columns)[-1] == Phase.PARKED


@pytest.mark.requirement("OS-R20")
@pytest.mark.parametrize(
    "fault",
    [
        Fault.HEAD_FLAGGED,
        Fault.CAM_FLAGGED,
        Fault.VACUUM_FLAGGED,
        Fault.CONTACT_FLAGGED,
        Fault.CONTACT_CLOSED,
        Fault.PUMP_DEAD,
        Fault.OVERRUN,
    ],
    ids=lambda fault: fault.name,
)
def test_nothing_is_inserted_with_a_fault_from_before(fault: Fault) -> None:
    columns = simulate(EXACT, 40.0, {1.0: START, 20.0: START}, during(fault, 0.0))[1]
    assert not set(phases(columns)) & {Phase.PRELOADING, Phase.INSERTING}
    assert phases(columns)[-1] == Phase.HALTED
    # The pre-use test may have moved the head within the gap, and the valve without vacuum.
    assert np.ptp(columns["truth.tip_mm"]) < 0.01
    assert columns["truth.tip_vacuum_mmhg"].max() == 0.0


def test_each_check_tests_the_pump_anew() -> None:
    # The line of a completed cycle is vented, so that what is left in it does not pass the check.
    buttons = {0.0: START, 42.0: START}
    columns = simulate(EXACT, 66.0, buttons, during(Fault.PUMP_DEAD, 40.0))[1]
    assert at(columns, 41.9, "truth.line_vacuum_mmhg") < 1.0
    assert phases(columns)[-3:] == [Phase.CHECKING, Phase.ABORTING, Phase.HALTED]


def test_a_person_resetting_into_a_fault_gets_another_halt() -> None:
    always = dict.fromkeys(np.round(np.arange(16.0, 56.0, 0.5), 1), RESET | START)
    for fault in (Fault.HEAD_NAN, Fault.CAM_NAN, Fault.CONTACT_CLOSED, Fault.HEAD_FROZEN):
        _, columns = simulate(EXACT, 56.0, {0.0: START} | always, during(fault, 11.0))
        assert phases(columns).count(Phase.INSERTING) == 1
        assert_held(columns, at_rest(EXACT)[0], fault)
