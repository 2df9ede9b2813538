"""The governor only narrows, whatever is proposed, read or remembered."""

import math

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from opensuction.kernel.interface import Readings, Setpoints
from opensuction.safety.condition import Condition
from opensuction.safety.condition_mask import TRIPS, cuts_vacuum, decode_trips
from opensuction.safety.governor import governor
from opensuction.safety.governor.governor import (
    WAITING_S,
    ForcedWithdrawal,
    GovernorState,
    longest_s,
)
from opensuction.safety.governor.limiter import ADVANCE_MM
from opensuction.safety.handling import Reaction
from opensuction.safety.head import head_vote
from opensuction.safety.head.drive_force import DriveForce
from opensuction.safety.head.head_vote import HeadVote
from opensuction.safety.invalid_ticks import InvalidTicks
from opensuction.safety.limits import AdvanceBound, TipInterval
from opensuction.safety.watch import vacuum_signature
from opensuction.safety.watch.bus_watch import BusWatch
from opensuction.safety.watch.patient_watch import Breath, PatientWatch, Sag
from opensuction.safety.watch.tip_force import ContactWindow
from opensuction.safety.watch.vacuum_signature import LineFilter, LineWatch
from opensuction.safety.watch.valve_axis import ValveAxis
from opensuction.safety.watch.watch import PARKED_MM
from opensuction.safety.watch.watch_state import Durations, Watch
from tests.safety.watchdog import (
    DT_S,
    HEAD_CAP_MM,
    LIMITS,
    PARK_MM,
    follows,
    govern,
    locate,
    run,
    staying,
)

anything = st.floats(allow_nan=True, allow_infinity=True)
plausible = st.floats(-80.0, 160.0)
seconds = st.one_of(st.just(0.0), st.floats(0.0, 3.0))
counts = st.integers(0, 12)

