import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from opensuction.hysteresis import play
from opensuction.kernel.compiled import compiled
from opensuction.twin import parameter, preset
from opensuction.twin.machine import transmission
from opensuction.twin.machine.transmission import Transmission, TransmissionState
from tests.hysteresis import distributed_play

DT_S = 0.001
NOMINAL = preset.transmission_of(parameter.nominal(parameter.BENCH))
STILL = NOMINAL._replace(creep=NOMINAL.creep._replace(fast_mm=0.0, slow_mm=0.0))
"""Without creep: rate-independent."""


@compiled
def move(
    conduit: Transmission, state: TransmissionState, goal_mm: float, tips_mm: NDArray[np.float64]
) -> TransmissionState:
    """As many ticks as the tip's path has entries, at constant speed to the goal."""
    start = state.head_mm
    for k in range(tips_mm.size):
        head = start + (goal_mm - start) * (k + 1) / tips_mm.size
        state = transmission.step(conduit, state, head, DT_S)
        tips_mm[k] = state.tip_mm
    return state


def follow(
    conduit: Transmission, state: TransmissionState, heads_mm: list[float], speed_mm_per_s: float
) -> tuple[TransmissionState, list[float]]:
    """Head led from point to point at constant speed; returns the state and the tip's path."""
    tips: list[float] = []
    for goal in heads_mm:
        ticks = max(round(abs(goal - state.head_mm) / (speed_mm_per_s * DT_S)), 1)
        way = np.empty(ticks)
        state = move(conduit, state, goal, way)
        tips.extend(way)
    return state, tips


def rest(conduit: Transmission, state: TransmissionState, seconds: float) -> TransmissionState:
    return move(conduit, state, state.head_mm, np.empty(round(seconds / DT_S)))


@pytest.mark.parametrize("head_mm", [-5.0, 0.0, 60.0])
def test_the_retracted_state_is_a_fixed_point(head_mm: float) -> None:
    start = transmission.after_retract(NOMINAL, head_mm)
    later = rest(NOMINAL, start, 0.2)
    assert later.tip_mm == start.tip_mm
    # And a retract ends in it.
    retracted, _ = follow(STILL, transmission.after_retract(STILL, head_mm + 80.0), [head_mm], 9.0)
    assert retracted.tip_mm == pytest.approx(start.tip_mm, abs=1e-9)


def test_the_gap_is_bend_times_clearance_and_stretch() -> None:
    values = parameter.nominal(parameter.BENCH)
    head = 60.0
    back = transmission.after_retract(STILL, head)
    forth, _ = follow(STILL, transmission.after_retract(STILL, -60.0), [head], 50.0)
    # The same head, come to from either side: widths plus stretch, times the gain at that depth.
    gap = back.tip_mm - forth.tip_mm
    width = values["bend_rad"] * values["clearance_mm"] + values["stretch_mm"]
    slope = values["gain"] * (1.0 + values["gain_per_100mm"] / 100.0 * (head - 50.0))
    assert gap == pytest.approx(width * slope, rel=1e-9)


def test_gain_changes_with_depth_as_its_parameter_says() -> None:
    shallow = (transmission.depth_mm(STILL, 0.5) - transmission.depth_mm(STILL, -0.5)) / 1.0
    deep = (transmission.depth_mm(STILL, 100.5) - transmission.depth_mm(STILL, 99.5)) / 1.0
    gain = STILL.gain
    assert (deep - shallow) / gain == pytest.approx(0.01)
    assert 0.5 * (deep + shallow) == pytest.approx(gain)
    assert transmission.depth_mm(STILL, 0.0) == STILL.offset_mm


turns = st.lists(st.floats(0.0, 100.0), min_size=1, max_size=5)


