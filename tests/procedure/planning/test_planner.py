import math
from typing import Any

import pytest

from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import AgeGroup, Phase
from opensuction.procedure.cycle import plan as plans
from opensuction.procedure.cycle.check import CheckItem
from opensuction.procedure.cycle.plan import Excitation, Plan
from opensuction.procedure.planning import planner
from opensuction.procedure.planning.planner import WAY_IN_MMHG, Abilities
from opensuction.procedure.planning.protocol import (
    BENCH_SITE,
    PAPER,
    PROTOCOLS,
    VACUUM_LIMIT_S,
    Protocol,
)

IN_MMHG = WAY_IN_MMHG[AgeGroup.ADULT]
EXCITATION = Excitation(range_mm=100.0, period_s=20.0, duration_s=40.0)

BENCH = Abilities(
    head_mm_per_s=17.0,
    acceleration_mm_per_s2=200.0,
    park_head_mm=0.0,
    settle_mm=0.25,
    cam_open_rad=0.5236,
    cam_rad_per_s=0.2618,
    gap_in_mm=0.0,
    gap_out_mm=0.0,
    relief_mmhg=150.0,
    jog_mm=2.0,
    pump_mmhg_per_s=285.0,
    pump_occluded_mmhg=560.0,
    turn_mm=0.0,
)
WITH_GAP = BENCH._replace(gap_in_mm=16.5, gap_out_mm=16.5, turn_mm=16.5)


def planned(protocol: Protocol, abilities: Abilities = BENCH, by_contact: bool = False) -> Plan:
    return planner.plan(protocol, abilities, EXCITATION, by_contact, BENCH_SITE)


def refusal(protocol: Protocol, abilities: Abilities = BENCH, by_contact: bool = False) -> str:
    with pytest.raises(InputError) as caught:
        planned(protocol, abilities, by_contact)
    message = str(caught.value)
    assert "\n" not in message
    return message


def test_the_papers_timeline() -> None:
    times = planner.timeline(PAPER, BENCH, BENCH_SITE, by_contact=False)
    # 90 mm at 9 mm/s; accelerating at 200 mm/s2 adds 9/200 s.
    assert times.insertion == pytest.approx(10.0 + 0.045)
    assert times.withdrawal == pytest.approx(10.0 + 0.045)
    assert times.dwell == 9.0
    assert times.stroke == pytest.approx(2.0)
    assert times.preload == 0.0
    assert times.negative_pressure == pytest.approx(9.0 + 10.045 + 2.0)
    assert times.build == 0.0, "the bench has nobody to be drawn at: its line is ready before"
    assert times.in_airway == pytest.approx(10.045 + 9.0 + 10.045)


def test_a_pump_that_is_slow_or_weak_is_given_as_long_as_the_pre_use_test_gives_it() -> None:
    # 285 mmHg/s less as much as of 560 mmHg is there, from 15 to 108.
    expected = pytest.approx(560.0 / 285.0 * math.log(545.0 / 452.0))
    assert planner.build_s(BENCH, IN_MMHG, 120.0) == expected
    assert planner.build_s(BENCH, IN_MMHG, 80.0) < planner.build_s(BENCH, IN_MMHG, 120.0)
    assert planner.build_s(BENCH._replace(pump_mmhg_per_s=2.0), IN_MMHG, 120.0) == VACUUM_LIMIT_S
    assert (
        planner.build_s(BENCH._replace(pump_occluded_mmhg=108.0), IN_MMHG, 120.0) == VACUUM_LIMIT_S
    )
    assert planner.build_s(BENCH, IN_MMHG, 10.0) == 0.0


def test_a_gap_is_crossed_before_insertion_and_in_the_last_part_of_the_dwell() -> None:
    plan = planned(PAPER, WITH_GAP)
    # 16.5 mm at 17 mm/s from rest to rest: 16.5/17 + 17/200.
    assert plan.preload_s == pytest.approx(16.5 / 17.0 + 0.085)
    assert plan.gap_lead_s == plan.preload_s
    assert planned(PAPER, BENCH).gap_lead_s == 0.0


@pytest.mark.parametrize("name", PROTOCOLS)
@pytest.mark.parametrize("abilities", [BENCH, WITH_GAP], ids=["plain", "gap"])
def test_every_preset_fits_the_bench(name: str, abilities: Abilities) -> None:
    plan = planned(PROTOCOLS[name], abilities)
    assert plan.motion.target_mm == PROTOCOLS[name].travel_mm
    assert plan.dwell_s >= plan.gap_lead_s


