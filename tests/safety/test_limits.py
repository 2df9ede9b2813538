import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.hysteresis import play
from opensuction.safety import limits as bounds
from opensuction.safety.limits import GAP_LEAST, GAP_MOST, TipBounds

BOUNDS = bounds.tip_bounds(gain=0.9677, offset_mm=-7.151, gap_mm=22.18)

paths = st.lists(st.floats(-60.0, 130.0), min_size=1, max_size=25)
shares = st.floats(0.0, 1.0)


def width(share: float) -> float:
    """A gap between the narrowest and the widest thought possible."""
    return BOUNDS.narrow_mm + share * (BOUNDS.wide_mm - BOUNDS.narrow_mm)


def test_the_gap_is_given_in_tip_travel_and_held_in_head_travel() -> None:
    tip = bounds.tip_bounds(gain=0.9677, offset_mm=-7.151, gap_mm=22.18)
    assert tip == TipBounds(
        gain=0.9677,
        offset_mm=-7.151,
        narrow_mm=GAP_LEAST * 22.18 / 0.9677,
        wide_mm=GAP_MOST * 22.18 / 0.9677,
    )
    assert (GAP_LEAST, GAP_MOST) == (0.7, 1.3)


@pytest.mark.requirement("OS-R02")
@given(path=paths, share=shares, start=st.floats(-1.0, 1.0))
def test_no_gap_thought_possible_brings_the_catheter_further(
    path: list[float], share: float, start: float
) -> None:
    element = path[0] + 0.5 * start * width(share)
    foremost = bounds.anywhere(BOUNDS, path[0])
    for head in path:
        element = play.step(width(share), element, head)
        foremost = bounds.follow(BOUNDS, foremost, head)
        assert element <= foremost + 1e-12


@given(path=paths, sharing=st.lists(shares, min_size=1, max_size=25))
def test_not_even_one_that_changes_on_the_way(path: list[float], sharing: list[float]) -> None:
    element = bounds.anywhere(BOUNDS, path[0])
    foremost = element
    for i, head in enumerate(path):
        element = play.step(width(sharing[i % len(sharing)]), element, head)
        foremost = bounds.follow(BOUNDS, foremost, head)
        assert element <= foremost + 1e-12


def test_the_extremes_alone_do_not_bound_what_lies_between() -> None:
    # Turned at 100, drawn back 20: the narrow gap (16 mm) has followed, the wide one (30 mm) was
    # never as far in, and a middle one still stands where it was.
    turned, head = 100.0, 80.0
    narrow, middle, wide = (
        play.step(gap, turned - 0.5 * gap, head)
        for gap in (BOUNDS.narrow_mm, width(0.45), BOUNDS.wide_mm)
    )
    assert middle > max(narrow, wide) + 0.5
    foremost = bounds.follow(BOUNDS, bounds.follow(BOUNDS, 0.0, turned), head)
    assert foremost >= middle


@given(head=st.floats(-60.0, 130.0), further=st.floats(0.0, 100.0))
def test_drawn_back_far_the_tip_is_no_deeper_than_after_any_retract(
    head: float, further: float
) -> None:
    tip = TipBounds(gain=1.0, offset_mm=0.0, narrow_mm=10.0, wide_mm=30.0)
    assert bounds.follow(tip, head + 15.0 + further, head) == head + 15.0
    assert bounds.follow(tip, head - 5.0 - further, head) == head - 5.0
    assert bounds.follow(tip, head + 3.0, head) == head + 3.0


@given(path=paths, lower=st.floats(0.0, 5.0))
def test_a_head_further_out_is_never_a_deeper_tip(path: list[float], lower: float) -> None:
    here = there = bounds.anywhere(BOUNDS, path[0])
    there -= lower
    for head in path:
        here = bounds.follow(BOUNDS, here, head)
        there = bounds.follow(BOUNDS, there, head - lower)
        assert there <= here + 1e-12


@given(path=paths)
def test_advancing_never_lowers_and_drawing_back_never_raises_the_bound(path: list[float]) -> None:
    foremost = bounds.follow(BOUNDS, bounds.anywhere(BOUNDS, path[0]), path[0])
    before = path[0]
    for head in path:
        after = bounds.follow(BOUNDS, foremost, head)
        assert after >= foremost if head >= before else after <= foremost
        foremost, before = after, head


@pytest.mark.requirement("OS-R02")
@given(cap=st.floats(20.0, 130.0), start=st.floats(-60.0, -40.0))
def test_a_head_below_its_cap_keeps_the_tip_below_its_own(cap: float, start: float) -> None:
    foremost = bounds.anywhere(BOUNDS, start)
    highest = bounds.head_cap_mm(BOUNDS, cap)
    for head in np.linspace(start, highest, 40):
        foremost = bounds.follow(BOUNDS, foremost, float(head))
    assert bounds.deepest_mm(BOUNDS, foremost) <= cap + 1e-9
    beyond = bounds.follow(BOUNDS, foremost, highest + 1.0)
    assert bounds.deepest_mm(BOUNDS, beyond) == pytest.approx(cap + BOUNDS.gain)


def test_unknown_is_as_deep_as_after_a_retract() -> None:
    tip = bounds.deepest_mm(BOUNDS, bounds.anywhere(BOUNDS, 50.0))
    assert tip == pytest.approx(0.9677 * (50.0 + 0.5 * BOUNDS.wide_mm) - 7.151)
