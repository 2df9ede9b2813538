"""Reactions of the governor on head, valve and vacuum, and its state after a reset."""

import math

import pytest

from opensuction.kernel.interface import Readings, Setpoints
from opensuction.safety.condition import Condition
from opensuction.safety.condition_mask import decode_trips
from opensuction.safety.governor import governor
from opensuction.safety.handling import Reaction
from opensuction.safety.limits import Limits
from opensuction.safety.watch import vacuum_signature
from tests.safety.watchdog import (
    DT_S,
    HEAD_CAP_MM,
    INF,
    LIMITS,
    NAN,
    PARK_MM,
    Tick,
    ahead,
    at,
    first,
    run,
    sound,
    staying,
    tripped,
    turning,
)

AFTER_S = 0.05
"""Faults begin here."""


def stay(head_mm: float = PARK_MM) -> Setpoints:
    return staying(head_mm)


@pytest.mark.requirement("OS-R13")
def test_a_head_that_cannot_be_withdrawn_is_let_go_in_the_end() -> None:
    def propose(time_s: float) -> Setpoints:
        return stay(50.0)._replace(head_mm=NAN) if time_s >= AFTER_S else stay(50.0)

    ticks = run(4.3, propose, lambda t, _: sound(50.0 + 1e-3 * (round(t / DT_S) % 2)), at(50.0))
    last = first(ticks, Condition.WITHDRAWAL_TIME)
    assert last.time_s == pytest.approx(AFTER_S + governor.WAITING_S, abs=2 * DT_S)
    assert last.verdict.reaction == Reaction.TORQUE_OFF


def cap_at(head_mm: float) -> Limits:
    """Limits by which the head may be there at most: the way home from there is short."""
    least_mm = head_mm - 0.5 * LIMITS.tip.narrow_mm
    return LIMITS._replace(cap_mm=least_mm * LIMITS.tip.gain + LIMITS.tip.offset_mm)


def is_let_go(tick: Tick) -> bool:
    return tick.verdict.reaction == Reaction.TORQUE_OFF


@pytest.mark.requirement("OS-R13")
@pytest.mark.parametrize(
    ("deep_mm", "back_mm"),
    [(50.0, 60.0), (PARK_MM + 1.0, 1.0), pytest.param(50.0, 1.0, marks=pytest.mark.sweep)],
)
def test_a_head_of_which_both_sensors_say_for_ever_that_it_comes_is_let_go(
    deep_mm: float, back_mm: float
) -> None:
    """As they drift out, as they jump back again and again, and as they say "home" in between."""

    def drift(time_s: float, _: float) -> Readings:
        return sound(deep_mm - 1.2 * time_s % back_mm)

    limits = cap_at(PARK_MM + 2.0)
    state = at(deep_mm)
    ticks = run(13.0, lambda _: stay()._replace(head_mm=NAN), drift, state, limits=limits)
    driven = [tick for tick in ticks if not is_let_go(tick)]
    assert is_let_go(ticks[-1])
    assert Condition.WITHDRAWAL_TIME in decode_trips(ticks[-1].verdict.trips)
    away_s = DT_S * sum(tick.state.watch.head_mm > PARK_MM + 0.5 for tick in driven)
    assert away_s == pytest.approx(governor.longest_s(limits), abs=2 * DT_S)


def test_a_head_that_comes_as_slowly_as_one_may_is_not_let_go_on_its_way_from_the_cap() -> None:
    """After a loose contact that was waited for nearly as long as one is."""
    cap_mm, waits_s = PARK_MM + 3.0, governor.WAITING_S - 0.1

    def creep(time_s: float, _: float) -> Readings:
        trembling_mm = 1e-3 * (round(time_s / DT_S) % 2)
        return sound(max(cap_mm - 1.02 * max(time_s - waits_s, 0.0), PARK_MM) + trembling_mm)

    limits = cap_at(cap_mm)._replace(in_airway_s=9.0)
    state = at(cap_mm)
    ticks = run(8.0, lambda _: stay()._replace(head_mm=NAN), creep, state, limits=limits)
    assert not any(is_let_go(tick) for tick in ticks)
    assert ticks[-1].readings.head_mm < PARK_MM + 0.01


