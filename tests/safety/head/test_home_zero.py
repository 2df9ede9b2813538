import pytest

from opensuction.safety.governor import governor
from opensuction.safety.governor.governor import GovernorState
from opensuction.safety.head import head_vote
from tests.safety.watchdog import DT_S, LIMITS, PARK_MM, sound, staying


def stood(state: GovernorState, head_mm: float, off_mm: float, ticks: int) -> GovernorState:
    """The governor after the head has stood there, its second sensor reading that much more."""
    for _ in range(ticks):
        read = sound(head_mm)._replace(carriage_mm=head_mm + off_mm)
        vote = governor.locate(LIMITS, state, read, 0.0, DT_S)
        state, _, _ = governor.step(LIMITS, state, staying(head_mm), read, vote, False, DT_S)
    return state


def started(head_mm: float = PARK_MM) -> GovernorState:
    return governor.start(LIMITS, head_mm)


@pytest.mark.parametrize("off_mm", [-0.55, -0.3, 0.0, 0.2, 0.55])
def test_at_home_the_second_sensor_s_zero_is_learnt(off_mm: float) -> None:
    state = stood(started(), PARK_MM, off_mm, 200)
    assert state.watch.vote.zero_mm == pytest.approx(off_mm, abs=0.01)
    assert state.watch.vote.carriage_mm == pytest.approx(PARK_MM, abs=0.01)
    assert state.trips == 0


@pytest.mark.parametrize("off_mm", [-0.65, 0.65, 40.0])
def test_more_than_that_is_not_a_zero(off_mm: float) -> None:
    assert stood(started(), PARK_MM, off_mm, 200).watch.vote.zero_mm == 0.0


def test_away_from_home_nothing_is_learnt() -> None:
    away_mm = PARK_MM + head_vote.HOME_MM + 0.1
    assert stood(started(away_mm), away_mm, 0.3, 200).watch.vote.zero_mm == 0.0


def test_a_head_that_moves_teaches_nothing() -> None:
    state = started()
    for tick in range(100):
        head_mm = PARK_MM + 0.005 * (tick % 2)
        state = stood(state, head_mm, 0.3, 1)
    assert state.watch.vote.zero_mm == 0.0


def test_a_zero_that_is_learnt_is_no_motion_of_the_head() -> None:
    """Neither sensor seems to run away from the motor by it."""
    state = started()
    for _ in range(300):
        state = stood(state, PARK_MM, 0.5, 1)
        assert abs(state.watch.vote.carriage_lead_mm) <= 0.51  # the first reading's own
    assert abs(state.watch.vote.encoder_lead_mm) < 1e-9
    assert state.watch.vote.head_mm == PARK_MM
