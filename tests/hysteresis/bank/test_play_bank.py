from itertools import pairwise

import numpy as np
import pytest

from opensuction.hysteresis.bank import play_bank
from opensuction.hysteresis.bank.play_bank import PlayBank
from opensuction.hysteresis.bank.play_readout import PlayReadout, inverse_step, is_rising, output_mm
from opensuction.hysteresis.play import ModelState

RANDOM = np.random.default_rng(4)
HEADS = np.cumsum(RANDOM.normal(size=(2, 300)), axis=1)
EDGES = np.array([0, 90, 200, 300])


@pytest.mark.parametrize("goes_on", [True, False])
def test_sums_of_cells_are_those_of_their_columns(goes_on: bool) -> None:
    bank = PlayBank(
        widths_mm=np.array([0.0, 3.0, 1.0]),
        lows_mm=np.array([-4.0, -2.0, -5.0]),
        cell_mm=2.0,
        cells=np.array([5, 3, 4]),
        inputs=np.array([0, 0, 1]),
        goes_on=goes_on,
    )
    starts, others = np.zeros(3), RANDOM.normal(size=(2, 300))
    sums = play_bank.sum_products(bank, HEADS, starts, others, EDGES, 1)
    columns = []
    for row, input_ in enumerate(bank.inputs):
        one = PlayBank(
            widths_mm=bank.widths_mm[[row]],
            lows_mm=bank.lows_mm[[row]],
            cell_mm=bank.cell_mm,
            cells=bank.cells[[row]],
            inputs=bank.inputs[[row]],
            goes_on=goes_on,
        )
        columns.append(play_bank.basis(one, HEADS[input_], starts[[row]]))
    table = np.hstack([*columns, others.T])
    expected = [table[a:b].T @ table[a:b] for a, b in pairwise(EDGES)]
    assert sums == pytest.approx(np.array(expected), abs=1e-9)


def test_an_inverse_that_could_turn_the_wrong_way_is_refused() -> None:
    """A slow state that lags by more than the play without width makes good."""
    model = PlayReadout(
        low_mm=0.0,
        high_mm=10.0,
        widths_mm=np.array([0.0, 2.0]),
        gains=np.full((2, 3), 0.4),
        decays_mm=np.array([5.0]),
        lags=np.array([0.3]),
        offset_mm=0.0,
    )
    state = ModelState(5.0, np.array([5.0, 4.0, -5.0]))
    target_mm = output_mm(model, state) + 1.0
    assert not is_rising(model)
    assert inverse_step(model, state, target_mm) == (0.0, False)
    assert inverse_step(model._replace(lags=np.array([0.1])), state, 3.0).reached
