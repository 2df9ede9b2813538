"""Models that are not linear are found wherever their parameters lie, or said to end at a limit."""

import math

import numpy as np
import pytest

from opensuction.hysteresis import dahl, modified_dahl
from opensuction.hysteresis.catalogue.duhem_family import BOUC_WEN_FORM, MODIFIED_DAHL_FORM
from opensuction.hysteresis.dahl import Dahl
from opensuction.hysteresis.modified_dahl import ModifiedDahl
from opensuction.identification.estimator import nonlinear
from opensuction.identification.estimator.search import search
from opensuction.identification.workbench import identify
from opensuction.kernel.record import Array

PHASE = np.linspace(0.0, 12.0 * math.pi, 1500)
INPUT = (1.0 - np.cos(PHASE)) * (0.6 + 0.4 * np.sin(0.31 * PHASE))
NOISE = np.random.default_rng(3).normal(0.0, 1.0, INPUT.size)
SHARE = 0.003
"""Of the output's range: noise of the recordings."""


def noisy(output: Array) -> Array:
    return output + SHARE * float(np.ptp(output)) * NOISE


def bouc_wen(length: float, bend_ratio: float, exponent: float, slope: float, gain: float) -> Array:
    vector = np.array([length, bend_ratio, exponent, slope, gain, 0.3, 0.0])
    return BOUC_WEN_FORM.simulate(vector, INPUT)


@pytest.mark.parametrize(
    ("length", "bend_ratio", "exponent", "slope", "gain"),
    [
        (0.02, 0.4, 1.3, 0.02, 40.0),
        (0.1, 0.5, 2.0, 0.0, 10.0),
        (0.2, 0.5, 2.0, -0.1, 5.0),
        (0.1, 0.3, 1.5, 9.0, -8.0),
        (0.3, -10.0, 1.5, 1.0, -0.8),
        (0.3, 0.98, 1.5, 1.0, -0.8),
    ],
    ids=["damper", "rubbing", "falling", "steep", "much bent", "hardly passive"],
)
def test_bouc_wen_is_found_far_from_usual_backlash(
    length: float, bend_ratio: float, exponent: float, slope: float, gain: float
) -> None:
    truth = bouc_wen(length, bend_ratio, exponent, slope, gain)
    found = identify(INPUT, noisy(truth), model="bouc-wen")
    rest = found.fitted - truth
    # Seven parameters of 1500 samples take a share of .07 of the noise.
    assert math.sqrt(float(rest @ rest) / rest.size) < 0.15 * SHARE * float(np.ptp(truth))
    assert found.parameters["memory_gain"].value == pytest.approx(gain, rel=0.1)
    assert found.parameters["slope"].value == pytest.approx(slope, abs=0.01 * abs(gain))
    assert found.at_bound == ()
    assert not any(warning.startswith("Not determined") for warning in found.warnings)


def test_bouc_wen_takes_any_unit() -> None:
    output = noisy(bouc_wen(0.1, 0.5, 12.0, 0.0, 10.0))
    one = identify(INPUT, output, model="bouc-wen")
    other = identify(1e-25 * INPUT, 1e20 * output, model="bouc-wen")
    assert other.rmse_percent_of_range == pytest.approx(one.rmse_percent_of_range, rel=1e-4)
    memory = other.parameters["memory_length"].value
    assert memory == pytest.approx(1e-25 * one.parameters["memory_length"].value, rel=0.02)


@pytest.mark.parametrize("decay", [1e3, 3e3, 1e4])
def test_a_memory_shorter_than_usual_is_found(decay: float) -> None:
    truth = ModifiedDahl(1.0, 0.1 * decay, decay, 0.2)
    found = identify(INPUT, noisy(modified_dahl.simulate(truth, INPUT, 0.0)))
    assert found.parameters["decay"].value == pytest.approx(decay, rel=0.05)
    assert found.at_bound == ()


@pytest.mark.parametrize("stiffness", [1e3, 5e3, 1e4])
def test_stiff_friction_is_found(stiffness: float) -> None:
    output = noisy(dahl.simulate(Dahl(stiffness, 1.0), INPUT, 0.0))
    found = identify(INPUT, output, model="dahl")
    assert found.parameters["stiffness"].value == pytest.approx(stiffness, rel=0.05)
    assert found.rmse_percent_of_range == pytest.approx(100.0 * SHARE, rel=0.1)


@pytest.mark.parametrize("gain", [0.0, 0.002])
@pytest.mark.parametrize("seed", [1, 2])
def test_noise_about_a_line_is_no_friction(gain: float, seed: int) -> None:
    noise = np.random.default_rng(seed).normal(0.0, 0.02, INPUT.size)
    line = modified_dahl.simulate(ModifiedDahl(0.9, gain, 5.0, 0.0), INPUT, 0.0)
    assert not nonlinear.fit_modified_dahl(INPUT, line + noise).determined


@pytest.mark.parametrize("slope", [pytest.param(6.0, marks=pytest.mark.soak), 9.0])
def test_a_search_that_draws_lots_leaves_its_box(slope: float) -> None:
    input_ = np.ascontiguousarray(INPUT[::10])
    truth = ModifiedDahl(slope, 0.9 * slope, 3.0, 0.2)
    output = modified_dahl.simulate(truth, input_, 0.0)
    found = search("differential-evolution", MODIFIED_DAHL_FORM, input_, output)
    assert found[:3] == pytest.approx(truth[:3], rel=1e-3)
