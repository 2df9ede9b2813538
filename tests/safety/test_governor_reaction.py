"""What the governor does to the head, the valve and the vacuum, and what a reset leaves."""

import pytest

from opensuction.kernel.commands import Setpoints
from opensuction.kernel.readings import Readings
from opensuction.safety import governor
from opensuction.safety.trip import Reaction, Trip
from tests.safety.watchdog import (
    DT_S,
    HEAD_CAP_MM,
    INF,
    LIMITS,
    NAN,
    PARK_MM,
    at,
    first,
    run,
    sound,
    staying,
    tripped,
)

AFTER_S = 0.05
"""Faults begin here."""


def stay(head_mm: float = PARK_MM) -> Setpoints:
    return staying(head_mm)


def test_a_head_that_cannot_be_withdrawn_is_let_go_in_the_end() -> None:
    def propose(time_s: float) -> Setpoints:
        return stay(50.0)._replace(head_mm=NAN) if time_s >= AFTER_S else stay(50.0)

    ticks = run(0.6, propose, lambda t, _: sound(50.0 + 1e-3 * (round(t / DT_S) % 2)), at(50.0))
    last = first(ticks, Trip.WITHDRAWAL_TIME)
    assert last.time_s == pytest.approx(AFTER_S + 0.4, abs=2 * DT_S)
    assert last.verdict.reaction == Reaction.TORQUE_OFF


def test_a_head_at_home_is_not_withdrawn_forever() -> None:
    ticks = run(1.0, lambda _: stay()._replace(head_mm=NAN))
    assert tripped(ticks) == {Trip.PROPOSAL_INVALID}


def test_withdrawal_brings_the_head_home_at_its_speed_limit_and_stays() -> None:
    limits = LIMITS._replace(withdrawal_s=9.0, in_airway_s=9.0)
    ticks = run(1.2, lambda _: stay(10.0)._replace(head_mm=NAN), state=at(10.0), limits=limits)
    home = next(tick for tick in ticks if tick.allowed.head_mm == PARK_MM)
    assert home.time_s == pytest.approx((10.0 - PARK_MM) / 20.0, abs=2 * DT_S)
    assert all(tick.allowed.head_mm == PARK_MM for tick in ticks if tick.time_s > home.time_s)


def test_withdrawal_starts_from_where_the_head_is_not_from_a_command_far_ahead() -> None:
    state = at(50.0)._replace(head_mm=57.0)
    ticks = run(0.002, lambda _: stay()._replace(vacuum_mmhg=NAN), lambda *_: sound(50.0), state)
    assert ticks[0].allowed.head_mm == pytest.approx(50.0 - 20.0 * DT_S)


def test_contact_stops_the_head_in_the_same_tick() -> None:
    state = at(50.0)._replace(head_mm=51.2)
    ahead = [sound(50.0)._replace(contact_closed=True), sound(50.3)._replace(contact_closed=True)]
    ticks = run(0.002, lambda _: stay(52.0), lambda t, _: ahead[round(t / DT_S)], state)
    assert [tick.verdict.reaction for tick in ticks] == [Reaction.HOLD, Reaction.HOLD]
    # And it does not follow a head that is pushed on.
    assert [tick.allowed.head_mm for tick in ticks] == [50.0, 50.0]
    assert ticks[0].allowed.head_mm_per_s == 0.0


def test_contact_does_not_keep_the_head_from_leaving() -> None:
    def leave(time_s: float) -> Setpoints:
        return stay(50.0 - 9.0 * time_s)

    touching = run(0.1, leave, lambda _, h: sound(h)._replace(contact_closed=True), at(50.0))
    assert {tick.verdict.reaction for tick in touching} == {Reaction.PASS}


def test_an_opening_valve_stops_a_command_that_is_ahead() -> None:
    state = at(50.0)._replace(head_mm=53.0)
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
    tick = run(0.001, lambda _: stay()._replace(vacuum_mmhg=200.0))[0]
    assert (tick.allowed.vacuum_mmhg, tick.verdict.reaction) == (150.0, Reaction.CAP)


def test_a_reset_clears_but_a_cause_that_is_still_there_trips_again_at_once() -> None:
    def broken(*_: float) -> Readings:
        return sound(50.0)._replace(cam_valid=False)

    ticks = run(0.05, lambda _: stay(50.0), broken, at(50.0))
    assert tripped(ticks) == {Trip.CAM_READING_INVALID}
    cleared = governor.reset(LIMITS, ticks[-1].state)
    assert Trip.CAM_READING_INVALID in tripped(run(0.001, lambda _: stay(50.0), broken, cleared))
    assert tripped(run(0.05, lambda _: stay(50.0), lambda *_: sound(50.0), cleared)) == set()


def test_after_a_reset_the_tip_is_as_deep_as_it_can_be_and_the_command_where_the_head_is() -> None:
    state = at(PARK_MM)._replace(head_mm=60.0)
    cleared = governor.reset(LIMITS, state)
    assert cleared.head_mm == PARK_MM
    assert cleared.watch.foremost_mm == at(PARK_MM).watch.foremost_mm


@pytest.mark.parametrize("head_mm", [NAN, INF])
def test_an_unknown_head_at_power_up_is_taken_to_be_as_deep_as_can_be(head_mm: float) -> None:
    state = governor.start(LIMITS, head_mm)
    assert state.head_mm == HEAD_CAP_MM
    assert state.watch.lasting.inside == 0.0
