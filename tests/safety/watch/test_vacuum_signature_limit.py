"""Limits, times and names of each signature of the line, one tick at a time."""

import math

import pytest

from opensuction.safety.condition import Condition
from opensuction.safety.condition_mask import decode_trips
from opensuction.safety.limits import LineLimits
from opensuction.safety.watch import vacuum_signature
from opensuction.safety.watch.vacuum_signature import START, LineWatch
from tests.safety.watchdog import above, below, changed

LIMITS = LineLimits(
    open_low_share=0.35,
    clogged_share=0.95,
    rests_open=False,
    open_fall_mmhg_per_s=84.0,
    bore_fall_mmhg_per_s=300.0,
    bore_fall_mmhg_per_s_per_root=30.0,
    parked_closed_mmhg=190.0,
)
SET = 120.0
BUILT = LineWatch(
    vacuum_mmhg=SET,
    slow_mmhg=SET,
    set_mmhg=SET,
    pumping_s=60.0,
    built=True,
    fall_mmhg_per_s=0.0,
    rest_s=0.0,
    kept_mmhg=0.0,
    rest_low_s=0.0,
    closed_low_s=0.0,
    open_low_s=0.0,
    clogged_s=0.0,
    over_s=0.0,
    unvented_s=0.0,
    open_rest_s=0.0,
    no_flow_s=0.0,
)
"""A sound line that has held its set point for a minute."""
TIMES = ("closed_low_s", "open_low_s", "clogged_s", "over_s", "unvented_s", "no_flow_s")
DT_S = 0.001


def found(**values: object) -> list[Condition]:
    return decode_trips(vacuum_signature.judge(LIMITS, changed(BUILT, values), False))


def tick(
    state: LineWatch,
    vacuum_mmhg: float,
    set_mmhg: float = SET,
    pump_on: bool = True,
    is_open: bool = False,
    is_closed: bool = False,
) -> LineWatch:
    return vacuum_signature.step(
        LIMITS, state, vacuum_mmhg, set_mmhg, pump_on, is_open, is_closed, DT_S
    )


def counting(state: LineWatch) -> set[str]:
    """What has begun to be held against the line."""
    return {name for name in TIMES if getattr(state, name) > 0.0}


def test_a_sound_line_and_one_at_power_up_have_nothing_against_them() -> None:
    assert vacuum_signature.judge(LIMITS, BUILT, False) == 0
    assert vacuum_signature.judge(LIMITS, START, False) == 0
    assert LineWatch(0.0, 0.0, 0.0, 0.0, False, *[0.0] * 11) == START


@pytest.mark.parametrize(
    ("name", "allowed_s", "code"),
    [
        ("closed_low_s", 0.3, Condition.VACUUM_LOST),
        ("no_flow_s", 0.3, Condition.LINE_CLOGGED),
        ("open_low_s", 0.5, Condition.VACUUM_LOST),
        ("clogged_s", 4.6, Condition.LINE_CLOGGED),
        ("over_s", 0.5, Condition.VACUUM_EXCEEDED),
        ("unvented_s", 1.0, Condition.PUMP_RUNAWAY),
    ],
)
def test_each_may_last_its_time_and_no_longer(name: str, allowed_s: float, code: Condition) -> None:
    assert found(**{name: allowed_s}) == []
    assert found(**{name: above(allowed_s)}) == [code]


@pytest.mark.parametrize(
    ("fall_mmhg_per_s", "code"),
    [
        # A pump that stands still loses less than 8 % of 120 mmHg a second.
        (0.0, Condition.VACUUM_LOST),
        (above(-0.08 * SET), Condition.VACUUM_LOST),
        (-0.08 * SET, Condition.VALVE_STUCK_OPEN),
        # An open valve, half as steep again at most.
        (-126.0, Condition.VALVE_STUCK_OPEN),
        (below(-126.0), Condition.LINE_LEAKING),
        (-5000.0, Condition.LINE_LEAKING),
    ],
)
def test_how_steeply_a_closed_line_lost_its_vacuum_names_the_cause(
    fall_mmhg_per_s: float, code: Condition
) -> None:
    assert found(closed_low_s=0.4, fall_mmhg_per_s=fall_mmhg_per_s) == [code]


