"""Evaluation of a tick's readings: limits, times, dropouts and the state after a reset."""

import pytest

from opensuction.safety import limits as safety_limits
from opensuction.safety.head import head_vote
from opensuction.safety.head.drive_force import DriveForce
from opensuction.safety.invalid_ticks import INVALID_TICKS, InvalidTicks
from opensuction.safety.limits import AdvanceBound, TipInterval
from opensuction.safety.watch import tip_force, vacuum_signature, watch
from opensuction.safety.watch.bus_watch import BusWatch
from opensuction.safety.watch.tip_force import ContactWindow, Load, TipForce
from opensuction.safety.watch.vacuum_signature import START, LineFilter, LineWatch
from opensuction.safety.watch.valve_axis import ValveAxis
from opensuction.safety.watch.watch_state import NO_DURATIONS, Durations, Watch
from tests.safety.observer import HEAD_MM, observed, seen
from tests.safety.watchdog import (
    DT_S,
    INF,
    LIMITS,
    NAN,
    PARK_MM,
    above,
    believed,
    below,
    changed,
    sound,
    staying,
)

HERE = staying(HEAD_MM)
TIMES = Durations._fields


def counting(after: Watch) -> set[str]:
    """What has begun to last."""
    return {name for name in TIMES if getattr(after.durations, name) > 0.0}


# At power-up.


def test_at_power_up_nothing_has_lasted_and_the_tip_is_as_deep_as_can_be() -> None:
    state = watch.start(LIMITS, HEAD_MM, read=True)
    assert state.head_mm == state.suction_start_mm == state.advance.head_mm == HEAD_MM
    assert state.speed_mm_per_s == state.cam_rad == 0.0
    # Whoever was in control before may have left it on its way in.
    assert state.advance.coast_mm_per_s == LIMITS.leaving_mm_per_s
    assert state.tip == safety_limits.assume_anywhere(LIMITS.tip, HEAD_MM)
    assert not state.parked_closed
    assert state.open_contact_ticks == state.late_ticks == 0
    assert state.invalid == InvalidTicks(0, 0, 0, 0, 0)
    assert state.durations == NO_DURATIONS
    assert state.drive == DriveForce(0.0, 0.0, 0.0, 0.0, 0.0)
    assert state.vote == head_vote.start(HEAD_MM, read=True)
    assert state.runaway_ticks == state.overspeed_ticks == 0
    assert state.late_share == 0.0
    assert state.valve == ValveAxis(0.0, 0.0, 0.0, resting=False)
    assert state.line == START
    assert state.window == tip_force.WINDOW_START
    assert state.filter == vacuum_signature.FILTER_START


def test_a_head_that_was_never_read_has_no_speed_when_it_is() -> None:
    blind = watch.start(LIMITS, 90.0, read=False)
    assert blind.vote.unseen_ticks > INVALID_TICKS
    found = observed(blind, sound(HEAD_MM))
    assert (found.head_mm, found.vote.unseen_ticks) == (HEAD_MM, 0)
    assert abs(found.speed_mm_per_s) < 0.01
    assert found.advance.head_mm == HEAD_MM


def test_a_sound_tick_begins_nothing() -> None:
    after = observed(seen(PARK_MM), sound(PARK_MM))
    assert counting(after) == set()
    assert after.invalid == InvalidTicks(0, 0, 0, 0, 0)
    assert after.late_ticks == 0


# Dropouts.


@pytest.mark.parametrize(
    ("wrong", "name"),
    [
        ({"head_mm": NAN}, "head"),
        ({"head_mm": INF}, "head"),
        ({"head_valid": False}, "head"),
        ({"carriage_mm": NAN}, "carriage"),
        ({"carriage_valid": False}, "carriage"),
        ({"cam_rad": -INF}, "cam"),
        ({"cam_valid": False}, "cam"),
        ({"line_vacuum_mmhg": NAN}, "vacuum"),
        ({"vacuum_valid": False}, "vacuum"),
        ({"contact_valid": False}, "contact"),
    ],
    ids=str,
)
def test_ticks_without_a_reading_are_counted_each_for_itself(
    wrong: dict[str, object], name: str
) -> None:
    before = seen()._replace(invalid=InvalidTicks(2, 2, 2, 2, 2))
    after = observed(before, changed(sound(HEAD_MM), wrong))
    assert after.invalid == InvalidTicks(0, 0, 0, 0, 0)._replace(**{name: 3})