proposals = st.builds(
    Setpoints,
    head_mm=st.one_of(plausible, anything),
    head_mm_per_s=st.one_of(st.floats(-30.0, 30.0), anything),
    valve_open=st.booleans(),
    pump_on=st.booleans(),
    vacuum_mmhg=st.one_of(st.floats(0.0, 300.0), anything),
)
possible = st.builds(
    Setpoints,
    head_mm=plausible,
    head_mm_per_s=st.floats(-30.0, 30.0),
    valve_open=st.booleans(),
    pump_on=st.booleans(),
    vacuum_mmhg=st.floats(0.0, 300.0),
)
readings = st.builds(
    Readings,
    head_mm=st.one_of(plausible, anything),
    head_valid=st.booleans(),
    carriage_mm=st.one_of(plausible, anything),
    carriage_valid=st.booleans(),
    cam_rad=st.one_of(st.floats(-0.1, 0.7), anything),
    cam_valid=st.booleans(),
    line_vacuum_mmhg=st.one_of(st.floats(0.0, 300.0), anything),
    vacuum_valid=st.booleans(),
    contact_closed=st.booleans(),
    contact_valid=st.booleans(),
    insertion_current_a=anything,
)
forces = st.floats(-8.0, 8.0)
watches = st.builds(
    Watch,
    head_mm=plausible,
    vote=st.builds(
        HeadVote,
        head_mm=plausible,
        least_mm=plausible,
        most_mm=plausible,
        jumped_mm=plausible,
        driven_v=st.floats(-24.0, 24.0),
        motor_mm_per_s=st.floats(-60.0, 60.0),
        encoder_lead_mm=plausible,
        carriage_lead_mm=plausible,
        encoder_mm=plausible,
        carriage_mm=plausible,
        encoder_odd=st.integers(0, head_vote.OUT_TICKS),
        surprised_ticks=st.integers(0, head_vote.SURPRISED_TICKS),
        encoder_out=st.booleans(),
        carriage_out=st.booleans(),
        switched=st.booleans(),
        unseen_ticks=counts,
        zero_mm=st.floats(-head_vote.MOST_MM, head_vote.MOST_MM),
        zero_ticks=st.integers(0, head_vote.STILL_TICKS),
    ),
    speed_mm_per_s=st.floats(-60.0, 60.0),
    tip=st.builds(TipInterval, plausible, plausible),
    suction_start_mm=plausible,
    advance=st.builds(AdvanceBound, plausible, st.floats(0.0, 20.0)),
    cam_rad=st.floats(-0.1, 0.7),
    parked_closed=st.booleans(),
    open_contact_ticks=counts,
    bus=st.builds(BusWatch, st.integers(0, 200), st.booleans(), st.floats(0.0, 1.0)),
    late_ticks=counts,
    late_share=st.floats(0.0, 1.0),
    runaway_ticks=counts,
    overspeed_ticks=counts,
    invalid=st.builds(InvalidTicks, *[counts] * len(InvalidTicks._fields)),
    durations=st.builds(Durations, *[seconds] * len(Durations._fields)),
    drive=st.builds(DriveForce, forces, forces, forces, st.floats(-0.1, 0.1), forces),
    window=st.builds(ContactWindow, plausible, seconds, st.booleans(), plausible),
    valve=st.builds(ValveAxis, seconds, seconds, st.floats(-0.1, 0.7), st.booleans()),
    line=st.builds(
        LineWatch,
        vacuum_mmhg=st.floats(0.0, 300.0),
        slow_mmhg=st.floats(0.0, 300.0),
        set_mmhg=st.floats(0.0, 190.0),
        pumping_s=seconds,
        built=st.booleans(),
        fall_mmhg_per_s=st.floats(-5000.0, 0.0),
        rest_s=seconds,
        kept_mmhg=st.floats(0.0, 300.0),
        rest_low_s=seconds,
        closed_low_s=seconds,
        open_low_s=seconds,
        clogged_s=seconds,
        over_s=seconds,
        unvented_s=seconds,
        open_rest_s=seconds,
        no_flow_s=seconds,
    ),
    filter=st.builds(
        LineFilter,
        raw_mmhg=st.floats(0.0, 300.0),
        smooth_mmhg=st.floats(0.0, 300.0),
        zero_mmhg=st.floats(-vacuum_signature.ZERO_MMHG, vacuum_signature.ZERO_MMHG),
        heard=st.booleans(),
    ),
)
PATIENT = (
    0,
    1 << Condition.SPO2_LOW,
    1 << Condition.LUNG_VOLUME_LOST | 1 << Condition.MONITOR_LINK_LOST,
)
"""Masks of what the monitor may have said of the patient."""
states = st.builds(
    GovernorState,
    last=st.builds(
        Setpoints,
        head_mm=plausible,
        head_mm_per_s=st.floats(-20.0, 20.0),
        valve_open=st.booleans(),
        pump_on=st.booleans(),
        vacuum_mmhg=st.floats(0.0, 190.0),
    ),
    valve_command_changed=st.booleans(),
    watch=watches,
    patient=st.builds(
        PatientWatch,
        st.floats(0.0, 100.0),
        *[seconds] * 6,
        st.floats(-30.0, 30.0),
        seconds,
        st.builds(Sag, seconds, seconds, seconds),
        *[seconds] * 2,
        st.builds(Breath, st.booleans(), seconds, st.floats(-30.0, 30.0)),
        *[seconds] * 2,
        st.sampled_from(PATIENT),
    ),
    withdrawal=st.builds(
        ForcedWithdrawal,
        forced_s=seconds,
        blocked_s=seconds,
        unseen_s=seconds,
        waiting_s=st.floats(0.0, 2.0 * WAITING_S),
        whole_s=st.floats(0.0, 2.0 * float(longest_s(LIMITS))),
    ),
    turned_ticks=counts,
    trips=st.one_of(
        st.just(0),
        st.sets(st.sampled_from(decode_trips(TRIPS))).map(lambda codes: sum(1 << c for c in codes)),
    ),
)

REACH_MM = LIMITS.head_speed_mm_per_s * DT_S + 1e-12


