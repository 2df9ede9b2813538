"""Passes at one patient: three, a rest between them, then a person; nothing goes round it."""

import numpy as np
import pytest

from opensuction.controller import controller
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle.lock_out import Refusal
from opensuction.procedure.cycle.schedule import Preoxygenation, ScheduleMode
from opensuction.procedure.planning.guideline import MOST_PASSES, RULES
from opensuction.safety.condition import Condition
from opensuction.safety.condition_mask import decode
from opensuction.simulation.closed_loop import DT_S, Loop, LoopState
from opensuction.simulation.trace import Columns
from tests.controller.bedside import EXACT, at_bed, count, starts_s
from tests.controller.drive import (
    ABORT,
    ASSESSED,
    NOT_NEEDED,
    OXYGEN_SKIPPED,
    OXYGENATED,
    RESET,
    START,
    phases,
    simulate,
)
from tests.controller.invariant import assert_commands_held
from tests.controller.used_machine import clocked

SKIPPING = START | OXYGEN_SKIPPED
DUE_S = 3599.0
"""An hour's schedule is about to act."""
patients = pytest.mark.parametrize(
    "name", ["adult-icu", pytest.param("child-10kg", marks=pytest.mark.soak), "neonate"]
)


def rest_s(loop: Loop) -> float:
    return loop.controller.service.passes.rest_s


def held(seconds: float, bits: int) -> dict[float, int]:
    """Buttons that nobody lets go."""
    return dict.fromkeys((np.arange(round(seconds / DT_S)) * DT_S).tolist(), bits)


def pressed_often(seconds: float, every_s: float, bits: int) -> dict[float, int]:
    return dict.fromkeys(np.round(np.arange(0.0, seconds, every_s), 3).tolist(), bits)


def told(columns: Columns) -> set[Condition]:
    """All that was signalled."""
    masks = np.unique(columns["signals.present"].astype(np.int64))
    return {Condition(bit) for bit in decode(int(np.bitwise_or.reduce(masks)))}


def rested(state: LoopState) -> LoopState:
    """The same machine once the rest is over."""
    kept = state.controller.core.upkeep
    over = kept._replace(episode=kept.episode._replace(rest_left_s=0.0))
    return state._replace(controller=controller.with_upkeep(state.controller, over))


def after_passes(name: str, passes: int) -> LoopState:
    """A parked machine that has made some passes and rested."""
    state = at_bed(name)[1]
    kept = state.controller.core.upkeep
    made = kept._replace(episode=kept.episode._replace(passes=passes))
    return state._replace(controller=controller.with_upkeep(state.controller, made))


@pytest.mark.requirement("OS-R44")
@patients
def test_everything_held_for_300_s_is_one_cycle(name: str) -> None:
    loop, start = at_bed(name)
    bits = SKIPPING | OXYGENATED | ASSESSED | NOT_NEEDED | RESET
    _, columns = simulate(EXACT, 300.0, held(300.0, bits), start=start, loop=loop)
    assert count(columns, Phase.INSERTING) == 1
    assert phases(columns)[-1] == Phase.PARKED
    assert_commands_held(columns, loop)


@pytest.mark.requirement("OS-R41")
@patients
def test_eleven_starts_in_300_s_are_as_many_cycles_as_the_rests_leave(name: str) -> None:
    loop, start = at_bed(name)
    often = pressed_often(300.0, 300.0 / 11.0, SKIPPING)
    _, columns = simulate(EXACT, 300.0, often, start=start, loop=loop)
    began = starts_s(columns)
    assert 1 < len(began) <= MOST_PASSES
    ended = np.flatnonzero(np.diff(np.isin(columns["phase"], (Phase.PARKED,)).astype(int)) == 1)
    gaps = [began[i + 1] - ended[i] * DT_S for i in range(len(began) - 1)]
    assert min(gaps) >= rest_s(loop)
    assert Refusal.RESTING in columns["counters.refusal"]
    assert columns["counters.passes"][-1] == len(began)


@pytest.mark.requirement("OS-R40")
@patients
def test_pressing_all_day_is_three_passes_and_then_an_alarm_until_somebody_has_looked(
    name: str,
) -> None:
    loop, start = at_bed(name)
    seconds = 4.0 * (rest_s(loop) + 40.0)
    state, columns = simulate(
        EXACT, seconds, pressed_often(seconds, 1.0, SKIPPING), start=start, loop=loop
    )
    assert count(columns, Phase.INSERTING) == MOST_PASSES
    assert state.controller.core.upkeep.refusal == Refusal.PASS_LIMIT
    assert told(columns) == {Condition.PASS_LIMIT_REACHED}
    # Three passes that did what they should are no alarm: the fourth request is one.
    present = columns["signals.present"].astype(np.int64) >> Condition.PASS_LIMIT_REACHED & 1
    assert columns["counters.passes"][np.argmax(present)] == MOST_PASSES
    assert (np.diff(present) >= 0).all()
    state, columns = simulate(
        EXACT, 60.0, {1.0: ASSESSED, 2.0: SKIPPING}, start=rested(state), loop=loop
    )
    shown = columns["signals.present"].astype(np.int64) >> Condition.PASS_LIMIT_REACHED & 1
    assert shown[: round(0.99 / DT_S)].all()
    assert not shown[round(1.01 / DT_S) :].any()
    assert count(columns, Phase.INSERTING) == 1
    assert state.controller.core.upkeep.episode.passes == 1