def test_what_cannot_be_read_is_what_was_read_last() -> None:
    before = seen(**{"cam_rad": 0.3, "line.vacuum_mmhg": 77.0})
    dark = changed(
        sound(10.0),
        {
            "cam_rad": 0.1,
            "line_vacuum_mmhg": 10.0,
            "head_valid": False,
            "cam_valid": False,
            "vacuum_valid": False,
        },
    )
    after = observed(before, dark)
    assert (after.head_mm, after.cam_rad, after.line.vacuum_mmhg) == (HEAD_MM, 0.3, 77.0)
    assert after.speed_mm_per_s == 0.0
    read = observed(before, sound(10.0))
    assert (read.head_mm, read.cam_rad, read.line.vacuum_mmhg) == (10.0, 0.0, 10.0)


def test_late_ticks_are_counted_in_a_row() -> None:
    late = seen(late_ticks=3)
    assert observed(late, sound(HEAD_MM), overrun=True).late_ticks == 4
    assert observed(late, sound(HEAD_MM)).late_ticks == 0


def test_the_share_of_late_ticks_is_averaged_over_a_tenth_of_a_second() -> None:
    late = seen(late_share=0.2)
    assert observed(late, sound(HEAD_MM), overrun=True).late_share == pytest.approx(
        0.2 + 0.8 * 0.001 / 0.101
    )
    assert observed(late, sound(HEAD_MM)).late_share == pytest.approx(0.2 - 0.2 * 0.001 / 0.101)


# The head.


def test_speed_is_averaged_over_ten_milliseconds() -> None:
    before = seen(speed_mm_per_s=2.0)
    after = observed(before, sound(HEAD_MM + 0.013))
    assert after.speed_mm_per_s == pytest.approx(2.0 + (13.0 - 2.0) * 0.001 / 0.011)


def test_a_head_that_was_not_read_for_three_ticks_moved_in_four() -> None:
    before = seen(**{"vote.unseen_ticks": 3})
    after = observed(before, sound(HEAD_MM + 0.04))
    assert after.speed_mm_per_s == pytest.approx(10.0 / 11.0)


@pytest.mark.parametrize(
    ("last_mm", "named"),
    [
        (HEAD_MM + 8.0, {"stalled_s"}),
        (above(HEAD_MM + 8.0), {"off_command_s", "stalled_s"}),
        (HEAD_MM - 8.0, {"stalled_s"}),
        (below(HEAD_MM - 8.0), {"off_command_s", "stalled_s"}),
        (HEAD_MM + 0.10, set()),
        (HEAD_MM + 0.12, {"stalled_s"}),
        (HEAD_MM - 0.12, {"stalled_s"}),
    ],
)
def test_a_head_away_from_its_command_lags_and_one_that_stands_has_stalled(
    last_mm: float, named: set[str]
) -> None:
    outside = {"inside_s"}
    assert counting(observed(seen(), sound(HEAD_MM), head_mm=last_mm)) - outside == named
    # Whatever moves has not stalled.
    moved = observed(seen(below(HEAD_MM)), sound(HEAD_MM), head_mm=last_mm)
    assert counting(moved) - outside == named - {"stalled_s"}


def test_a_command_just_as_far_as_friction_may_hold_the_head_is_no_stall() -> None:
    near = LIMITS._replace(stalled_mm=0.125)
    for last_mm, stalled in ((HEAD_MM + 0.125, 0.0), (above(HEAD_MM + 0.125), DT_S)):
        after = observed(seen(), sound(HEAD_MM), limits=near, head_mm=last_mm)
        assert after.durations.stalled_s == stalled


@pytest.mark.parametrize(("opened", "apart_mm"), [(False, 1.0), (True, 0.3)])
def test_motor_and_catheter_head_disagree_beyond_a_distance_that_is_less_with_the_valve_open(
    opened: bool, apart_mm: float
) -> None:
    for off_mm, begun in ((apart_mm, 0.0), (above(apart_mm), DT_S)):
        read = sound(0.0)._replace(carriage_mm=-off_mm)
        after = observed(seen(0.0), read, valve_open=opened)
        assert after.durations.disagreeing_s == begun


def test_the_tip_is_inside_beyond_its_border_and_not_on_it() -> None:
    border = safety_limits.deepest_mm(
        LIMITS.tip, safety_limits.assume_anywhere(LIMITS.tip, HEAD_MM)
    )
    for outside_mm, inside in ((border, 0.0), (below(border), DT_S)):
        limits = LIMITS._replace(outside_mm=outside_mm)
        after = observed(seen(), sound(HEAD_MM), limits=limits)
        assert after.durations.inside_s == inside