@pytest.mark.parametrize(
    ("fall_mmhg_per_s", "code"),
    [
        (0.0, Condition.VACUUM_LOST),
        # Twice as steep as an open catheter without a pump: no room in the canister.
        (-600.0, Condition.VACUUM_LOST),
        (below(-600.0), Condition.CANISTER_FULL),
    ],
)
def test_how_steeply_an_open_line_lost_its_vacuum_names_the_cause(
    fall_mmhg_per_s: float, code: Condition
) -> None:
    assert found(open_low_s=0.6, fall_mmhg_per_s=fall_mmhg_per_s) == [code]


@pytest.mark.parametrize(
    ("falling_mmhg_per_s", "code"),
    [
        (-2.0, Condition.PUMP_RUNAWAY),
        (0.0, Condition.PUMP_RUNAWAY),
        (0.99, Condition.PUMP_RUNAWAY),
        (1.01, Condition.VACUUM_EXCEEDED),
        (50.0, Condition.VACUUM_EXCEEDED),
    ],
)
def test_an_unvented_vacuum_that_falls_by_a_hundredth_a_second_has_no_pump_behind_it(
    falling_mmhg_per_s: float, code: Condition
) -> None:
    slow = 100.0 + 0.1 * falling_mmhg_per_s
    assert found(unvented_s=1.1, vacuum_mmhg=100.0, slow_mmhg=slow) == [code]


def test_several_faults_are_told_together() -> None:
    several = found(closed_low_s=9.0, clogged_s=9.0, over_s=9.0)
    assert several == [Condition.VACUUM_EXCEEDED, Condition.VACUUM_LOST, Condition.LINE_CLOGGED]


@pytest.mark.parametrize(
    ("vacuum_mmhg", "valve", "against"),
    [
        # Closed: 94 % of the set point.
        (0.94 * SET, "closed", set()),
        (below(0.94 * SET), "closed", {"closed_low_s"}),
        (0.0, "turning", set()),
        # Open: 35 to 95 % of it.
        (0.35 * SET, "open", set()),
        (below(0.35 * SET), "open", {"open_low_s"}),
        (0.95 * SET, "open", set()),
        (above(0.95 * SET), "open", {"clogged_s"}),
        # 15 mmHg over it, wherever the valve is.
        (SET + 15.0, "turning", set()),
        (above(SET + 15.0), "turning", {"over_s"}),
        (above(SET + 15.0), "closed", {"over_s"}),
    ],
)
def test_what_counts_against_a_line_begins_beyond_its_limit(
    vacuum_mmhg: float, valve: str, against: set[str]
) -> None:
    state = tick(BUILT, vacuum_mmhg, is_open=valve == "open", is_closed=valve == "closed")
    assert counting(state) == against
    for name in against:
        before = BUILT._replace(**dict.fromkeys(TIMES, 1.0))  # type: ignore[arg-type]
        after = tick(before, vacuum_mmhg, is_open=valve == "open", is_closed=valve == "closed")
        assert getattr(after, name) == 1.0 + DT_S
        assert counting(after) == against  # the others begin anew


def test_a_vented_line_keeps_fifteen_mmhg_at_most() -> None:
    assert counting(tick(BUILT, 15.0, 0.0, pump_on=False)) == set()
    assert counting(tick(BUILT, above(15.0), 0.0, pump_on=False)) == {"unvented_s"}
    # Told to run, or to hold, be it 1 mmHg: another matter.
    assert counting(tick(BUILT, 16.1, 1.0, pump_on=False)) == {"over_s"}
    assert counting(tick(BUILT, 99.0, 0.0, pump_on=True)) == set()
    assert counting(tick(BUILT, 99.0, 100.0, pump_on=False)) == set()


def test_without_a_pump_an_open_line_is_neither_clogged_nor_empty() -> None:
    assert counting(tick(BUILT, 119.0, pump_on=False, is_open=True)) == set()
    assert counting(tick(BUILT, 1.0, pump_on=False, is_open=True)) == set()
    assert counting(tick(BUILT, 1.0, pump_on=False, is_closed=True)) == set()