def test_an_assessment_is_asked_for_after_the_third_pass_without_an_alarm() -> None:
    loop, _ = at_bed("child-10kg")
    second = after_passes("child-10kg", MOST_PASSES - 1)
    state, columns = simulate(EXACT, 20.0, {0.0: SKIPPING}, start=second, loop=loop)
    assert phases(columns)[-1] == Phase.PARKED
    assert told(columns) == set()
    assert columns["counters.passes"][-1] == MOST_PASSES
    # One that was made while the catheter was inside does not count: it was not the end of it.
    state, columns = simulate(EXACT, 20.0, {0.0: SKIPPING, 9.0: ASSESSED}, start=second, loop=loop)
    assert columns["counters.passes"][-1] == MOST_PASSES
    state, _ = simulate(EXACT, 1.0, {0.0: NOT_NEEDED}, start=state, loop=loop)
    assert state.controller.core.upkeep.episode.passes == 0


def test_a_pass_that_was_broken_off_counts_and_is_followed_by_a_rest() -> None:
    loop, start = at_bed("adult-icu")
    buttons = {0.0: SKIPPING, 12.0: ABORT, 30.0: RESET, 31.0: SKIPPING}
    state, columns = simulate(EXACT, 32.0, buttons, start=start, loop=loop)
    assert Phase.INSERTING in phases(columns)
    assert phases(columns)[-1] == Phase.PARKED
    assert state.controller.core.upkeep.refusal == Refusal.RESTING
    assert state.controller.core.upkeep.episode.passes == 1


def test_a_cycle_that_was_stopped_before_the_catheter_moved_is_no_pass() -> None:
    loop, start = at_bed("adult-icu")
    buttons = {0.0: SKIPPING, 2.0: ABORT, 9.0: RESET, 10.0: SKIPPING}
    state, columns = simulate(EXACT, 11.0, buttons, start=start, loop=loop)
    assert len(starts_s(columns)) == 2
    assert state.controller.core.upkeep.episode.passes == 0


@pytest.mark.requirement("OS-R40")
def test_the_clock_does_not_go_round_the_limit() -> None:
    loop, start = clocked(
        (at_bed("neonate")[0], after_passes("neonate", MOST_PASSES)), ScheduleMode.TIMED, DUE_S
    )
    state, columns = simulate(EXACT, 20.0, {10.0: ASSESSED}, start=start, loop=loop)
    early = {name: columns[name][:9_900] for name in ("time_s", "phase", "signals.present")}
    assert phases(early) == [Phase.PARKED]
    assert told(early) == {Condition.PASS_LIMIT_REACHED, Condition.AUTOMATION_STOPPED}
    # Who looks at the patient when a cycle is due lets it begin.
    assert starts_s(columns) == pytest.approx([10.0])
    assert state.controller.core.upkeep.episode.passes == 1


@pytest.mark.requirement("OS-R42")
def test_an_unanswered_request_for_oxygen_starts_nothing() -> None:
    loop, start = at_bed("adult-icu")
    state, columns = simulate(EXACT, 200.0, {1.0: START, 100.0: START}, start=start, loop=loop)
    assert phases(columns) == [Phase.PARKED]
    assert state.controller.core.upkeep.refusal == Refusal.OXYGEN_UNANSWERED
    asked = columns["counters.preoxygenation"]
    assert asked[500] == Preoxygenation.NOT_ASKED
    assert asked[-1] == Preoxygenation.REQUESTED
    assert told(columns) == set()


@pytest.mark.parametrize(
    ("answer", "on_record"),
    [(OXYGENATED, Preoxygenation.CONFIRMED), (OXYGEN_SKIPPED, Preoxygenation.SKIPPED)],
)
def test_what_was_answered_is_on_record_for_the_pass_and_must_be_answered_anew(
    answer: int, on_record: Preoxygenation
) -> None:
    loop, start = at_bed("child-10kg")
    buttons = {0.0: START, 60.0: answer, 61.0: START}
    state, columns = simulate(EXACT, 80.0, buttons, start=start, loop=loop)
    assert starts_s(columns) == pytest.approx([61.0])
    during = columns["phase"] != Phase.PARKED
    assert set(columns["counters.preoxygenation"][during]) == {on_record}
    assert columns["counters.preoxygenation"][-1] == Preoxygenation.NOT_ASKED
    state, columns = simulate(EXACT, 1.0, {0.0: START}, start=rested(state), loop=loop)
    assert phases(columns) == [Phase.PARKED]