def test_a_head_at_home_is_not_withdrawn_forever() -> None:
    ticks = run(1.0, lambda _: stay()._replace(head_mm=NAN))
    assert tripped(ticks) == {Condition.PROPOSAL_INVALID}


def test_withdrawal_brings_the_head_home_at_its_speed_limit_and_stays() -> None:
    limits = LIMITS._replace(withdrawal_s=9.0, in_airway_s=9.0)
    ticks = run(1.2, lambda _: stay(10.0)._replace(head_mm=NAN), state=at(10.0), limits=limits)
    home = next(tick for tick in ticks if tick.allowed.head_mm == PARK_MM)
    assert home.time_s == pytest.approx((10.0 - PARK_MM) / 20.0, abs=2 * DT_S)
    assert all(tick.allowed.head_mm == PARK_MM for tick in ticks if tick.time_s > home.time_s)


def test_withdrawal_starts_from_where_the_head_is_not_from_a_command_far_ahead() -> None:
    state = ahead(at(50.0), 57.0)
    ticks = run(0.002, lambda _: stay()._replace(vacuum_mmhg=NAN), lambda *_: sound(50.0), state)
    assert ticks[0].allowed.head_mm == pytest.approx(50.0 - 20.0 * DT_S)


@pytest.mark.requirement("OS-R06")
def test_contact_stops_the_head_in_the_same_tick() -> None:
    state = ahead(at(50.0), 51.2)
    touching = [
        sound(50.0)._replace(contact_closed=True),
        sound(50.2)._replace(contact_closed=True),
    ]
    ticks = run(0.002, lambda _: stay(52.0), lambda t, _: touching[round(t / DT_S)], state)
    assert [tick.verdict.reaction for tick in ticks] == [Reaction.HOLD, Reaction.HOLD]
    # And it does not follow a head that is pushed on.
    assert [tick.allowed.head_mm for tick in ticks] == [50.0, 50.0]
    assert ticks[0].allowed.head_mm_per_s == 0.0


def test_on_contact_a_way_out_leaves_from_where_the_head_is_not_from_a_command_ahead() -> None:
    state = ahead(at(50.0), 51.2)

    def touch(_time_s: float, _head_mm: float) -> Readings:
        return sound(50.0)._replace(contact_closed=True)

    stopped = run(0.001, lambda _: stay(50.0), touch, state)[0]
    leaving = run(0.001, lambda _: stay(40.0), touch, state)[0]
    assert (stopped.allowed.head_mm, stopped.allowed.head_mm_per_s) == (50.0, 0.0)
    assert stopped.verdict.reaction == Reaction.PASS
    assert leaving.allowed.head_mm == pytest.approx(50.0 - 20.0 * DT_S)


def test_contact_does_not_keep_the_head_from_leaving() -> None:
    def leave(time_s: float) -> Setpoints:
        return stay(50.0 - 9.0 * time_s)

    touching = run(0.1, leave, lambda _, h: sound(h)._replace(contact_closed=True), at(50.0))
    assert {tick.verdict.reaction for tick in touching} == {Reaction.PASS}


def test_an_opening_valve_stops_a_command_that_is_ahead() -> None:
    state = ahead(at(50.0), 53.0)
    ticks = run(
        0.002, lambda _: stay(53.0)._replace(valve_open=True), lambda *_: sound(50.0), state
    )
    assert ticks[0].allowed.valve_open
    assert ticks[0].allowed.head_mm == 50.5
    assert ticks[0].verdict.reaction == Reaction.HOLD


def test_a_jump_is_spread_over_ticks_and_told() -> None:
    ticks = run(0.3, lambda _: stay(PARK_MM + 2.6))
    assert ticks[0].verdict.reaction == Reaction.CAP
    assert ticks[0].allowed.head_mm_per_s == pytest.approx(20.0)
    assert ticks[-1].allowed.head_mm == PARK_MM + 2.6
    arrival = next(tick for tick in ticks if tick.allowed.head_mm == PARK_MM + 2.6)
    assert arrival.time_s == pytest.approx(2.6 / 20.0, abs=2 * DT_S)


