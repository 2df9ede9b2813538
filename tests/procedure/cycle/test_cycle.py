"""Pump and vacuum in a cycle: little while the catheter goes in, that of suction at its end."""

import pytest

from opensuction.kernel.interface import NO_REQUESTS, Readings
from opensuction.kernel.vocabulary import AgeGroup, Phase
from opensuction.procedure.cycle import cycle
from opensuction.procedure.cycle.demand import Demand
from opensuction.procedure.cycle.progress import ControlFeedback, ProcedureState
from opensuction.procedure.planning.planner import WAY_IN_MMHG
from tests.procedure.cycle.test_progress import AT_HOME, DT_S, QUIET
from tests.procedure.cycle.test_progress import PLAN as AT_BENCH
from tests.settled import settled

PLAN = AT_BENCH._replace(bench_only=False, way_in_mmhg=WAY_IN_MMHG[AgeGroup.ADULT])
"""At a patient."""
ADVANCING = (Phase.PRELOADING, Phase.INSERTING, Phase.BACKING_OFF)
AWAY = QUIET._replace(head_wanted_mm=30.0)
"""The head is still on its way to its command, so that the phase lasts."""
SLOW_S = PLAN.build_most_s - 0.1
"""A pump that takes as long as this for its vacuum, and passes the pre-use test."""


def stepped(
    phase: Phase,
    vacuum_mmhg: float,
    was_ready: bool,
    valid: bool = True,
    phase_ticks: int = 100,
    valve_open: bool = False,
) -> tuple[ProcedureState, Demand]:
    state: ProcedureState = cycle.begin(PLAN, phase)._replace(
        phase_ticks=phase_ticks, line_ready=was_ready, valve_open=valve_open
    )
    readings = AT_HOME._replace(line_vacuum_mmhg=vacuum_mmhg, vacuum_valid=valid)
    return followed(state, readings)


step = settled(cycle.step)


def followed(
    state: ProcedureState, readings: Readings, feedback: ControlFeedback = AWAY
) -> tuple[ProcedureState, Demand]:
    return step(PLAN, state, readings, NO_REQUESTS, feedback, DT_S)


@pytest.mark.requirement("OS-R03")
@pytest.mark.parametrize("phase", ADVANCING)
def test_the_pump_rests_on_the_way_in_and_leaves_the_set_point(phase: Phase) -> None:
    """Whatever the line has lost since: who refills it hides a valve that lets gas through."""
    for vacuum_mmhg in (PLAN.way_in_mmhg, 0.5 * PLAN.way_in_mmhg, 0.0):
        state, asked = stepped(phase, vacuum_mmhg, was_ready=True)
        assert state.phase == phase
        assert state.line_ready
        assert not asked.pump_on
        assert asked.vacuum_mmhg == PLAN.way_in_mmhg


@pytest.mark.requirement("OS-R03")
def test_no_more_than_twenty_mmhg_are_asked_for_before_the_tip_is_there() -> None:
    for phase in ADVANCING:
        assert 0.0 < stepped(phase, 0.0, was_ready=False)[1].vacuum_mmhg < 20.0


@pytest.mark.parametrize("phase", ADVANCING)
def test_the_pump_runs_until_the_line_has_its_vacuum(phase: Phase) -> None:
    way_in_mmhg = PLAN.way_in_mmhg
    state, asked = stepped(phase, 0.89 * way_in_mmhg, was_ready=False)
    assert asked.pump_on
    assert not state.line_ready
    assert stepped(phase, 0.91 * way_in_mmhg, was_ready=False)[0].line_ready
    assert not stepped(phase, way_in_mmhg, was_ready=False, valid=False)[0].line_ready


def test_what_the_pre_use_test_has_left_in_the_line_is_let_out_first() -> None:
    """The reading is 20 ms behind a line that vents."""
    early = stepped(Phase.PRELOADING, PLAN.way_in_mmhg, was_ready=False, phase_ticks=99)[0]
    assert not early.line_ready


@pytest.mark.requirement("OS-R03")
@pytest.mark.parametrize("share", [0.79, 1.21])
def test_the_way_in_begins_once_the_resting_line_has_kept_its_vacuum(share: float) -> None:
    """For .3 s without a break, however long the gap has been taken up."""
    state = cycle.begin(PLAN, Phase.PRELOADING)._replace(phase_ticks=900, line_ready=True)
    kept = AT_HOME._replace(line_vacuum_mmhg=PLAN.way_in_mmhg)
    for _ in range(300):
        state, _ = followed(state, kept, QUIET)
    assert state.phase == Phase.PRELOADING
    lost = kept._replace(line_vacuum_mmhg=share * PLAN.way_in_mmhg)
    assert followed(followed(state, kept, QUIET)[0], kept, QUIET)[0].phase == Phase.INSERTING
    assert state.kept_ticks > 0
    assert followed(state, lost, QUIET)[0].kept_ticks == 0
    turned = kept._replace(cam_rad=0.5 * PLAN.cam_open_rad)
    assert followed(state, turned, QUIET)[0].phase == Phase.PRELOADING


