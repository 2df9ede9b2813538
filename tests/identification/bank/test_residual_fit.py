"""The residual readout: what it finds on plants of its kind and on the one beneath."""

import numpy as np
import pytest

from opensuction.hysteresis import modified_dahl
from opensuction.hysteresis.bank import residual_readout
from opensuction.hysteresis.modified_dahl import ModifiedDahl
from opensuction.identification import record
from opensuction.identification.bank import residual_fit
from opensuction.identification.bank.residual_fit import ResidualFit
from opensuction.kernel.record import Array

HEAD = 50.0 * (1.0 - np.cos(np.linspace(0.0, 12.0 * np.pi, 1800)))
PLANT = ModifiedDahl(slope=0.95, velocity_gain=0.3, decay_per_mm=0.15, offset_mm=-4.0)
LAG_MM = PLANT.velocity_gain / PLANT.decay_per_mm
"""After a long retract."""


def noise(size: int, sigma: float) -> Array:
    return sigma * np.random.default_rng(5).standard_normal(size)


def texture(head: Array) -> Array:
    """What teeth and turns add, another on each way."""
    forward = np.asarray(np.gradient(head) > 0.0)
    added: Array = np.where(forward, 0.3 * np.sin(0.6 * head), 0.2 * np.cos(0.8 * head))
    return added


def predict(found: ResidualFit, head: Array) -> Array:
    return np.asarray(residual_readout.simulate(found.record, head, found.elements))


def rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def test_a_plant_that_is_the_model_beneath_gets_that_model() -> None:
    tip = modified_dahl.simulate(PLANT, HEAD, LAG_MM) + noise(HEAD.size, 0.05)
    found = residual_fit.fit(HEAD, tip, record.cut(HEAD), PLANT.decay_per_mm)
    assert found.record.slope == pytest.approx(PLANT.slope, abs=0.01)
    assert found.record.velocity_gain == pytest.approx(PLANT.velocity_gain, abs=0.02)
    # Of 245 factors hardly any is used: two of the model, its past, and a few of noise.
    assert found.freedom < 20.0
    clean = modified_dahl.simulate(PLANT, HEAD, LAG_MM)
    assert rms(predict(found, HEAD) - clean) < 0.01


def test_what_comes_back_at_each_place_on_each_way_is_predicted() -> None:
    """Fitted to half of it; the noise is .02 mm, the model beneath leaves .2 mm."""
    tip = modified_dahl.simulate(PLANT, HEAD, LAG_MM) + texture(HEAD)
    half = HEAD.size // 2
    seen = (tip + noise(HEAD.size, 0.02))[:half]
    found = residual_fit.fit(HEAD[:half], seen, record.cut(HEAD[:half]), PLANT.decay_per_mm)
    late = (predict(found, HEAD) - tip)[half:]
    # At a turn the texture jumps, which no lag of a hundredth of the range and more follows.
    away = (HEAD[half:] > 6.0) & (HEAD[half:] < 94.0)
    assert rms(late[away]) < 0.05
    assert found.scores.rmse < 0.12


def test_what_was_before_the_recording_fades() -> None:
    """A start that is off by 1 mm and comes back over two strokes does not tilt what follows."""
    path = np.append(0.0, np.cumsum(np.abs(np.diff(HEAD))))
    clean = modified_dahl.simulate(PLANT, HEAD, LAG_MM)
    start = np.exp(-path / 250.0)
    tip = clean + start + noise(HEAD.size, 0.02)
    half = HEAD.size // 2
    errors = []
    for fading in (True, False):
        found = residual_fit.fit(
            HEAD[:half], tip[:half], record.cut(HEAD[:half]), PLANT.decay_per_mm, fading
        )
        errors.append(rms((predict(found, HEAD) - clean - start)[half:]))
    assert errors[0] < 0.05
    assert errors[1] > 2.0 * errors[0]


@pytest.mark.parametrize("past", [-1.0, 0.0, 1.0])
def test_whatever_the_past_was_what_follows_is_predicted(past: float) -> None:
    """Fitted to one stroke and back, from a place where the past shows; the noise is .01 mm."""
    head = 50.0 * (1.0 - np.cos(np.linspace(0.3, 12.4, 1200)))
    tip = modified_dahl.simulate(PLANT, head, -past * LAG_MM)
    half = head.size // 2
    seen = (tip + noise(head.size, 0.01))[:half]
    found = residual_fit.fit(head[:half], seen, record.cut(head[:half]), PLANT.decay_per_mm)
    late = (predict(found, head) - tip)[half:]
    assert rms(late) < 0.1
    assert rms(predict(found, head)[:half] - seen) < 0.1
    # Where the past shows, its share of the mean is nearly all.
    assert found.elements[0] == pytest.approx(-past / PLANT.decay_per_mm, abs=0.8)


def test_a_past_that_does_not_show_is_not_chosen() -> None:
    """A recording that begins saturated and drifts: no one past takes all, as evidence would."""
    head = 50.0 * (1.0 - np.cos(np.linspace(0.0, 6.2, 600)))
    path = np.append(0.0, np.cumsum(np.abs(np.diff(head))))
    tip = modified_dahl.simulate(PLANT, head, 0.0) + 2.0 * np.exp(-path / 30.0)
    rough = np.convolve(np.random.default_rng(3).standard_normal(640), np.ones(41) / 41.0, "valid")
    found = residual_fit.fit(head, tip + 2.0 * rough, record.cut(head), PLANT.decay_per_mm)
    assert abs(found.elements[0]) < 0.9 / PLANT.decay_per_mm
