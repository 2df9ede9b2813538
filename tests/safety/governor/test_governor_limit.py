"""Every limit of the governor: what is on it is allowed, the least more is a trip, and that one."""

from typing import Any

import pytest

from opensuction.kernel.interface import Readings
from opensuction.safety.condition import Condition
from opensuction.safety.condition_mask import TRIPS, decode_trips
from opensuction.safety.governor import governor, judgement
from opensuction.safety.governor.governor import ForcedWithdrawal, GovernorState
from opensuction.safety.handling import Reaction
from opensuction.safety.limits import Limits, WindowLimits
from tests.safety.watchdog import (
    DT_S,
    HEAD_CAP_MM,
    INF,
    LIMITS,
    NAN,
    PARK_MM,
    above,
    ahead,
    at,
    believed,
    below,
    changed,
    sound,
    staying,
    step,
)

HEAD_MM = 50.0
AT_REST = at(HEAD_MM)
WAY_S = (HEAD_MM - PARK_MM) / 17.0
"""Of a withdrawal from there."""


def read_at(head_mm: float, **watched: object) -> GovernorState:
    """The head there, and no further in than it was told."""
    values = {"head_mm": head_mm, "advance.head_mm": head_mm, **watched}
    state: GovernorState = changed(
        AT_REST, {f"watch.{place}": value for place, value in values.items()}
    )
    return state


def judged(
    state: GovernorState, limits: Limits = LIMITS, proposed: dict[str, object] | None = None
) -> list[Condition]:
    proposal = changed(staying(HEAD_MM), proposed or {})
    return decode_trips(governor.judge(limits, state, state.watch, proposal))


LATEST: list[tuple[str, Any, Any, Condition]] = [
    # The head.
    ("watch.invalid.head", 4, 5, Condition.HEAD_READING_INVALID),
    ("watch.invalid.carriage", 4, 5, Condition.CARRIAGE_READING_INVALID),
    ("watch.durations.disagreeing_s", 0.05, above(0.05), Condition.HEAD_SENSORS_DISAGREE),
    ("watch.vote.encoder_out", False, True, Condition.HEAD_READING_INVALID),
    ("watch.vote.carriage_out", False, True, Condition.CARRIAGE_READING_INVALID),
    ("watch.overspeed_ticks", 19, 20, Condition.HEAD_OVERSPEED),
    ("watch.runaway_ticks", 4, 5, Condition.HEAD_RUNAWAY),
    ("watch.durations.off_command_s", 0.2, above(0.2), Condition.HEAD_NOT_FOLLOWING),
    ("watch.durations.stalled_s", 0.1, above(0.1), Condition.HEAD_STALLED),
    ("watch.durations.jammed_s", 0.1, above(0.1), Condition.CATHETER_JAMMED),
    ("watch.durations.overforce_s", 0.08, above(0.08), Condition.DRIVE_OVERFORCE),
    ("withdrawal.blocked_s", 0.3, above(0.3), Condition.WITHDRAWAL_BLOCKED),
    # The switch.
    ("watch.durations.adrift_s", 1.2, above(1.2), Condition.HEAD_SENSORS_DISAGREE),
    ("watch.durations.remaining_s", 0.2, above(0.2), Condition.HEAD_SENSORS_DISAGREE),
    ("watch.durations.absent_s", 0.05, above(0.05), Condition.TIP_DETACHED),
    ("watch.window.impossible_s", 0.6, above(0.6), Condition.CONTACT_STUCK_CLOSED),
    ("watch.durations.contact_s", 0.3, above(0.3), Condition.CONTACT_TIME),
    # Valve and line.
    ("watch.invalid.cam", 4, 5, Condition.CAM_READING_INVALID),
    ("watch.invalid.vacuum", 4, 5, Condition.VACUUM_READING_INVALID),
    ("watch.durations.overpressure_s", 0.2, above(0.2), Condition.VACUUM_EXCEEDED),
    ("watch.durations.sucking_s", 0.5, above(0.5), Condition.NEGATIVE_PRESSURE_TIME),
    ("watch.line.clogged_s", 4.6, above(4.6), Condition.LINE_CLOGGED),
    ("watch.valve.still_s", 0.15, above(0.15), Condition.VALVE_STUCK_OPEN),
    # The patient, and the host.
    ("watch.durations.inside_s", 0.8, above(0.8), Condition.IN_AIRWAY_TIME),
    ("watch.late_ticks", 4, 5, Condition.LATE_TICKS),
]