def test_too_high_a_set_point_is_lowered_and_told() -> None:
    tick = run(0.001, lambda _: stay(50.0)._replace(vacuum_mmhg=200.0), state=at(50.0))[0]
    assert (tick.allowed.vacuum_mmhg, tick.verdict.reaction) == (150.0, Reaction.CAP)


@pytest.mark.requirement("OS-R14")
def test_a_reset_clears_but_a_cause_that_is_still_there_trips_again_at_once() -> None:
    def broken(*_: float) -> Readings:
        return sound(50.0)._replace(cam_valid=False)

    ticks = run(0.05, lambda _: stay(50.0), broken, at(50.0))
    assert tripped(ticks) == {Condition.CAM_READING_INVALID}
    cleared = governor.reset(LIMITS, ticks[-1].state)
    assert Condition.CAM_READING_INVALID in tripped(
        run(0.001, lambda _: stay(50.0), broken, cleared)
    )
    assert tripped(run(0.05, lambda _: stay(50.0), lambda *_: sound(50.0), cleared)) == set()


def test_after_a_reset_the_tip_is_as_deep_as_it_can_be() -> None:
    state = run(1.0, lambda t: stay(PARK_MM + 20.0 * t))[-1].state
    cleared = governor.reset(LIMITS, state)
    assert state.watch.tip.foremost_mm < cleared.watch.tip.foremost_mm
    assert cleared.watch.tip.foremost_mm == at(state.watch.head_mm).watch.tip.foremost_mm


def test_after_a_reset_a_command_that_was_ahead_waits_at_the_head() -> None:
    assert governor.reset(LIMITS, ahead(at(PARK_MM), 60.0)).last.head_mm == PARK_MM
    assert governor.reset(LIMITS, ahead(at(50.0), 48.0)).last.head_mm == 48.0


def test_after_a_reset_the_way_out_has_its_time_anew() -> None:
    ticks = run(0.85, lambda _: stay(50.0), state=at(50.0))
    assert tripped(ticks) == {Condition.IN_AIRWAY_TIME}
    assert (
        tripped(run(0.1, lambda _: stay(50.0), state=governor.reset(LIMITS, ticks[-1].state)))
        == set()
    )


def test_a_head_pushed_by_hand_while_it_was_let_go_is_no_runaway_after_a_reset() -> None:
    def pushed(time_s: float, _head_mm: float) -> Readings:
        return sound(50.0 + 15.0 * time_s)

    ticks = run(0.3, lambda _: stay(50.0), pushed, at(50.0))
    assert tripped(ticks) == {Condition.HEAD_RUNAWAY}
    where_mm = ticks[-1].readings.head_mm
    cleared = governor.reset(LIMITS, ticks[-1].state)
    assert (
        tripped(run(0.05, lambda _: stay(where_mm), lambda *_: sound(where_mm), cleared)) == set()
    )


def test_the_valve_waits_until_the_head_has_stopped() -> None:
    def propose(time_s: float) -> Setpoints:
        return stay(PARK_MM + 9.0 * min(time_s, 0.2))._replace(valve_open=time_s >= 0.1)

    ticks = run(0.3, propose)
    opened = next(tick for tick in ticks if tick.allowed.valve_open)
    # The averaged speed falls from 9 to 3 mm/s in 11 ms.
    assert opened.time_s == pytest.approx(0.211, abs=0.003)
    refused = next(tick for tick in ticks if tick.time_s >= 0.1)
    assert refused.verdict.reaction == Reaction.CAP


def test_a_valve_that_is_not_closed_yet_holds_the_head_too() -> None:
    ticks = run(
        0.3,
        lambda t: stay(50.0 + 9.0 * t),
        lambda t, head: turning(t, head, 0.1),
        at(50.0),
    )
    assert max(tick.allowed.head_mm for tick in ticks) == 50.5
    assert ticks[-1].verdict.reaction == Reaction.HOLD


