"""Head and conduit are moved: how often, how far, seldom with the catheter inside."""

import numpy as np
import pytest

from opensuction.kernel import random_stream
from opensuction.twin import preset
from opensuction.twin.behaviour import spontaneous_event
from opensuction.twin.behaviour.spontaneous_event import Posture, PostureState
from opensuction.twin.machine.machine import MachineState
from tests.settled import settled
from tests.twin.behaviour import bed
from tests.twin.holding import IDLE, hold_machine

RESTLESS = Posture(per_s=0.05, inside_share=0.1, carina_mm=3.0, gap_ratio=0.04)


step_posture = settled(spontaneous_event.step_posture)


def goals(inside: bool, seconds: float) -> tuple[list[PostureState], PostureState]:
    """The states right after each move, and the last."""
    state, moved = spontaneous_event.settled(random_stream.stream(1, 9)), []
    for _ in range(round(10.0 * seconds)):
        before = state.carina_goal_mm
        state = step_posture(RESTLESS, state, inside, 0.1)
        if state.carina_goal_mm != before:
            moved.append(state)
    return moved, state


def test_moves_come_at_their_rate_and_a_tenth_as_often_inside() -> None:
    outside, _ = goals(False, 20_000.0)
    inside, _ = goals(True, 20_000.0)
    assert len(outside) == pytest.approx(1000, abs=130)
    assert len(inside) == pytest.approx(100, abs=40)


def test_the_carina_goes_some_mm_either_way_and_does_not_wander_off() -> None:
    moved, _ = goals(False, 20_000.0)
    depths = np.array([one.carina_goal_mm for one in moved])
    gaps = np.array([one.gap_goal_ratio for one in moved])
    assert np.std(depths) == pytest.approx(3.0, rel=0.1)
    assert np.abs(depths).max() <= 10.0
    assert abs(depths.mean()) < 0.4
    assert np.std(gaps) == pytest.approx(0.04, rel=0.1)
    # The last move is where the first ones went, too: no sum of all.
    assert np.std(depths[-200:]) == pytest.approx(3.0, rel=0.25)


def test_a_move_takes_a_second_or_two() -> None:
    state = spontaneous_event.settled(random_stream.stream(1, 9))._replace(carina_goal_mm=6.0)
    for _ in range(200):
        before = state.carina_mm
        state = spontaneous_event.step_posture(RESTLESS._replace(per_s=0.0), state, False, 0.01)
        assert state.carina_mm - before < 0.13
    assert state.carina_mm == pytest.approx(6.0, abs=0.15)


MACHINE = preset.machine(bed.VALUES, bed.lively())
START = preset.park(MACHINE, bed.VALUES, 40.0, seed=1, run=0).machine
FORTH = IDLE._replace(insertion_v=12.0)


def pushed(shift_mm: float, gap_ratio: float, ticks: int, until_n: float) -> MachineState:
    """The head pushed for so long, or until the tip presses. Only the machine steps."""
    there = START.coupling._replace(carina_shift_mm=shift_mm, gap_ratio=gap_ratio)
    state = START._replace(coupling=there)
    for _ in range(ticks):
        if state.airway.contact_n > until_n:
            break
        state = hold_machine(MACHINE, state, FORTH, 1)
    return state


@pytest.mark.parametrize("shift_mm", [-5.0, 0.0, 5.0])
def test_a_moved_head_moves_what_the_tip_meets(shift_mm: float) -> None:
    there = pushed(shift_mm, 1.0, 4000, 0.005)
    assert there.airway.contact_n > 0.005
    assert there.airway.tip_mm == pytest.approx(MACHINE.airway.carina_mm + shift_mm, abs=0.1)


def test_a_bent_conduit_has_another_gap() -> None:
    """After the same way of the head the tip lags by half of what the gap is wider."""
    wide, usual, narrow = (pushed(0.0, ratio, 1000, 0.3).airway for ratio in (1.1, 1.0, 0.9))
    gap_mm = sum(MACHINE.transmission.widths_mm) / len(MACHINE.transmission.widths_mm)
    lag_mm = 0.5 * 0.1 * gap_mm * MACHINE.transmission.gain
    assert usual.tip_mm - wide.tip_mm == pytest.approx(lag_mm, rel=0.1)
    assert narrow.tip_mm - usual.tip_mm == pytest.approx(lag_mm, rel=0.1)
