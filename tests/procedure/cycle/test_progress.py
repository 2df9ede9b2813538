from typing import Any

import pytest

from opensuction.kernel.interface import NO_MONITOR, NO_REQUESTS, Readings, Requests
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle import check, cycle, progress
from opensuction.procedure.cycle.check import CheckItem
from opensuction.procedure.cycle.plan import Plan
from opensuction.procedure.cycle.progress import ControlFeedback, ProcedureState
from opensuction.procedure.cycle.transition import Event
from opensuction.procedure.planning import planner
from opensuction.procedure.planning.protocol import BENCH_SITE, PAPER
from tests.procedure.planning.test_planner import BENCH, EXCITATION

PLAN = planner.plan(PAPER, BENCH, EXCITATION, by_contact=False, site=BENCH_SITE)
DT_S = 0.001
NAN = float("nan")

AT_HOME = Readings(
    head_mm=0.0,
    head_valid=True,
    carriage_mm=0.0,
    carriage_valid=True,
    cam_rad=0.0,
    cam_valid=True,
    line_vacuum_mmhg=120.0,
    vacuum_valid=True,
    contact_closed=False,
    contact_valid=True,
    mouth_clear=True,
    insertion_current_a=0.0,
    monitor=NO_MONITOR,
)
QUIET = ControlFeedback(
    head_wanted_mm=0.0,
    head_wanted_mm_per_s=0.0,
    tripped=False,
    powerless=False,
    locked_out=False,
    contact_tip_mm=0.0,
    tip_mm=0.0,
)


def events(
    phase: Phase,
    readings: Readings = AT_HOME,
    requests: Requests = NO_REQUESTS,
    feedback: ControlFeedback = QUIET,
    plan: Plan = PLAN,
    **state: Any,
) -> set[Event]:
    before: ProcedureState = cycle.begin(plan, phase)._replace(phase_ticks=1)
    before = before._replace(**state)
    mask = progress.events(plan, before, before.check, readings, requests, feedback, DT_S)
    return {event for event in Event if mask >> event & 1}


def test_the_check_is_passed_when_every_item_is_and_the_machine_rests() -> None:
    assert events(Phase.CHECKING) == {Event.CHECK_PASSED}
    assert events(Phase.CHECKING, AT_HOME._replace(cam_rad=0.1)) == set()
    assert events(Phase.CHECKING, AT_HOME._replace(head_mm=0.8)) == set()
    testing = check.begin()
    assert events(Phase.CHECKING, check=testing) == set()
    failed = testing._replace(failed=int(CheckItem.READINGS))
    assert events(Phase.CHECKING, check=failed) == {Event.CHECK_FAILED}


def test_whoever_aborts_starts_and_resets_nothing() -> None:
    everything = Requests(*[True] * len(Requests._fields))
    for phase in Phase:
        asked = events(phase, requests=everything)
        assert Event.ABORT_REQUESTED in asked
        assert not asked & {
            Event.START_REQUESTED,
            Event.IDENTIFY_REQUESTED,
            Event.TEACH_REQUESTED,
            Event.SERVICE_REQUESTED,
            Event.SERVICE_ENDED,
            Event.RESET_REQUESTED,
            Event.RECOVERY_REQUESTED,
        }


def test_identification_is_for_the_bench_only() -> None:
    asked = NO_REQUESTS._replace(identify=True)
    assert events(Phase.PARKED, requests=asked) == {Event.IDENTIFY_REQUESTED}
    clinical = PLAN._replace(bench_only=False)
    assert events(Phase.PARKED, requests=asked, plan=clinical) == set()


@pytest.mark.parametrize(
    ("readings", "event"),
    [
        (AT_HOME, Event.RESET_REQUESTED),
        (AT_HOME._replace(head_mm=0.7), Event.RESET_REQUESTED),
        (AT_HOME._replace(head_mm=0.8), Event.RECOVERY_REQUESTED),
        (AT_HOME._replace(head_mm=-40.0), Event.RECOVERY_REQUESTED),
        # What a dead encoder reports is no proof that the catheter is out.
        (AT_HOME._replace(head_valid=False), Event.RECOVERY_REQUESTED),
        (AT_HOME._replace(head_mm=NAN), Event.RECOVERY_REQUESTED),
    ],
)
def test_a_reset_parks_only_with_the_head_known_to_be_home(
    readings: Readings, event: Event
) -> None:
    assert events(Phase.HALTED, readings, NO_REQUESTS._replace(reset=True)) == {event}


