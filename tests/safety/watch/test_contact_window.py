import pytest

from opensuction.safety import limits
from opensuction.safety.limits import WindowLimits
from opensuction.safety.watch import tip_force
from opensuction.safety.watch.tip_force import WINDOW_START, ContactWindow
from tests.safety.watchdog import above, below

BOUNDS = limits.bound_tip(gain=0.9677, offset_mm=-7.151, gap_mm=22.18)
LIMITS = WindowLimits(from_mm=50.0, by_mm=80.0)
DT_S = 0.001


def moved(
    state: ContactWindow, head_mm: float, touching: bool, touched: bool, ticks: int = 1
) -> ContactWindow:
    """With the tip anywhere behind the gap."""
    tip = limits.assume_anywhere(BOUNDS, head_mm)
    deepest = limits.deepest_mm(BOUNDS, tip)
    shallowest = limits.shallowest_mm(BOUNDS, tip)
    for _ in range(ticks):
        state = tip_force.step_window(LIMITS, state, deepest, shallowest, touching, touched, DT_S)
        touched = touching
    return state


def test_contact_is_impossible_where_even_the_deepest_tip_is_above_the_window() -> None:
    state = WINDOW_START
    assert moved(state, 20.0, True, False, ticks=610).impossible_s > tip_force.IMPOSSIBLE_S
    assert moved(state, 70.0, True, False, ticks=610).impossible_s == 0.0
    assert moved(state, 20.0, False, False, ticks=610).impossible_s == 0.0


def test_contact_must_end_once_the_tip_is_certainly_back_from_where_it_began() -> None:
    state = moved(WINDOW_START, 100.0, True, False)
    least = limits.shallowest_mm(BOUNDS, limits.assume_anywhere(BOUNDS, 100.0))
    assert state.touched_mm == least
    # The head that brings even the deepest possible tip back to there.
    home = (least - BOUNDS.offset_mm) / BOUNDS.gain - 0.5 * BOUNDS.wide_mm
    near = moved(state, home - tip_force.RELEASE_MM + 0.5, True, True, ticks=610)
    far = moved(state, home - tip_force.RELEASE_MM - 1.0, True, True, ticks=610)
    assert near.impossible_s == 0.0
    assert far.impossible_s > tip_force.IMPOSSIBLE_S


@pytest.mark.requirement("OS-R17")
def test_contact_is_missed_where_even_the_shallowest_tip_has_passed_the_carina() -> None:
    for shallowest, missed in ((80.0, False), (above(80.0), True)):
        assert tip_force.is_missed(LIMITS, WINDOW_START, shallowest, False) == missed
        assert not tip_force.is_missed(LIMITS, WINDOW_START, shallowest, True)


@pytest.mark.requirement("OS-R17")
def test_a_carina_that_was_met_is_not_missed_on_the_way_back_from_it() -> None:
    """One that has moved deeper, to where contact must have come; beyond it is missed again."""
    state = WINDOW_START
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
        state = tip_force.step_window(LIMITS, state, 90.0, shallowest, touching, False, DT_S)
        assert tip_force.is_missed(LIMITS, state, shallowest, touching) == missed


@pytest.mark.requirement("OS-R17")
def test_a_switch_is_proven_by_closing_where_it_may_and_opening_until_a_reset() -> None:
    closed = moved(WINDOW_START, 70.0, True, False)
    assert not closed.proven
    proven = moved(closed, 70.0, False, True)
    assert proven.proven
    assert not tip_force.reset(proven).proven
    bridged = moved(moved(WINDOW_START, 20.0, True, False), 20.0, False, True)
    assert not bridged.proven


SHALLOWEST_MM = 45.0


def contact(
    state: ContactWindow, deepest_mm: float, touching: bool, touched: bool
) -> ContactWindow:
    """A tick with the tip at `SHALLOWEST_MM` or deeper."""
    return tip_force.step_window(LIMITS, state, deepest_mm, SHALLOWEST_MM, touching, touched, DT_S)


def test_at_power_up_nothing_is_touched_and_the_switch_is_not_trusted() -> None:
    assert WINDOW_START.impossible_s == 0.0
    assert not WINDOW_START.proven
    # Above every tip that there can be.
    assert WINDOW_START.touched_mm < -1000.0


def test_the_window_begins_on_its_edge() -> None:
    assert contact(WINDOW_START, 50.0, True, False).impossible_s == 0.0
    assert contact(WINDOW_START, below(50.0), True, False).impossible_s == DT_S
    closed = WINDOW_START._replace(touched_mm=45.0)
    assert contact(closed, 50.0, False, True).proven
    assert not contact(closed, below(50.0), False, True).proven


def test_contact_may_last_three_millimetres_of_the_way_back() -> None:
    closed = WINDOW_START._replace(touched_mm=70.0)
    assert contact(closed, 67.0, True, True).impossible_s == 0.0
    assert contact(closed, below(67.0), True, True).impossible_s == DT_S
    # Where it began stays where it was; a new contact begins where the tip is at least.
    assert contact(closed, 67.0, True, True).touched_mm == 70.0
    assert contact(closed, 67.0, True, False).touched_mm == SHALLOWEST_MM
    assert contact(closed, 67.0, False, True).touched_mm < -1000.0


def test_a_contact_that_was_impossible_proves_nothing_when_it_ends() -> None:
    closed = WINDOW_START._replace(touched_mm=45.0, impossible_s=DT_S)
    assert not contact(closed, 60.0, False, True).proven
    assert contact(closed._replace(impossible_s=0.0), 60.0, False, True).proven
    assert contact(WINDOW_START._replace(proven=True), 60.0, False, False).proven
    assert not contact(WINDOW_START, 60.0, False, False).proven


def test_a_reset_forgets_what_was_seen_of_the_switch_but_not_where_contact_is() -> None:
    known = ContactWindow(touched_mm=58.0, impossible_s=0.04, proven=True, met_mm=81.0)
    assert tip_force.reset(known) == WINDOW_START._replace(touched_mm=58.0)


@pytest.mark.parametrize(("closed_ticks", "open_ticks", "told"), [(15, 10, True), (9, 10, False)])
def test_a_switch_that_chatters_where_nothing_is_adds_up(
    closed_ticks: int, open_ticks: int, told: bool
) -> None:
    state = WINDOW_START
    for _ in range(200):
        state = moved(state, 20.0, True, False, closed_ticks)
        state = moved(state, 20.0, False, True, open_ticks)
    assert (state.impossible_s > tip_force.IMPOSSIBLE_S) == told
    assert not state.proven