@pytest.mark.parametrize(("place", "allowed", "beyond", "code"), LATEST)
def test_what_is_on_a_limit_is_allowed_and_the_least_more_is_its_trip_alone(
    place: str, allowed: object, beyond: object, code: Condition
) -> None:
    assert judged(changed(AT_REST, {place: allowed})) == []
    assert judged(changed(AT_REST, {place: beyond})) == [code]


def test_a_line_of_the_switch_that_is_cut_away_from_home_may_have_gone_with_the_tip() -> None:
    there = judgement.AWAY_MM + PARK_MM
    for ticks, head_mm, trips in (
        (4, 50.0, []),
        (5, there, [Condition.CONTACT_READING_INVALID]),
        (5, above(there), [Condition.CONTACT_READING_INVALID, Condition.TIP_DETACHED]),
    ):
        state = changed(read_at(head_mm), {"watch.invalid.contact": ticks})
        assert judged(state) == trips


def test_sensors_that_disagree_with_the_valve_open_are_told_ten_times_sooner() -> None:
    for lasted_s, trips in ((0.005, []), (above(0.005), [Condition.HEAD_SENSORS_DISAGREE])):
        opened = {"watch.durations.sucking_s": DT_S, "watch.durations.disagreeing_s": lasted_s}
        assert judged(changed(AT_REST, opened)) == trips


def test_a_head_at_rest_has_nothing_against_it() -> None:
    assert judged(AT_REST) == []
    # A trip that was there stays.
    old = 1 << Condition.LATE_TICKS | 1 << Condition.SPO2_LOW
    assert judged(AT_REST._replace(trips=old)) == [Condition.LATE_TICKS, Condition.SPO2_LOW]


@pytest.mark.parametrize(
    ("head_mm", "allowed_s"),
    [(PARK_MM - 2.0, 0.5), (PARK_MM, 0.5), (PARK_MM + 0.5, 0.5 / 17.0 + 0.5)],
)
def test_a_way_out_that_is_not_seen_has_the_time_of_its_way_and_no_less_than_a_turns(
    head_mm: float, allowed_s: float
) -> None:
    there = changed(read_at(head_mm), {"watch.vote.unseen_ticks": 1})
    assert judged(changed(there, {"withdrawal.unseen_s": allowed_s})) == []
    over = changed(there, {"withdrawal.unseen_s": above(allowed_s)})
    assert judged(over) == [Condition.WITHDRAWAL_UNSEEN]
    # Seen again in this tick it goes on.
    assert judged(changed(over, {"watch.vote.unseen_ticks": 0})) == []


@pytest.mark.parametrize(
    ("forced_s", "waiting_s", "given_up"),
    [(0.4, 5.0, False), (above(0.4), 4.0, False), (above(0.4), above(4.0), True)],
)
def test_a_way_out_has_its_time_and_goes_on_for_as_long_as_the_head_comes(
    forced_s: float, waiting_s: float, given_up: bool
) -> None:
    late = {"withdrawal.forced_s": forced_s, "withdrawal.waiting_s": waiting_s}
    assert judged(changed(AT_REST, late)) == [Condition.WITHDRAWAL_TIME] * given_up


def test_a_way_out_has_a_last_clock_by_which_also_a_head_that_comes_is_let_go() -> None:
    for whole_s, trips in (
        (governor.longest_s(LIMITS), []),
        (above(governor.longest_s(LIMITS)), [Condition.WITHDRAWAL_TIME]),
    ):
        comes = {"withdrawal.forced_s": 0.1, "withdrawal.whole_s": whole_s}
        assert judged(changed(AT_REST, comes)) == trips