def test_a_valve_that_cannot_be_read_counts_as_open() -> None:
    ticks = run(0.6, lambda _: stay(), lambda _, head: sound(head)._replace(cam_rad=NAN))
    assert first(ticks, Condition.NEGATIVE_PRESSURE_TIME).time_s == pytest.approx(
        0.504, abs=2 * DT_S
    )


def test_a_head_that_moved_unseen_was_neither_too_fast_nor_a_runaway() -> None:
    def report(time_s: float, _head_mm: float) -> Readings:
        lost = 0.05 < time_s < 0.25
        coasting = sound(50.0 + 15.0 * min(time_s, 0.2))
        blind = coasting._replace(head_valid=False, carriage_valid=False)
        return blind if lost else coasting

    ticks = run(0.4, lambda t: stay(50.1 + 15.0 * t), report, at(50.0))
    assert not tripped(ticks) & {Condition.HEAD_OVERSPEED, Condition.HEAD_RUNAWAY}


@pytest.mark.parametrize("head_mm", [NAN, INF, -1e306])
def test_an_unknown_head_at_power_up_is_taken_to_be_as_deep_as_can_be(head_mm: float) -> None:
    state = governor.start(LIMITS, head_mm)
    assert state.last.head_mm == HEAD_CAP_MM
    assert state.watch.durations.inside_s == 0.0


@pytest.mark.requirement("OS-R03")
def test_a_head_stops_where_vacuum_is_lost_behind_a_closed_valve() -> None:
    """Long before it is a trip: the valve may have opened by itself."""
    lost_s = AFTER_S

    def advance(time_s: float) -> Setpoints:
        return staying(50.0 + 9.0 * time_s)._replace(pump_on=True, vacuum_mmhg=100.0)

    def report(time_s: float, head_mm: float) -> Readings:
        vacuum = 100.0 if time_s < lost_s else 90.0
        return sound(head_mm)._replace(line_vacuum_mmhg=vacuum)

    ticks = run(0.2, advance, report, at(50.0))
    assert tripped(ticks) == set()
    # The filter goes from 100 to 90 mmHg, and 94 are the least.
    low_s = lost_s + vacuum_signature.FILTER_S * math.log(10.0 / 4.0)
    before = [tick for tick in ticks if tick.time_s < low_s + 0.02 - 2 * DT_S]
    after = [tick for tick in ticks if tick.time_s > low_s + 0.02 + 3 * DT_S]
    assert all(tick.verdict.reaction == Reaction.PASS for tick in before)
    assert all(tick.verdict.reaction == Reaction.HOLD for tick in after)
    assert all(tick.allowed.head_mm <= tick.readings.head_mm for tick in after)


@pytest.mark.parametrize("off_mm", [0.0, 0.02, 0.06])
def test_a_head_that_leaves_on_contact_is_told_the_speed_of_its_way_whatever_it_reads(
    off_mm: float,
) -> None:
    """By an encoder whose steps are now ahead of the command, now behind: a servo leads speed."""

    def leave(time_s: float) -> Setpoints:
        return stay(50.0 - 9.0 * time_s)._replace(head_mm_per_s=-9.0)

    def touching(time_s: float, _head_mm: float) -> Readings:
        off = -off_mm if round(time_s / DT_S) % 7 < 3 else off_mm
        read = 0.005 * round((50.0 - 9.0 * time_s + off) / 0.005)
        return sound(read)._replace(contact_closed=True)

    ticks = run(0.29, leave, touching, ahead(at(50.0), 50.0, -9.0))[3:]
    assert not any(tick.verdict.trips for tick in ticks)
    speeds = [tick.allowed.head_mm_per_s for tick in ticks]
    assert min(speeds) >= -9.5
    assert max(speeds) <= -8.5
    assert all(tick.allowed.head_mm <= tick.readings.head_mm for tick in ticks)
