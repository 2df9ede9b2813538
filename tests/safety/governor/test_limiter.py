"""Limits on a proposal, a tick at a time: each limit, on it and just beyond."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel.interface import Setpoints
from opensuction.safety.condition import Condition
from opensuction.safety.governor import limiter
from opensuction.safety.handling import Reaction
from opensuction.safety.limits import Limits
from opensuction.safety.watch.watch_state import Watch
from tests.safety.watchdog import (
    HEAD_CAP_MM,
    LIMITS,
    PARK_MM,
    above,
    at,
    below,
    changed,
    staying,
)

HEAD_MM = 50.0
DT_S = 0.0078125
"""1/128 s: what is multiplied by it stays exact."""
STEP_MM = 20.0 * DT_S
"""Furthest that a head of 20 mm/s is told to go in a tick."""
HERE = staying(HEAD_MM)
SEEN = at(HEAD_MM).watch
CLOGGED = 1 << Condition.LINE_CLOGGED
"""Withdraws with the vacuum kept."""
LATE = 1 << Condition.LATE_TICKS
"""Withdraws with the vacuum cut."""
RUNAWAY = 1 << Condition.HEAD_RUNAWAY
"""Torque off."""


def seeing(**values: object) -> Watch:
    watch: Watch = changed(SEEN, values)
    return watch


TOUCHING: Watch = changed(SEEN, {"durations.contact_s": 0.01})
SUCKING: Watch = changed(SEEN, {"durations.sucking_s": 0.01})


def narrowed(
    proposal: Setpoints,
    seen: Watch = SEEN,
    last: Setpoints = HERE,
    trips: int = 0,
    limits: Limits = LIMITS,
) -> tuple[Setpoints, Reaction]:
    allowed, reaction = limiter.narrow(limits, last, seen, proposal, trips, DT_S)
    return allowed, Reaction(reaction)


def told(head_mm: float, mm_per_s: float = 0.0) -> Setpoints:
    return HERE._replace(head_mm=head_mm, head_mm_per_s=mm_per_s)


@pytest.mark.parametrize(
    ("wanted_mm", "allowed_mm", "reaction"),
    [
        (HEAD_MM, HEAD_MM, Reaction.PASS),
        (HEAD_MM + STEP_MM, HEAD_MM + STEP_MM, Reaction.PASS),
        (above(HEAD_MM + STEP_MM), HEAD_MM + STEP_MM, Reaction.CAP),
        (HEAD_MM - STEP_MM, HEAD_MM - STEP_MM, Reaction.PASS),
        (below(HEAD_MM - STEP_MM), HEAD_MM - STEP_MM, Reaction.CAP),
    ],
)
def test_a_head_goes_as_far_in_a_tick_as_its_speed_and_no_further(
    wanted_mm: float, allowed_mm: float, reaction: Reaction
) -> None:
    allowed, done = narrowed(told(wanted_mm))
    assert allowed.head_mm == allowed_mm
    assert allowed.head_mm_per_s == pytest.approx((allowed_mm - HEAD_MM) / DT_S)
    assert done == reaction


@pytest.mark.parametrize(
    ("before_mm_per_s", "wanted_mm", "mm_per_s"),
    [
        # 128 mm/s2 are 1 mm/s in a tick, in both directions.
        (0.0, 90.0, 1.0),
        (5.0, 90.0, 6.0),
        (19.5, 90.0, 20.0),
        (-5.0, 90.0, 1.0),
        (0.0, 10.0, -1.0),
        (-5.0, 10.0, -6.0),
        (-19.5, 10.0, -20.0),
        (5.0, 10.0, -1.0),
    ],
)
def test_speed_is_gained_from_what_it_was_in_that_direction(
    before_mm_per_s: float, wanted_mm: float, mm_per_s: float
) -> None:
    slow = LIMITS._replace(head_mm_per_s2=128.0)
    allowed, done = narrowed(told(wanted_mm), last=told(HEAD_MM, before_mm_per_s), limits=slow)
    assert allowed.head_mm_per_s == mm_per_s
    assert allowed.head_mm == HEAD_MM + mm_per_s * DT_S
    assert done == Reaction.CAP


def test_no_command_goes_past_the_cap() -> None:
    high = changed(SEEN, {"head_mm": HEAD_CAP_MM, "suction_start_mm": HEAD_CAP_MM})
    for wanted in (HEAD_CAP_MM, HEAD_CAP_MM + 0.1):
        allowed, done = narrowed(told(wanted), high, told(HEAD_CAP_MM))
        assert allowed.head_mm == HEAD_CAP_MM
        assert done == (Reaction.PASS if wanted == HEAD_CAP_MM else Reaction.CAP)
    beyond = narrowed(told(90.0), high._replace(head_mm=90.0), told(90.0))[0]
    assert beyond.head_mm == 90.0 - STEP_MM if HEAD_CAP_MM < 90.0 else HEAD_CAP_MM


@pytest.mark.parametrize("seen", [SUCKING, SEEN], ids=["not closed yet", "opening"])
def test_with_the_valve_not_closed_half_a_millimetre_beyond_the_anchor_is_all(seen: Watch) -> None:
    opened = seen is SEEN
    there = seen._replace(head_mm=HEAD_MM + 0.45)
    for wanted, done in (
        (HEAD_MM + 0.5, Reaction.PASS),
        (above(HEAD_MM + 0.5), Reaction.HOLD),
    ):
        proposal = told(wanted)._replace(valve_open=opened)
        allowed, reaction = narrowed(proposal, there, told(HEAD_MM + 0.45))
        assert allowed.head_mm == HEAD_MM + 0.5
        assert reaction == done
    # Closed, it may go on.
    free = narrowed(told(HEAD_MM + 0.55), SEEN, told(HEAD_MM + 0.45))
    assert free == (free[0]._replace(head_mm=HEAD_MM + 0.55), Reaction.PASS)


def test_in_contact_the_command_drops_to_the_head_and_never_rises() -> None:
    ahead = told(HEAD_MM + 1.0)
    allowed, reaction = narrowed(told(HEAD_MM + 1.1), TOUCHING, ahead)
    assert (allowed.head_mm, allowed.head_mm_per_s) == (HEAD_MM, 0.0)
    assert reaction == Reaction.HOLD
    # Behind the head, it stays behind: what pushed the head on is not followed.
    behind = told(HEAD_MM - 1.0)
    allowed, reaction = narrowed(told(HEAD_MM), TOUCHING, behind)
    assert (allowed.head_mm, reaction) == (HEAD_MM - 1.0, Reaction.HOLD)
    # Out, it may go.
    allowed, reaction = narrowed(told(HEAD_MM - 0.1), TOUCHING)
    assert (allowed.head_mm, reaction) == (HEAD_MM - 0.1, Reaction.PASS)
    # Faster than it can: told as a cap, nothing was held.
    assert narrowed(told(HEAD_MM - 9.0), TOUCHING)[1] == Reaction.CAP


def test_without_contact_a_command_ahead_of_the_head_goes_on() -> None:
    allowed, reaction = narrowed(told(HEAD_MM + 1.1), SEEN, told(HEAD_MM + 1.0))
    assert (allowed.head_mm, reaction) == (HEAD_MM + 1.1, Reaction.PASS)


# The way out.


def test_a_withdrawal_never_leads_the_head_by_more_than_half_the_following_limit() -> None:
    leading = told(HEAD_MM - 4.0 + STEP_MM, -20.0)
    allowed, reaction = narrowed(HERE, SEEN, leading, CLOGGED)
    assert allowed.head_mm == HEAD_MM - 4.0
    assert allowed.head_mm_per_s == -20.0
    assert reaction == Reaction.WITHDRAW
    # There it waits for a head that does not come.
    waiting = narrowed(HERE, SEEN, told(HEAD_MM - 4.0), CLOGGED)[0]
    assert (waiting.head_mm, waiting.head_mm_per_s) == (HEAD_MM - 4.0, 0.0)


def test_a_withdrawal_leaves_from_the_lower_of_head_and_command_and_stops_at_home() -> None:
    assert narrowed(HERE, SEEN, told(HEAD_MM + 3.0), LATE)[0].head_mm == HEAD_MM - STEP_MM
    assert narrowed(HERE, SEEN, told(HEAD_MM - 1.0), LATE)[0].head_mm == HEAD_MM - 1.0 - STEP_MM
    near = seeing(head_mm=PARK_MM + 0.1)
    home = narrowed(told(PARK_MM + 0.1), near, told(PARK_MM + 0.1), LATE)[0]
    assert home.head_mm == PARK_MM
    outside = narrowed(HERE, seeing(head_mm=PARK_MM - 2.0), told(PARK_MM - 2.0), LATE)[0]
    assert outside.head_mm == PARK_MM - 2.0


def test_a_head_that_is_home_without_its_catheter_goes_five_millimetres_on() -> None:
    """By the light barrier; then it is let go, for sensors may be adrift."""
    adrift = LATE | 1 << Condition.HEAD_SENSORS_DISAGREE
    # And no longer than a second, for readings may be frozen.
    for remaining_s, end_mm in ((0.0, PARK_MM), (DT_S, PARK_MM - 5.0), (1.0, PARK_MM)):
        away = changed(SEEN, {"head_mm": PARK_MM + 0.6, "durations.remaining_s": remaining_s})
        assert narrowed(told(PARK_MM + 0.6), away, told(PARK_MM + 0.6), adrift)[0].insertion_on
        near = changed(SEEN, {"head_mm": end_mm + 0.1, "durations.remaining_s": remaining_s})
        assert not narrowed(told(end_mm + 0.1), near, told(end_mm + 0.1), adrift)[0].insertion_on
        driven = narrowed(told(end_mm + 0.1), near, told(end_mm + 0.1), LATE)[0]
        assert driven.insertion_on
        assert driven.head_mm == end_mm
    # The barrier cleared on the way: nothing drives it in again.
    clear = changed(SEEN, {"head_mm": PARK_MM - 3.0})
    assert not narrowed(told(PARK_MM - 3.0), clear, told(PARK_MM - 3.0), adrift)[0].insertion_on


def test_a_withdrawal_has_torque_whatever_was_proposed() -> None:
    limp = HERE._replace(insertion_on=False)
    allowed, reaction = narrowed(limp, trips=LATE)
    assert allowed.insertion_on
    assert allowed.head_mm < HEAD_MM
    assert reaction == Reaction.WITHDRAW


def test_torque_off_leaves_the_command_at_the_head() -> None:
    allowed, reaction = narrowed(told(HEAD_MM + 0.1), SEEN, told(HEAD_MM + 3.0, 9.0), RUNAWAY)
    assert not allowed.insertion_on
    assert (allowed.head_mm, allowed.head_mm_per_s) == (HEAD_MM, 0.0)
    assert reaction == Reaction.TORQUE_OFF
    # It beats the withdrawal.
    assert narrowed(HERE, trips=RUNAWAY | LATE)[1] == Reaction.TORQUE_OFF


@pytest.mark.parametrize("trips", [0, RUNAWAY])
def test_a_head_that_was_let_go_tells_its_reaction(trips: int) -> None:
    limp = HERE._replace(insertion_on=False, head_mm=90.0)
    allowed, reaction = narrowed(limp, trips=trips)
    assert not allowed.insertion_on
    assert (allowed.head_mm, allowed.head_mm_per_s) == (HEAD_MM, 0.0)
    assert reaction == (Reaction.TORQUE_OFF if trips else Reaction.PASS)
    if not trips:
        assert narrowed(limp._replace(vacuum_mmhg=151.0))[1] == Reaction.CAP
        quick = seeing(speed_mm_per_s=9.0)
        assert narrowed(limp._replace(valve_open=True), quick)[1] == Reaction.CAP


# Valve and vacuum.

OPENING = HERE._replace(valve_open=True)


@pytest.mark.parametrize(
    ("place", "allowed", "beyond"),
    [
        ("speed_mm_per_s", 3.0, above(3.0)),
        ("line.vacuum_mmhg", 150.0, above(150.0)),
    ],
)
def test_a_valve_opens_on_a_head_at_rest_and_a_vacuum_within_its_limit(
    place: str, allowed: float, beyond: float
) -> None:
    assert narrowed(OPENING, changed(SEEN, {place: allowed}))[0].valve_open
    refused, reaction = narrowed(OPENING, changed(SEEN, {place: beyond}))
    assert not refused.valve_open
    assert reaction == Reaction.CAP
    # One that is open stays so: closing it is another's affair.
    assert narrowed(OPENING, changed(SEEN, {place: beyond}), OPENING)[0].valve_open


def test_a_valve_opens_on_a_head_that_is_drawn_back() -> None:
    assert narrowed(OPENING, seeing(speed_mm_per_s=-20.0))[0].valve_open


def test_a_valve_that_is_not_proposed_to_open_closes() -> None:
    assert not narrowed(HERE, SUCKING, OPENING)[0].valve_open


def test_the_set_point_ends_at_the_patients_limit_or_the_sealed_lines() -> None:
    strong = HERE._replace(vacuum_mmhg=200.0)
    assert narrowed(strong)[0].vacuum_mmhg == 150.0
    assert narrowed(strong)[1] == Reaction.CAP
    park_mm = LIMITS.park_head_mm
    sealed = changed(SEEN, {"parked_closed": True, "vote.encoder_mm": park_mm})
    assert narrowed(strong, sealed)[0].vacuum_mmhg == 190.0
    # What the vote rides out, a missing reading or one that leapt, is not parked in its tick.
    for place, unread in (
        ("invalid.head", 1),
        ("invalid.cam", 1),
        ("vote.encoder_mm", park_mm + above(3.0)),
        ("vote.encoder_mm", park_mm - above(3.0)),
    ):
        assert narrowed(strong, changed(sealed, {place: unread}))[0].vacuum_mmhg == 150.0
    assert narrowed(strong._replace(valve_open=True), sealed)[0].vacuum_mmhg == 150.0
    for limit, seen in ((150.0, SEEN), (190.0, sealed)):
        assert narrowed(HERE._replace(vacuum_mmhg=limit), seen)[1] == Reaction.PASS
    # A sealed line is never allowed less than the patient is.
    weak = changed(LIMITS, {"line.parked_closed_mmhg": 100.0})
    assert narrowed(strong, sealed, limits=weak)[0].vacuum_mmhg == 150.0


def test_a_cut_closes_vents_and_stops_and_what_keeps_vacuum_leaves_all_three() -> None:
    cut = narrowed(OPENING, SEEN, OPENING, LATE)[0]
    assert (cut.valve_open, cut.pump_on, cut.vacuum_mmhg) == (False, False, 0.0)
    kept = narrowed(OPENING, SEEN, OPENING, CLOGGED)[0]
    assert (kept.valve_open, kept.pump_on) == (True, True)
    assert kept.vacuum_mmhg == OPENING.vacuum_mmhg > 0.0
    unpumped = narrowed(HERE._replace(pump_on=False))[0]
    assert not unpumped.pump_on


@given(
    head=st.floats(-20.0, 90.0),
    command=st.floats(-20.0, 90.0),
    wanted=st.floats(-20.0, 140.0),
    speed=st.floats(-20.0, 20.0),
    trips=st.sampled_from([0, CLOGGED, LATE]),
)
def test_the_velocity_belongs_to_the_way_from_where_the_command_began(
    head: float, command: float, wanted: float, speed: float, trips: int
) -> None:
    seen = seeing(head_mm=head, suction_start_mm=head)
    allowed = narrowed(told(wanted), seen, told(command, speed), trips)[0]
    origin = min(command, head) if trips else min(command, max(head, HEAD_CAP_MM))
    farthest = head - limiter.LEAD_SHARE * LIMITS.following_mm
    if trips and allowed.head_mm <= farthest and farthest > PARK_MM:
        # It waits for the head: its own steps would be the encoder's.
        assert allowed.head_mm_per_s == min(speed, 0.0)
        return
    assert allowed.head_mm_per_s == pytest.approx((allowed.head_mm - origin) / DT_S, abs=1e-9)


def test_a_withdrawal_that_waits_for_its_head_keeps_its_speed() -> None:
    """A head that creeps out against what holds it, by one step of its encoder in three ticks."""
    command, speed = told(50.0, -20.0), []
    for tick in range(300):
        head_mm = 50.0 - 0.005 * (tick // 3)
        command = narrowed(told(50.0), seeing(head_mm=head_mm), command, LATE)[0]
        speed.append(command.head_mm_per_s)
    assert command.head_mm == pytest.approx(head_mm - limiter.LEAD_SHARE * LIMITS.following_mm)
    assert set(speed[-30:]) == {speed[-1]}
    assert speed[-1] == pytest.approx(-LIMITS.head_speed_mm_per_s)
