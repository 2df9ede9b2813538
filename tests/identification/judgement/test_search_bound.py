"""A fit that ends at a bound of its search says so, and blames no recording for it."""

import math

import numpy as np
import pytest

from opensuction.hysteresis import dahl, modified_dahl, play
from opensuction.hysteresis.catalogue.duhem_family import BOUC_WEN_FORM
from opensuction.hysteresis.dahl import Dahl
from opensuction.hysteresis.modified_dahl import ModifiedDahl
from opensuction.identification.workbench import identify
from opensuction.kernel.record import Array

PHASE = np.linspace(0.0, 12.0 * math.pi, 1500)
INPUT = (1.0 - np.cos(PHASE)) * (0.6 + 0.4 * np.sin(0.31 * PHASE))
NOISE = np.random.default_rng(3).normal(0.0, 1.0, INPUT.size)
FRICTION = BOUC_WEN_FORM.simulate(np.array([0.1, 0.0, 1.0, 0.5, 3.0, 0.3, 0.0]), INPUT)


def bouc_wen(length: float, bend_ratio: float, exponent: float, gain: float) -> Array:
    vector = np.array([length, bend_ratio, exponent, 1.0, gain, 0.3, 0.0])
    return BOUC_WEN_FORM.simulate(vector, INPUT)


@pytest.mark.parametrize(
    ("model", "output", "name", "says"),
    [
        ("bouc-wen", bouc_wen(0.3, 0.0, 60.0, -1.0), "exponent", "exponent is 30, the highest"),
        ("bouc-wen", bouc_wen(0.3, -60.0, 1.5, -0.8), "bend_ratio", "bend_ratio is -20, the low"),
        ("bouc-wen", bouc_wen(100.0, 0.0, 1.0, 100.0), "memory_length", "memory_length is"),
        ("modified-dahl", FRICTION, "velocity_gain", "as friction does"),
        ("modified-dahl", 3.0 * FRICTION, "velocity_gain", "try dahl or bouc-wen"),
        (
            "modified-dahl",
            modified_dahl.simulate(ModifiedDahl(11.0, 10.0, 0.005, 0.0), INPUT, 0.0),
            "decay",
            "the lowest that is searched",
        ),
        ("dahl", dahl.simulate(Dahl(1.0, 100.0), INPUT, 0.0), "limit", "20 times the input's"),
    ],
)
def test_a_parameter_at_its_bound_is_told(model: str, output: Array, name: str, says: str) -> None:
    found = identify(INPUT, output + 0.003 * float(np.ptp(output)) * NOISE, model=model)
    assert name in found.at_bound
    told = [warning for warning in found.warnings if warning.startswith("At its bound: ")]
    assert any(says in warning for warning in told), told
    assert not any(warning.startswith("Not determined") for warning in found.warnings)
    if model != "dahl":
        assert math.isnan(found.parameters[name].low)


@pytest.mark.parametrize("model", ["modified-dahl", "dahl", "bouc-wen"])
def test_a_fit_within_its_bounds_tells_of_none(model: str) -> None:
    output = {
        "modified-dahl": modified_dahl.simulate(ModifiedDahl(9.0, 8.0, 3.0, 0.2), INPUT, 0.0),
        "dahl": dahl.simulate(Dahl(50.0, 5.0), INPUT, 0.0),
        "bouc-wen": bouc_wen(0.3, 0.3, 2.0, -0.8),
    }[model]
    found = identify(INPUT, output + 0.003 * float(np.ptp(output)) * NOISE, model=model)
    assert found.at_bound == ()
    assert not any(warning.startswith("At its bound") for warning in found.warnings)


HEAD = 15.0 * (1.0 - np.cos(np.linspace(0.0, 8.0 * math.pi, 1500)))


def backlash(width: float) -> Array:
    """Over a stroke of 30 mm, from rest in the middle of the gap, with .05 mm of noise."""
    return 0.95 * play.simulate(width, HEAD, 0.0) - 3.0 + 0.05 * NOISE


LESS = [pytest.param(width, marks=pytest.mark.soak) for width in (16.0, 20.0, 25.0)]
"""Narrower than the widest that is followed, for the long runs."""


@pytest.mark.parametrize("width", [*LESS, 28.0])
@pytest.mark.parametrize(
    ("model", "most"),
    [("prandtl-ishlinskii", 0.1), ("generalised", 0.1), ("play-readout", 0.1)],
)
def test_a_gap_of_most_of_the_stroke_is_followed(model: str, width: float, most: float) -> None:
    output = backlash(width)
    found = identify(HEAD, output, model=model)
    assert found.rmse < most  # .05 of it noise; plays of half the stroke left .7 to 1.2
    assert found.cross_validation_percent_of_range < 100.0 * 2.0 * most / float(np.ptp(output))


@pytest.mark.parametrize(
    ("model", "width", "name"),
    [
        ("generalised", 28.0, "play_weight_92_percent"),
        ("maxwell-slip", 25.0, "gain_46_percent"),
        ("maxwell-slip", 28.0, "gain_46_percent"),
        pytest.param("preisach", 12.0, "levels", marks=pytest.mark.sweep),  # takes seconds
    ],
)
def test_a_grid_that_ends_is_told(model: str, width: float, name: str) -> None:
    found = identify(HEAD, backlash(width), model=model)
    assert found.at_bound == (name,)
    assert any(warning.startswith("At its bound: ") for warning in found.warnings)


@pytest.mark.parametrize("width", [3.0, pytest.param(8.0, marks=pytest.mark.soak), 16.0])
@pytest.mark.parametrize("model", ["prandtl-ishlinskii", "generalised", "maxwell-slip"])
def test_a_grid_that_holds_the_gap_tells_of_no_end(model: str, width: float) -> None:
    assert identify(HEAD, backlash(width), model=model).at_bound == ()
