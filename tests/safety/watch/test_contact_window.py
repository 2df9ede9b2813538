import pytest

from opensuction.safety import tip_bound
from opensuction.safety.limits import WindowLimits
from opensuction.safety.watch import contact_window
from opensuction.safety.watch.contact_window import START, ContactWindow
from tests.safety.watchdog import above, below

BOUNDS = tip_bound.bound_tip(gain=0.9677, offset_mm=-7.151, gap_mm=22.18)
LIMITS = WindowLimits(from_mm=50.0, by_mm=80.0)
DT_S = 0.001


def moved(
    state: ContactWindow, head_mm: float, touching: bool, touched: bool, ticks: int = 1
) -> ContactWindow:
    """With the tip anywhere behind the gap."""
    tip = tip_bound.assume_anywhere(BOUNDS, head_mm)
    deepest = tip_bound.deepest_mm(BOUNDS, tip)
    shallowest = tip_bound.shallowest_mm(BOUNDS, tip)
    for _ in range(ticks):
        state = contact_window.step(LIMITS, state, deepest, shallowest, touching, touched, DT_S)
        touched = touching
    return state


def test_contact_is_impossible_where_even_the_deepest_tip_is_above_the_window() -> None:
    state = START
    assert moved(state, 20.0, True, False, ticks=610).impossible_s > contact_window.IMPOSSIBLE_S
    assert moved(state, 70.0, True, False, ticks=610).impossible_s == 0.0
    assert moved(state, 20.0, False, False, ticks=610).impossible_s == 0.0


def test_contact_must_end_once_the_tip_is_certainly_back_from_where_it_began() -> None:
    state = moved(START, 100.0, True, False)
    least = tip_bound.shallowest_mm(BOUNDS, tip_bound.assume_anywhere(BOUNDS, 100.0))
    assert state.touched_mm == least
    # The head that brings even the deepest possible tip back to there.
    home = (least - BOUNDS.offset_mm) / BOUNDS.gain - 0.5 * BOUNDS.wide_mm
    near = moved(state, home - contact_window.RELEASE_MM + 0.5, True, True, ticks=610)
    far = moved(state, home - contact_window.RELEASE_MM - 1.0, True, True, ticks=610)
    assert near.impossible_s == 0.0
    assert far.impossible_s > contact_window.IMPOSSIBLE_S


@pytest.mark.requirement("OS-R17")
def test_contact_is_missed_where_even_the_shallowest_tip_has_passed_the_carina() -> None:
    for shallowest, missed in ((80.0, False), (above(80.0), True)):
        assert contact_window.is_missed(LIMITS, START, shallowest, False) == missed
        assert not contact_window.is_missed(LIMITS, START, shallowest, True)


@pytest.mark.requirement("OS-R17")
def test_a_carina_that_was_met_is_not_missed_on_the_way_back_from_it() -> None:
    """One that has moved deeper, to where contact must have come; beyond it is missed again."""
    state = START
    for shallowest, touching, missed in (
        (82.0, False, True),
        (82.0, True, False),
        (83.0, True, False),
        (82.5, True, False),
        (83.0, False, False),
        (81.0, False, False),
        (above(83.0), False, True),
        (80.0, False, False),
        (81.0, False, True),
    ):
        state = contact_window.step(LIMITS, state, 90.0, shallowest, touching, False, DT_S)
        assert contact_window.is_missed(LIMITS, state, shallowest, touching) == missed


@pytest.mark.requirement("OS-R17")
def test_a_switch_is_proven_by_closing_where_it_may_and_opening_until_a_reset() -> None:
    closed = moved(START, 70.0, True, False)
    assert not closed.proven
    proven = moved(closed, 70.0, False, True)
    assert proven.proven
    assert not contact_window.reset(proven).proven
    bridged = moved(moved(START, 20.0, True, False), 20.0, False, True)
    assert not bridged.proven


SHALLOWEST_MM = 45.0


def contact(
    state: ContactWindow, deepest_mm: float, touching: bool, touched: bool
) -> ContactWindow:
    """A tick with the tip at `SHALLOWEST_MM` or deeper."""
    return contact_window.step(LIMITS, state, deepest_mm, SHALLOWEST_MM, touching, touched, DT_S)


def test_at_power_up_nothing_is_touched_and_the_switch_is_not_trusted() -> None:
    assert START.impossible_s == 0.0
    assert not START.proven
    # Above every tip that there can be.
    assert START.touched_mm < -1000.0


def test_the_window_begins_on_its_edge() -> None:
    assert contact(START, 50.0, True, False).impossible_s == 0.0
    assert contact(START, below(50.0), True, False).impossible_s == DT_S
    closed = START._replace(touched_mm=45.0)
    assert contact(closed, 50.0, False, True).proven
    assert not contact(closed, below(50.0), False, True).proven


def test_contact_may_last_three_millimetres_of_the_way_back() -> None:
    closed = START._replace(touched_mm=70.0)
    assert contact(closed, 67.0, True, True).impossible_s == 0.0
    assert contact(closed, below(67.0), True, True).impossible_s == DT_S
    # Where it began stays where it was; a new contact begins where the tip is at least.
    assert contact(closed, 67.0, True, True).touched_mm == 70.0
    assert contact(closed, 67.0, True, False).touched_mm == SHALLOWEST_MM
    assert contact(closed, 67.0, False, True).touched_mm < -1000.0


def test_a_contact_that_was_impossible_proves_nothing_when_it_ends() -> None:
    closed = START._replace(touched_mm=45.0, impossible_s=DT_S)
    assert not contact(closed, 60.0, False, True).proven
    assert contact(closed._replace(impossible_s=0.0), 60.0, False, True).proven
    assert contact(START._replace(proven=True), 60.0, False, False).proven
    assert not contact(START, 60.0, False, False).proven


def test_a_reset_forgets_what_was_seen_of_the_switch_but_not_where_contact_is() -> None:
    known = ContactWindow(touched_mm=58.0, impossible_s=0.04, proven=True, met_mm=81.0)
    assert contact_window.reset(known) == START._replace(touched_mm=58.0)


@pytest.mark.parametrize(("closed_ticks", "open_ticks", "told"), [(15, 10, True), (9, 10, False)])
def test_a_switch_that_chatters_where_nothing_is_adds_up(
    closed_ticks: int, open_ticks: int, told: bool
) -> None:
    state = START
    for _ in range(200):
        state = moved(state, 20.0, True, False, closed_ticks)
        state = moved(state, 20.0, False, True, open_ticks)
    assert (state.impossible_s > contact_window.IMPOSSIBLE_S) == told
    assert not state.proven
