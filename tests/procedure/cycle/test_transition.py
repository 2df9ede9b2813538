import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle.transition import ACTIVE, STAY, TRANSITIONS, Event, cause, follow

URGENT = (Event.TRIPPED, Event.ABORT_REQUESTED, Event.PHASE_OVERDUE)


def bits(*events: Event) -> int:
    return sum(1 << event for event in events)


def test_every_pair_goes_where_the_table_says_and_an_unknown_one_nowhere() -> None:
    for phase in Phase:
        for event in Event:
            expected = TRANSITIONS.get((phase, event), phase)
            assert follow(phase, bits(event)) == expected, (phase, event)


def test_nothing_happened_changes_nothing() -> None:
    assert all(follow(phase, 0) == phase for phase in Phase)


@given(phase=st.sampled_from(Phase), events=st.sets(st.sampled_from(Event)))
def test_of_several_events_the_most_urgent_known_one_counts(
    phase: Phase, events: set[Event]
) -> None:
    known = [event for event in sorted(events) if (phase, event) in TRANSITIONS]
    expected = TRANSITIONS[phase, known[0]] if known else phase
    assert follow(phase, bits(*events)) == expected
    assert cause(phase, bits(*events)) == (known[0] if known else STAY)


def test_stopping_outranks_everything() -> None:
    assert tuple(sorted(Event))[:3] == URGENT


@pytest.mark.requirement("OS-R26")
@given(
    phase=st.sampled_from(ACTIVE),
    urgent=st.sampled_from(URGENT),
    others=st.sets(st.sampled_from(Event)),
)
def test_every_active_phase_is_broken_off_whatever_else_happens(
    phase: Phase, urgent: Event, others: set[Event]
) -> None:
    assert follow(phase, bits(urgent, *(others - {urgent}))) == Phase.ABORTING


def test_active_phases_are_all_but_those_that_wait_or_already_leave() -> None:
    resting = {Phase.PARKED, Phase.HALTED, Phase.ABORTING, Phase.OUT_OF_SERVICE}
    assert set(ACTIVE) == set(Phase) - resting


def reachable(start: Phase) -> set[Phase]:
    found, left = {start}, [start]
    while left:
        here = left.pop()
        for (phase, _), following in TRANSITIONS.items():
            if phase == here and following not in found:
                found.add(following)
                left.append(following)
    return found


def test_every_phase_can_be_reached_and_left_again() -> None:
    for phase in set(Phase):
        assert reachable(phase) == set(Phase), phase


@pytest.mark.requirement("OS-R26")
def test_a_halt_ends_only_by_a_persons_hand() -> None:
    ways_out = {event for phase, event in TRANSITIONS if phase == Phase.HALTED}
    assert ways_out == {Event.RESET_REQUESTED, Event.RECOVERY_REQUESTED, Event.SERVICE_REQUESTED}
    assert follow(Phase.HALTED, bits(*(set(Event) - ways_out))) == Phase.HALTED


def test_a_cycle_begins_only_from_parked_and_only_by_a_request() -> None:
    assert [pair for pair, after in TRANSITIONS.items() if after == Phase.CHECKING] == [
        (Phase.PARKED, Event.START_REQUESTED)
    ]


@pytest.mark.requirement("OS-R20")
def test_the_tip_goes_in_only_after_check_and_preload() -> None:
    assert [pair for pair, after in TRANSITIONS.items() if after == Phase.INSERTING] == [
        (Phase.PRELOADING, Event.PRELOADED)
    ]
    assert [pair for pair, after in TRANSITIONS.items() if after == Phase.PRELOADING] == [
        (Phase.CHECKING, Event.CHECK_PASSED)
    ]


def test_an_abort_ends_halted_never_parked() -> None:
    after = {following for (phase, _), following in TRANSITIONS.items() if phase == Phase.ABORTING}
    assert after == {Phase.HALTED}


def test_out_of_service_nothing_happens_until_a_person_ends_it() -> None:
    ways_out = {event for phase, event in TRANSITIONS if phase == Phase.OUT_OF_SERVICE}
    assert ways_out == {Event.SERVICE_ENDED, Event.SERVICE_ENDED_AWAY}
    assert follow(Phase.OUT_OF_SERVICE, bits(*(set(Event) - ways_out))) == Phase.OUT_OF_SERVICE


def test_service_and_teaching_begin_only_with_the_tip_out() -> None:
    before = {
        after: {phase for (phase, _), following in TRANSITIONS.items() if following == after}
        for after in (Phase.OUT_OF_SERVICE, Phase.TEACHING)
    }
    assert before[Phase.OUT_OF_SERVICE] == {Phase.PARKED, Phase.HALTED}
    assert before[Phase.TEACHING] == {Phase.PARKED}