def test_a_line_that_is_being_built_must_rise_as_long_as_it_is_pumped() -> None:
    """By .5 mmHg over its average, from .2 s on: a free catheter keeps it at 77 mmHg."""
    building = BUILT._replace(built=False, pumping_s=0.2, slow_mmhg=60.0)
    assert counting(tick(building, 60.0, is_closed=True)) == {"closed_low_s"}
    assert counting(tick(building, 60.6, is_closed=True)) == set()
    assert counting(tick(building, 60.0)) == set()
    begun = building._replace(pumping_s=0.2 - 2.0 * DT_S)
    assert counting(tick(begun, 60.0, is_closed=True)) == set()
    assert counting(tick(building, 60.0, pump_on=False, is_closed=True)) == set()
    # At 94 % nothing is lacking.
    there = building._replace(slow_mmhg=0.94 * SET)
    assert counting(tick(there, 0.94 * SET, is_closed=True)) == set()


def test_a_line_that_rises_no_more_is_named_by_what_it_has() -> None:
    stands = {"built": False, "pumping_s": 0.6, "closed_low_s": above(0.3)}
    least = 0.35 * SET
    # A pump that stopped half-way leaves as much as pump and free catheter may agree on.
    either = {Condition.VACUUM_LOST, Condition.VALVE_STUCK_OPEN}
    assert set(found(**stands, vacuum_mmhg=least)) == either
    assert found(**stands, vacuum_mmhg=below(least)) == [Condition.VACUUM_LOST]
    assert found(**{**stands, "closed_low_s": 0.3}, vacuum_mmhg=least) == []
    # With the tip parked the pre-use test says so first, but not for ever.
    parked = changed(BUILT, {**stands, "vacuum_mmhg": least})
    assert vacuum_signature.judge(LIMITS, parked, True) == 0
    late = parked._replace(pumping_s=above(5.0))
    assert vacuum_signature.judge(LIMITS, late, True) == 1 << Condition.VACUUM_LOST


def test_a_line_is_not_judged_before_it_is_built_or_should_be() -> None:
    building = BUILT._replace(built=False, pumping_s=4.5, slow_mmhg=59.0)
    assert counting(tick(building, 60.0, is_closed=True)) == set()
    assert counting(tick(building, 10.0, is_open=True)) == set()
    overdue = building._replace(pumping_s=5.0)
    assert counting(tick(overdue, 60.0, is_closed=True)) == {"closed_low_s"}
    assert counting(tick(overdue, 10.0, is_open=True)) == {"open_low_s"}
    in_time = building._replace(pumping_s=5.0 - DT_S)
    assert counting(tick(in_time, 60.0, is_closed=True)) == set()


def test_nine_tenths_of_the_set_point_are_built_until_it_is_raised() -> None:
    empty = BUILT._replace(built=False, vacuum_mmhg=0.0)
    assert not tick(empty, below(108.0)).built
    assert tick(empty, 108.0).built
    assert tick(BUILT, 50.0).built
    assert tick(BUILT, 50.0, set_mmhg=100.0).built  # lowered
    assert not tick(BUILT, 120.0, set_mmhg=140.0).built
    assert tick(BUILT, 126.0, set_mmhg=140.0).built
    assert tick(BUILT, 120.0, pump_on=False).built  # it rests
    assert not tick(BUILT, 120.0, set_mmhg=0.0).built


def test_the_pump_has_its_time_from_when_it_was_told_to_build_more() -> None:
    assert tick(BUILT, 120.0).pumping_s == 60.0 + DT_S
    assert tick(BUILT, 120.0, set_mmhg=100.0).pumping_s == 60.0 + DT_S
    assert tick(BUILT, 120.0, set_mmhg=above(SET)).pumping_s == 0.0
    assert tick(BUILT, 120.0, pump_on=False).pumping_s == 0.0
    assert tick(BUILT, 120.0, set_mmhg=0.0).pumping_s == 0.0
    # A set point of 1 mmHg is one.
    assert tick(BUILT, 120.0, set_mmhg=1.0).pumping_s > 0.0


def resting(state: LineWatch, vacuum_mmhg: float, set_mmhg: float = SET) -> LineWatch:
    return tick(state, vacuum_mmhg, set_mmhg, pump_on=False, is_closed=True)