def test_the_papers_suction_does_not_fit_into_fifteen_seconds() -> None:
    message = refusal(PAPER._replace(negative_pressure_budget_s=15.0))
    assert message == (
        "negative pressure would last 21.0 s = dwell 9.0 s + withdrawal 10.0 s + valve stroke "
        "2.0 s; the budget is 15 s: shorten dwell_s, raise withdrawal_mm_per_s or reduce travel_mm"
    )


@pytest.mark.requirement("OS-R04")
def test_a_budget_is_met_exactly_or_not_at_all() -> None:
    needed = planner.timeline(PAPER, BENCH, BENCH_SITE, by_contact=False).negative_pressure
    planned(PAPER._replace(negative_pressure_budget_s=needed), BENCH)
    refusal(PAPER._replace(negative_pressure_budget_s=needed - 1e-6))


@pytest.mark.requirement("OS-R05")
def test_time_in_the_airway_is_refused_with_its_sum() -> None:
    within = PAPER._replace(in_airway_budget_s=20.0)
    assert refusal(within) == (
        "the catheter would be in the airway for 29.1 s = insertion 10.0 s + dwell 9.0 s + "
        "withdrawal 10.0 s; the budget is 20 s"
    )
    assert refusal(within._replace(bench_only=False)) == (
        "the catheter would be in the airway for 29.5 s = insertion 10.0 s + vacuum 0.4 s + "
        "dwell 9.0 s + withdrawal 10.0 s; the budget is 20 s"
    )


def test_the_back_off_of_contact_counts_as_time_in_the_airway() -> None:
    protocol = PAPER._replace(backoff_mm=10.0)
    by_travel = planner.timeline(protocol, WITH_GAP, BENCH_SITE, by_contact=False)
    by_contact = planner.timeline(protocol, WITH_GAP, BENCH_SITE, by_contact=True)
    # 16.5 mm of gap at 17 mm/s from rest to rest at 200 mm/s2, then 10 mm at half of that.
    assert by_contact.back_off == pytest.approx(16.5 / 17.0 + 0.085 + 10.0 / 17.0 + 0.17)
    assert by_travel.back_off == 0.0
    # The way out begins where the back-off ended: 10 mm less at 9 mm/s.
    assert by_travel.withdrawal - by_contact.withdrawal == pytest.approx(10.0 / 9.0)
    assert by_contact.in_airway - by_travel.in_airway == pytest.approx(
        by_contact.back_off - 10.0 / 9.0
    )
    assert refusal(protocol._replace(in_airway_budget_s=29.0), WITH_GAP, by_contact=True) == (
        "the catheter would be in the airway for 29.8 s = insertion 10.0 s + back-off 1.8 s + "
        "dwell 9.0 s + withdrawal 8.9 s; the budget is 29 s"
    )


@pytest.mark.parametrize(("cap_mm", "fits"), [(95.0, True), (94.99, False)])
def test_the_cap_is_five_millimetres_beyond_the_target(cap_mm: float, fits: bool) -> None:
    protocol = PAPER._replace(cap_mm=cap_mm)
    if fits:
        planned(protocol, BENCH)
    else:
        assert refusal(protocol) == (
            "cap_mm 94.99 mm is nearer than 5 mm to travel_mm 90 mm: set cap_mm to 95 mm or more"
        )


def test_a_search_that_ends_before_its_window_is_refused() -> None:
    near = PAPER._replace(travel_mm=30.0)
    assert refusal(near, by_contact=True) == (
        "contact_from_mm 30 mm should be less than travel_mm 30 mm, where the search for contact "
        "ends"
    )
    planned(near)


def test_a_dwell_shorter_than_valve_and_gap_is_refused() -> None:
    message = refusal(PAPER._replace(dwell_s=2.5), WITH_GAP)
    assert message == (
        "dwell_s 2.5 s is too short: the valve stroke takes 2.0 s and the gap of the way back 1.1 s"
    )
    planned(PAPER._replace(dwell_s=2.5), BENCH)


@pytest.mark.parametrize("name", ["insertion_mm_per_s", "withdrawal_mm_per_s"])
def test_a_speed_the_head_cannot_do_is_refused(name: str) -> None:
    faster: dict[str, Any] = {name: 20.0}
    message = refusal(PAPER._replace(**faster))
    assert message == "a speed of 20 mm/s is more than this machine's head can do (17 mm/s)"


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("cap_mm", float("nan"), "cap_mm nan should be a finite number"),
        ("dwell_s", float("inf"), "dwell_s inf should be a finite number"),
        ("vacuum_mmhg", 0.0, "vacuum_mmhg 0 should be greater than 0"),
        ("withdrawal_mm_per_s", -9.0, "withdrawal_mm_per_s -9 should be greater than 0"),
    ],
)
def test_what_no_arithmetic_is_possible_with_is_refused(
    name: str, value: float, message: str
) -> None:
    """No comparison refuses a number that is none."""
    changed: dict[str, Any] = {name: value}
    assert refusal(PAPER._replace(**changed)) == message


