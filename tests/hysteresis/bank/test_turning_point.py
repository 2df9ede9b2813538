"""Turning points hold what plays of any width remember."""

from itertools import pairwise

import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st

from opensuction.hysteresis import play
from opensuction.hysteresis.bank import play_lines, turning_point
from opensuction.hysteresis.bank.play_lines import PlayLines
from opensuction.hysteresis.bank.turning_point import ROOM

WIDTHS_MM = np.array([0.0, 0.5, 3.0, 9.0, 20.0, 24.0])
TABLE = play_lines.tabulate(PlayLines(WIDTHS_MM, np.zeros(6), 10.0, np.ones((6, 2)), 1.0, 0.0, 0.0))


def turn_over(heads_mm: list[float]) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Positions by the turning points of a head that began after a long retract."""
    turns = turning_point.after_retract(heads_mm[0])
    for here, there in pairwise(heads_mm):
        turns = turning_point.step(turns, here, there)
    return play_lines.positions_mm(TABLE, turns, heads_mm[-1])


def play_over(heads_mm: list[float]) -> list[float]:
    """Positions by the plays themselves."""
    found = []
    for width_mm in WIDTHS_MM.tolist():
        position_mm = heads_mm[0] + 0.5 * width_mm
        for head_mm in heads_mm:
            position_mm = play.step(width_mm, position_mm, head_mm)
        found.append(float(position_mm))
    return found


@given(heads=st.lists(st.integers(-12, 12), min_size=1, max_size=14))
@example(heads=[0, 8, 2, 6, 3, 5, 4, 12, -3, 7])
@example(heads=[0, 5, 5, 0, 5, -1])
def test_plays_stand_where_their_own_steps_bring_them(heads: list[int]) -> None:
    heads_mm = [3.0 * head for head in heads]
    np.testing.assert_allclose(turn_over(heads_mm), play_over(heads_mm), rtol=0.0, atol=1e-12)


def test_the_smallest_loop_is_forgotten_where_there_is_no_room_for_more() -> None:
    shrinking = [float((-1) ** k * (40 - k)) for k in range(30)]
    assert len(set(shrinking)) > ROOM
    after = turn_over(shrinking)
    # From -40 in steps of 79, 78, ..: every play has its slot used up at each turn.
    np.testing.assert_allclose(after, play_over(shrinking), rtol=0.0, atol=1e-12)
    small = [float((-1) ** k * 0.1 * (40 - k)) for k in range(30)]
    off_mm = np.abs(turn_over(small) - play_over(small)).max()
    assert off_mm <= 0.1 * (80 - ROOM)  # the loop that made room was so wide


def test_a_head_that_came_in_over_a_long_way_has_drawn_every_play() -> None:
    positions = play_lines.positions_mm(TABLE, turning_point.AFTER_ADVANCE, 30.0)
    np.testing.assert_allclose(positions, 30.0 - 0.5 * WIDTHS_MM)
