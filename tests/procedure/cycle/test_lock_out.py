"""Lock-out of a machine by resets, for any order of stops, resets and causes."""

from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle import lock_out
from opensuction.procedure.cycle.lock_out import MOST_RESETS, MOVING, NONE, REPEATING, LockOut
from opensuction.safety.condition import Condition
from opensuction.safety.condition_mask import decode

HALTED, ABORTING, PARKED = (int(p) for p in (Phase.HALTED, Phase.ABORTING, Phase.PARKED))


def stop_and_reset(state: LockOut, trips: int, away: bool) -> tuple[LockOut, bool]:
    """The machine halts for something, and a person resets it; whether that was granted."""
    state = lock_out.step(state, HALTED, HALTED, False, trips)
    granted = lock_out.lets_reset(state, not away)
    after = (ABORTING if away else PARKED) if granted else HALTED
    return lock_out.step(state, HALTED, after, granted, 0), granted


causes = st.integers(0, 2**53 - 1)


@given(st.lists(st.tuples(causes, st.booleans()), min_size=60, max_size=60))
def test_resets_are_bounded_whatever_the_machine_calls_its_trouble(
    stops: list[tuple[int, bool]],
) -> None:
    """Each kind of cause is new once; from then on every reset counts."""
    state, granted = NONE, 0
    for trips, away in stops:
        counted = trips & REPEATING != 0
        state, went = stop_and_reset(state, trips, away)
        granted += went and counted
    kinds = len(decode(REPEATING & ~MOVING)) + 1
    assert granted <= MOST_RESETS + kinds + 1  # and one recovery


@given(st.lists(st.sampled_from(decode(MOVING)), min_size=10, max_size=10))
def test_a_jam_is_one_cause_under_whatever_name(names: list[int]) -> None:
    state, granted = NONE, 0
    for name in names:
        state, went = stop_and_reset(state, 1 << name, True)
        granted += went
    assert granted == MOST_RESETS


def test_what_the_patient_shows_locks_nothing() -> None:
    state = NONE
    for _ in range(10):
        state, granted = stop_and_reset(state, 1 << Condition.SPO2_LOW, False)
        assert granted
    assert state.resets == 0


def test_service_and_a_whole_cycle_begin_anew() -> None:
    state = NONE
    for _ in range(MOST_RESETS):
        state, _ = stop_and_reset(state, 1 << Condition.CAM_READING_INVALID, False)
    assert state.resets == MOST_RESETS
    closing, service = int(Phase.CLOSING), int(Phase.OUT_OF_SERVICE)
    assert lock_out.step(state, closing, PARKED, False, 0) == NONE
    assert lock_out.step(state, service, PARKED, False, 0) == NONE
    assert lock_out.step(state, service, HALTED, False, 0) == NONE
    assert lock_out.step(state, service, service, False, 0) == state
    assert lock_out.step(state, closing, ABORTING, False, 0).resets == MOST_RESETS