def test_every_working_phase_has_a_limit_above_its_plan() -> None:
    plan = planned(PAPER, WITH_GAP, by_contact=True)
    times = planner.timeline(PAPER, WITH_GAP, BENCH_SITE, by_contact=True)
    durations = {
        Phase.CHECKING: 2.0,  # the pump fills the canister
        Phase.PRELOADING: times.preload,
        Phase.INSERTING: times.insertion,
        Phase.BACKING_OFF: times.back_off,
        Phase.OPENING: times.stroke,
        Phase.SUCTIONING: times.dwell,
        Phase.WITHDRAWING: times.withdrawal,
        Phase.CLOSING: times.stroke,
        # At the head's speed from the deepest point, then the valve closes.
        Phase.ABORTING: (PAPER.travel_mm + 2 * 16.5) / BENCH.head_mm_per_s + times.stroke,
        Phase.IDENTIFYING: EXCITATION.duration_s,
    }
    for phase, seconds in durations.items():
        assert seconds + 1.0 <= plan.limits_s[phase] < 60.0, phase


def test_every_phase_and_item_has_a_limit() -> None:
    plan = planned(PAPER, BENCH)
    assert len(plan.limits_s) == len(Phase)
    assert len(plan.check.limits_s) == len(CheckItem)


@pytest.mark.parametrize("phase", [Phase.PARKED, Phase.HALTED])
def test_waiting_for_a_person_has_no_limit(phase: Phase) -> None:
    plan = planned(PAPER, BENCH)
    assert plan.limits_s[phase] == float("inf")


@pytest.mark.parametrize(("pump_mmhg_per_s", "most_s"), [(285.0, None), (2.0, VACUUM_LIMIT_S)])
def test_the_tip_waits_for_the_vacuum_half_as_long_again_as_the_pump_needs(
    pump_mmhg_per_s: float, most_s: float | None
) -> None:
    abilities = BENCH._replace(pump_mmhg_per_s=pump_mmhg_per_s)
    plan = planned(PAPER._replace(bench_only=False), abilities)
    if most_s is None:
        most_s = 1.5 * planner.build_s(abilities, IN_MMHG, PAPER.vacuum_mmhg) + 1.0
    assert plan.build_most_s == most_s


def test_only_a_bench_protocol_may_identify() -> None:
    assert planned(PAPER, BENCH).bench_only
    assert not planned(PAPER._replace(bench_only=False), BENCH).bench_only


@pytest.mark.parametrize(("backoff_mm", "deepest_mm"), [(0.0, math.inf), (10.0, 94.0)])
def test_by_contact_suction_is_no_deeper_than_off_the_middle_of_the_search(
    backoff_mm: float, deepest_mm: float
) -> None:
    protocol = PAPER._replace(travel_mm=108.0, cap_mm=113.0, backoff_mm=backoff_mm)
    site = BENCH_SITE._replace(carina_mm=100.0)
    contact = planner.plan(protocol, BENCH, EXCITATION, by_contact=True, site=site).contact
    assert contact.suction_mm == deepest_mm
    for at_mm in (90.0, 104.0, 108.5):
        expected_mm = min(at_mm - backoff_mm, deepest_mm)
        assert plans.backed_off_mm(contact, at_mm) == expected_mm


def test_all_that_cannot_be_done_is_told_with_the_field_to_change_and_the_first_is_raised() -> None:
    wrong = PAPER._replace(
        cap_mm=91.0, dwell_s=14.0, in_airway_budget_s=29.0, withdrawal_mm_per_s=18.0
    )
    told = list(planner.refusals(wrong, BENCH, BENCH_SITE, by_contact=False))
    assert [one.field for one in told] == ["cap_mm", "in_airway_budget_s", "withdrawal_mm_per_s"]
    assert refusal(wrong) == told[0].sentence
    slow = PAPER._replace(dwell_s=1.0, negative_pressure_budget_s=5.0, insertion_mm_per_s=19.0)
    told = list(planner.refusals(slow, BENCH, BENCH_SITE, by_contact=False))
    assert [one.field for one in told] == ["dwell_s", "dwell_s", "insertion_mm_per_s"]
    search = PAPER._replace(contact_from_mm=95.0)
    told = list(planner.refusals(search, BENCH, BENCH_SITE, by_contact=True))
    assert [one.field for one in told] == ["contact_from_mm"]
    assert not list(planner.refusals(PAPER, BENCH, BENCH_SITE, by_contact=False))