class Case:
    """One tick."""

    def __init__(
        self,
        state: GovernorState,
        proposal: Setpoints,
        read: Readings,
        volts: float,
        overrun: bool,
    ) -> None:
        self.before, self.proposal = state, proposal
        vote = locate(LIMITS, state, read, volts, DT_S)
        self.after, self.allowed, self.verdict = govern(
            LIMITS, state, proposal, read, vote, overrun, DT_S
        )
        self.seen = self.after.watch
        self.driven = self.verdict.insertion_on


volts = st.floats(-24.0, 24.0)
cases = st.builds(Case, states, proposals, readings, volts, st.booleans())
sane_cases = st.builds(Case, states, possible, readings, volts, st.booleans())


# Drawing a case takes far longer than judging it: each test judges all that belongs together.


@given(case=cases)
def test_whatever_comes_in_only_numbers_come_out(case: Case) -> None:
    assert all(math.isfinite(value) for value in case.allowed)
    assert math.isfinite(case.verdict.deepest_mm)
    seen = case.seen
    flat = (
        *case.after.last,
        *seen.vote,
        seen.head_mm,
        seen.speed_mm_per_s,
        *seen.tip,
        seen.suction_start_mm,
        *seen.advance,
        *seen.durations,
        *seen.drive,
        *seen.window,
        *seen.line,
    )
    assert math.isfinite(sum(case.after.withdrawal))
    assert all(math.isfinite(value) for value in flat)


@pytest.mark.requirement("OS-R01")
@given(case=cases)
def test_suction_is_never_more_than_proposed_nor_than_its_limit_and_none_when_cut(
    case: Case,
) -> None:
    assert case.proposal.valve_open or not case.allowed.valve_open
    assert case.proposal.pump_on or not case.allowed.pump_on
    sealed = case.seen.parked_closed and not case.allowed.valve_open
    sealed = sealed and case.seen.invalid.head == 0 and case.seen.invalid.cam == 0
    sealed = sealed and abs(case.seen.vote.encoder_mm - LIMITS.park_head_mm) <= PARKED_MM
    highest = LIMITS.line.parked_closed_mmhg if sealed else LIMITS.vacuum_mmhg
    assert 0.0 <= case.allowed.vacuum_mmhg <= highest
    wanted = case.proposal.vacuum_mmhg
    assert case.allowed.vacuum_mmhg <= (wanted if wanted >= 0.0 else 0.0)
    if cuts_vacuum(case.verdict.trips):
        assert not case.allowed.valve_open
        assert not case.allowed.pump_on
        assert case.allowed.vacuum_mmhg == 0.0


@pytest.mark.requirement("OS-R02", "OS-R08", "OS-R13")
@given(case=cases)
def test_the_head_is_driven_in_no_faster_than_its_limit_and_not_past_the_cap(case: Case) -> None:
    if case.driven:
        assert case.allowed.head_mm <= case.before.last.head_mm + REACH_MM
        # Positions of about 100 are rounded to 1e-14; a tick divides that by 1e-3.
        limit = LIMITS.head_speed_mm_per_s + 1e-9
        assert -limit <= case.allowed.head_mm_per_s <= limit
        assert case.allowed.head_mm <= max(HEAD_CAP_MM, case.before.last.head_mm)
        if case.before.last.head_mm > HEAD_CAP_MM + REACH_MM:
            # Unless it leads the head by all that a withdrawal may.
            leading = case.seen.head_mm - case.before.last.head_mm > 3.9
            assert case.allowed.head_mm < case.before.last.head_mm or leading
    else:  # nothing is driven, and the command waits at the head
        assert not case.verdict.insertion_on
        assert case.allowed.head_mm == case.seen.head_mm
        assert case.allowed.head_mm_per_s == 0.0


def unless_released(case: Case) -> Setpoints:
    """The proposal; where it asks for no torque its head position means nothing."""
    wanted = case.proposal._replace(head_mm_per_s=case.allowed.head_mm_per_s)
    return wanted if case.driven else wanted._replace(head_mm=case.allowed.head_mm)