def test_a_resting_line_may_lose_a_little_a_second() -> None:
    settled = BUILT._replace(rest_s=0.3, kept_mmhg=100.0, slow_mmhg=98.6, vacuum_mmhg=98.6)
    # From the first tick on; what it had over its set point the regulator has taken.
    pumped = tick(BUILT, SET + 5.0, is_closed=True)
    assert (pumped.slow_mmhg, pumped.kept_mmhg) == (SET + 5.0, SET)
    early = resting(settled._replace(rest_s=0.0, kept_mmhg=101.0), 98.0)
    assert early.kept_mmhg == pytest.approx(101.0 * (1.0 - 0.06 * DT_S))
    assert early.rest_low_s == DT_S
    # 0.06 of its vacuum a second; what is left is within 1.4 mmHg of that.
    later = resting(settled, 98.6)
    assert later.kept_mmhg == pytest.approx(100.0 - 0.06 * 100.0 * DT_S)
    assert later.rest_low_s == 0.0
    assert resting(settled._replace(slow_mmhg=98.58), 98.58).rest_low_s == DT_S
    # At 1.4 mmHg below nothing is lost yet.
    edge = later.kept_mmhg - vacuum_signature.REST_FALL_MMHG
    assert resting(settled._replace(slow_mmhg=edge), edge).rest_low_s == 0.0
    assert resting(settled._replace(slow_mmhg=below(edge)), below(edge)).rest_low_s == DT_S
    # A set point of 1 mmHg is one.
    assert resting(BUILT, 98.0, set_mmhg=1.0).rest_s == DT_S
    # A line that loses less is held to what it still has.
    assert resting(settled._replace(kept_mmhg=97.0, slow_mmhg=98.0), 98.0).kept_mmhg == 98.0
    # Pumped, vented or open it is not looked at.
    low = settled._replace(kept_mmhg=120.0, rest_low_s=0.05)
    assert resting(low, 98.0).rest_low_s == 0.05 + DT_S
    assert tick(low, 98.0, is_closed=True).rest_low_s == 0.0
    assert tick(low, 98.0, pump_on=False, is_open=True).rest_low_s == 0.0
    assert resting(low, 98.0, set_mmhg=0.0).rest_low_s == 0.0


def test_what_a_resting_line_lost_is_named_by_how_fast_it_falls() -> None:
    # Of what it had: 100 mmHg, so 10 times as much as at 1.
    fall = 10.0 * LIMITS.bore_fall_mmhg_per_s_per_root
    steep = 98.0 - 0.1 * (fall + 20.0)
    assert found(rest_low_s=0.1) == []
    assert found(rest_low_s=above(0.1)) == [Condition.VALVE_STUCK_OPEN]
    falling = {"rest_low_s": 0.2, "slow_mmhg": 98.0, "kept_mmhg": 100.0}
    assert found(**falling, vacuum_mmhg=steep + 1e-9) == [Condition.VALVE_STUCK_OPEN]
    assert found(**falling, vacuum_mmhg=steep - 1e-9) == [Condition.LINE_LEAKING]
    # At that rate to the last digit it is still the valve's.
    last = -0.1 * (-fall - 20.0)
    assert (0.0 - last) / 0.1 == -fall - 20.0
    named = found(rest_low_s=0.2, slow_mmhg=last, vacuum_mmhg=0.0, kept_mmhg=100.0)
    assert named == [Condition.VALVE_STUCK_OPEN]
    # What is left of less falls more slowly, however high the set point.
    less = {"rest_low_s": 0.2, "slow_mmhg": 12.0, "kept_mmhg": 16.0, "vacuum_mmhg": 0.0}
    assert found(**less) == [Condition.VALVE_STUCK_OPEN]
    assert found(**{**less, "slow_mmhg": 14.1}) == [Condition.LINE_LEAKING]
    parked = changed(BUILT, {"rest_low_s": 9.0})
    assert vacuum_signature.judge(LIMITS, parked, True) == 0


def test_what_was_read_and_told_is_kept() -> None:
    state = tick(BUILT, 77.0, set_mmhg=88.0)
    assert (state.vacuum_mmhg, state.set_mmhg) == (77.0, 88.0)


def test_the_fall_is_that_over_a_tenth_of_a_second() -> None:
    state, slope = BUILT, 200.0
    for i in range(1, 401):
        state = tick(state, SET - slope * i * DT_S)
    # Four windows into a steady fall; 1 - exp(-4) of it.
    assert state.fall_mmhg_per_s == pytest.approx(-slope * (1.0 - math.exp(-4.0)), rel=0.01)
    assert state.slow_mmhg - state.vacuum_mmhg == pytest.approx(-0.1 * state.fall_mmhg_per_s)


