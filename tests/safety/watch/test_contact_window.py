import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.hysteresis import play
from opensuction.safety import limits as bounds
from opensuction.safety.limits import TipBounds, WindowLimits
from opensuction.safety.watch import contact_window
from opensuction.safety.watch.contact_window import ContactWindow
from tests.safety.watchdog import above, below

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


PLAIN = TipBounds(gain=1.0, offset_mm=0.0, narrow_mm=10.0, wide_mm=30.0)
"""A tip that is where its head is."""


def contact(
    state: ContactWindow, deepest_mm: float, touching: bool, touched: bool
) -> ContactWindow:
    """A tick with the head at 60 mm, its catheter wherever it was."""
    return contact_window.step(PLAIN, LIMITS, state, 60.0, deepest_mm, touching, touched, DT_S)


FRESH = contact_window.start(PLAIN, 60.0)


@given(rearmost=st.floats(-60.0, 130.0), head=st.floats(-60.0, 130.0))
def test_rearmost_and_foremost_are_mirror_images(rearmost: float, head: float) -> None:
    assert contact_window.anywhere(BOUNDS, head) == -bounds.anywhere(BOUNDS, -head)
    mirrored = -bounds.follow(BOUNDS, -rearmost, -head)
    assert contact_window.follow(BOUNDS, rearmost, head) == mirrored


def test_at_power_up_the_tip_may_be_anywhere_and_the_switch_is_not_trusted() -> None:
    assert FRESH.rearmost_mm == 60.0 - 15.0
    assert FRESH.impossible_s == 0.0
    assert not FRESH.proven
    # Above every tip that there can be.
    assert FRESH.touched_mm < -1000.0


def test_the_window_begins_on_its_edge() -> None:
    assert contact(FRESH, 50.0, True, False).impossible_s == 0.0
    assert contact(FRESH, below(50.0), True, False).impossible_s == DT_S
    closed = FRESH._replace(touched_mm=45.0)
    assert contact(closed, 50.0, False, True).proven
    assert not contact(closed, below(50.0), False, True).proven


def test_contact_may_last_three_millimetres_of_the_way_back() -> None:
    closed = FRESH._replace(touched_mm=70.0)
    assert contact(closed, 67.0, True, True).impossible_s == 0.0
    assert contact(closed, below(67.0), True, True).impossible_s == DT_S
    # Where it began stays where it was; a new contact begins where the tip is at least.
    assert contact(closed, 67.0, True, True).touched_mm == 70.0
    assert contact(closed, 67.0, True, False).touched_mm == FRESH.rearmost_mm
    assert contact(closed, 67.0, False, True).touched_mm < -1000.0


def test_a_contact_that_was_impossible_proves_nothing_when_it_ends() -> None:
    closed = FRESH._replace(touched_mm=45.0, impossible_s=DT_S)
    assert not contact(closed, 60.0, False, True).proven
    assert contact(closed._replace(impossible_s=0.0), 60.0, False, True).proven
    assert contact(FRESH._replace(proven=True), 60.0, False, False).proven
    assert not contact(FRESH, 60.0, False, False).proven


def test_the_carina_is_missed_beyond_its_place_and_not_on_it() -> None:
    for rearmost, missed in ((80.0, False), (above(80.0), True)):
        state = FRESH._replace(rearmost_mm=rearmost)
        assert contact_window.is_missed(PLAIN, LIMITS, state, False) == missed
        assert not contact_window.is_missed(PLAIN, LIMITS, state, True)


def test_a_reset_forgets_what_was_seen_of_tip_and_switch_but_not_where_contact_is() -> None:
    known = ContactWindow(rearmost_mm=59.0, touched_mm=58.0, impossible_s=0.04, proven=True)
    after = contact_window.unseen(PLAIN, known, 60.0)
    assert after == ContactWindow(rearmost_mm=45.0, touched_mm=58.0, impossible_s=0.0, proven=False)