@pytest.mark.requirement("OS-R01")
@given(case=sane_cases)
def test_the_head_is_driven_no_further_in_than_proposed_nor_out_faster_than_its_limit(
    case: Case,
) -> None:
    if case.driven:
        assert case.allowed.head_mm <= max(case.proposal.head_mm, case.before.last.head_mm)
        origin = min(case.before.last.head_mm, case.seen.head_mm)
        assert case.allowed.head_mm >= origin - REACH_MM


@given(case=sane_cases)
def test_what_is_within_every_limit_passes_unchanged_and_all_else_is_reported(case: Case) -> None:
    wanted = unless_released(case)
    if case.verdict.reaction == Reaction.PASS:
        assert case.allowed == wanted
        assert case.verdict.trips == 0
    assert (case.allowed == wanted) or case.verdict.reaction >= Reaction.CAP


@pytest.mark.requirement("OS-R14")
@given(case=cases)
def test_a_trip_stays_until_a_person_resets_and_withdraws_outwards_to_the_park_position(
    case: Case,
) -> None:
    assert case.verdict.trips & case.before.trips == case.before.trips
    assert case.after.trips == case.verdict.trips
    assert (case.verdict.trips != 0) == (case.verdict.reaction >= Reaction.WITHDRAW)
    assert governor.reset(LIMITS, case.after).trips == 0
    if case.verdict.reaction == Reaction.WITHDRAW:
        origin = min(case.before.last.head_mm, case.seen.head_mm)
        assert case.allowed.head_mm <= origin
        assert case.allowed.head_mm >= min(origin, PARK_MM)
        if origin > PARK_MM:
            assert case.allowed.head_mm < origin or case.seen.head_mm - origin > 3.9


@pytest.mark.requirement("OS-R03")
@given(case=cases)
def test_the_valve_opens_only_on_a_head_at_rest_and_a_cam_that_errs_is_left_to_its_spring(
    case: Case,
) -> None:
    untrusted = (
        Condition.CAM_READING_INVALID,
        Condition.VALVE_STUCK_OPEN,
        Condition.VALVE_STUCK_CLOSED,
    )
    trusted = all(not case.verdict.trips >> code & 1 for code in untrusted)
    driven = case.allowed.valve_open or not case.seen.valve.resting
    assert case.verdict.valve_on == (trusted and driven)
    if not case.before.last.valve_open and case.seen.speed_mm_per_s > 3.0:
        assert not case.allowed.valve_open


@pytest.mark.requirement("OS-R03", "OS-R06")
@given(case=cases)
def test_the_command_stays_at_the_anchor_with_suction_and_at_the_head_in_contact(
    case: Case,
) -> None:
    came_from = min(case.before.last.head_mm, case.seen.head_mm)
    held = case.allowed.valve_open or case.seen.durations.sucking_s > 0.0
    if case.driven and held:
        assert case.allowed.head_mm <= max(case.seen.suction_start_mm + ADVANCE_MM, came_from)
    if case.driven and case.seen.durations.contact_s > 0.0:  # in the same tick
        assert case.allowed.head_mm <= came_from


@pytest.mark.requirement("OS-R03")
@given(
    targets=st.lists(st.tuples(plausible, st.booleans(), seconds), min_size=1, max_size=4),
)
@example(targets=[(40.0, False, 0.2), (90.0, True, 0.2), (90.0, False, 0.2)])
def test_the_head_advances_half_a_millimetre_at_most_while_the_valve_is_open(
    targets: list[tuple[float, bool, float]],
) -> None:
    part_s = 0.1

    def propose(time_s: float) -> Setpoints:
        head, valve_open, _ = targets[min(int(time_s / part_s), len(targets) - 1)]
        return staying(head)._replace(valve_open=valve_open)

    least, worst = math.inf, 0.0
    for tick in run(part_s * len(targets), propose, follows):
        if not tick.allowed.valve_open:
            least = math.inf
            continue
        least = min(least, tick.readings.head_mm)
        worst = max(worst, tick.allowed.head_mm - least)
    assert worst <= ADVANCE_MM + 1e-9
