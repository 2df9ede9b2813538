"""Due times of cycles, whatever is pressed and whatever state the machine is in."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel.errors import InputError
from opensuction.procedure.cycle import schedule
from opensuction.procedure.cycle.schedule import (
    LEAST_INTERVAL_S,
    ON_REQUEST_ONLY,
    Schedule,
    ScheduleMode,
    ScheduleState,
)

TIMED = schedule.schedule(ScheduleMode.TIMED, 3600.0)
PROMPT = schedule.schedule(ScheduleMode.PROMPT, 3600.0)

modes = st.sampled_from([ON_REQUEST_ONLY, TIMED, PROMPT])
times = st.floats(0.0, 1e6)


@given(times, times)
def test_on_request_nothing_is_ever_due(cycle_s: float, assessed_s: float) -> None:
    state = ScheduleState(cycle_s, assessed_s)
    assert not schedule.starts(ON_REQUEST_ONLY, state)
    assert not schedule.prompts(ON_REQUEST_ONLY, state)


@given(times, times)
def test_timed_starts_and_prompt_asks_when_the_interval_is_over(
    cycle_s: float, assessed_s: float
) -> None:
    state = ScheduleState(cycle_s, assessed_s)
    assert schedule.starts(TIMED, state) == (cycle_s >= 3600.0)
    assert not schedule.prompts(TIMED, state)
    assert schedule.prompts(PROMPT, state) == (assessed_s >= 3600.0)
    assert not schedule.starts(PROMPT, state)


@given(
    modes,
    st.lists(st.tuples(st.booleans(), st.booleans(), st.booleans()), max_size=60),
)
def test_after_a_cycle_or_a_persons_return_a_whole_interval_passes(
    chosen: Schedule, history: list[tuple[bool, bool, bool]]
) -> None:
    state, waited_s = schedule.restart(), 0.0
    for began, assessed, attended in history:
        state = schedule.step(state, began, assessed, attended, 300.0)
        waited_s = 0.0 if began or attended else waited_s + 300.0
        assert state.since_cycle_s == waited_s
        if schedule.starts(chosen, state):
            assert waited_s >= LEAST_INTERVAL_S
        assert state.since_assessment_s <= state.since_cycle_s


def test_an_assessment_postpones_the_prompt_but_not_a_timed_cycle() -> None:
    state = schedule.step(ScheduleState(3600.0, 3600.0), False, True, False, 0.001)
    assert not schedule.prompts(PROMPT, state)
    assert schedule.starts(TIMED, state)


@pytest.mark.parametrize("mode", [ScheduleMode.TIMED, ScheduleMode.PROMPT])
@pytest.mark.parametrize("interval_s", [0.0, 899.0, float("nan"), float("inf"), -1.0])
def test_an_interval_that_is_none_is_refused(mode: ScheduleMode, interval_s: float) -> None:
    with pytest.raises(InputError, match="not at least 15 min"):
        schedule.schedule(mode, interval_s)


def test_guidelines_have_their_say_about_timed_cycles() -> None:
    assert schedule.notes(ON_REQUEST_ONLY) == []
    assert len(schedule.notes(PROMPT)) == 1
    four_hours = schedule.schedule(ScheduleMode.TIMED, 4 * 3600.0)
    assert len(schedule.notes(four_hours)) == 1
    assert "24 times a day: more than 6" in schedule.notes(TIMED)[1]
