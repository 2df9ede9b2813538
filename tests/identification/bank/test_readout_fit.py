"""Plays and their lines are found again, simple where a recording is poor."""

import numpy as np
import pytest

from opensuction.hysteresis import play
from opensuction.hysteresis.bank import play_readout
from opensuction.identification import record as record_module
from opensuction.identification.bank import preisach_fit, readout_fit
from opensuction.identification.bank.readout_fit import ReadoutFit
from opensuction.kernel.record import Array

PHASE = np.linspace(0.0, 12.0 * np.pi, 1500)
HEAD = 50.0 + 50.0 * np.cos(PHASE) * (0.7 + 0.3 * np.cos(PHASE / 2.0))
NOISE = np.random.default_rng(2).normal(0.0, 0.05, HEAD.size)
OTHER = 10.0 * np.sin(1.7 * PHASE)


def follow(found: ReadoutFit, *inputs: Array) -> Array:
    total = np.zeros(inputs[0].size)
    for record, past, input_ in zip(found.records, found.pasts, inputs, strict=True):
        start = play_readout.start_elements_mm(record, float(input_[0]), past)
        total += play_readout.simulate(record, input_, start)
    return total


def bent(head: Array) -> Array:
    """A play whose output rises ever faster."""
    moved = play.simulate(8.0, head, head[0])
    return 0.2 * head + 0.004 * moved * moved


HALF = HEAD.size // 2


@pytest.fixture(scope="module")
def half_fitted() -> ReadoutFit:
    """Of a bent line over a play, in noise."""
    tip = bent(HEAD) + NOISE
    return readout_fit.fit(HEAD[None, :HALF], tip[:HALF], record_module.cut(HEAD[:HALF]))


def test_a_bent_line_over_a_play_is_followed_to_its_noise(half_fitted: ReadoutFit) -> None:
    found = half_fitted
    rest = follow(found, HEAD) - bent(HEAD)
    assert float(np.sqrt(np.mean(rest[HALF:] ** 2))) < 0.12  # a straight line leaves 2.3
    assert found.scores.rmse == pytest.approx(0.1, abs=0.06)
    assert found.bounded
    assert all(play_readout.is_rising(record) for record in found.records)


def test_a_poor_recording_gets_a_simple_model(half_fitted: ReadoutFit) -> None:
    """Loops in noise are worth fewer gains than the same loops with hardly any."""
    head = HEAD[:HALF]
    poor = readout_fit.fit(head[None], bent(head) + 60.0 * NOISE[:HALF], record_module.cut(head))
    assert poor.freedom < 0.6 * half_fitted.freedom


def test_what_a_second_input_adds_may_have_either_sign() -> None:
    moved = play.simulate(3.0, OTHER, OTHER[0])
    tip = bent(HEAD) - 0.7 * moved + NOISE
    both = np.vstack([HEAD, OTHER])
    found = readout_fit.fit(both, tip, record_module.cut(HEAD))
    rest = follow(found, HEAD, OTHER) - (tip - NOISE)
    assert float(np.sqrt(np.mean(rest**2))) < 0.1
    alone = follow(found._replace(records=found.records[1:], pasts=found.pasts[1:]), OTHER)
    assert alone - alone.mean() == pytest.approx(-0.7 * (moved - moved.mean()), abs=2.0)
    assert float(np.corrcoef(alone, moved)[0, 1]) < -0.99
    assert found.records[1].lags.size == 0


def test_a_lag_that_fades_over_strokes_is_a_slow_state() -> None:
    state = play_readout.lag_columns(np.array([300.0]), HEAD, np.array([0.0]))[0]
    found = readout_fit.fit(HEAD[None], bent(HEAD) + 0.02 * state + NOISE, record_module.cut(HEAD))
    assert found.records[0].decays_mm.size == 1
    assert found.records[0].lags[0] > 0.0


def test_units_and_origin_do_not_matter(half_fitted: ReadoutFit) -> None:
    head, tip = HEAD[:HALF], (bent(HEAD) + NOISE)[:HALF]
    other = 1e-3 * head + 7.0
    two = readout_fit.fit(other[None], 50.0 * tip - 3.0, record_module.cut(other))
    assert two.scores.rmse == pytest.approx(50.0 * half_fitted.scores.rmse, rel=1e-3)
    assert follow(two, other) == pytest.approx(50.0 * follow(half_fitted, head) - 3.0, abs=0.1)


def test_a_triangle_gets_as_many_levels_as_the_recording_bears() -> None:
    """A gap of 8 % of the range shows between levels of 5 %, not of 20 %."""
    tip = bent(HEAD) + NOISE
    found = preisach_fit.fit(HEAD, tip, record_module.cut(HEAD))
    assert len(found.record.weights_mm) >= 15
    assert found.scores.rmse < 0.5


@pytest.mark.soak
def test_a_triangle_of_a_short_recording_in_noise_is_simple() -> None:
    tip = bent(HEAD) + NOISE
    few = preisach_fit.fit(
        HEAD[:200], tip[:200] + 20.0 * NOISE[:200], record_module.cut(HEAD[:200])
    )
    assert few.freedom < 30.0
