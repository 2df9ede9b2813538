"""A machine that trips for the same reason again and again is locked out, and lets a hand help."""

import numpy as np
import pytest

from opensuction.controller import controller
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle.lock_out import MOST_RESETS, NONE, LockOut, Refusal
from opensuction.safety.condition import Condition
from opensuction.simulation.closed_loop import DT_S, LoopState
from opensuction.simulation.trace import Columns, phase_spans
from tests.controller.drive import (
    RESET,
    RETURN_TO_SERVICE,
    SERVICE,
    START,
    Fault,
    at_rest,
    during,
    phases,
    simulate,
)
from tests.controller.invariant import assert_held
from tests.controller.test_cycle import CYCLE, EXACT

JAMMED = during(Fault.HEAD_JAMMED, 30.0)
"""In the middle of the withdrawal."""
RESETS_S = np.round(np.arange(60.0, 60.0 + 56.0 * 25.0, 25.0), 1).tolist()
"""56, each once the pull of the one before is over."""
SOON_S = [*RESETS_S[: MOST_RESETS + 1], *(RESETS_S[MOST_RESETS] + 2.0 * n for n in range(1, 53))]
"""As many; those that are refused, with no pull to wait for, soon after one another."""


def pulls(columns: Columns) -> int:
    """How often the drive drew at the catheter with the torque that it has, after the trip."""
    strong = np.abs(columns["commands.insertion_v"]) > 20.0
    spans = phase_spans(columns)
    return sum(
        bool(strong[round(span.start_s / DT_S) : round(span.end_s / DT_S)].any())
        for span in spans
        if span.phase == Phase.ABORTING and span.start_s > RESETS_S[0] - 1.0
    )


def locked(state: LoopState) -> LockOut:
    return state.controller.core.upkeep.lock


def alarmed(columns: Columns, code: Condition) -> np.ndarray[tuple[int, ...], np.dtype[np.int64]]:
    return columns["signals.present"].astype(np.int64) >> int(code) & 1


@pytest.mark.requirement("OS-R43")
@pytest.mark.parametrize(
    "resets_s",
    [SOON_S, pytest.param(RESETS_S, marks=pytest.mark.soak)],
    ids=["in minutes", "in 23 minutes"],
)
def test_56_resets_on_a_jam_are_three_pulls_more(resets_s: list[float]) -> None:
    assert len(resets_s) == 56
    buttons = {0.0: START} | dict.fromkeys(resets_s, RESET)
    state, columns = simulate(EXACT, resets_s[-1] + 30.0, buttons, JAMMED)
    after = columns["time_s"] > RESETS_S[0] - 1.0
    assert phases(columns).count(Phase.ABORTING) == 1 + MOST_RESETS
    assert pulls(columns) == MOST_RESETS
    # What is refused moves nothing: a hand has the catheter.
    late = columns["time_s"] > RESETS_S[MOST_RESETS]
    assert not columns["commands.insertion_on"][late].any()
    assert not columns["commands.pump_on"][after].any()
    assert state.controller.core.upkeep.refusal == Refusal.LOCKED_OUT
    assert alarmed(columns, Condition.LOCKED_OUT)[late].all()
    assert columns["counters.resets"][-1] == MOST_RESETS
    # The alarm comes with the stop that locks, before somebody presses in vain.
    first = int(np.argmax(alarmed(columns, Condition.LOCKED_OUT)))
    assert RESETS_S[MOST_RESETS - 1] < first * DT_S < RESETS_S[MOST_RESETS]


@pytest.mark.requirement("OS-R43")
def test_service_ends_a_lock_out_wherever_the_head_is_and_one_recovery_draws_it_out() -> None:
    """Somebody has freed the catheter meanwhile; it is still inside."""
    buttons = {0.0: START} | dict.fromkeys(RESETS_S[: MOST_RESETS + 1], RESET)
    end_s = RESETS_S[MOST_RESETS] + 5.0
    state, columns = simulate(EXACT, end_s, buttons, JAMMED)
    assert locked(state).locked
    inside_mm = columns["truth.head_mm"][-1] - at_rest(EXACT)[0].controller.limits.park_head_mm
    assert inside_mm > 10.0
    freed = {0.0: START, 1.0: SERVICE, 3.0: RETURN_TO_SERVICE, 5.0: RESET, 25.0: RESET}
    state, columns = simulate(EXACT, 80.0, freed | {30.0: START}, start=state)
    assert phases(columns) == [
        Phase.HALTED,
        Phase.OUT_OF_SERVICE,
        Phase.HALTED,
        Phase.ABORTING,
        Phase.HALTED,
        Phase.PARKED,
        *CYCLE,
    ]
    serviced = columns["phase"] == Phase.OUT_OF_SERVICE
    assert not columns["commands.insertion_on"][serviced].any()
    assert locked(state) == NONE
    assert_held(columns, at_rest(EXACT)[0])