@given(turns=turns, conduit=st.sampled_from([NOMINAL, STILL]))
def test_a_closed_head_cycle_never_returns_more_tip_travel_than_given(
    turns: list[float], conduit: Transmission
) -> None:
    start = transmission.after_retract(conduit, 0.0)
    _, tips = follow(conduit, start, [*turns, 0.0], 40.0)
    path = float(np.abs(np.diff([start.tip_mm, *tips])).sum())
    given_mm = float(np.abs(np.diff([0.0, *turns, 0.0])).sum())
    steepest = conduit.gain * (1.0 + 0.5 * 0.01 + 0.002)
    # Creep gives back at each turn at most what it held.
    held = 2.0 * (conduit.creep.fast_mm + conduit.creep.slow_mm) * (len(turns) + 1)
    assert path <= steepest * given_mm + held + 1e-9


def test_the_tip_never_moves_against_the_head() -> None:
    """The catheter's creep acts on its own motion: a head inside the clearance moves nothing."""
    state, _ = follow(NOMINAL, transmission.after_retract(NOMINAL, 0.0), [80.0], 9.0)
    state = rest(NOMINAL, state, 30.0)
    start = state.tip_mm
    _, tips = follow(NOMINAL, state, [20.0], 9.0)
    assert max(tips) <= start + 1e-3  # what creep is left after 30 s: 0.1 mm * e^-6
    assert np.diff(tips).max() <= 1e-6
    gap = [tip for tip in tips if tip > start - 1e-3]
    assert len(gap) * DT_S * 9.0 > 10.0  # mm of head travel that the tip ignores


@given(turns=turns)
def test_without_creep_speed_does_not_matter(turns: list[float]) -> None:
    start = transmission.after_retract(STILL, 0.0)
    slow, _ = follow(STILL, start, turns, 50.0)
    fast, _ = follow(STILL, start, turns, 1e9)
    assert slow.tip_mm == pytest.approx(fast.tip_mm, abs=1e-9)


@pytest.mark.parametrize(("fast", "seconds"), [(True, 0.5), (False, 5.0)])
def test_creep_has_its_amplitude_and_time_constant(fast: bool, seconds: float) -> None:
    amplitudes = {"fast_mm": 0.15 if fast else 0.0, "slow_mm": 0.0 if fast else 0.10}
    conduit = NOMINAL._replace(creep=NOMINAL.creep._replace(**amplitudes))
    speed = 9.0
    state, _ = follow(conduit, transmission.after_retract(conduit, -1000.0), [0.0], speed)
    amplitude = 0.15 if fast else 0.10
    # 3 mm/s draw half of it; the catheter follows at the head's speed.
    drawn = amplitude * speed / (speed + transmission.VELOCITY_MM_PER_S)
    final = rest(conduit, state, 20.0 * seconds)
    assert final.tip_mm - state.tip_mm == pytest.approx(drawn, rel=2e-3)
    later = rest(conduit, state, seconds)
    # Explicit Euler: a tick is a 500th of the fast time constant, half of that is the error.
    assert (final.tip_mm - later.tip_mm) / drawn == pytest.approx(math.exp(-1.0), rel=4e-3)


@given(mean=st.floats(5.0, 40.0), spread=st.floats(0.0, 4.0), count=st.integers(2, 40))
def test_widths_have_exactly_their_mean_and_deviation(
    mean: float, spread: float, count: int
) -> None:
    widths = preset.play_widths_mm(mean, spread, count)
    assert widths.size == count
    assert np.mean(widths) == pytest.approx(mean, rel=1e-12)
    assert np.std(widths) == pytest.approx(spread, rel=1e-9, abs=1e-12)


def test_a_bundle_is_the_plays_that_an_array_holds() -> None:
    """Number for number what `distributed_play.step` gives."""
    widths = np.array(NOMINAL.widths_mm)
    positions = distributed_play.retracted_positions_mm(widths, 0.0)
    state = transmission.bundle(positions)
    for head_mm in (3.0, 40.0, 18.5, 19.0, -20.0, 70.0):
        state, mean = play.step_bundle(NOMINAL.widths_mm, state, head_mm)
        assert mean == distributed_play.step(widths, positions, head_mm)
        assert state == tuple(positions)


def test_a_conduit_has_twelve_plays() -> None:
    with pytest.raises(ValueError, match="12 plays, not 11"):
        transmission.bundle([20.0] * 11)