def test_a_withdrawal_that_is_held_from_its_first_tick_is_blocked() -> None:
    held_s = above(governor.BLOCKED_S)
    held = {"withdrawal.forced_s": held_s, "withdrawal.blocked_s": held_s}
    assert judged(changed(AT_REST, held)) == [Condition.WITHDRAWAL_BLOCKED]


@pytest.mark.parametrize(
    ("mm_per_s", "unseen", "waits"),
    [(-0.9, False, True), (-1.0, False, False), (20.0, False, True), (-20.0, True, True)],
)
def test_a_head_that_is_seen_to_come_is_not_waited_for(
    mm_per_s: float, unseen: bool, waits: bool
) -> None:
    seen = changed(
        read_at(50.0).watch, {"speed_mm_per_s": mm_per_s, "vote.unseen_ticks": int(unseen)}
    )
    before = governor.NONE._replace(waiting_s=1.0)
    after = governor.step_withdrawal(before, seen, True, DT_S)
    assert after.waiting_s == (1.0 + DT_S if waits else 0.0)
    assert governor.step_withdrawal(before, seen, False, DT_S).waiting_s == 0.0


def test_of_a_way_out_that_is_broken_off_only_the_last_clock_is_kept() -> None:
    before = ForcedWithdrawal(1.0, 2.0, 3.0, 4.0, 5.0)
    after = governor.step_withdrawal(before, AT_REST.watch, False, DT_S)
    assert after == governor.NONE._replace(whole_s=5.0)
    forced = governor.step_withdrawal(before, AT_REST.watch, True, DT_S)
    assert forced.whole_s == 5.0 + DT_S


def test_a_millimetre_beyond_the_cap_is_overshoot_more_is_a_trip() -> None:
    for head_mm, trips in (
        (HEAD_CAP_MM + 1.0, []),
        (above(HEAD_CAP_MM + 1.0), [Condition.TIP_BEYOND_CAP]),
    ):
        assert judged(read_at(head_mm)) == trips


@pytest.mark.parametrize(
    ("head_mm", "seconds", "trips"),
    [
        # Up to 5 mm from its place the pre-use test has a contact's whole time to name it.
        (PARK_MM + 5.0, 0.3, []),
        (PARK_MM + 5.0, above(0.3), [Condition.CONTACT_STUCK_CLOSED]),
        (above(PARK_MM + 5.0), 0.6, []),
        (above(PARK_MM + 5.0), above(0.6), [Condition.CONTACT_STUCK_CLOSED]),
    ],
)
def test_a_contact_with_nothing_to_touch_matters_at_once_away_from_home(
    head_mm: float, seconds: float, trips: list[Condition]
) -> None:
    assert judged(read_at(head_mm, **{"window.impossible_s": seconds})) == trips


@pytest.mark.parametrize(("driven_s", "trips"), [(0.2, []), (above(0.2), [Condition.CONTACT_TIME])])
def test_a_tip_that_its_drive_holds_may_touch_for_less_time_than_one_in_a_hand(
    driven_s: float, trips: list[Condition]
) -> None:
    touching = {"watch.durations.contact_s": 0.3, "watch.durations.driven_contact_s": driven_s}
    assert judged(changed(AT_REST, touching), LIMITS._replace(driven_contact_s=0.2)) == trips
    assert judged(changed(AT_REST, touching)) == []


def test_a_contact_that_cannot_be_one_does_not_press() -> None:
    for_long = {"window.impossible_s": DT_S, "durations.contact_s": 9.0}
    assert judged(read_at(PARK_MM, **for_long)) == []
    # Away from home no switch is closed for longer than a contact may last, whatever it touches.
    away = read_at(above(PARK_MM + 5.0), **for_long)
    assert judged(away) == [Condition.CONTACT_STUCK_CLOSED]


