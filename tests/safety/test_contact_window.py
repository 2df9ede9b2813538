import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.hysteresis import play
from opensuction.safety import contact_window
from opensuction.safety import limits as bounds
from opensuction.safety.contact_window import ContactWindow
from opensuction.safety.limits import WindowLimits

BOUNDS = bounds.tip_bounds(gain=0.9677, offset_mm=-7.151, gap_mm=22.18)
LIMITS = WindowLimits(from_mm=50.0, by_mm=80.0)
DT_S = 0.001

paths = st.lists(st.floats(-60.0, 130.0), min_size=1, max_size=25)
shares = st.floats(0.0, 1.0)


@given(path=paths, share=shares, start=st.floats(-1.0, 1.0))
def test_no_gap_thought_possible_leaves_the_catheter_further_back(
    path: list[float], share: float, start: float
) -> None:
    width = BOUNDS.narrow_mm + share * (BOUNDS.wide_mm - BOUNDS.narrow_mm)
    element = path[0] + 0.5 * start * width
    rearmost = contact_window.anywhere(BOUNDS, path[0])
    foremost = bounds.anywhere(BOUNDS, path[0])
    for head in path:
        element = play.step(width, element, head)
        rearmost = contact_window.follow(BOUNDS, rearmost, head)
        foremost = bounds.follow(BOUNDS, foremost, head)
        assert rearmost - 1e-12 <= element <= foremost + 1e-12


def moved(
    state: ContactWindow, head_mm: float, touching: bool, touched: bool, ticks: int = 1
) -> ContactWindow:
    """With the deepest possible tip as after a retract."""
    deepest = bounds.deepest_mm(BOUNDS, bounds.anywhere(BOUNDS, head_mm))
    for _ in range(ticks):
        state = contact_window.step(
            BOUNDS, LIMITS, state, head_mm, deepest, touching, touched, DT_S
        )
        touched = touching
    return state


def test_contact_is_impossible_where_even_the_deepest_tip_is_above_the_window() -> None:
    state = contact_window.start(BOUNDS, 20.0)
    assert moved(state, 20.0, True, False, ticks=60).impossible_s > contact_window.IMPOSSIBLE_S
    assert moved(state, 70.0, True, False, ticks=60).impossible_s == 0.0
    assert moved(state, 20.0, False, False, ticks=60).impossible_s == 0.0


def test_contact_must_end_once_the_tip_is_certainly_back_from_where_it_began() -> None:
    state = moved(contact_window.start(BOUNDS, 100.0), 100.0, True, False)
    least = contact_window.least_mm(BOUNDS, state)
    # The head that brings even the deepest possible tip back to there.
    home = (least - BOUNDS.offset_mm) / BOUNDS.gain - 0.5 * BOUNDS.wide_mm
    near = moved(state, home - contact_window.RELEASE_MM + 0.5, True, True, ticks=60)
    far = moved(state, home - contact_window.RELEASE_MM - 1.0, True, True, ticks=60)
    assert near.impossible_s == 0.0
    assert far.impossible_s > contact_window.IMPOSSIBLE_S


@pytest.mark.requirement("OS-R17")
def test_contact_is_missed_where_even_the_least_deep_tip_has_passed() -> None:
    start = contact_window.start(BOUNDS, 0.0)
    head = (LIMITS.by_mm - BOUNDS.offset_mm) / BOUNDS.gain + 0.5 * BOUNDS.wide_mm
    before, after = moved(start, head - 0.1, False, False), moved(start, head + 0.1, False, False)
    assert not contact_window.is_missed(BOUNDS, LIMITS, before, False)
    assert contact_window.is_missed(BOUNDS, LIMITS, after, False)
    assert not contact_window.is_missed(BOUNDS, LIMITS, after, True)


@pytest.mark.requirement("OS-R17")
def test_a_switch_is_proven_by_closing_where_it_may_and_opening_until_a_reset() -> None:
    start = contact_window.start(BOUNDS, 70.0)
    closed = moved(start, 70.0, True, False)
    assert not closed.proven
    proven = moved(closed, 70.0, False, True)
    assert proven.proven
    assert not contact_window.unseen(BOUNDS, proven, 70.0).proven
    bridged = moved(moved(start, 20.0, True, False), 20.0, False, True)
    assert not bridged.proven