def test_the_target_is_reached_when_the_head_is_where_the_cycle_wants_it() -> None:
    target = PLAN.motion.target_mm
    there = QUIET._replace(head_wanted_mm=target)
    at_target = AT_HOME._replace(head_mm=target - 0.2)
    assert events(Phase.INSERTING, at_target, feedback=there, reference_mm=target) == {
        Event.TARGET_REACHED
    }
    # Held back by the governor: command and head agree with each other, but not with the cycle.
    held = AT_HOME._replace(head_mm=target - 20.0)
    assert events(Phase.INSERTING, held, feedback=there, reference_mm=target) == set()
    # The reference passes the target at speed only if something is wrong.
    assert (
        events(
            Phase.INSERTING,
            at_target,
            feedback=there,
            reference_mm=target,
            reference_mm_per_s=9.0,
        )
        == set()
    )


def test_contact_counts_within_its_window_and_the_search_ends_at_the_target() -> None:
    plan = PLAN._replace(contact=PLAN.contact._replace(enabled=True))
    target, first = plan.motion.target_mm, plan.contact.window_start_mm
    closed = AT_HOME._replace(contact_closed=True, head_mm=target)
    feedback = QUIET._replace(head_wanted_mm=target)

    def found(
        readings: Readings, tip_mm: float, plan: Plan = plan, *, held_ticks: int = 0
    ) -> set[Event]:
        estimated = feedback._replace(tip_mm=tip_mm)
        # The reference itself says nothing: uncompensated it is 15 mm ahead of the tip.
        return events(
            Phase.INSERTING,
            readings,
            feedback=estimated,
            plan=plan,
            reference_mm=target,
            held_ticks=held_ticks,
        )

    assert found(closed, first) == {Event.CONTACTED}
    # Before it, contact may be a cough, and is waited for.
    assert found(closed, first - 0.01, held_ticks=549) == set()
    assert found(closed, first - 0.01, held_ticks=550) == {Event.CONTACT_MISPLACED}
    assert found(closed, target) == {Event.CONTACTED}
    unmet = closed._replace(contact_closed=False)
    assert found(unmet, 60.0) == {Event.CONTACT_MISPLACED}
    assert (
        events(Phase.INSERTING, unmet, feedback=feedback, plan=plan, reference_mm=target - 0.01)
        == set()
    )
    # A reading that is marked invalid is no contact.
    invalid = closed._replace(contact_valid=False)
    assert (
        events(Phase.INSERTING, invalid, feedback=feedback, plan=plan, reference_mm=60.0) == set()
    )
    # By travel it means nothing to the cycle.
    assert found(closed, 60.0, PLAN) == {Event.TARGET_REACHED}


def test_a_back_off_is_over_when_the_head_has_crossed_the_gap_and_rests() -> None:
    plan = PLAN._replace(contact=PLAN.contact._replace(enabled=True, backoff_mm=10.0))

    def over(feedback: ControlFeedback = QUIET, **state: Any) -> bool:
        way = {"start_mm": 65.0, "end_mm": 55.0, "touched_mm": 65.0}
        there: dict[str, Any] = way | {"reference_mm": 55.0} | state
        found = events(Phase.BACKING_OFF, feedback=feedback, plan=plan, **there)
        return found == {Event.BACKED_OFF}

    assert over()
    assert not over(reference_mm=55.1)
    assert not over(reference_mm_per_s=-5.0)
    # The head follows its command closely, but is still inside the gap.
    assert not over(QUIET._replace(head_wanted_mm_per_s=-17.0))
    assert not over(QUIET._replace(head_wanted_mm=5.0))
    # Half of its length must lie behind where the switch opened.
    assert over(touched_mm=60.0)
    assert not over(touched_mm=59.9)