def test_an_answer_of_long_ago_is_none_and_a_skip_takes_no_confirmation_back() -> None:
    loop, start = at_bed("child-10kg")
    late = {0.0: OXYGENATED, 121.0: START}
    _, columns = simulate(EXACT, 122.0, late, start=start, loop=loop)
    assert phases(columns) == [Phase.PARKED]
    both = {0.0: OXYGENATED, 119.0: SKIPPING}
    _, columns = simulate(EXACT, 122.0, both, start=start, loop=loop)
    assert starts_s(columns) == pytest.approx([119.0])
    assert columns["counters.preoxygenation"][-1] == Preoxygenation.CONFIRMED


def test_a_neonate_is_given_none_and_nobody_is_asked() -> None:
    loop, start = at_bed("neonate")
    _, columns = simulate(EXACT, 5.0, {0.0: START}, start=start, loop=loop)
    assert starts_s(columns) == [0.0]
    assert set(columns["counters.preoxygenation"]) == {Preoxygenation.NOT_REQUIRED}


def test_a_due_cycle_waits_for_the_answer_and_is_missed_aloud_without_one() -> None:
    loop, start = clocked(at_bed("adult-icu"), ScheduleMode.TIMED, DUE_S)
    _, answered = simulate(EXACT, 100.0, {90.0: OXYGENATED}, start=start, loop=loop)
    assert starts_s(answered) == pytest.approx([90.0])
    assert told(answered) == set()
    _, columns = simulate(EXACT, 130.0, {}, start=start, loop=loop)
    assert phases(columns) == [Phase.PARKED]
    missed = columns["signals.present"].astype(np.int64) >> Condition.AUTOMATION_STOPPED & 1
    assert np.argmax(missed) * DT_S == pytest.approx(121.0, abs=0.01)


def test_a_prompt_to_look_waits_without_an_alarm_for_as_long_as_it_takes() -> None:
    loop, start = clocked(at_bed("adult-icu"), ScheduleMode.PROMPT, DUE_S)
    _, columns = simulate(EXACT, 300.0, {290.0: ASSESSED}, start=start, loop=loop)
    assert told(columns) == set()


def test_a_controller_that_starts_anew_goes_on_counting() -> None:
    loop, _ = at_bed("adult-icu")
    kept = after_passes("adult-icu", MOST_PASSES).controller.core.upkeep
    resting = kept._replace(episode=kept.episode._replace(rest_left_s=100.0))
    home_mm = loop.controller.plan.motion.park_head_mm
    again = controller.restart(loop.controller, home_mm, resting, 40.0).core.upkeep
    assert (again.episode.passes, again.episode.rest_left_s) == (MOST_PASSES, 60.0)
    away = controller.restart(loop.controller, home_mm + 30.0, resting, 40.0).core.upkeep
    assert away.episode.rest_left_s == rest_s(loop)


def test_a_controller_that_died_in_a_cycle_waits_for_a_person_even_with_the_head_home() -> None:
    loop, start = at_bed("adult-icu")
    kept = start.controller.core.upkeep
    home_mm = loop.controller.plan.motion.park_head_mm
    for phase in Phase:
        state = controller.restart(loop.controller, home_mm, kept, 1.0, phase)
        halts = phase not in (Phase.PARKED, Phase.HALTED, Phase.OUT_OF_SERVICE)
        assert state.core.procedure.phase == (Phase.HALTED if halts else Phase.PARKED)
        assert (state.core.reasons >> Condition.AUTOMATION_STOPPED & 1 == 1) == halts


def test_power_up_with_the_catheter_away_from_home_begins_with_a_rest() -> None:
    loop, _ = at_bed("adult-icu")
    away_mm = loop.controller.plan.motion.park_head_mm + 30.0
    kept = controller.start(loop.controller, away_mm, 0.0).core.upkeep
    assert kept.episode.rest_left_s == rest_s(loop)
    home_mm = loop.controller.plan.motion.park_head_mm
    assert controller.start(loop.controller, home_mm, 0.0).core.upkeep.episode.rest_left_s == 0.0


def test_every_age_has_a_rule_that_limits() -> None:
    for rule in RULES.values():
        assert rule.most_passes == 3
        # Lung volume has not recovered after a minute [Maggiore-2003].
        assert rule.rest_s > 60.0
