"""The form in which a model of plays drives: the same model as the catalogue's, and its inverse."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from opensuction.control import preview
from opensuction.control.backlash_inverse import HeadState
from opensuction.hysteresis.bank import play_lines, turning_point
from opensuction.hysteresis.bank.play_lines import PlayLines
from opensuction.hysteresis.bank.play_readout import PlayReadout
from opensuction.hysteresis.catalogue.catalogue import CATALOGUE
from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii
from opensuction.hysteresis.preisach import Preisach
from opensuction.kernel.compiled import compiled

RANDOM = np.random.default_rng(11)
PLAYS = PrandtlIshlinskii(
    np.array([1.5, 8.0, 10.0, 11.0]), np.array([0.0, 0.3, 0.4, 0.2]), 0.05, -6.0, 0.0
)
RELAYS = Preisach(-2.0, 102.0, np.triu(RANDOM.uniform(0.0, 0.9, (12, 12)))[:, ::-1].copy(), -4.0)
READOUT = PlayReadout(
    low_mm=0.0,
    high_mm=100.0,
    widths_mm=np.array([0.0, 3.0, 10.0, 20.0, 25.0]),
    gains=RANDOM.uniform(0.05, 0.3, (5, 12)),
    decays_mm=np.empty(0),
    lags=np.empty(0),
    offset_mm=-3.0,
)
LAGGING = READOUT._replace(decays_mm=np.array([30.0]), lags=np.array([0.02]))
LEADING = LAGGING._replace(lags=np.array([-0.04]))
MODELS: dict[str, tuple[str, Any, PlayLines]] = {
    "plays": ("prandtl-ishlinskii", PLAYS, play_lines.of_prandtl_ishlinskii(PLAYS)),
    "relays": ("preisach", RELAYS, play_lines.of_preisach(RELAYS)),
    "readout": ("play-readout", READOUT, play_lines.of_readout(READOUT)),
    "lagging": ("play-readout", LAGGING, play_lines.of_readout(LAGGING)),
    "leading": ("play-readout", LEADING, play_lines.of_readout(LEADING)),
}
every_model = pytest.mark.parametrize("name", MODELS)


@compiled
def follow(table: play_lines.Table, state: HeadState, heads_mm: NDArray[np.float64]) -> HeadState:
    """The tip of each head, written in its place."""
    for k in range(heads_mm.size):
        state = preview.advance(table, state, heads_mm[k], 0.0)
        heads_mm[k] = preview.tip_mm(table, state)
    return state


def retracted(table: play_lines.Table, head_mm: float) -> HeadState:
    decay_mm = float(table[0, play_lines.DECAY])
    return HeadState(head_mm, 0.0, decay_mm, turning_point.after_retract(head_mm))


@every_model
def test_the_tip_is_that_of_the_catalogue_s_model(name: str) -> None:
    model, record, lines = MODELS[name]
    entry = CATALOGUE[model]
    # Within the range of the models: beyond it a head is driven by each play's mean gain.
    heads_mm = np.clip(50.0 + np.cumsum(RANDOM.normal(0.0, 15.0, 300)), 0.0, 100.0)
    heads_mm[0] = 0.0
    expected = entry.simulate(record, heads_mm, entry.memory(record, 0.0, -1.0))
    table = play_lines.tabulate(lines)
    follow(table, retracted(table, 0.0), heads_mm)
    np.testing.assert_allclose(heads_mm, expected, rtol=0.0, atol=1e-11)


@every_model
@settings(max_examples=60)
@given(heads=st.lists(st.floats(-40.0, 140.0), max_size=6), target_mm=st.floats(-80.0, 160.0))
def test_the_inverse_brings_the_tip_to_its_target(
    name: str, heads: list[float], target_mm: float
) -> None:
    table = play_lines.tabulate(MODELS[name][2])
    state = follow(table, retracted(table, 0.0), np.array([0.0, *heads]))
    positions = play_lines.positions_mm(table, state.plays_mm, state.head_mm)
    move_mm = play_lines.inverse_step(table, positions, state.head_mm, state.lag_mm, target_mm)
    before_mm = preview.tip_mm(table, state)
    assert move_mm * (target_mm - before_mm) >= 0.0
    tips = np.array([state.head_mm + move_mm])
    follow(table, state, tips)
    # Rounding of tips of a hundred mm; where the slope is .05 the head is twenty times as far off.
    assert tips[0] == pytest.approx(target_mm, abs=1e-10)


@every_model
@pytest.mark.parametrize("direction", [1.0, -1.0])
@pytest.mark.parametrize("tip_mm", [-150.0, 0.0, 37.0, 90.0, 170.0])
def test_a_long_way_ends_with_the_tip_at_its_depth(
    name: str, tip_mm: float, direction: float
) -> None:
    table = play_lines.tabulate(MODELS[name][2])
    there = preview.at_rest(table, tip_mm, direction)
    assert preview.tip_mm(table, there) == pytest.approx(tip_mm, abs=1e-10)
    # The same by going there: 600 mm forget what was before, by e to the -20.
    far = retracted(table, there.head_mm)
    tips = np.array([there.head_mm - direction * 600.0, there.head_mm])
    follow(table, far, tips)
    assert tips[-1] == pytest.approx(tip_mm, abs=1e-6)


@every_model
def test_a_table_holds_the_model(name: str) -> None:
    lines = MODELS[name][2]
    back = play_lines.to_lines(play_lines.tabulate(lines))
    for mine, theirs in zip(lines, back, strict=True):
        np.testing.assert_array_equal(mine, theirs)
    assert play_lines.why_not_driven(back) is None


def test_a_play_that_adds_nothing_is_left_out() -> None:
    assert MODELS["plays"][2].widths_mm.tolist() == [0.0, 16.0, 20.0, 22.0]


UNDRIVEN: dict[str, dict[str, Any]] = {
    "it holds a number that is not finite": {"offset_mm": np.nan},
    "it is not monotone: a gain is -0.2, none should be below 0": {"gains": np.array([[-0.2]])},
    "its tip stands still somewhere while every play moves": {"gains": np.array([[0.0]])},
    "it is not monotone: its slow state takes up to 0.1 from the slope after a reversal, and the "
    "play without width has 0": {"lag": 0.05},
    "its cells, its decay length or a width is no length": {"cell_mm": 0.0},
}


@pytest.mark.parametrize("reason", UNDRIVEN)
def test_what_cannot_drive_says_why(reason: str) -> None:
    one = PlayLines(np.array([20.0]), np.zeros(1), 1.0, np.array([[0.9]]), 1.0, 0.0, 0.0)
    assert play_lines.why_not_driven(one) is None
    assert play_lines.why_not_driven(one._replace(**UNDRIVEN[reason])) == reason


@pytest.mark.parametrize("name", ["relays", "readout"])
@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_beyond_the_recording_the_tip_goes_on_at_the_mean_slope(
    name: str, direction: float
) -> None:
    """The last cell tells of its own place: 13 mm beyond it went .9 mm wrong by that alone."""
    lines = MODELS[name][2]
    start_mm = 50.0 + direction * 90.0
    table = play_lines.tabulate(lines)
    state = preview.at_rest(table, 0.0, direction)
    tips_mm = np.array([0.0, start_mm, start_mm + direction * 10.0])
    tips_mm[0] = state.head_mm
    follow(table, state, tips_mm)
    inner = lines.gains[:, 1:-1]
    if name == "relays":  # a row has as many cells of its own as the triangle leaves it
        levels = inner.shape[1]
        inner = np.where(np.arange(levels) < levels - np.arange(levels)[:, None], inner, np.nan)
    mean = float(np.nanmean(inner, axis=1).sum())
    assert direction * (tips_mm[2] - tips_mm[1]) == pytest.approx(10.0 * mean)