@pytest.mark.requirement("OS-R03")
def test_the_valve_waits_for_the_vacuum_of_suction_and_the_dwell_for_the_valve() -> None:
    ready_mmhg = PLAN.check.ready_mmhg
    state = cycle.begin(PLAN, Phase.OPENING)._replace(phase_ticks=1, arrived_ticks=7)
    building = AT_HOME._replace(line_vacuum_mmhg=0.99 * ready_mmhg)
    for _ in range(round(SLOW_S / DT_S)):
        state, asked = followed(state, building)
        assert (asked.pump_on, asked.valve_open) == (True, False)
        assert asked.vacuum_mmhg == PLAN.vacuum_mmhg
    assert state.phase == Phase.OPENING
    assert state.arrived_ticks == 7
    # The stroke has all of its own time.
    planned_s = PLAN.limits_s[Phase.OPENING]
    assert state.limit_s - state.phase_ticks * DT_S == pytest.approx(planned_s, abs=0.01)
    state, asked = followed(state, AT_HOME._replace(line_vacuum_mmhg=ready_mmhg))
    assert asked.valve_open
    assert state.arrived_ticks == 8
    # What the open valve draws does not close it again.
    state, asked = followed(state, AT_HOME._replace(line_vacuum_mmhg=0.5 * ready_mmhg))
    assert asked.valve_open


@pytest.mark.requirement("OS-R03")
def test_the_valve_does_not_open_on_what_the_tip_touches() -> None:
    """A carina that has come to the tip would be drawn in; where a protocol wants that, it may."""
    state = cycle.begin(PLAN, Phase.OPENING)._replace(phase_ticks=1)
    ready = AT_HOME._replace(line_vacuum_mmhg=PLAN.check.ready_mmhg)
    touching = ready._replace(contact_valid=True, contact_closed=True)
    for _ in range(200):
        state, asked = followed(state, touching)
        assert not asked.valve_open
    assert followed(state, ready)[1].valve_open
    opened, _ = followed(state, ready)
    assert followed(opened, touching)[1].valve_open, "one that is open is another's affair"
    where_it_stops = PLAN.contact._replace(enabled=True, backoff_mm=0.0)
    for plan in (AT_BENCH, PLAN._replace(contact=where_it_stops)):
        meant = cycle.begin(plan, Phase.OPENING)._replace(phase_ticks=1)
        assert cycle.step(plan, meant, touching, NO_REQUESTS, QUIET, DT_S)[1].valve_open


def test_a_vacuum_that_never_comes_keeps_the_tip_no_longer_than_a_weak_pump_may_need() -> None:
    state, ticks = cycle.begin(PLAN, Phase.OPENING)._replace(phase_ticks=1), 0
    while state.phase == Phase.OPENING and ticks < 20000:
        state, _ = followed(state, AT_HOME._replace(line_vacuum_mmhg=0.0))
        ticks += 1
    assert state.phase == Phase.ABORTING
    assert state.limit_s == PLAN.limits_s[Phase.ABORTING]
    longest_s = PLAN.build_most_s + PLAN.limits_s[Phase.OPENING]
    assert ticks * DT_S == pytest.approx(longest_s, abs=0.01)


def test_a_bench_goes_in_with_its_whole_vacuum_and_its_valve_waits_for_nothing() -> None:
    """Nobody is there to be drawn at, and the paper's times are those of its procedure."""
    drawn = AT_HOME._replace(line_vacuum_mmhg=0.5 * AT_BENCH.vacuum_mmhg)
    for phase in ADVANCING:
        state = cycle.begin(AT_BENCH, phase)._replace(phase_ticks=100)
        asked = cycle.step(AT_BENCH, state, drawn, NO_REQUESTS, AWAY, DT_S)[1]
        assert asked.vacuum_mmhg == AT_BENCH.vacuum_mmhg
    state = cycle.begin(AT_BENCH, Phase.PRELOADING)._replace(phase_ticks=1)
    after = cycle.step(AT_BENCH, state, drawn, NO_REQUESTS, QUIET, DT_S)[0]
    assert after.phase == Phase.INSERTING
    state = cycle.begin(AT_BENCH, Phase.OPENING)._replace(phase_ticks=1)
    assert cycle.step(AT_BENCH, state, drawn, NO_REQUESTS, QUIET, DT_S)[1].valve_open


def test_it_sucks_with_the_valve_open() -> None:
    for phase in (Phase.OPENING, Phase.SUCTIONING, Phase.WITHDRAWING):
        state, asked = stepped(phase, PLAN.vacuum_mmhg, was_ready=True, valve_open=True)
        assert state.phase == phase
        assert asked.pump_on


def test_what_the_line_had_in_the_last_cycle_does_not_count() -> None:
    for phase in (Phase.PARKED, Phase.CHECKING, Phase.OPENING, Phase.HALTED):
        assert not stepped(phase, PLAN.vacuum_mmhg, was_ready=True)[0].line_ready
