"""The dwell ends when nothing comes, and the way out is slow where mucus comes again."""

import pytest

from opensuction.kernel.interface import NO_REQUESTS
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle import cycle
from opensuction.procedure.cycle.demand import OUTWARDS, Demand
from opensuction.procedure.cycle.plan import Plan
from opensuction.procedure.cycle.progress import ProcedureState
from opensuction.procedure.cycle.transition import Event
from opensuction.procedure.planning import planner
from opensuction.procedure.planning.protocol import BENCH_SITE, PAPER
from opensuction.procedure.suction.line_flow import FreeFlow
from tests.procedure.cycle.test_progress import AT_HOME, DT_S, QUIET
from tests.procedure.planning.test_planner import EXCITATION, WITH_GAP
from tests.settled import settled

WAIT_S = 2.0
FLOW = FreeFlow(
    window_s=0.1,
    pump_ml_per_s=300.0,
    pump_ml_per_s_per_mmhg=300.0 / 560.0,
    bore_ml_per_s_per_root_mmhg=29.5,
    canister_ml_per_mmhg=800.0 / 760.0,
    free_share=0.86,
    at_rest=False,
)
FREE = AT_HOME._replace(line_vacuum_mmhg=77.0, cam_rad=0.52, head_mm=90.0)
"""Pump and free catheter agree on that."""
MUCUS = FREE._replace(line_vacuum_mmhg=121.0)
UNSETTLED = QUIET._replace(head_wanted_mm=30.0)
"""The head is still on its way, so that the way out lasts."""


def plan(nothing_comes_s: float = WAIT_S) -> Plan:
    protocol = PAPER._replace(nothing_comes_s=nothing_comes_s)
    found = planner.plan(protocol, WITH_GAP, EXCITATION, by_contact=False, site=BENCH_SITE)
    return found._replace(flow=FLOW)


def dwelling(plan: Plan) -> ProcedureState:
    """The tip where it stopped, the valve just open."""
    begun: ProcedureState = cycle.begin(plan, Phase.SUCTIONING)
    return begun._replace(reference_mm=90.0, start_mm=90.0, arrived_ticks=2000, valve_open=True)


step = settled(cycle.step)


def play(
    plan: Plan, state: ProcedureState, vacuums_mmhg: list[tuple[float, float]]
) -> list[tuple[ProcedureState, Demand]]:
    """Every tick under a line's vacuum for some seconds each."""
    found = []
    for seconds, vacuum_mmhg in vacuums_mmhg:
        readings = FREE._replace(line_vacuum_mmhg=vacuum_mmhg)
        for _ in range(round(seconds / DT_S)):
            state, asked = step(plan, state, readings, NO_REQUESTS, UNSETTLED, DT_S)
            found.append((state, asked))
    return found


def leaving_s(found: list[tuple[ProcedureState, Demand]]) -> float:
    return DT_S * next(i for i, (state, _) in enumerate(found) if state.phase == Phase.WITHDRAWING)


def test_it_ends_when_nothing_has_come_for_the_stated_time() -> None:
    found = play(plan(), dwelling(plan()), [(1.0, 121.0), (4.0, 77.0)])
    # Mucus for 1 s, the fall in a window of .1 s, and the time in which nothing comes.
    assert leaving_s(found) == pytest.approx(1.0 + WAIT_S, abs=0.25)
    assert found[-1][0].cause == Event.NOTHING_CAME


def test_it_lasts_its_whole_time_where_mucus_comes_or_it_is_switched_off() -> None:
    whole_s = PAPER.dwell_s - 2.0
    for wait_s, vacuum_mmhg in ((WAIT_S, 121.0), (0.0, 77.0)):
        found = play(plan(wait_s), dwelling(plan(wait_s)), [(8.0, vacuum_mmhg)])
        assert leaving_s(found) == pytest.approx(whole_s, abs=0.005)
        assert found[-1][0].cause == Event.DWELL_ELAPSED


def test_the_way_back_is_announced_as_long_before_as_its_gap_takes() -> None:
    protocol_plan = plan()
    found = play(protocol_plan, dwelling(protocol_plan), [(4.0, 77.0)])
    announced = [asked for _, asked in found if asked.starts_in_s > 0.0]
    assert announced[0].starts_in_s == pytest.approx(protocol_plan.gap_lead_s, abs=0.002)
    assert all(asked.direction == OUTWARDS for asked in announced)
    assert announced[-1].starts_in_s <= 2.0 * DT_S


def test_mucus_that_comes_again_while_the_gap_is_crossed_keeps_tip_and_head_where_they_are() -> (
    None
):
    found = play(plan(), dwelling(plan()), [(1.5, 77.0), (1.0, 121.0)])
    state, asked = found[-1]
    assert state.phase == Phase.SUCTIONING
    assert (asked.direction, asked.reference_mm_per_s) == (OUTWARDS, 0.0)
    assert asked.starts_in_s < 0.0


def test_a_wait_shorter_than_the_gap_takes_is_as_long_as_that() -> None:
    short = plan(0.1)
    assert short.pace.nothing_comes_s == short.gap_lead_s
    assert plan(0.0).pace.nothing_comes_s == 0.0


def test_the_way_out_is_slow_where_mucus_comes_and_no_longer_than_the_dwell_left_time_for() -> None:
    protocol_plan = plan()
    dwelt = play(protocol_plan, dwelling(protocol_plan), [(3.0, 77.0)])
    start = next(state for state, _ in dwelt if state.phase == Phase.WITHDRAWING)
    free = [asked.reference_mm for _, asked in play(protocol_plan, start, [(3.0, 77.0)])]
    wet = [asked.reference_mm for _, asked in play(protocol_plan, start, [(3.0, 121.0)])]
    assert free[-1] < wet[-1] < wet[0]
    speeds = [-asked.reference_mm_per_s for _, asked in play(protocol_plan, start, [(3.0, 121.0)])]
    assert min(speeds[1000:]) == pytest.approx(planner.SLOW_MM_PER_S)
    spare_s = start.pace.spare_s
    last = play(protocol_plan, start, [(20.0, 121.0)])[-1][0]
    assert last.pace.late_s == pytest.approx(spare_s, abs=0.2)
    assert last.pace.late_s <= spare_s


def test_time_that_was_not_spent_on_mucus_makes_no_phase_longer() -> None:
    protocol_plan = plan()
    dwelt = play(protocol_plan, dwelling(protocol_plan), [(3.0, 77.0)])
    start = next(state for state, _ in dwelt if state.phase == Phase.WITHDRAWING)
    limit_s = protocol_plan.limits_s[Phase.WITHDRAWING]
    found = play(protocol_plan, start, [(limit_s + 1.0, 77.0)])
    ended = next(i for i, (state, _) in enumerate(found) if state.phase == Phase.ABORTING)
    assert ended * DT_S == pytest.approx(limit_s, abs=0.01)
    assert found[ended][0].cause == Event.PHASE_OVERDUE
