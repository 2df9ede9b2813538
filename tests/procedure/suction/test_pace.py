"""Duration of the dwell, and speed of the way out."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.procedure.suction import line_flow
from opensuction.procedure.suction.line_flow import BEGUN, Pace, PacePlan

DT_S = 0.001
PLAN = PacePlan(nothing_comes_s=0.75, gap_lead_s=0.6, slow_ratio=1.0 / 6.0, ramp_s=0.3)
OFF = PLAN._replace(nothing_comes_s=0.0)


def listened(plan: PacePlan, heard: list[bool]) -> Pace:
    state = BEGUN
    for nothing_comes in heard:
        state = line_flow.listen(plan, state, nothing_comes)
    return state


def test_the_dwell_ends_when_nothing_has_come_for_the_stated_time_without_a_break() -> None:
    assert not line_flow.is_over(PLAN, listened(PLAN, [True] * 749), DT_S)
    assert line_flow.is_over(PLAN, listened(PLAN, [True] * 750), DT_S)
    assert not line_flow.is_over(PLAN, listened(PLAN, [True] * 700 + [False] + [True] * 700), DT_S)


def test_switched_off_it_never_ends_before_its_time() -> None:
    state = listened(OFF, [True] * 9000)
    assert not line_flow.is_over(OFF, state, DT_S)
    assert line_flow.left_s(OFF, state, 8.0, DT_S) == 8.0
    assert line_flow.leave(OFF, 8.0).spare_s == 0.0


def test_the_gap_is_crossed_while_nothing_comes_and_no_later_than_the_whole_dwell_has_it() -> None:
    state = listened(PLAN, [True] * 200)
    assert line_flow.left_s(PLAN, state, 8.0, DT_S) == pytest.approx(0.55)
    assert line_flow.left_s(PLAN, state, 0.1, DT_S) == 0.1
    turned = line_flow.turn(PLAN, state, 0.55)
    assert turned.turned
    again = line_flow.listen(PLAN, turned, False)
    assert line_flow.left_s(PLAN, again, 7.9, DT_S) == 7.9
    assert line_flow.turn(PLAN, again, 7.9).turned  # the head stays behind the gap


def go(plan: PacePlan, state: Pace, comes: list[bool]) -> list[Pace]:
    found = []
    for one in comes:
        state = line_flow.go_on(plan, state, one, DT_S)
        found.append(state)
    return found


def test_the_way_out_is_slow_where_mucus_comes_and_fast_elsewhere() -> None:
    found = go(PLAN, line_flow.leave(PLAN, 5.0), [False] * 100 + [True] * 500 + [False] * 400)
    assert all(state.ratio == 1.0 for state in found[:100])
    assert found[599].ratio == PLAN.slow_ratio
    assert found[-1].ratio == 1.0


def test_a_dwell_that_lasted_its_whole_time_leaves_none_for_the_way_out() -> None:
    found = go(PLAN, line_flow.leave(PLAN, 0.0), [True] * 1000)
    assert all(state.ratio == 1.0 and state.late_s == 0.0 for state in found)


@given(
    spare_s=st.floats(0.0, 9.0),
    slow_ratio=st.floats(0.0, 1.0),
    ramp_s=st.floats(0.0, 2.0),
    runs=st.lists(st.tuples(st.booleans(), st.integers(1, 800)), max_size=12),
)
def test_the_way_out_never_takes_more_than_is_left_of_the_dwell(
    spare_s: float, slow_ratio: float, ramp_s: float, runs: list[tuple[bool, int]]
) -> None:
    plan = PLAN._replace(slow_ratio=slow_ratio, ramp_s=ramp_s)
    comes = [one for one, ticks in runs for _ in range(ticks)] + [True] * 3000
    begun = line_flow.leave(plan, spare_s)
    before = begun
    for state in go(plan, begun, comes):
        assert 0.0 <= state.ratio <= 1.0
        assert state.late_s >= before.late_s
        most = DT_S / ramp_s if ramp_s > DT_S else 1.0
        assert abs(state.ratio - before.ratio) <= most * (1.0 + 1e-9)
        before = state
    assert before.late_s <= spare_s + 1e-9
