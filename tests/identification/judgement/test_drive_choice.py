"""The model that a machine is driven by: the plays, unless another surely and much better."""

import numpy as np
import pytest

from opensuction.hysteresis import modified_dahl, prandtl_ishlinskii
from opensuction.hysteresis.bank import play_lines
from opensuction.hysteresis.bank.play_readout import PlayReadout
from opensuction.hysteresis.modified_dahl import ModifiedDahl
from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii
from opensuction.identification.judgement import recommendation
from opensuction.identification.judgement.recommendation import DAHL, PLAYS
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array


def _strokes() -> Array:
    """Strokes from 0 that turn at six places, a few hundred samples each."""
    ends = (100.0, 100.0, 80.0, 60.0, 40.0, 20.0)
    turns = [0.5 * end * (1.0 - np.cos(np.linspace(0.0, 2.0 * np.pi, 160))) for end in ends]
    return np.concatenate(turns)


HEAD = _strokes()
NOISE = 0.05 * np.random.default_rng(3).normal(size=HEAD.size)


def test_on_plays_the_calibration_s_own_stay() -> None:
    plays = PrandtlIshlinskii(np.array([8.0, 10.0]), np.array([0.4, 0.5]), 0.02, -6.0, 3e-5)
    start = prandtl_ishlinskii.retracted_positions_mm(plays, 0.0)
    found = recommendation.choose(HEAD, prandtl_ishlinskii.simulate(plays, HEAD, start) + NOISE)
    assert found.model == PLAYS
    assert found.errors_mm[PLAYS] < 0.06 < found.errors_mm[DAHL]
    assert "No other model is surely and much better" in found.reason
    assert found.lines is not None


def test_a_machine_that_is_a_modified_dahl_model_is_driven_by_one() -> None:
    model = ModifiedDahl(slope=0.95, velocity_gain=0.4, decay_per_mm=0.08, offset_mm=-6.0)
    saturated = float(modified_dahl.saturation_mm(model))
    found = recommendation.choose(HEAD, modified_dahl.simulate(model, HEAD, saturated) + NOISE)
    assert found.model == DAHL
    assert "modified-dahl is surely and much better than the plays" in found.reason


def test_loops_that_change_with_the_place_are_driven_by_lines_over_the_plays() -> None:
    rising = np.linspace(0.2, 1.6, 12)
    model = PlayReadout(
        low_mm=0.0,
        high_mm=100.0,
        widths_mm=np.array([0.0, 5.0, 20.0]),
        gains=np.array([0.3 * rising, 0.3 * np.ones(12), 0.4 * rising[::-1]]),
        decays_mm=np.empty(0),
        lags=np.empty(0),
        offset_mm=-6.0,
    )
    table = play_lines.tabulate(play_lines.of_readout(model))
    found = recommendation.choose(HEAD, play_lines.simulate(table, HEAD) + NOISE)
    assert found.model in recommendation.ON_LINES
    assert found.model == found.lines_model
    assert found.errors_mm[found.model] < 0.6 * found.errors_mm[PLAYS]


def test_where_nothing_drives_it_says_why_of_each() -> None:
    with pytest.raises(InputError, match=r"no model drives .*prandtl-ishlinskii: .*preisach: "):
        recommendation.choose(HEAD, -HEAD, only_lines=True)