@pytest.mark.parametrize(("proven", "stuck"), [(True, []), (False, [Condition.CONTACT_STUCK_OPEN])])
def test_a_carina_that_was_missed_puts_the_switch_in_doubt_unless_it_was_proven(
    proven: bool, stuck: list[Condition]
) -> None:
    searching = LIMITS._replace(window=WindowLimits(from_mm=10.0, by_mm=20.0))
    passed = changed(AT_REST, {"watch.window.proven": proven})
    assert judged(passed, searching) == [Condition.CARINA_MISSED, *stuck]
    # Touching, it has been found; however short the time.
    assert judged(changed(passed, {"watch.durations.contact_s": DT_S}), searching) == []
    short = changed(passed, {"watch.tip.rearmost_mm": 20.0})
    assert judged(short, searching) == []


def test_a_valve_is_stuck_the_way_it_does_not_go() -> None:
    stuck = changed(AT_REST, {"watch.valve.still_s": 1.0})
    assert judged(stuck) == [Condition.VALVE_STUCK_OPEN]
    opened = changed(stuck, {"last.valve_open": True})
    assert judged(opened) == [Condition.VALVE_STUCK_CLOSED]


@pytest.mark.parametrize(
    ("name", "value", "possible"),
    [
        ("vacuum_mmhg", 0.0, True),
        ("vacuum_mmhg", -0.0, True),
        ("vacuum_mmhg", below(0.0), False),
        ("vacuum_mmhg", 1e6, True),
        ("vacuum_mmhg", INF, False),
        ("head_mm", NAN, False),
        ("head_mm_per_s", -INF, False),
    ],
)
def test_only_numbers_can_be_proposed_and_no_pressure(
    name: str, value: float, possible: bool
) -> None:
    assert judged(AT_REST, proposed={name: value}) == (
        [] if possible else [Condition.PROPOSAL_INVALID]
    )


# What it remembers from tick to tick.

ALONE = sound(HEAD_MM)._replace(carriage_valid=False)
"""The encoder without the second sensor."""
FORCED = AT_REST._replace(trips=1 << Condition.LATE_TICKS)
"""On its way out."""
PATIENT = LIMITS._replace(withdrawal_s=9.0, in_airway_s=9.0)


def following(state: GovernorState, read: Readings, limits: Limits = PATIENT) -> GovernorState:
    return step(limits, state, staying(HEAD_MM), read, False, DT_S)[0]


def test_at_power_up_nothing_is_on_and_nothing_has_lasted() -> None:
    state = governor.start(LIMITS, HEAD_MM)
    assert state.last.head_mm == HEAD_MM
    assert state.last.head_mm_per_s == state.last.vacuum_mmhg == 0.0
    assert not any((state.last.insertion_on, state.last.valve_open, state.last.pump_on))
    assert not state.valve_command_changed
    assert state.withdrawal == governor.NONE
    assert state.trips == 0
    assert state.patient.conditions == 0


@pytest.mark.parametrize(
    ("from_home_mm", "forced"), [(0.0, False), (0.5, False), (0.51, True), (40.0, True)]
)
def test_a_withdrawal_lasts_until_half_a_millimetre_from_home(
    from_home_mm: float, forced: bool
) -> None:
    there = PARK_MM + from_home_mm
    state = at(there)._replace(
        trips=1 << Condition.LATE_TICKS, withdrawal=ForcedWithdrawal(1.0, 0.0, 0.0, 0.0, 0.0)
    )
    after = following(state, sound(there))
    assert after.withdrawal.forced_s == (1.0 + DT_S if forced else 0.0)


def test_without_a_trip_nothing_is_forced() -> None:
    state = AT_REST._replace(withdrawal=ForcedWithdrawal(1.0, 0.2, 0.2, 0.2, 0.0))
    blind = sound(HEAD_MM)._replace(head_valid=False)
    after = following(state, blind)
    assert after.withdrawal == governor.NONE


