import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from opensuction.hysteresis import play
from tests.hysteresis import distributed_play

widths = st.floats(0.0, 40.0)
heads = st.lists(st.floats(-100.0, 100.0), min_size=1, max_size=20)


def test_one_stroke_forth_and_back() -> None:
    head_mm = np.array([0.0, 15.0, 20.0, 60.0, 45.0, 40.0, 10.0])
    # After a retract the element leans on the far end: it waits for 20 mm, then trails by 10.
    expected = [10.0, 10.0, 10.0, 50.0, 50.0, 50.0, 20.0]
    assert play.simulate(20.0, head_mm, 10.0).tolist() == expected


def test_a_start_outside_the_slot_is_brought_inside() -> None:
    assert play.simulate(20.0, np.array([0.0]), 99.0).tolist() == [10.0]
    assert play.simulate(20.0, np.array([0.0]), -99.0).tolist() == [-10.0]


@given(width_mm=widths, head_mm=heads, start_mm=st.floats(-100.0, 100.0))
def test_the_element_stays_in_its_slot(
    width_mm: float, head_mm: list[float], start_mm: float
) -> None:
    record = np.array(head_mm)
    apart = np.abs(play.simulate(width_mm, record, start_mm) - record)
    assert apart.max() <= 0.5 * width_mm + 1e-12


@given(head_mm=heads, start_mm=st.floats(-100.0, 100.0))
def test_without_width_the_element_is_the_head(head_mm: list[float], start_mm: float) -> None:
    assert play.simulate(0.0, np.array(head_mm), start_mm).tolist() == head_mm


@given(width_mm=widths, turns=heads)
def test_a_closed_cycle_never_returns_more_travel_than_given(
    width_mm: float, turns: list[float]
) -> None:
    cycle = np.array([0.0, *turns, 0.0])
    element = play.simulate(width_mm, np.concatenate([cycle, cycle]), 0.5 * width_mm)
    given_mm = np.abs(np.diff(cycle)).sum()
    once, again = element[: cycle.size], element[cycle.size :]
    for passage in (once, again):
        assert np.abs(np.diff(passage)).sum() <= given_mm + 1e-9
    # And from the first closed cycle on, it repeats itself.
    assert again[-1] == once[-1]


def spread(elements: int) -> NDArray[np.float64]:
    return np.linspace(14.0, 26.0, elements)


def test_distributed_play_is_the_mean_of_its_elements() -> None:
    widths_mm = spread(7)
    head_mm = 40.0 * np.sin(np.linspace(0.0, 9.0, 300))
    start_mm = distributed_play.retracted_positions_mm(widths_mm, 0.0)
    alone = [
        play.simulate(width, head_mm, start)
        for width, start in zip(widths_mm, start_mm, strict=True)
    ]
    tip_mm = distributed_play.simulate(widths_mm, 0.95, -6.2, head_mm, start_mm)
    # The order of seven additions.
    assert tip_mm == pytest.approx(0.95 * np.mean(alone, axis=0) - 6.2, abs=1e-12)
    assert start_mm.tolist() == distributed_play.retracted_positions_mm(widths_mm, 0.0).tolist()


def test_the_step_of_a_distributed_play_keeps_its_state_in_place() -> None:
    widths_mm, positions_mm = np.array([10.0, 20.0]), np.array([0.0, 0.0])
    assert distributed_play.step(widths_mm, positions_mm, 12.0) == pytest.approx(0.5 * (7.0 + 2.0))
    assert positions_mm.tolist() == [7.0, 2.0]


def test_a_retract_moves_all_elements_at_once_and_an_advance_the_narrow_first() -> None:
    widths_mm = spread(5)
    start_mm = distributed_play.retracted_positions_mm(widths_mm, 50.0)
    head_mm = np.array([50.0, 40.0, 53.0, 57.5])
    tip_mm = distributed_play.simulate(widths_mm, 1.0, 0.0, head_mm, start_mm)
    assert tip_mm[1] - tip_mm[0] == pytest.approx(-10.0)
    # 13 mm forth is inside every slot; 17.5 mm leaves that of 14 mm by 3.5 and of 17 by 0.5.
    assert tip_mm[2] == pytest.approx(tip_mm[1])
    assert tip_mm[3] - tip_mm[2] == pytest.approx((3.5 + 0.5) / 5.0)


@given(
    width_mm=widths,
    memory=st.floats(-1.0, 1.0),
    head_mm=st.floats(-100.0, 100.0),
    target_mm=st.floats(-100.0, 100.0),
)
def test_the_inverse_is_the_smallest_move_that_reaches_the_target(
    width_mm: float, memory: float, head_mm: float, target_mm: float
) -> None:
    model = play.Play(width_mm=width_mm, gain=0.95, offset_mm=-6.2)
    position_mm = head_mm - 0.5 * memory * model.width_mm
    found = play.inverse_step(model, head_mm, position_mm, target_mm)
    assert found.reached
    moved = [
        play.output_mm(model, play.step(width_mm, position_mm, head_mm + share * found.move_mm))
        for share in (1.0, 0.99)
    ]
    # Rounding of numbers around 100.
    assert moved[0] == pytest.approx(target_mm, abs=1e-12)
    if abs(found.move_mm) > 1e-9:
        assert abs(moved[1] - target_mm) > 1e-13


def test_a_tip_on_its_target_asks_for_no_move() -> None:
    model = play.Play(width_mm=20.0, gain=1.0, offset_mm=0.0)
    assert play.inverse_step(model, 3.0, 7.0, 7.0) == (0.0, True)
    assert play.inverse_step(model, 3.0, 7.0, float("nan")) == (0.0, False)
