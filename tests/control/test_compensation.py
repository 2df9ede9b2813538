import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from numpy.typing import NDArray

from opensuction.control import compensation
from opensuction.control.backlash_inverse import AT_REST, Curves, HeadState
from opensuction.control.compensation import (
    KIND_OF_NAME,
    ON_PLAYS,
    Branches,
    Compensation,
    CompensationKind,
)
from opensuction.control.motion_profile import HeadLimits
from opensuction.control.preview import RunIn
from opensuction.hysteresis import modified_dahl, play_sum
from opensuction.hysteresis.bank import turning_point
from opensuction.hysteresis.bank.play_lines import PlayLines
from opensuction.hysteresis.modified_dahl import PUBLISHED
from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii
from opensuction.kernel.compiled import compiled

DT_S = 0.001
FULL = 1000.0
"""No slower than the head can."""
PLAYS = PrandtlIshlinskii(np.array([8.0, 10.0]), np.array([0.45, 0.5]), 0.0, -6.0, 2e-5)
LINES = PlayLines(
    widths_mm=np.array([0.0, 16.0, 20.0]),
    lows_mm=np.zeros(3),
    cell_mm=50.0,
    gains=np.array([[0.1, 0.1], [0.4, 0.3], [0.45, 0.55]]),
    decay_mm=10.0,
    lag=0.03,
    offset_mm=-6.0,
)
CURVES = Curves(0.0, 50.0, np.array([16.0, 69.0, 121.0]), np.array([-4.0, 48.0, 100.0]))


def chosen(kind: CompensationKind) -> Compensation:
    limits = HeadLimits(17.0, 200.0)
    return compensation.choose(kind, limits, PUBLISHED, PLAYS, CURVES, RunIn(0.06, 0.06))


def heads_mm(kind: CompensationKind) -> Branches | None:
    return compensation.branches(kind, CURVES, LINES)


every_kind = pytest.mark.parametrize("kind", CompensationKind)


def parked(kind: CompensationKind, reference_mm: float) -> HeadState:
    at = compensation.rest(chosen(kind), heads_mm(kind), reference_mm)
    return compensation.park(chosen(kind), at)


def test_every_kind_has_one_name() -> None:
    assert sorted(KIND_OF_NAME.values()) == sorted(CompensationKind)


@every_kind
@pytest.mark.parametrize("starts_in_s", [0.0, -1.0])
def test_a_parked_head_stays(kind: CompensationKind, starts_in_s: float) -> None:
    start = parked(kind, 0.0)
    after = compensation.step(
        chosen(kind), heads_mm(kind), start, 0.0, 0.0, -1.0, starts_in_s, DT_S
    )
    assert after.head_mm == pytest.approx(start.head_mm, abs=1e-9)
    resting = compensation.home(chosen(kind), heads_mm(kind), start, start.head_mm, FULL, DT_S)
    assert resting == start


@every_kind
def test_the_compensators_park_the_modelled_tip_on_the_reference(kind: CompensationKind) -> None:
    at = compensation.rest(chosen(kind), heads_mm(kind), 0.0)
    _, tip = compensation.at_contact(chosen(kind), heads_mm(kind), at, at.head_mm)
    assert tip == pytest.approx(0.0, abs=1e-12)
    if kind == CompensationKind.NONE:
        assert at.head_mm == 0.0


@every_kind
def test_a_long_way_in_ends_with_the_modelled_tip_at_its_depth(kind: CompensationKind) -> None:
    head = compensation.head_after_travel_mm(chosen(kind), heads_mm(kind), 80.0, 1.0)
    at = compensation.rest(chosen(kind), heads_mm(kind), -60.0)
    _, tip = compensation.at_contact(chosen(kind), heads_mm(kind), at, head)
    # The Dahl model forgets a reversal by e to the -0.077 per mm: 0.01 % is left after 120 mm.
    assert tip == pytest.approx(80.0, abs=1e-2)


@compiled
def go_home(
    chosen: Compensation,
    table: Branches | None,
    state: HeadState,
    heads: NDArray[np.float64],
    speeds: NDArray[np.float64],
) -> HeadState:
    """As many ticks as the rows have entries after the first one."""
    for i in range(1, heads.size):
        state = compensation.home(chosen, table, state, -3.0, FULL, DT_S)
        heads[i], speeds[i] = state.head_mm, state.head_mm_per_s
    return state


@every_kind
@given(head=st.floats(-60.0, 120.0), velocity=st.floats(-17.0, 17.0))
@example(head=-2.75, velocity=-11.0)
def test_home_is_reached_from_anywhere_within_the_limits(
    kind: CompensationKind, head: float, velocity: float
) -> None:
    plays = play_sum.retracted_positions_mm(play_sum.bundle(PLAYS), head)
    heads, speeds = np.empty(9001), np.empty(9001)  # 123 mm at 17 mm/s is 7.3 s
    heads[0], speeds[0] = head, velocity
    if kind == CompensationKind.MODEL_PREVIEW:
        plays = turning_point.after_retract(head)
    start = HeadState(head, velocity, 0.0, plays)
    after = go_home(chosen(kind), heads_mm(kind), start, heads, speeds)
    assert np.abs(speeds[1:]).max() <= 17.0
    changes, inwards = np.abs(np.diff(speeds[1:])), np.diff(heads)
    # One that begins too fast to brake passes its home, stops there at once and comes back.
    braking_mm = velocity**2 / (2.0 * 200.0) + abs(velocity) * DT_S
    if velocity * (-3.0 - head) > 0.0 and braking_mm > abs(-3.0 - head):
        past = (heads[1:-1] + 3.0) * speeds[1:-1] > 0.0
        changes, inwards = changes[~past], inwards[heads[1:] > -3.0 + 1e-4]
    assert changes.max() <= 0.2 * (1.0 + 1e-9)
    if head >= -3.0:  # never further in, not even to brake; the last tick rounds by 25 nm
        assert inwards.max(initial=0.0) <= 1e-4
    assert after.head_mm == pytest.approx(-3.0, abs=1e-6)
    assert speeds[-1] == 0.0


def test_homing_keeps_track_of_the_lag() -> None:
    kind = CompensationKind.EXACT_INVERSE
    start = -float(modified_dahl.saturation_mm(PUBLISHED))
    state = AT_REST._replace(head_mm=50.0, lag_mm=start)
    for _ in range(5000):
        state = compensation.home(chosen(kind), heads_mm(kind), state, 0.0, FULL, DT_S)
    # The last tick of the way comes back by 25 nm, at up to 2 beta of lag for each.
    expected = modified_dahl.step(PUBLISHED, start, -50.0)
    assert state.lag_mm == pytest.approx(expected, abs=1e-4)


@pytest.mark.parametrize("kind", ON_PLAYS)
def test_homing_keeps_track_of_the_plays(kind: CompensationKind) -> None:
    thresholds_mm = np.array(play_sum.bundle(PLAYS).thresholds_mm)
    state = AT_REST._replace(head_mm=50.0, plays_mm=tuple((50.0 - thresholds_mm).tolist()))
    for _ in range(5000):
        state = compensation.home(chosen(kind), heads_mm(kind), state, 0.0, FULL, DT_S)
    np.testing.assert_allclose(state.plays_mm, thresholds_mm, atol=1e-4)  # the last tick rounds