@pytest.mark.parametrize(
    ("bound_mm", "coast", "last_mm", "last_mm_per_s", "allowed_mm", "coasting"),
    [
        # At rest where it was told to be.
        (50.0, 0.0, 50.0, 0.0, 50.0, 0.0),
        # Told inwards: as far as it was told, or as its speed takes it.
        (50.0, 0.0, 50.0, 10.0, 50.01, 10.0),
        (50.0, 0.0, 50.5, 10.0, 50.5, 10.0),
        # Told to stop at 10 mm/s: it may coast, braked by 0.2 mm/s each tick.
        (50.0, 10.0, 50.0, 0.0, 50.0098, 9.8),
        (50.0, 0.1, 50.0, 0.0, 50.0, 0.0),
        # Outwards it gains nothing.
        (50.0, 0.0, 50.0, -10.0, 50.0, 0.0),
    ],
)
def test_a_head_may_be_as_far_in_as_it_was_told_and_needs_to_brake(
    bound_mm: float,
    coast: float,
    last_mm: float,
    last_mm_per_s: float,
    allowed_mm: float,
    coasting: float,
) -> None:
    before = seen(advance=AdvanceBound(bound_mm, coast))
    far = observed(before, sound(60.0), head_mm=last_mm, head_mm_per_s=last_mm_per_s)
    assert far.advance.head_mm == pytest.approx(allowed_mm)
    assert far.advance.coast_mm_per_s == pytest.approx(coasting)
    # Its reading lowers it again.
    near = observed(before, sound(45.0), head_mm=last_mm, head_mm_per_s=last_mm_per_s)
    assert near.advance.head_mm == 45.0


@pytest.mark.parametrize(("ticks", "bound_mm"), [(4, 50.0), (5, 60.0), (9, 60.0)])
def test_a_head_that_was_not_read_for_five_ticks_may_be_anywhere_when_it_is_seen_again(
    ticks: int, bound_mm: float
) -> None:
    before = seen(**{"vote.unseen_ticks": ticks})
    assert observed(before, sound(60.0), head_mm=HEAD_MM).advance.head_mm == bound_mm


# The switch.


@pytest.mark.parametrize(
    ("before_s", "open_ticks", "closed", "lasted_s"),
    [
        (0.0, 50, True, DT_S),
        (0.0, 0, False, 0.0),
        (0.1, 0, True, 0.1 + DT_S),
        # Open for nine ticks it may bounce; for ten it is released.
        (0.1, 8, False, 0.1 + DT_S),
        (0.1, 9, False, 0.0),
    ],
)
def test_contact_begins_at_once_and_ends_after_ten_open_ticks(
    before_s: float, open_ticks: int, closed: bool, lasted_s: float
) -> None:
    before = seen(**{"durations.contact_s": before_s, "open_contact_ticks": open_ticks})
    after = observed(before, sound(HEAD_MM)._replace(contact_closed=closed))
    assert after.durations.contact_s == lasted_s
    assert after.open_contact_ticks == (0 if closed else open_ticks + 1)


def test_the_window_learns_when_contact_began_and_when_it_ended() -> None:
    begun = observed(seen(), sound(HEAD_MM)._replace(contact_closed=True))
    tip = LIMITS.tip
    least = tip.gain * (HEAD_MM - 0.5 * tip.wide_mm) + tip.offset_mm
    assert begun.window.touched_mm == pytest.approx(least)
    # A contact that goes on began where it began.
    there = changed(begun, {"window.touched_mm": 12.0})
    assert observed(there, sound(HEAD_MM)._replace(contact_closed=True)).window.touched_mm == 12.0
    ending = changed(begun, {"open_contact_ticks": 9})
    assert observed(ending, sound(HEAD_MM)).window.proven
    assert not observed(seen(), sound(HEAD_MM)).window.proven


# The drive.


@pytest.mark.parametrize(
    ("name", "limit_n"),
    [("jammed_s", 1.4), ("overforce_s", 6.0)],
)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_what_holds_and_what_drives_is_judged_both_ways(
    name: str, limit_n: float, sign: float
) -> None:
    plain = changed(LIMITS, {"drive.newton_per_a": 1.0, "drive.volts_per_a": 1.0})
    # A current that goes on as it is keeps both where they are.
    for size_n, lasted in ((limit_n, 0.0), (above(limit_n), DT_S)):
        force = sign * size_n
        before = seen(drive=DriveForce(force, force, force, 0.0, 0.0))
        read = sound(HEAD_MM)._replace(insertion_current_a=force)
        after = observed(before, read, limits=plain)
        assert getattr(after.durations, name) == lasted


