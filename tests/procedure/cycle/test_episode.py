"""Passes, their rest, and the answer about oxygen: the rules by themselves."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel.interface import (
    ABORT,
    ASSESSED,
    NO_REQUESTS,
    OXYGEN_SKIPPED,
    OXYGENATED,
    Requests,
)
from opensuction.kernel.vocabulary import RESTING, AgeGroup, Phase
from opensuction.procedure.cycle import button, interlocks, lock_out, schedule
from opensuction.procedure.cycle.interlocks import LIFE_S, Service
from opensuction.procedure.cycle.lock_out import Refusal
from opensuction.procedure.cycle.schedule import NEW, VALID_S, Episode, OxygenAnswer, Preoxygenation
from opensuction.procedure.planning import guideline
from opensuction.procedure.planning.guideline import BENCH, RULES

RULE = RULES[AgeGroup.ADULT]
PARKED, INSERTING = int(Phase.PARKED), int(Phase.INSERTING)
SERVICE = Service(life_s=LIFE_S, cycle_s=60.0, schedule=schedule.ON_REQUEST_ONLY, passes=RULE)


@given(st.lists(st.tuples(st.sampled_from(Phase), st.floats(0.001, 100.0)), max_size=40))
def test_a_rest_is_over_only_after_so_long_at_rest(history: list[tuple[Phase, float]]) -> None:
    state, before, at_rest_s, passes = NEW, Phase.PARKED, float("inf"), 0
    for phase, seconds in history:
        state = schedule.step_episode(RULE, state, int(before), int(phase), seconds)
        if phase == Phase.INSERTING and before != Phase.INSERTING:
            passes, at_rest_s = passes + 1, 0.0
        elif phase not in RESTING and at_rest_s < RULE.rest_s:
            at_rest_s = 0.0
        elif phase in RESTING:
            at_rest_s += seconds
        assert state.passes == passes
        assert state.rest_left_s == pytest.approx(max(RULE.rest_s - at_rest_s, 0.0), abs=1e-6)
        before = phase


def test_idle_time_is_time_at_rest() -> None:
    state = Episode(passes=2, exceeded=False, rest_left_s=100.0)
    assert schedule.pass_idle_time_episode(state, 40.0).rest_left_s == 60.0
    assert schedule.pass_idle_time_episode(state, 400.0) == state._replace(rest_left_s=0.0)
    stepped = schedule.step_episode(RULE, state, PARKED, PARKED, 40.0)
    assert stepped == schedule.pass_idle_time_episode(state, 40.0)


def test_nobody_is_counted_on_the_bench() -> None:
    state = NEW
    for _ in range(10):
        state = schedule.step_episode(BENCH, state, PARKED, INSERTING, 0.001)
        state = schedule.step_episode(BENCH, state, INSERTING, PARKED, 0.001)
    assert state.rest_left_s == 0.0
    assert not schedule.is_exhausted(BENCH, state)
    assert guideline.of(bench_only=True, age=AgeGroup.ADULT) == BENCH


def test_the_seconds_that_are_left_are_said() -> None:
    kept = interlocks.start(0.0)._replace(episode=NEW._replace(rest_left_s=41.2))
    assert "another 42 s" in lock_out.say(Refusal.RESTING, 41.2)
    assert lock_out.say(Refusal.HALTED, 41.2) == lock_out.SENTENCES[Refusal.HALTED]
    assert interlocks.refusal(SERVICE, kept, PARKED, True, 0) == Refusal.RESTING


def test_the_patient_is_looked_at_first_then_rests_then_is_given_oxygen() -> None:
    kept = interlocks.start(0.0)._replace(episode=Episode(3, False, 10.0))
    said = []
    for state in (
        kept,
        kept._replace(episode=NEW._replace(rest_left_s=10.0)),
        kept._replace(episode=NEW),
        kept._replace(episode=NEW, oxygen=OxygenAnswer(int(Preoxygenation.SKIPPED), 1.0)),
    ):
        said.append(interlocks.refusal(SERVICE, state, PARKED, True, 0))
    assert said == [
        Refusal.PASS_LIMIT,
        Refusal.RESTING,
        Refusal.OXYGEN_UNANSWERED,
        Refusal.NONE,
    ]


@pytest.mark.parametrize("pressed", [ASSESSED, OXYGENATED, OXYGEN_SKIPPED])
def test_who_aborts_answers_nothing(pressed: Requests) -> None:
    kept = interlocks.start(0.0)._replace(episode=Episode(3, True, 0.0))
    assert interlocks.hear(SERVICE, kept, PARKED, pressed) != kept
    both = pressed._replace(abort=True)
    assert interlocks.hear(SERVICE, kept, PARKED, both) == kept
    assert interlocks.hear(SERVICE, kept, PARKED, ABORT) == kept


@given(st.sampled_from(Phase))
def test_only_a_parked_machine_hears_about_oxygen_and_only_a_resting_one_of_a_look(
    phase: Phase,
) -> None:
    kept = interlocks.start(0.0)._replace(episode=Episode(3, True, 0.0))
    heard = interlocks.hear(SERVICE, kept, int(phase), ASSESSED._replace(oxygenated=True))
    assert (heard.oxygen != kept.oxygen) == (phase == Phase.PARKED)
    assert (heard.episode.passes == 0) == (phase in RESTING)


def test_an_answer_ends_with_its_time_its_pass_and_a_halt() -> None:
    given_now = schedule.hear(True, schedule.NONE, PARKED, OXYGENATED)
    assert given_now.left_s == VALID_S
    later = schedule.pass_oxygen_time(given_now, VALID_S - 1.0)
    assert schedule.is_answered(later)
    assert not schedule.is_answered(schedule.pass_oxygen_time(given_now, VALID_S))
    for before, phase in ((Phase.CLOSING, Phase.PARKED), (Phase.PARKED, Phase.HALTED)):
        ended = schedule.step_oxygen(True, given_now, int(before), int(phase), False, 0.001)
        assert ended.state == Preoxygenation.NOT_ASKED
    assert schedule.hear(False, given_now, PARKED, OXYGENATED) == schedule.NONE


def test_a_button_acts_once_and_an_abort_as_long_as_it_is_held() -> None:
    everything = Requests(*[True] * len(Requests._fields))
    assert button.press_once(everything, button.NONE) == everything
    assert button.press_once(everything, button.hold(everything)) == ABORT
    assert button.press_once(NO_REQUESTS, button.hold(everything)) == NO_REQUESTS
