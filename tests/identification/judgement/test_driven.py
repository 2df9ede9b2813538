"""Suitability of fitted models to drive a head, and the reason given for those that are not."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from opensuction.hysteresis.bank.play_readout import PlayReadout
from opensuction.hysteresis.catalogue.catalogue import CATALOGUE
from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii
from opensuction.hysteresis.preisach import Preisach
from opensuction.identification.judgement import candidate
from opensuction.kernel.record import Array


def strokes(*ends: float) -> Array:
    """An input that goes from each place to the next."""
    return np.concatenate([np.linspace(a, b, 50) for a, b in pairwise(ends)])


TWO = strokes(0.0, 100.0, 0.0, 100.0, 0.0)
SIX = strokes(0.0, 100.0, 0.0, 80.0, 0.0, 60.0, 0.0, 40.0, 0.0, 20.0, 0.0)
PLAYS = PrandtlIshlinskii(np.array([9.0, 10.0]), np.array([0.4, 0.5]), 0.0, -6.0, 0.0)
RELAYS = Preisach(0.0, 100.0, np.diag(np.linspace(5.0, 9.0, 10))[:, ::-1].copy() + 1.0, -6.0)
FLAT = PlayReadout(
    low_mm=0.0,
    high_mm=100.0,
    widths_mm=np.array([0.0, 20.0]),
    gains=np.array([[0.1] * 4, [0.8] * 4]),
    decays_mm=np.empty(0),
    lags=np.empty(0),
    offset_mm=-6.0,
)
LAGGING = FLAT._replace(decays_mm=np.array([30.0]), lags=np.array([0.2]))


@pytest.mark.parametrize(("inputs", "places"), [(TWO, 2), (SIX, 6), (strokes(0.0, 100.0, 40.0), 3)])
def test_places_near_to_one_another_count_once(inputs: Array, places: int) -> None:
    assert candidate.count_places(inputs) == places
    assert candidate.count_places(inputs + 0.3 * np.sin(np.arange(inputs.size))) == places


@pytest.mark.parametrize(
    ("model", "record", "inputs"),
    [
        ("prandtl-ishlinskii", PLAYS, TWO),
        ("preisach", RELAYS, SIX),
        ("play-readout", FLAT, TWO),  # one gain a play: its loops are the same everywhere
    ],
)
def test_models_of_plays_drive(model: str, record: Any, inputs: Array) -> None:
    found = candidate.judge(CATALOGUE[model], record, inputs[None])
    assert found.lines is not None
    assert found.why_not == ""


@pytest.mark.parametrize(
    ("model", "record", "inputs", "says"),
    [
        ("preisach", RELAYS, TWO[None], "turns at 2 places only: record strokes that turn at 6"),
        ("play-readout", LAGGING, TWO[None], "its slow state takes up to 0.4 from the slope"),
        ("play-readout", FLAT, np.array([TWO, TWO]), "follows several inputs, and a head is one"),
        ("preisach", RELAYS._replace(weights_mm=-RELAYS.weights_mm), SIX[None], "below 0"),
        ("bouc-wen", None, TWO[None], "a search whose steps no tick could bound"),
        ("generalised", None, TWO[None], "its weights may have either sign"),
        ("dahl", None, TWO[None], "stands still once it is saturated"),
    ],
)
def test_what_does_not_drive_says_why_and_what_would(
    model: str, record: Any, inputs: Array, says: str
) -> None:
    found = candidate.judge(CATALOGUE[model], record, inputs)
    assert found.lines is None
    assert says in found.why_not
    assert "\n" not in found.why_not


def test_every_model_drives_or_says_why_not() -> None:
    for name, model in CATALOGUE.items():
        drives = model.lines is not None or name == "modified-dahl"
        assert drives == (model.undriven == ""), name