def drawn(mm_per_s: float) -> GovernorState:
    """A withdrawal at this measured speed, held by 5 N."""
    values: dict[str, object] = {
        "watch.speed_mm_per_s": mm_per_s,
        "watch.head_mm": HEAD_MM,
        "watch.drive.resistance_n": -5.0,
        "watch.drive.force_n": -5.0,
        "watch.drive.borne_n": -5.0,
        "withdrawal.blocked_s": 0.1,
        "last.insertion_on": True,
    }
    state: GovernorState = changed(FORCED, values)
    return state


@pytest.mark.parametrize(("apart_s", "forced"), [(0.049, False), (above(0.049), True)])
def test_a_motor_that_is_home_has_withdrawn_nothing_while_its_sensors_disagree(
    apart_s: float, forced: bool
) -> None:
    home = changed(
        read_at(PARK_MM, **{"durations.disagreeing_s": apart_s}),
        {
            "trips": 1 << Condition.HEAD_SENSORS_DISAGREE,
            "last.head_mm": PARK_MM,
            "withdrawal.forced_s": 0.1,
        },
    )
    after = following(home, sound(PARK_MM)._replace(carriage_mm=PARK_MM + 9.0))
    assert after.withdrawal.forced_s == (0.1 + DT_S if forced else 0.0)


@pytest.mark.parametrize(
    ("mm_per_s", "blocked"), [(0.0, True), (-0.9, True), (-1.1, False), (-5.0, False)]
)
def test_a_head_that_is_held_but_still_comes_at_a_millimetre_a_second_is_not_blocked(
    mm_per_s: float, blocked: bool
) -> None:
    # Read where this speed has brought it.
    read = sound(HEAD_MM + mm_per_s * DT_S)._replace(insertion_current_a=-5.0 / 833.0)
    after = following(drawn(mm_per_s), read)
    assert after.withdrawal.blocked_s == (pytest.approx(0.1 + DT_S) if blocked else 0.0)
    # Nothing holds it: not blocked, however slow.
    free = changed(drawn(mm_per_s), {"watch.drive.resistance_n": 0.0, "watch.drive.force_n": 0.0})
    assert following(free, read._replace(insertion_current_a=0.0)).withdrawal.blocked_s == 0.0


def test_a_head_that_comes_at_a_millimetre_a_second_is_not_blocked() -> None:
    values = {"watch.speed_mm_per_s": -1.0, "watch.head_mm": 0.0, "last.head_mm": 0.0}
    before = changed(drawn(-1.0), values)
    read = sound(-0.001)._replace(insertion_current_a=-5.0 / 833.0)
    after = following(before, read)
    assert after.watch.speed_mm_per_s == -1.0
    assert after.watch.durations.jammed_s > 0.0
    assert after.withdrawal.blocked_s == 0.0


def test_a_reading_may_stand_for_a_tenth_of_a_second_on_the_way_out() -> None:
    standing = ahead(FORCED, HEAD_MM - 4.0)
    for dt_s, unseen in ((0.1, False), (above(0.1), True)):
        after = step(PATIENT, standing, staying(HEAD_MM), ALONE, False, dt_s)[0]
        assert after.watch.durations.stalled_s == dt_s
        assert (after.withdrawal.unseen_s > 0.0) == unseen


@pytest.mark.parametrize("out", ["encoder_out", "carriage_out"])
def test_a_head_that_both_sensors_have_standing_still_is_seen(out: str) -> None:
    standing = ahead(changed(FORCED, {"watch.durations.stalled_s": 0.2}), HEAD_MM - 4.0)
    assert following(standing, sound(HEAD_MM)).withdrawal.unseen_s == 0.0
    vote = believed(PATIENT, standing.watch, sound(HEAD_MM))._replace(**{out: True})
    alone = governor.step(PATIENT, standing, staying(HEAD_MM), sound(HEAD_MM), vote, False, DT_S)
    assert alone[0].withdrawal.unseen_s == DT_S


