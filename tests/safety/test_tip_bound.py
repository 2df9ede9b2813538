import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.hysteresis import play
from opensuction.safety import limits
from opensuction.safety.limits import GAP_LEAST, GAP_MOST, TipBounds, TipInterval

BOUNDS = limits.bound_tip(gain=0.9677, offset_mm=-7.151, gap_mm=22.18)

paths = st.lists(st.floats(-60.0, 130.0), min_size=1, max_size=25)
shares = st.floats(0.0, 1.0)


def width(share: float) -> float:
    """A gap between the narrowest and the widest thought possible."""
    return BOUNDS.narrow_mm + share * (BOUNDS.wide_mm - BOUNDS.narrow_mm)


def test_the_gap_is_given_in_tip_travel_and_held_in_head_travel() -> None:
    tip = limits.bound_tip(gain=0.9677, offset_mm=-7.151, gap_mm=22.18)
    assert tip == TipBounds(
        gain=0.9677,
        offset_mm=-7.151,
        narrow_mm=GAP_LEAST * 22.18 / 0.9677,
        wide_mm=GAP_MOST * 22.18 / 0.9677,
    )
    assert (GAP_LEAST, GAP_MOST) == (0.7, 1.3)


@pytest.mark.requirement("OS-R02")
@given(path=paths, share=shares, start=st.floats(-1.0, 1.0))
def test_no_gap_thought_possible_brings_the_catheter_out_of_its_interval(
    path: list[float], share: float, start: float
) -> None:
    element = path[0] + 0.5 * start * width(share)
    tip = limits.assume_anywhere(BOUNDS, path[0])
    for head in path:
        element = play.step(width(share), element, head)
        tip = limits.follow(BOUNDS, tip, head)
        assert tip.rearmost_mm - 1e-12 <= element <= tip.foremost_mm + 1e-12


@given(path=paths, sharing=st.lists(shares, min_size=1, max_size=25), end=st.integers(0, 1))
def test_not_even_one_that_changes_on_the_way(
    path: list[float], sharing: list[float], end: int
) -> None:
    tip = limits.assume_anywhere(BOUNDS, path[0])
    element = tip[end]
    for i, head in enumerate(path):
        element = play.step(width(sharing[i % len(sharing)]), element, head)
        tip = limits.follow(BOUNDS, tip, head)
        assert tip.rearmost_mm - 1e-12 <= element <= tip.foremost_mm + 1e-12


def test_the_extremes_alone_do_not_bound_what_lies_between() -> None:
    # Turned at 100, drawn back 20: the narrow gap (16 mm) has followed, the wide one (30 mm) was
    # never as far in, and a middle one still stands where it was.
    turned, head = 100.0, 80.0
    narrow, middle, wide = (
        play.step(gap, turned - 0.5 * gap, head)
        for gap in (BOUNDS.narrow_mm, width(0.45), BOUNDS.wide_mm)
    )
    assert middle > max(narrow, wide) + 0.5
    tip = TipInterval(foremost_mm=0.0, rearmost_mm=0.0)
    for position in (turned, head):
        tip = limits.follow(BOUNDS, tip, position)
    assert tip.foremost_mm >= middle


PLAIN = TipBounds(gain=1.0, offset_mm=0.0, narrow_mm=10.0, wide_mm=30.0)


@given(head=st.floats(-60.0, 130.0), further=st.floats(0.0, 100.0))
def test_drawn_back_far_the_tip_is_no_deeper_than_after_any_retract(
    head: float, further: float
) -> None:
    for before, after in (
        (head + 15.0 + further, head + 15.0),
        (head - 5.0 - further, head - 5.0),
        (head + 3.0, head + 3.0),
    ):
        interval = TipInterval(foremost_mm=before, rearmost_mm=before)
        assert limits.follow(PLAIN, interval, head).foremost_mm == after


@given(
    foremost=st.floats(-60.0, 130.0), rearmost=st.floats(-60.0, 130.0), head=st.floats(-60.0, 130.0)
)
def test_rearmost_and_foremost_are_mirror_images(
    foremost: float, rearmost: float, head: float
) -> None:
    def mirrored(tip: TipInterval) -> TipInterval:
        return TipInterval(foremost_mm=-tip.rearmost_mm, rearmost_mm=-tip.foremost_mm)

    assert limits.assume_anywhere(BOUNDS, head) == mirrored(limits.assume_anywhere(BOUNDS, -head))
    before = TipInterval(foremost, rearmost)
    assert limits.follow(BOUNDS, before, head) == mirrored(
        limits.follow(BOUNDS, mirrored(before), -head)
    )


@given(path=paths, lower=st.floats(0.0, 5.0))
def test_a_head_further_out_is_never_a_deeper_tip(path: list[float], lower: float) -> None:
    here = limits.assume_anywhere(BOUNDS, path[0])
    there = TipInterval(here.foremost_mm - lower, here.rearmost_mm - lower)
    for head in path:
        here = limits.follow(BOUNDS, here, head)
        there = limits.follow(BOUNDS, there, head - lower)
        assert there.foremost_mm <= here.foremost_mm + 1e-12
        assert there.rearmost_mm <= here.rearmost_mm + 1e-12


@given(path=paths)
def test_advancing_never_lowers_and_drawing_back_never_raises_the_bound(path: list[float]) -> None:
    tip = limits.follow(BOUNDS, limits.assume_anywhere(BOUNDS, path[0]), path[0])
    before = path[0]
    for head in path:
        after = limits.follow(BOUNDS, tip, head)
        for now_mm, then_mm in zip(after, tip, strict=True):
            assert now_mm >= then_mm if head >= before else now_mm <= then_mm
        tip, before = after, head


@pytest.mark.requirement("OS-R02")
@given(cap=st.floats(20.0, 130.0), start=st.floats(-60.0, -40.0))
def test_a_head_below_its_cap_keeps_the_tip_below_its_own(cap: float, start: float) -> None:
    tip = limits.assume_anywhere(BOUNDS, start)
    highest = limits.head_cap_mm(BOUNDS, cap)
    for head in np.linspace(start, highest, 40):
        tip = limits.follow(BOUNDS, tip, float(head))
    assert limits.deepest_mm(BOUNDS, tip) <= cap + 1e-9
    beyond = limits.follow(BOUNDS, tip, highest + 1.0)
    assert limits.deepest_mm(BOUNDS, beyond) == pytest.approx(cap + BOUNDS.gain)


def test_unknown_is_as_deep_as_after_a_retract_and_as_shallow_as_after_an_advance() -> None:
    tip = limits.assume_anywhere(BOUNDS, 50.0)
    deepest, shallowest = (end(BOUNDS, tip) for end in (limits.deepest_mm, limits.shallowest_mm))
    assert deepest == pytest.approx(0.9677 * (50.0 + 0.5 * BOUNDS.wide_mm) - 7.151)
    assert shallowest == pytest.approx(0.9677 * (50.0 - 0.5 * BOUNDS.wide_mm) - 7.151)