def test_an_abort_is_over_when_the_head_rests_at_home_and_the_valve_is_closed() -> None:
    assert events(Phase.ABORTING) == {Event.CLEARED}
    assert events(Phase.ABORTING, AT_HOME._replace(cam_rad=0.1)) == set()
    assert events(Phase.ABORTING, AT_HOME._replace(head_mm=5.0)) == set()
    # Passing through home on the way in, still moving.
    assert events(Phase.ABORTING, feedback=QUIET._replace(head_wanted_mm=1.2)) == set()
    assert events(
        Phase.ABORTING, AT_HOME._replace(head_mm=50.0), feedback=QUIET._replace(powerless=True)
    ) == {Event.CLEARED}


@pytest.mark.requirement("OS-R05")
def test_every_phase_with_a_limit_becomes_overdue() -> None:
    late = round(100.0 / DT_S)
    overdue = {phase for phase in Phase if Event.PHASE_OVERDUE in events(phase, phase_ticks=late)}
    assert overdue == {
        Phase.CHECKING,
        Phase.PRELOADING,
        Phase.INSERTING,
        Phase.BACKING_OFF,
        Phase.OPENING,
        Phase.SUCTIONING,
        Phase.WITHDRAWING,
        Phase.CLOSING,
        Phase.ABORTING,
        Phase.IDENTIFYING,
    }


def test_a_trip_is_seen_in_every_phase() -> None:
    assert all(
        Event.TRIPPED in events(phase, feedback=QUIET._replace(tripped=True)) for phase in Phase
    )


def test_a_steady_contact_a_little_before_the_window_may_be_the_carina() -> None:
    search = PLAN.contact._replace(enabled=True, nearest_mm=PLAN.contact.window_start_mm - 10.0)
    plan, target = PLAN._replace(contact=search), PLAN.motion.target_mm
    closed = AT_HOME._replace(contact_closed=True, head_mm=target)

    def found(tip_mm: float, held_ticks: int) -> set[Event]:
        feedback = QUIET._replace(head_wanted_mm=target, tip_mm=tip_mm)
        return events(
            Phase.INSERTING,
            closed,
            feedback=feedback,
            plan=plan,
            reference_mm=target,
            held_ticks=held_ticks,
        )

    assert found(search.nearest_mm, 549) == set()
    assert found(search.nearest_mm, 550) == {Event.CONTACTED}
    assert found(search.nearest_mm - 0.01, 550) == {Event.CONTACT_MISPLACED}


@pytest.mark.parametrize(("nearer", "told"), [(True, {Event.CONTACT_MISPLACED}), (False, set())])
def test_a_switch_that_drawing_back_does_not_open_is_none_of_a_carina(
    nearer: bool, told: set[Event]
) -> None:
    search = PLAN.contact._replace(enabled=True, backoff_mm=10.0)
    plan = PLAN._replace(contact=search)

    def found(touched_mm: float) -> set[Event]:
        return events(
            Phase.BACKING_OFF,
            plan=plan,
            start_mm=25.0,
            end_mm=15.0,
            reference_mm=17.0,
            reference_mm_per_s=-20.0,
            touched_mm=touched_mm,
            nearer=nearer,
        )

    # Three quarters of a back-off are given to press-in and gap.
    assert found(17.51) == set()
    assert found(17.5) == told


def test_contact_where_none_can_be_is_counted_off_again_once_it_is_over() -> None:
    search = PLAN.contact._replace(enabled=True)
    closed, early_mm = AT_HOME._replace(contact_closed=True), search.window_start_mm - 5.0

    def held(*ways: tuple[Readings, int], tip_mm: float = early_mm, enabled: bool = True) -> int:
        state = cycle.begin(PLAN, Phase.INSERTING)
        for readings, ticks in ways:
            for _ in range(ticks):
                chosen = search._replace(enabled=enabled)
                state = progress.hold(chosen, state, tip_mm, readings)
        return state.held_ticks

    assert held((closed, 300)) == 300
    # An open switch may chatter for 10 ms.
    assert held((closed, 300), (AT_HOME, 9)) == 309
    assert held((closed, 300), (AT_HOME, 209)) == 109
    assert held(*[(closed, 3), (AT_HOME, 7)] * 60) == 600
    assert held((AT_HOME, 50)) == 0
    # Where the carina can be it is contact, and by travel nothing is expected anywhere.
    assert held((closed, 300), tip_mm=search.window_start_mm) == 0
    assert held((closed, 300), enabled=False) == 0