def test_a_withdrawal_is_unseen_without_a_reading_and_with_one_that_stands_still() -> None:
    state = changed(FORCED, {"withdrawal.unseen_s": 0.2})
    assert following(state, sound(HEAD_MM)).withdrawal.unseen_s == 0.0
    blind = sound(HEAD_MM)._replace(head_valid=False)
    assert following(state, blind).withdrawal.unseen_s == 0.2 + DT_S
    # Its command 4 mm away and its reading the same for more than 0.1 s.
    for stood_s, unseen in ((0.1 - 2.0 * DT_S, False), (0.1 + DT_S, True)):
        standing = ahead(changed(state, {"watch.durations.stalled_s": stood_s}), HEAD_MM - 4.0)
        assert following(standing, ALONE).withdrawal.unseen_s == (0.2 + DT_S if unseen else 0.0)


def test_the_valve_is_known_to_have_been_told_otherwise() -> None:
    opened = staying(HEAD_MM)._replace(valve_open=True)
    first = step(PATIENT, AT_REST, opened, sound(HEAD_MM), False, DT_S)[0]
    second = step(PATIENT, first, opened, sound(HEAD_MM), False, DT_S)[0]
    assert (first.valve_command_changed, second.valve_command_changed) == (True, False)


def test_a_verdict_tells_what_was_done() -> None:
    state, allowed, verdict = step(PATIENT, AT_REST, staying(HEAD_MM), sound(HEAD_MM), False, DT_S)
    assert verdict.reaction == Reaction.PASS
    assert (verdict.trips, verdict.patient) == (0, 0)
    assert verdict.insertion_on
    assert not verdict.valve_on  # it is closed, and its spring keeps it so
    assert verdict.deepest_mm == pytest.approx(
        0.9677 * (HEAD_MM + 0.5 * PATIENT.tip.wide_mm) - 7.151
    )
    assert state.last == allowed
    assert state.patient.missing_s == 0.0


def test_a_valve_that_cannot_be_read_or_steered_is_left_to_its_spring_and_no_other() -> None:
    springs = {
        Condition.CAM_READING_INVALID,
        Condition.VALVE_STUCK_OPEN,
        Condition.VALVE_STUCK_CLOSED,
    }
    for code in decode_trips(TRIPS):
        latched = AT_REST._replace(trips=1 << code)
        proposal = staying(HEAD_MM)
        read = sound(HEAD_MM)._replace(cam_rad=0.3)
        verdict = step(PATIENT, latched, proposal, read, False, DT_S)[2]
        assert verdict.trips == 1 << code
        assert verdict.valve_on == (code not in springs), code.name


def test_a_closed_valve_is_driven_from_the_tick_in_which_it_shall_open() -> None:
    closed = step(PATIENT, AT_REST, staying(HEAD_MM), sound(HEAD_MM), False, DT_S)
    erring = sound(HEAD_MM)._replace(cam_rad=-0.3)
    still = step(PATIENT, closed[0], staying(HEAD_MM), erring, False, DT_S)
    assert not closed[2].valve_on
    assert not still[2].valve_on
    opened = staying(HEAD_MM)._replace(valve_open=True)
    assert step(PATIENT, closed[0], opened, sound(HEAD_MM), False, DT_S)[2].valve_on


def test_a_reset_leaves_the_command_at_rest_and_everything_else_as_it_was() -> None:
    going = AT_REST.last._replace(
        head_mm=HEAD_MM,
        head_mm_per_s=12.0,
        insertion_on=True,
        valve_open=True,
        pump_on=True,
        vacuum_mmhg=77.0,
    )
    state = AT_REST._replace(
        last=going,
        valve_command_changed=True,
        withdrawal=ForcedWithdrawal(1.0, 2.0, 3.0, 4.0, 5.0),
        trips=5,
    )
    after = governor.reset(LIMITS, state)
    assert after.last == going._replace(head_mm_per_s=0.0)
    assert not after.valve_command_changed
    assert after.withdrawal == governor.NONE
    assert after.trips == 0
    assert after.patient == state.patient