def test_a_whole_cycle_between_begins_a_new_count() -> None:
    """The switch bridges, is cleaned, and bridges again weeks later."""
    state = at_rest(EXACT)[1]
    for _ in range(2):
        for resets in range(1, MOST_RESETS + 1):
            bridged = during(Fault.CONTACT_CLOSED, 0.0, 8.0)
            state, _ = simulate(EXACT, 25.0, {0.0: START, 20.0: RESET}, bridged, start=state)
            assert locked(state).resets == resets
            assert not locked(state).locked
        state, columns = simulate(EXACT, 50.0, {0.0: START}, start=state)
        assert phases(columns)[-1] == Phase.PARKED
        assert locked(state) == NONE


def test_the_fourth_time_with_the_head_at_home_is_locked_at_once() -> None:
    state = at_rest(EXACT)[1]
    for _ in range(MOST_RESETS + 1):
        bridged = during(Fault.CONTACT_CLOSED, 0.0, 8.0)
        buttons = {0.0: START, 20.0: RESET, 21.0: START}
        state, columns = simulate(EXACT, 22.0, buttons, bridged, start=state)
        if phases(columns)[-1] == Phase.CHECKING:
            state, _ = simulate(EXACT, 30.0, {}, bridged, start=state)
            state, _ = simulate(EXACT, 1.0, {0.0: RESET}, start=state)
    assert locked(state).locked
    assert state.controller.core.procedure.phase == Phase.HALTED
    buttons = {0.0: RESET, 1.0: SERVICE, 2.0: RETURN_TO_SERVICE, 3.0: START}
    _, columns = simulate(EXACT, 4.0, buttons, start=state)
    assert phases(columns) == [Phase.HALTED, Phase.OUT_OF_SERVICE, Phase.PARKED, Phase.CHECKING]


def with_lock(state: LoopState, lock: LockOut) -> LoopState:
    kept = state.controller.core.upkeep._replace(lock=lock)
    return state._replace(controller=controller.with_upkeep(state.controller, kept))


def test_a_lock_out_lets_one_recovery_happen_where_none_was_tried() -> None:
    """Three resets with the head at home; the fourth time the catheter is inside."""
    state, _ = simulate(EXACT, 20.0, {0.0: START})
    known = 1 << Condition.CAM_READING_INVALID
    state = with_lock(state, NONE._replace(dealt=known, resets=MOST_RESETS))
    # The valve's encoder breaks, and the head cannot be read for long enough to end the way out.
    state, columns = simulate(EXACT, 1.0, {}, during(Fault.CAM_NAN, 0.0), start=state)
    assert locked(state).locked
    state, columns = simulate(EXACT, 40.0, {}, during(Fault.HEAD_JAMMED, 0.0, 35.0), start=state)
    assert phases(columns)[-1] == Phase.HALTED
    away_mm = columns["truth.head_mm"][-1] - at_rest(EXACT)[0].controller.limits.park_head_mm
    assert away_mm > 10.0
    state, columns = simulate(EXACT, 30.0, {0.0: RESET, 20.0: RESET, 25.0: START}, start=state)
    # It comes out, and stays locked: the valve has not been looked at.
    assert phases(columns) == [Phase.ABORTING, Phase.HALTED]
    assert columns["truth.head_mm"][-1] == pytest.approx(
        at_rest(EXACT)[0].controller.limits.park_head_mm, abs=1.0
    )
    assert locked(state).locked
    assert state.controller.core.upkeep.refusal == Refusal.LOCKED_OUT


def test_a_persons_own_stops_lock_nothing() -> None:
    state = at_rest(EXACT)[1]
    for _ in range(MOST_RESETS + 2):
        state, columns = simulate(EXACT, 12.0, {0.0: START, 1.0: 4, 10.0: RESET}, start=state)
        assert phases(columns)[-1] == Phase.PARKED
    assert locked(state) == NONE


def test_the_plug_undoes_no_limit() -> None:
    loop, parked = at_rest(EXACT)
    kept = parked.controller.core.upkeep._replace(
        lock=NONE._replace(locked=True, resets=MOST_RESETS, recovered=True)
    )
    home_mm = loop.controller.plan.motion.park_head_mm
    again = controller.restart(loop.controller, home_mm, kept, 60.0)
    assert again.core.upkeep.catheter_age_s == kept.catheter_age_s + 60.0
    state = parked._replace(controller=again)
    buttons = {0.0: START, 1.0: SERVICE, 2.0: RETURN_TO_SERVICE, 3.0: START}
    _, columns = simulate(EXACT, 4.0, buttons, start=state)
    assert columns["counters.refusal"][500] == Refusal.LOCKED_OUT
    assert alarmed(columns, Condition.LOCKED_OUT)[500]
    assert phases(columns) == [Phase.PARKED, Phase.OUT_OF_SERVICE, Phase.PARKED, Phase.CHECKING]


def test_late_ticks_are_in_the_record() -> None:
    late = during(Fault.OVERRUN, 0.5, 0.502)
    _, columns = simulate(EXACT, 1.0, {}, late)
    share = columns["counters.late_share"]
    assert not share[:500].any()
    assert share.argmax() == 501
    assert 0.01 < share.max() < 0.05  # two ticks of the 0.1 s that it is averaged over
