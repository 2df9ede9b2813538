"""Conduits fitted to real recordings: shipped files, their models, their form in the twin."""

import numpy as np
import pytest

from opensuction.hysteresis.bank.play_readout import PlayReadout
from opensuction.hysteresis.catalogue.catalogue import CATALOGUE
from opensuction.hysteresis.catalogue.hysteresis_model import simulate
from opensuction.hysteresis.preisach import Preisach
from opensuction.settings import conduit_file
from opensuction.twin import parameter, preset, transmission_parameter
from opensuction.twin.conduit import conduit_fit, play_line
from opensuction.twin.machine import transmission
from tests.twin.conduit.example import DT_S, strokes_mm

HEADS = strokes_mm(20.0, 10.0, 120.0, 40.0, 80.0, 60.0, 65.0, 0.0)


@pytest.mark.parametrize("name", conduit_file.PREISACH)
def test_a_preisach_conduit_is_the_catalogues_preisach_model(name: str) -> None:
    conduit = conduit_file.load(name).conduit
    rows, levels = conduit.gains.shape
    weights = np.zeros((levels, levels))
    weights[:rows] = conduit.cell_mm * conduit.gains
    model = Preisach(0.0, levels * conduit.cell_mm, weights, conduit.offset_mm)
    whole = simulate(CATALOGUE["preisach"], model, HEADS, -1.0)
    assert play_line.tip_mm(conduit, HEADS) == pytest.approx(whole, abs=1e-9)


@pytest.mark.parametrize("name", conduit_file.READOUT)
def test_a_readout_conduit_is_the_catalogues_play_readout(name: str) -> None:
    conduit = conduit_file.load(name).conduit
    model = PlayReadout(
        low_mm=0.0,
        high_mm=conduit.cell_mm * conduit.gains.shape[1],
        widths_mm=conduit.widths_mm,
        gains=conduit.gains,
        decays_mm=np.empty(0),
        lags=np.empty(0),
        offset_mm=conduit.offset_mm,
    )
    whole = simulate(CATALOGUE["play-readout"], model, HEADS, -1.0)
    assert play_line.tip_mm(conduit, HEADS) == pytest.approx(whole, abs=1e-9)


def test_a_wider_gap_takes_so_much_longer_to_cross() -> None:
    conduit = conduit_file.load("readout-25").conduit
    heads = np.array([20.0, 60.0, 20.0])  # within the range, after a long retract
    tip, wide = (play_line.tip_mm(conduit, heads, ratio) for ratio in (1.0, 1.2))
    # On the way in the tip is half a gap behind, on the way out half a gap ahead.
    assert wide[1] < tip[1]
    assert wide[0] > tip[0]
    assert wide[2] > tip[2]


@pytest.mark.parametrize("name", conduit_file.NAMES)
def test_the_twins_form_is_near_the_conduit_and_never_falls(name: str) -> None:
    conduit = conduit_file.load(name).conduit
    chosen, lost_mm = conduit_file.smoothed(name)
    # What is said of it in docs/explanations/twin.md.
    assert lost_mm < 0.2
    values = parameter.nominal(parameter.BENCH | transmission_parameter.rows(chosen))
    drawn = preset.transmission_of(values, chosen)
    still = drawn._replace(creep=drawn.creep._replace(fast_mm=0.0, slow_mm=0.0))
    tips = transmission.simulate(still, transmission.after_retract(still, 10.0), HEADS, DT_S)
    whole = play_line.tip_mm(conduit, np.append(10.0, HEADS))[1:]
    assert np.sqrt(np.mean(np.square(tips - whole))) < 0.25
    ahead = np.diff(np.append(10.0, HEADS)) > 0.0
    moves = np.diff(np.append(tips[0], tips))
    assert moves[ahead].min() >= -1e-12
    assert moves[~ahead].max() <= 1e-12


def test_a_fit_finds_the_conduit_that_made_the_record() -> None:
    """Of a conduit of the same plays and cells without noise next to nothing is left."""
    made = play_line_example()
    heads = strokes_mm(2000.0, 0.0, 120.0, 0.0, 100.0, 20.0, 80.0, 40.0, 60.0, 0.0, 120.0, 0.0)
    found = conduit_fit.fit("readout", heads, play_line.tip_mm(made, heads))
    assert found.past == -1.0
    # The penalties pull each gain towards its neighbours, over a range of 110 mm.
    assert found.residual_mm < 0.1


def play_line_example() -> play_line.RecordedConduit:
    start = conduit_fit.empty("readout")
    gains = np.zeros_like(start.gains)
    gains[2], gains[3] = 0.5, np.linspace(0.3, 0.4, gains.shape[1])
    return start._replace(gains=gains, offset_mm=-7.0)


def test_repeats_scatter_by_what_was_added_to_them() -> None:
    once = strokes_mm(1000.0, 0.0, 120.0, 0.0)
    heads = np.tile(once, 20)
    shifts = np.repeat(np.random.default_rng(7).normal(0.0, 0.2, 20), once.size)
    # The standard deviation of 20 draws is known to a sixth.
    assert conduit_fit.scatter_mm(heads, heads + shifts) == pytest.approx(0.2, rel=0.35)


def test_lines_with_nothing_to_say_are_0() -> None:
    assert play_line.read_out_mm(play_line.NO_LINES, play_line.ZEROS) == 0.0
