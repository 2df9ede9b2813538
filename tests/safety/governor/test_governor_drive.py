"""Force, acceleration and the way out: what the governor makes of current and a blind encoder."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel.interface import Readings, Setpoints
from opensuction.safety.condition import Condition
from opensuction.safety.condition_mask import decode_trips
from opensuction.safety.governor import governor, limiter
from opensuction.safety.governor.governor import GovernorState, Verdict
from opensuction.safety.handling import Reaction
from tests.safety.watchdog import (
    DT_S,
    LIMITS,
    NAN,
    PARK_MM,
    ahead,
    at,
    believed,
    changed,
    first,
    run,
    sound,
    staying,
    tripped,
    turning,
)

PATIENT = LIMITS._replace(withdrawal_s=9.0, in_airway_s=9.0)
"""Time enough for what is tested here."""
SLOW = PATIENT._replace(head_mm_per_s2=200.0)
ONE_N_A = 1.0 / LIMITS.drive.newton_per_a


def stay(head_mm: float = 50.0) -> Setpoints:
    return staying(head_mm)


@given(before=st.floats(-20.0, 20.0), wanted=st.floats(-60.0, 140.0), contact=st.booleans())
def test_speed_is_gained_no_faster_than_its_limit_and_lost_at_once(
    before: float, wanted: float, contact: bool
) -> None:
    state = ahead(at(50.0), 50.0, before)
    report = sound(50.0)._replace(contact_closed=contact)
    tick = run(DT_S, lambda _: stay(wanted), lambda *_: report, state, limits=SLOW)[0]
    gained = SLOW.head_mm_per_s2 * DT_S + 1e-9
    speed = tick.allowed.head_mm_per_s
    assert min(before, 0.0) - gained <= speed <= max(before, 0.0) + gained
    stopped = run(DT_S, lambda _: stay(50.0), lambda *_: report, state, limits=SLOW)[0]
    assert stopped.allowed.head_mm_per_s == 0.0


def test_a_forced_withdrawal_gains_speed_as_slowly() -> None:
    ticks = run(0.05, lambda _: stay(NAN), lambda *_: sound(50.0), at(50.0), limits=SLOW)
    speeds = [tick.allowed.head_mm_per_s for tick in ticks]
    assert speeds[:3] == pytest.approx([-0.2, -0.4, -0.6])


def test_a_head_that_is_not_read_is_drawn_out_and_let_go_when_it_must_be_there() -> None:
    def report(time_s: float, _head_mm: float) -> Readings:
        read = time_s < 0.05
        return sound(50.0)._replace(head_valid=read, carriage_valid=read)

    ticks = run(4.5, lambda _: stay(), report, at(50.0), limits=PATIENT)
    lost, let_go = (
        first(ticks, Condition.HEAD_READING_INVALID),
        first(ticks, Condition.WITHDRAWAL_UNSEEN),
    )
    assert lost.verdict.reaction == Reaction.WITHDRAW
    assert lost.allowed.head_mm < 50.0
    way_s = (50.0 - PARK_MM) / LIMITS.leaving_mm_per_s
    assert let_go.time_s - lost.time_s == pytest.approx(way_s + 0.5, abs=0.01)
    assert let_go.verdict.reaction == Reaction.TORQUE_OFF
    assert min(tick.allowed.head_mm for tick in ticks) >= (
        50.0 - limiter.LEAD_SHARE * LIMITS.following_mm
    )


def test_a_parked_head_that_is_not_read_stays_where_it_is() -> None:
    ticks = run(1.0, lambda _: stay(PARK_MM), lambda *_: sound(PARK_MM)._replace(head_valid=False))
    assert {tick.allowed.head_mm for tick in ticks} == {PARK_MM}
    assert Condition.WITHDRAWAL_UNSEEN not in tripped(ticks)


def test_what_holds_the_head_on_its_way_out_is_not_pulled_for_long() -> None:
    def report(time_s: float, _head_mm: float) -> Readings:
        trembling = 50.0 + 1e-4 * (round(time_s / DT_S) % 2)
        return sound(trembling)._replace(insertion_current_a=-5.0 * ONE_N_A)

    ticks = run(1.0, lambda _: stay(NAN), report, at(50.0), limits=PATIENT)
    assert tripped(ticks) >= {Condition.CATHETER_JAMMED, Condition.WITHDRAWAL_BLOCKED}
    assert first(ticks, Condition.WITHDRAWAL_BLOCKED).time_s == pytest.approx(0.32, abs=0.02)
    assert not ticks[-1].allowed.insertion_on


def test_a_head_that_comes_out_against_a_jam_goes_on() -> None:
    def report(time_s: float, _head_mm: float) -> Readings:
        return sound(50.0 - 5.0 * time_s)._replace(insertion_current_a=-4.0 * ONE_N_A)

    ticks = run(1.0, lambda _: stay(NAN), report, at(50.0), limits=PATIENT)
    assert Condition.CATHETER_JAMMED in tripped(ticks)
    assert Condition.WITHDRAWAL_BLOCKED not in tripped(ticks)
    assert ticks[-1].allowed.insertion_on


@pytest.mark.parametrize(("force_n", "trips"), [(5.5, False), (6.5, True), (-6.5, True)])
def test_a_drive_stronger_than_its_limit_is_told_to_come_out(force_n: float, trips: bool) -> None:
    def report(_time_s: float, head_mm: float) -> Readings:
        return sound(head_mm)._replace(insertion_current_a=force_n * ONE_N_A)

    ticks = run(0.2, lambda _: stay(), report, at(50.0), limits=PATIENT)
    assert (Condition.DRIVE_OVERFORCE in tripped(ticks)) == trips
    if trips:
        tick = first(ticks, Condition.DRIVE_OVERFORCE)
        # 80 ms, and what the average of the current takes.
        assert 0.08 < tick.time_s < 0.11
        assert tick.verdict.reaction == Reaction.WITHDRAW


def test_the_relief_valve_is_tested_only_parked_and_behind_a_closed_valve() -> None:
    def test_it(head_mm: float, opened: bool = False) -> Setpoints:
        return stay(head_mm)._replace(vacuum_mmhg=175.0, valve_open=opened)

    def allowed_mmhg(head_mm: float, cam_rad: float, opened: bool = False) -> float:
        ticks = run(
            0.01,
            lambda _: test_it(head_mm, opened),
            lambda t, head: turning(t, head, cam_rad),
            at(head_mm),
        )
        return max(tick.allowed.vacuum_mmhg for tick in ticks)

    assert allowed_mmhg(PARK_MM, 0.01) == 175.0
    assert allowed_mmhg(PARK_MM + 5.0, 0.01) == LIMITS.vacuum_mmhg
    assert allowed_mmhg(PARK_MM, 0.03) == LIMITS.vacuum_mmhg
    assert allowed_mmhg(PARK_MM, 0.01, opened=True) == LIMITS.vacuum_mmhg


def test_no_valve_opens_on_more_vacuum_than_the_patients_limit() -> None:
    def full(_time_s: float, head_mm: float) -> Readings:
        return sound(head_mm)._replace(line_vacuum_mmhg=153.0)

    ticks = run(0.1, lambda _: stay(PARK_MM)._replace(valve_open=True), full)
    assert not any(tick.allowed.valve_open for tick in ticks)
    assert math.isfinite(ticks[-1].verdict.deepest_mm)


# A drive whose wires are swapped.


def running_away(force_n: float, asked_n: float) -> GovernorState:
    """In the tick before a runaway is a trip, with that force measured and that one asked for."""
    state: GovernorState = changed(
        at(50.0),
        {
            "last.insertion_on": True,
            "watch.advance.head_mm": 45.0,
            "watch.speed_mm_per_s": 9.0,
            "watch.runaway_ticks": 4,
            "watch.drive.force_n": force_n,
            "watch.drive.borne_n": asked_n,
        },
    )
    return state


def running(state: GovernorState, head_mm: float) -> tuple[GovernorState, Setpoints, Verdict]:
    """Another tick of it, its command far behind the head."""
    behind = ahead(changed(state, {"watch.advance.head_mm": head_mm - 5.0}), head_mm - 5.0)
    # The current that goes on as it is.
    current = state.watch.drive.force_n * ONE_N_A
    read = sound(head_mm)._replace(insertion_current_a=current)
    vote = believed(PATIENT, behind.watch, read)._replace(
        driven_v=state.watch.drive.borne_n * ONE_N_A * PATIENT.drive.volts_per_a
        + state.watch.speed_mm_per_s / PATIENT.drive.mm_per_s_per_v
    )
    return governor.step(PATIENT, behind, staying(head_mm - 5.0), read, vote, False, DT_S)


@pytest.mark.requirement("OS-R10", "OS-R45")
@pytest.mark.parametrize(
    ("force_n", "asked_n", "turned"),
    [
        (3.0, -3.0, True),
        (-3.0, 3.0, True),
        (3.0, 3.0, False),
        (3.0, -0.9, False),
        (0.9, -3.0, False),
        (0.0, 0.0, False),
    ],
)
def test_a_drive_that_pushes_against_its_volts_is_turned_round_and_any_other_let_go(
    force_n: float, asked_n: float, turned: bool
) -> None:
    state, allowed, verdict = running(running_away(force_n, asked_n), 50.0)
    assert Condition.HEAD_RUNAWAY in decode_trips(verdict.trips)
    assert verdict.turned == turned
    assert state.turned_ticks == int(turned)
    assert verdict.reaction == (Reaction.WITHDRAW if turned else Reaction.TORQUE_OFF)
    assert verdict.insertion_on == turned
    assert not allowed.pump_on
    if turned:
        # It may brake from where it is and as fast as it is, and no force is known yet.
        assert state.watch.advance.head_mm == 50.0
        assert state.watch.advance.coast_mm_per_s == pytest.approx(9.0, abs=1.0)
        assert state.watch.runaway_ticks == 0
        assert state.watch.drive.force_n == state.watch.drive.borne_n == 0.0


@pytest.mark.requirement("OS-R10", "OS-R45")
@pytest.mark.parametrize(
    ("force_n", "asked_n", "coasts"),
    [
        (0.1, -3.0, True),
        (-0.1, -3.0, True),
        (-3.0, -3.0, True),
        (0.3, -3.0, False),
        (0.1, -0.9, False),
    ],
)
def test_a_motor_that_does_not_push_leaves_the_head_to_coast_and_is_told_to_come_out(
    force_n: float, asked_n: float, coasts: bool
) -> None:
    state, _, verdict = running(running_away(force_n, asked_n), 50.0)
    trips = decode_trips(verdict.trips)
    assert (Condition.HEAD_NOT_FOLLOWING in trips) == coasts
    assert (Condition.HEAD_RUNAWAY in trips) == (not coasts)
    assert verdict.reaction == (Reaction.WITHDRAW if coasts else Reaction.TORQUE_OFF)
    assert not verdict.turned
    if coasts:
        # Pushed after all it runs away anew, and is let go.
        pushed = changed(state, {"watch.drive.force_n": 3.0, "watch.drive.borne_n": 3.0})
        for tick in range(5):
            pushed, _, verdict = running(pushed, 50.0 + 0.01 * tick)
        assert verdict.reaction == Reaction.TORQUE_OFF


@pytest.mark.requirement("OS-R10", "OS-R45")
@pytest.mark.parametrize(("resistance_n", "reaction"), [(-0.9, "WITHDRAW"), (-1.9, "TORQUE_OFF")])
def test_a_head_that_goes_in_although_its_motor_pulls_is_helped_and_let_go(
    resistance_n: float, reaction: str
) -> None:
    state = changed(running_away(-3.0, -3.0), {"watch.drive.resistance_n": resistance_n})
    assert running(state, 50.0)[2].reaction == Reaction[reaction]


@pytest.mark.requirement("OS-R10")
def test_one_that_runs_away_again_is_let_go_and_a_reset_forgets_all() -> None:
    state, _, _ = running(running_away(3.0, -3.0), 50.0)
    for tick in range(5):
        assert state.turned_ticks == tick + 1
        state, _, verdict = running(state, 50.0 + 0.01 * tick)
    assert not verdict.turned
    assert verdict.reaction == Reaction.TORQUE_OFF
    # Once let go it stays so, whatever the current says.
    again = changed(state, {"watch.drive.force_n": 3.0, "watch.drive.borne_n": -3.0})
    assert running(again, 50.1)[2].reaction == Reaction.TORQUE_OFF
    turned = running(running_away(3.0, -3.0), 50.0)[0]
    assert governor.reset(PATIENT, turned).turned_ticks == 0


@pytest.mark.requirement("OS-R10")
@pytest.mark.parametrize(("force_n", "obeys"), [(1.2, False), (0.8, True)])
def test_one_that_goes_on_pushing_after_five_ticks_is_let_go(force_n: float, obeys: bool) -> None:
    turned = running(running_away(3.0, -3.0), 50.0)[0]
    for ticks in (4, 5, 20, 21):
        before = changed(
            turned,
            {
                "turned_ticks": ticks,
                "watch.drive.force_n": force_n,
                "watch.drive.borne_n": force_n,
                "watch.runaway_ticks": 0,
            },
        )
        _, _, verdict = running(before, 50.0)
        # Later it pushes where it brakes at home.
        assert verdict.turned == (obeys or ticks in (4, 21))
        assert verdict.insertion_on == verdict.turned


def test_a_drive_that_is_told_the_opposite_by_no_runaway_is_not_turned() -> None:
    calm = changed(running_away(3.0, -3.0), {"watch.runaway_ticks": 0})
    assert not running(calm, 50.0)[2].turned


@pytest.mark.requirement("OS-R10", "OS-R45")
@pytest.mark.parametrize(
    ("forced_s", "trips", "believed_at_once"),
    [
        (0.05, 1 << Condition.HEAD_SENSORS_DISAGREE, False),
        (0.11, 1 << Condition.HEAD_SENSORS_DISAGREE, True),
        (0.05, 1 << Condition.HEAD_NOT_FOLLOWING, True),
    ],
)
def test_what_late_readings_tell_of_before_a_withdrawal_is_no_runaway_of_it(
    forced_s: float, trips: int, believed_at_once: bool
) -> None:
    """Readings 56 ms old, a servo that swings on them, and the current of the swing before.

    Believed, the drive was told the opposite of what brought it out, and let go: left inside.
    """
    before = changed(
        running_away(3.0, -3.0),
        {"trips": trips, "withdrawal.forced_s": forced_s},
    )
    state, _, verdict = running(before, 50.0)
    assert verdict.turned == believed_at_once
    assert verdict.reaction == Reaction.WITHDRAW
    if not believed_at_once:
        # A motor that pushes for good is told the opposite a little later.
        pushed = changed(
            state,
            {
                "withdrawal.forced_s": 0.2,
                "watch.runaway_ticks": 4,
                "watch.drive.force_n": 3.0,
                "watch.drive.borne_n": -3.0,
            },
        )
        assert running(pushed, 50.0)[2].turned