def test_the_steepest_fall_is_kept_until_the_set_point_is_reached_again() -> None:
    fallen = BUILT._replace(fall_mmhg_per_s=-300.0, vacuum_mmhg=90.0, slow_mmhg=90.0)
    assert tick(fallen, 91.0).fall_mmhg_per_s == -300.0
    assert tick(fallen, below(SET)).fall_mmhg_per_s == -300.0
    assert tick(fallen, SET).fall_mmhg_per_s == 0.0
    # While the pump rests too.
    assert tick(fallen, 80.0, pump_on=False).fall_mmhg_per_s == -300.0
    # Before the line is built, and once it is vented, there is nothing to fall from.
    assert tick(fallen._replace(built=False), 80.0).fall_mmhg_per_s == 0.0
    assert tick(fallen, 80.0, pump_on=False, set_mmhg=0.0).fall_mmhg_per_s == 0.0


def test_at_its_set_point_the_line_is_taken_as_it_is() -> None:
    high = BUILT._replace(slow_mmhg=140.0)
    assert tick(high, SET).slow_mmhg == SET
    assert tick(high, below(SET)).slow_mmhg > SET
    assert tick(high, 130.0, pump_on=False).slow_mmhg > 130.0
    # Told nothing, a line that vents is followed as it falls.
    assert tick(high, 100.0, set_mmhg=0.0, pump_on=False).slow_mmhg > 139.0


def test_after_a_reset_the_vacuum_is_known_and_nothing_is_held_against_it() -> None:
    lasting = (-300.0, 5.0, 80.0, 0.1, 1.0, 2.0, 6.0, 3.0, 4.0, 7.0, 8.0)
    broken = LineWatch(90.0, 95.0, SET, 60.0, True, *lasting)
    # What is going on, the average too, goes on.
    assert vacuum_signature.reset(broken) == LineWatch(
        90.0, 95.0, SET, 0.0, False, 0.0, 0.0, 95.0, *[0.0] * 8
    )


@pytest.mark.parametrize("other", [name for name in TIMES if name != "unvented_s"])
def test_what_is_not_vented_is_told_beside_all_else(other: str) -> None:
    alone = found(unvented_s=60.0)
    assert alone != []
    assert set(alone) <= set(found(**{"unvented_s": 60.0, other: 60.0}))


THIN = LIMITS._replace(rests_open=True, bore_fall_mmhg_per_s=24.0)
"""Of a catheter whose flow a running pump hides: a quarter of its fall is 6 mmHg/s."""


@pytest.mark.parametrize(
    ("fall_mmhg_per_s", "is_open", "pump_on", "limits", "flows"),
    [
        (5.9, True, False, THIN, False),
        (6.1, True, False, THIN, True),
        (0.0, False, False, THIN, True),  # behind the closed valve nothing needs to flow
        (0.0, True, True, THIN, True),
        (0.0, True, False, LIMITS, True),
    ],
)
def test_an_open_line_without_a_pump_must_lose_a_quarter_of_what_a_free_catheter_takes(
    fall_mmhg_per_s: float, is_open: bool, pump_on: bool, limits: LineLimits, flows: bool
) -> None:
    state = BUILT
    for i in range(700):
        vacuum = SET - fall_mmhg_per_s * i * DT_S
        state = vacuum_signature.step(
            limits, state, vacuum, SET, pump_on, is_open, not is_open, DT_S
        )
    assert (state.no_flow_s == 0.0) == flows
    if not flows:
        # Once the regulator has settled; a fall is averaged over a tenth of a second.
        assert state.no_flow_s == pytest.approx(0.4, abs=0.002)


def test_a_line_that_is_still_being_built_up_loses_nothing() -> None:
    """A pump raises it by 200 mmHg/s, from nine tenths to where it must stay in 24 ms."""
    state = BUILT._replace(built=False, vacuum_mmhg=95.0, slow_mmhg=80.0, pumping_s=0.1)
    for i in range(200):
        state = tick(state, min(95.0 + 0.2 * i, 119.0), is_closed=True)
        assert state.closed_low_s == 0.0
    # One that stays where it is loses as much as it gains.
    for _ in range(400):
        state = tick(state, 110.0, is_closed=True)
    assert state.closed_low_s > vacuum_signature.CLOSED_LOW_S