def test_of_a_drive_without_torque_or_without_a_reading_no_force_is_known() -> None:
    before = seen(drive=DriveForce(5.0, 5.0, 5.0, 0.0, 0.0))
    read = sound(HEAD_MM)._replace(insertion_current_a=5.0 / 833.0)
    assert tuple(observed(before, read).drive) == pytest.approx((5.0, 5.0, 5.0, 0.0, 0.0))
    freed = observed(before, read, insertion_on=False).drive
    assert freed == DriveForce(0.0, 0.0, 0.0, freed.offset_a, 0.0)  # all that is read there
    assert 0.0 < freed.offset_a < 5.0 / 833.0
    blind = changed(before, {"vote.unseen_ticks": 1})
    assert observed(blind, read).drive == DriveForce(0.0, 0.0, 0.0, 0.0, 0.0)
    # Nor where the head is other than the encoder has it, now or a tick ago.
    ridden = changed(before, {"vote.encoder_mm": HEAD_MM + 1.0})
    assert observed(ridden, read).drive == DriveForce(0.0, 0.0, 0.0, 0.0, 0.0)


# After a reset.


def test_a_reset_forgets_what_is_over_and_keeps_what_can_still_be_seen() -> None:
    before = Watch(
        head_mm=HEAD_MM,
        vote=head_vote.start(HEAD_MM, read=True)._replace(
            encoder_out=True, carriage_out=True, encoder_odd=8, surprised_ticks=2
        ),
        runaway_ticks=4,
        overspeed_ticks=19,
        late_share=0.2,
        speed_mm_per_s=3.0,
        tip=TipInterval(40.0, 45.0),
        suction_start_mm=48.0,
        advance=AdvanceBound(49.0, 7.0),
        cam_rad=0.3,
        parked_closed=True,
        open_contact_ticks=4,
        bus=BusWatch(6, rising=True, restless_share=0.4),
        late_ticks=3,
        invalid=InvalidTicks(1, 5, 2, 3, 4),
        durations=Durations(*map(float, range(1, 14))),
        drive=DriveForce(1.0, 2.0, 3.0, 0.01, 0.0),
        window=ContactWindow(44.0, 0.1, True, 44.0),
        pressed=TipForce(10.0, 2.0, Load(1.1, 0.9), Load(1.6, 1.4), 0.03),
        valve=ValveAxis(1.0, 2.0, 0.3, resting=True),
        line=LineWatch(
            90.0, 95.0, 120.0, 60.0, True, -300.0, 7.0, 80.0, 0.1, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0
        ),
        filter=LineFilter(92.0, 91.0, 1.0, True),
    )
    tip = LIMITS.tip
    after = watch.reset(LIMITS, before)
    kept = (
        "head_mm",
        "speed_mm_per_s",
        "suction_start_mm",
        "cam_rad",
        "open_contact_ticks",
        "late_ticks",
        "late_share",
    )
    for name in (*kept, "invalid"):
        assert getattr(after, name) == getattr(before, name)
    assert after.tip.foremost_mm == pytest.approx(HEAD_MM + 0.5 * tip.wide_mm)
    assert after.tip.rearmost_mm == pytest.approx(HEAD_MM - 0.5 * tip.wide_mm)
    assert after.advance == AdvanceBound(HEAD_MM, 0.0)
    assert not after.parked_closed
    # Valve not closed and contact go on; the rest begins anew.
    assert after.durations == NO_DURATIONS._replace(
        sucking_s=1.0, contact_s=3.0, driven_contact_s=4.0
    )
    # What the current sensor reads at rest is still so.
    assert after.drive == DriveForce(0.0, 0.0, 0.0, 0.01, 0.0)
    assert after.vote == head_vote.reset(before.vote)
    assert after.runaway_ticks == after.overspeed_ticks == 0
    assert after.window == (44.0, 0.0, False, tip_force.NOWHERE_MM)
    assert after.pressed == tip_force.START
    assert after.valve == ValveAxis(0.0, 0.0, 0.3, resting=True)
    assert after.line.vacuum_mmhg == 90.0
    assert after.filter == before.filter
    assert after.line.unvented_s == after.line.over_s == after.line.pumping_s == 0.0


# A runaway of the encoder alone.


@pytest.mark.parametrize(
    ("lead_mm", "out", "valid", "counts"),
    [
        (0.19, False, True, True),  # the second sensor goes with it, but for play and step
        (0.21, False, True, False),
        (0.21, True, True, True),  # there is nobody to ask
        (0.21, False, False, True),
    ],
)
def test_an_encoder_that_goes_in_without_the_head_is_no_runaway(
    lead_mm: float, out: bool, valid: bool, counts: bool
) -> None:
    told = staying(HEAD_MM - 5.0)
    read = sound(HEAD_MM)._replace(carriage_valid=valid)
    before = seen(**{"advance.head_mm": HEAD_MM - 5.0})
    vote = believed(LIMITS, before, read)._replace(
        encoder_lead_mm=lead_mm + 0.1, carriage_lead_mm=0.1, carriage_out=out
    )
    after = watch.step(LIMITS, before, told, False, read, vote, False, DT_S)
    assert after.runaway_ticks == int(counts)
